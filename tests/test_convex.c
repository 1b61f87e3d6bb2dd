// A point above a triangle around which an obstacle is convex is near to nothing else of it
// (detect/convex.h).

#include "detect/convex.h"
#include "surface_testing.h"

static const double RADIUS = 0.4; // m

enum { POINTS = 3000 };

/// Appends the part to the mesh and frees it.
static void append(PercaleMesh *mesh, PercaleMesh part)
{
    size_t vertices = mesh->vertex_count + part.vertex_count;
    size_t triangles = mesh->triangle_count + part.triangle_count;
    mesh->positions = realloc(mesh->positions, 3 * sizeof(float) * vertices);
    mesh->triangles = realloc(mesh->triangles, 3 * sizeof(uint32_t) * triangles);
    ck_assert(mesh->positions != NULL && mesh->triangles != NULL);
    memcpy(mesh->positions + 3 * (size_t)mesh->vertex_count, part.positions,
           3 * sizeof(float) * part.vertex_count);
    for (size_t i = 0; i < 3 * (size_t)part.triangle_count; i++) {
        mesh->triangles[3 * (size_t)mesh->triangle_count + i] = mesh->vertex_count + part.triangles[i];
    }
    mesh->vertex_count += part.vertex_count;
    mesh->triangle_count += part.triangle_count;
    percale_mesh_free(&part);
}

/// Boxes here and there, some in one another.
static PercaleMesh make_boxes(void)
{
    uint64_t seed = 9;
    PercaleMesh mesh = {0};
    for (int i = 0; i < 60; i++) {
        PercaleMesh box = percale_test_box(0.2f, 0.3f, 0.25f);
        percale_test_translate(&box, random_float(&seed, 1.0), random_float(&seed, 1.0),
                               random_float(&seed, 1.0));
        append(&mesh, box);
    }
    return mesh;
}

/// Two sheets that lie in each other, one of them half a cell aside.
static PercaleMesh make_double_sheet(void)
{
    PercaleMesh mesh = percale_test_sheet(33, 3.0f);
    PercaleMesh other = percale_test_sheet(33, 3.0f);
    percale_test_translate(&other, 0.047f, 0.0f, 0.02f);
    append(&mesh, other);
    return mesh;
}

/// Two sheets that face each other, a little farther apart than the radius.
static PercaleMesh make_gap(void)
{
    PercaleMesh mesh = percale_test_sheet(33, 3.0f);
    PercaleMesh other = percale_test_sheet(33, 3.0f);
    percale_test_translate(&other, 0.0f, (float)(1.1 * RADIUS), 0.0f);
    for (size_t t = 0; t < other.triangle_count; t++) {
        uint32_t corner = other.triangles[3 * t];
        other.triangles[3 * t] = other.triangles[3 * t + 1];
        other.triangles[3 * t + 1] = corner;
    }
    append(&mesh, other);
    return mesh;
}

/// A sheet that is tilted, so that it isn't quite plane, or wavy.
static PercaleMesh make_sheet(float tilt, float waves)
{
    PercaleMesh mesh = percale_test_sheet(33, 3.0f);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        float *x = mesh.positions + 3 * (size_t)i;
        x[1] = 5.0f + tilt * (0.3f * x[0] + 0.7f * x[2]) + waves * sinf(9.0f * x[0]) * cosf(7.0f * x[2]);
    }
    return mesh;
}

/// Obstacles, and of how many points at least the face has to be known.
typedef struct Kind {
    PercaleMesh (*make)(void);
    int which;
    uint32_t least;
} Kind;

static PercaleMesh make_tilted(void)
{
    return make_sheet(1.0f, 0.0f);
}

static PercaleMesh make_waves(void)
{
    return make_sheet(0.0f, 0.02f);
}

static PercaleMesh make_ball(void)
{
    return percale_test_sphere(4, 1.0f);
}

static const Kind KINDS[] = {{make_ball, 0, POINTS / 6},
                             {make_tilted, 0, POINTS / 20},
                             {make_grid, 0, POINTS / 10},
                             {make_boxes, 0, 1},
                             {make_double_sheet, 0, 0},
                             {make_gap, 0, POINTS / 20},
                             {make_waves, 0, 0},
                             {NULL, 0, POINTS / 10},
                             {NULL, 1, POINTS / 10},
                             {NULL, 2, 0},
                             {NULL, 3, 0},
                             {NULL, 4, 0},
                             {NULL, 6, 0},
                             {NULL, 7, 0}};
enum { KIND_COUNT = sizeof(KINDS) / sizeof(KINDS[0]) };

/// Somewhere in front of a triangle or a little behind it.
static Vec3 random_point(const Scene *scene, uint32_t triangle, uint64_t *seed)
{
    double a = percale_test_random(seed);
    double b = percale_test_random(seed) * (1.0 - a);
    const double weights[3] = {1.0 - a - b, a, b};
    Vec3 place = percale_surface_point(&scene->surface, triangle, weights);
    double height = RADIUS * (1.1 * percale_test_random(seed) - 0.1);
    return vadd(place, vscale(height, percale_surface_face_normal(&scene->surface, triangle)));
}

/// Whether any feature but the face has the point in front of itself, among those within reach.
static bool sees_another(const Scene *scene, Vec3 point, uint32_t face, PercaleFeatureList *list)
{
    const PercaleSurface *surface = &scene->surface;
    bool sees = false;
    percale_surface_sort(surface, list);
    for (size_t first = 0, end; first < list->count; first = end) {
        const PercaleFeature *feature = &list->items[first];
        uint64_t key = percale_surface_feature_key(surface, feature->triangle, feature->closest.region);
        for (end = first; end < list->count; end++) {
            const PercaleFeature *item = &list->items[end];
            if (percale_surface_feature_key(surface, item->triangle, item->closest.region) != key) {
                break;
            }
        }
        PercaleNearest here = {feature->triangle, feature->closest,
                               percale_surface_point(surface, feature->triangle, feature->closest.weights)};
        uint32_t around = percale_surface_face_count(surface, feature->triangle, feature->closest.region);
        sees = sees || (feature->triangle != face && end - first == around &&
                        percale_surface_side(surface, point, &here) > 0);
    }
    return sees;
}

START_TEST(the_only_face_is_the_nearest_and_no_other_sees_the_point)
{
    Scene scene;
    open_scene(&scene, KINDS[_i].make != NULL ? KINDS[_i].make() : make_mesh(KINDS[_i].which));
    PercaleConvex convex = {0};
    PercaleFeatureList list = {0};
    ck_assert(percale_convex_find(&convex, &scene.surface, RADIUS, &scene.memory));
    uint64_t seed = 21;
    uint32_t known = 0;
    for (int i = 0; i < POINTS; i++) {
        uint32_t count = scene.mesh.triangle_count;
        uint32_t triangle = (uint32_t)(percale_test_random(&seed) * (double)count);
        Vec3 point = random_point(&scene, triangle, &seed);
        double reach = RADIUS * percale_test_random(&seed);
        bool near = percale_test_random(&seed) < 0.7;
        uint32_t from = near ? triangle : (uint32_t)(percale_test_random(&seed) * (double)count);
        uint32_t face = percale_convex_face(&convex, &scene.surface, point, reach, from);
        if (face == NO_TRIANGLE) {
            continue;
        }
        known++;
        PercaleNearest nearest = percale_surface_nearest(&scene.surface, point, 100.0, NO_TRIANGLE);
        PercaleNearest only = percale_surface_nearest_of(&scene.surface, point, 100.0, &face, 1);
        ck_assert_uint_eq(nearest.triangle, face);
        ck_assert_int_eq(nearest.closest.region, REGION_FACE);
        ck_assert_mem_eq(&nearest.closest, &only.closest, sizeof(double[4]));
        ck_assert(percale_surface_gather(&scene.surface, point, reach, &scene.memory, &list));
        ck_assert(!sees_another(&scene, point, face, &list));
    }
    ck_assert_msg(known >= KINDS[_i].least, "kind %d: %u", _i, known);
    percale_memory_free(&scene.memory, list.items);
    percale_convex_free(&convex, &scene.memory);
    close_scene(&scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("convex");
    TCase *cases = tcase_create("convex");
    tcase_add_loop_test(cases, the_only_face_is_the_nearest_and_no_other_sees_the_point, 0, KIND_COUNT);
    suite_add_tcase(suite, cases);
    return percale_test_run(suite);
}
