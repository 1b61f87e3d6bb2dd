// Where an obstacle is flat to the cloth (detect/flat.h): what lies between places of it doesn't go deep
// below it.

#include "detect/flat.h"
#include "surface_testing.h"

static const double LENGTH = 0.05; // m, of the cloth's edges
static const double DROP = 5e-4;   // m
static const double MOST = 2.5; // drops; flat.h: within half a length one, beyond it a quarter of up to four

enum { SIDE = 41 }; // vertices of the hills' sides; 20 mm apart

static PercaleFlat flat_of(const Scene *scene)
{
    PercaleFlat flat = {0};
    PercaleMemory memory = {&scene->allocator, 0};
    ck_assert(percale_flat_find(scene->surface.mesh, scene->points, LENGTH, DROP, &flat, &memory));
    return flat;
}

static void free_flat(const Scene *scene, PercaleFlat *flat)
{
    PercaleMemory memory = {&scene->allocator, 0};
    percale_flat_free(flat, &memory);
}

static uint32_t count_flat(const uint8_t *flat, uint32_t count)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        sum += flat[i];
    }
    return sum;
}

/// A sheet of 0.8 m with hills, which are steeper towards one side, and a few bumps.
static PercaleMesh make_hills(uint64_t seed)
{
    PercaleMesh mesh = percale_test_sheet(SIDE, 0.8f);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        float *x = mesh.positions + 3 * (size_t)i;
        double steep = pow(((double)x[0] + 0.4) / 0.8, 2.0);
        double height = 0.02 * steep * sin(16.0 * (double)x[0]) * cos(14.0 * (double)x[2]);
        bool is_bump = percale_test_random(&seed) < 0.02;
        x[1] = (float)(height + (is_bump ? 2e-3 * percale_test_random(&seed) : 0.0));
    }
    return mesh;
}

static Vec3 place_of(const Scene *scene, uint32_t vertex)
{
    return vec3_of(scene->points[scene->surface.mesh->first_point + vertex]);
}

/// A place on a random triangle.
static Vec3 random_place(const Scene *scene, uint64_t *seed)
{
    const PercaleModelSurface *mesh = scene->surface.mesh;
    const uint32_t *corners =
        mesh->triangles + 3 * (size_t)(percale_test_random(seed) * (double)mesh->triangle_count);
    double a = percale_test_random(seed);
    double b = percale_test_random(seed) * (1.0 - a);
    Vec3 place = vscale(1.0 - a - b, vec3_of(scene->points[corners[0]]));
    place = vadd(place, vscale(a, vec3_of(scene->points[corners[1]])));
    return vadd(place, vscale(b, vec3_of(scene->points[corners[2]])));
}

/// How far a segment goes below an edge, seen from above; -HUGE_VAL where they don't cross.
static double depth_below(Vec3 a, Vec3 b, Vec3 c, Vec3 d)
{
    double turn = (b.x - a.x) * (d.z - c.z) - (b.z - a.z) * (d.x - c.x);
    if (turn == 0.0) {
        return -HUGE_VAL;
    }
    double s = ((c.x - a.x) * (d.z - c.z) - (c.z - a.z) * (d.x - c.x)) / turn;
    double t = ((c.x - a.x) * (b.z - a.z) - (c.z - a.z) * (b.x - a.x)) / turn;
    bool cross = s >= 0.0 && s <= 1.0 && t >= 0.0 && t <= 1.0;
    return cross ? (c.y + t * (d.y - c.y)) - (a.y + s * (b.y - a.y)) : -HUGE_VAL;
}

/// The deepest that anything goes below what isn't flat, and below what is.
static void expect_depths(const double deepest[2])
{
    ck_assert_msg(deepest[1] <= MOST * DROP, "%g below what is flat", deepest[1]);
    ck_assert_msg(deepest[1] > 0.3 * DROP, "%g", deepest[1]);
    ck_assert_msg(deepest[0] > MOST * DROP, "%g below others", deepest[0]);
}

/// A segment between places of the surface goes below a flat edge by no more than is said, and below others
/// by more.
START_TEST(an_edge_between_places_of_the_surface_stays_near_what_is_flat)
{
    Scene scene;
    open_scene(&scene, make_hills(5));
    PercaleFlat flat = flat_of(&scene);
    const PercaleEdges *edges = &scene.surface.mesh->edges;
    uint32_t flat_count = count_flat(flat.edges, edges->edge_count);
    ck_assert_uint_gt(flat_count, edges->edge_count / 5);
    ck_assert_uint_lt(flat_count, edges->edge_count * 4 / 5);
    uint64_t seed = 3;
    double deepest[2] = {0.0, 0.0}; // below others, below what is flat
    for (int i = 0; i < 40000; i++) {
        Vec3 a = random_place(&scene, &seed);
        Vec3 b = random_place(&scene, &seed);
        Vec3 way = vsub(b, a);
        b = vadd(a, vscale(fmin(1.0, LENGTH / vlength(way)), way));
        b = percale_surface_nearest(&scene.surface, b, 1.0, NO_TRIANGLE).foot;
        if (vlength(vsub(b, a)) > LENGTH) {
            continue;
        }
        for (uint32_t e = 0; e < edges->edge_count; e++) {
            double depth = depth_below(a, b, place_of(&scene, edges->vertices[e][0]),
                                       place_of(&scene, edges->vertices[e][1]));
            deepest[flat.edges[e]] = fmax(deepest[flat.edges[e]], depth);
        }
    }
    expect_depths(deepest);
    free_flat(&scene, &flat);
    close_scene(&scene);
}
END_TEST

/// Places around a vertex, on the surface, that an edge's length is apart at most: the triangle between them
/// goes below it by no more than is said.
START_TEST(a_face_between_places_of_the_surface_stays_near_what_is_flat)
{
    Scene scene;
    open_scene(&scene, make_hills(7));
    PercaleFlat flat = flat_of(&scene);
    uint64_t seed = 11;
    double deepest[2] = {0.0, 0.0};
    for (uint32_t v = 0; v < scene.surface.mesh->vertex_count; v++) {
        Vec3 middle = place_of(&scene, v);
        for (int i = 0; i < 40; i++) {
            Vec3 corners[3];
            double weights[3]; // with which the vertex is the corners' mean, seen from above
            double longest = 0.0;
            double angle = 6.3 * percale_test_random(&seed);
            for (int k = 0; k < 3; k++) {
                double radius = LENGTH * (0.05 + 0.6 * percale_test_random(&seed));
                angle += 1.6 + percale_test_random(&seed);
                Vec3 above = vadd(middle, vec3(radius * cos(angle), 0.0, radius * sin(angle)));
                corners[k] = percale_surface_nearest(&scene.surface, above, 1.0, NO_TRIANGLE).foot;
            }
            double area = 0.0;
            for (int k = 0; k < 3; k++) {
                Vec3 b = vsub(corners[(k + 1) % 3], middle);
                Vec3 c = vsub(corners[(k + 2) % 3], middle);
                weights[k] = b.z * c.x - b.x * c.z;
                area += weights[k];
                longest = fmax(longest, vlength(vsub(b, c)));
            }
            bool inside = area != 0.0;
            double depth = middle.y;
            for (int k = 0; k < 3; k++) {
                inside = inside && weights[k] / area >= 0.0;
                depth -= weights[k] / area * corners[k].y;
            }
            if (inside && longest <= LENGTH) {
                deepest[flat.vertices[v]] = fmax(deepest[flat.vertices[v]], depth);
            }
        }
    }
    expect_depths(deepest);
    free_flat(&scene, &flat);
    close_scene(&scene);
}
END_TEST

/// On a plane all is flat but what is nearer than a length to its rim; a valley is flat, a ridge isn't.
START_TEST(rims_and_ridges_are_not_flat)
{
    Scene scene;
    open_scene(&scene, percale_test_sheet(SIDE, 0.8f));
    PercaleFlat flat = flat_of(&scene);
    for (uint32_t v = 0; v < scene.surface.mesh->vertex_count; v++) {
        Vec3 place = place_of(&scene, v);
        double inward = 0.4 - fmax(fabs(place.x), fabs(place.z));
        ck_assert_int_eq(flat.vertices[v], inward > LENGTH);
    }
    free_flat(&scene, &flat);
    close_scene(&scene);
    for (int valley = 0; valley < 2; valley++) {
        PercaleMesh mesh = percale_test_sheet(SIDE, 0.8f);
        for (uint32_t i = 0; i < mesh.vertex_count; i++) {
            float *x = mesh.positions + 3 * (size_t)i;
            x[1] = (valley ? 0.1f : -0.1f) * fabsf(x[0]);
        }
        open_scene(&scene, mesh);
        flat = flat_of(&scene);
        for (uint32_t v = 0; v < scene.surface.mesh->vertex_count; v++) {
            Vec3 place = place_of(&scene, v);
            if (fabs(place.z) < 0.3 && fabs(place.x) < 1e-3) {
                ck_assert_int_eq(flat.vertices[v], valley);
            }
        }
        free_flat(&scene, &flat);
        close_scene(&scene);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("flat");
    TCase *cases = tcase_create("flat");
    tcase_add_test(cases, an_edge_between_places_of_the_surface_stays_near_what_is_flat);
    tcase_add_test(cases, a_face_between_places_of_the_surface_stays_near_what_is_flat);
    tcase_add_test(cases, rims_and_ridges_are_not_flat);
    suite_add_tcase(suite, cases);
    return percale_test_run(suite);
}
