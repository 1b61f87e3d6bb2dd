// The tree's answers against all pairs, on regular, random and degenerate meshes.

#include "testing.h"

#include "detect/surface.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- an obstacle with its tree ----

enum { BYSTANDERS = 5 }; // points of another obstacle that stand before the one under test

typedef struct Scene {
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleMessage message;
    PercaleObstacleObject objects[2]; // a bystander, so that points don't begin at 0, and the mesh
    PercaleObjects all;
    PercaleModel model;
    PercaleTree tree;
    f32x4 *points;
    PercaleMesh mesh;
    PercaleSurface surface;
} Scene;

static void refit(Scene *scene, int thread_count)
{
    const PercaleModelObstacle *obstacle = &scene->model.obstacles[1];
    for (uint32_t i = 0; i < obstacle->vertex_count; i++) {
        const float *x = scene->mesh.positions + 3 * (size_t)i;
        scene->points[obstacle->first_point + i] = (f32x4){x[0], x[1], x[2], 0.0f};
    }
    percale_tree_refit(&scene->tree, obstacle->triangles, scene->points, thread_count);
}

/// Takes the mesh over. The scene must not move.
static void open_scene(Scene *scene, PercaleMesh mesh)
{
    static uint32_t bystander[3] = {0, 2, 4};
    memset(scene, 0, sizeof(*scene));
    scene->allocator = percale_allocator_default();
    scene->memory.allocator = &scene->allocator;
    scene->mesh = mesh;
    scene->objects[0] = (PercaleObstacleObject){
        .vertex_count = BYSTANDERS, .triangle_count = 1, .triangles = bystander, .thickness = 0.002f};
    scene->objects[1] = (PercaleObstacleObject){.vertex_count = mesh.vertex_count,
                                                .triangle_count = mesh.triangle_count,
                                                .triangles = mesh.triangles,
                                                .thickness = 0.002f};
    scene->all.obstacles = scene->objects;
    scene->all.obstacle_count = 2;
    PERCALE_TEST_OK(NULL,
                    percale_model_assemble(&scene->model, &scene->all, &scene->memory, &scene->message));
    scene->points = calloc(scene->model.point_count, sizeof(f32x4));
    ck_assert_ptr_nonnull(scene->points);
    const PercaleModelObstacle *obstacle = &scene->model.obstacles[1];
    for (uint32_t i = 0; i < obstacle->vertex_count; i++) {
        const float *x = mesh.positions + 3 * (size_t)i;
        scene->points[obstacle->first_point + i] = (f32x4){x[0], x[1], x[2], 0.0f};
    }
    ck_assert(percale_tree_build(&scene->tree, obstacle->triangles, obstacle->triangle_count, scene->points,
                                 &scene->memory));
    scene->surface = (PercaleSurface){obstacle, &scene->tree, scene->points};
    refit(scene, 1);
}

static void close_scene(Scene *scene)
{
    percale_tree_free(&scene->tree, &scene->memory);
    percale_model_free(&scene->model, &scene->memory);
    ck_assert_uint_eq(scene->memory.bytes, 0);
    free(scene->points);
    percale_mesh_free(&scene->mesh);
}

// ---- meshes ----

/// Uniform between -half and half, rounded to float32.
static float random_float(uint64_t *seed, double half)
{
    return (float)(half * (2.0 * percale_test_random(seed) - 1.0));
}

/// Triangles that share nothing, of all sizes; every third has no area: two corners coincide, all three do,
/// or they lie on a line.
static PercaleMesh make_soup(uint32_t triangle_count, bool degenerate, uint64_t seed)
{
    PercaleMesh mesh = {.vertex_count = 3 * triangle_count, .triangle_count = triangle_count};
    mesh.positions = calloc(9 * (size_t)triangle_count, sizeof(float));
    mesh.triangles = calloc(3 * (size_t)triangle_count, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    for (uint32_t t = 0; t < triangle_count; t++) {
        float *x = mesh.positions + 9 * (size_t)t;
        double size = pow(10.0, -3.0 * percale_test_random(&seed));
        for (uint32_t axis = 0; axis < 3; axis++) {
            float middle = random_float(&seed, 1.0);
            for (uint32_t k = 0; k < 3; k++) {
                x[3 * k + axis] = middle + random_float(&seed, size);
                mesh.triangles[3 * (size_t)t + k] = 3 * t + k;
            }
            if (degenerate && t % 3 == 0) {
                bool on_a_line = t % 9 == 6;
                x[6 + axis] = on_a_line ? 0.5f * (x[axis] + x[3 + axis]) : x[axis];
                x[3 + axis] = t % 9 == 0 ? x[axis] : x[3 + axis];
            }
        }
    }
    return mesh;
}

/// Sheet of unit cells, whose points are exact: many queries have several nearest triangles.
static PercaleMesh make_grid(void)
{
    return percale_test_sheet(17, 16.0f);
}

/// A closed mesh with dents and spikes; every ray from the origin meets it once.
static PercaleMesh make_bumpy_sphere(uint64_t seed)
{
    PercaleMesh mesh = percale_test_sphere(2, 1.0f);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        float factor = 0.6f + 0.8f * (float)percale_test_random(&seed);
        for (uint32_t axis = 0; axis < 3; axis++) {
            mesh.positions[3 * (size_t)i + axis] *= factor;
        }
    }
    return mesh;
}

/// A box whose first edge has a vertex in the middle that only one of its two faces knows: a triangle without
/// area closes the gap.
static PercaleMesh make_box_with_sliver(void)
{
    PercaleMesh box = percale_test_box(2.0f, 2.0f, 2.0f);
    PercaleMesh mesh = {.vertex_count = 9, .triangle_count = 14};
    mesh.positions = calloc(27, sizeof(float));
    mesh.triangles = calloc(42, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    memcpy(mesh.positions, box.positions, 24 * sizeof(float));
    memcpy(mesh.triangles, box.triangles, 36 * sizeof(uint32_t));
    uint32_t a = box.triangles[0];
    uint32_t b = box.triangles[1];
    uint32_t c = box.triangles[2];
    for (uint32_t axis = 0; axis < 3; axis++) {
        mesh.positions[24 + axis] = 0.5f * (box.positions[3 * a + axis] + box.positions[3 * b + axis]);
    }
    const uint32_t split[3][3] = {{a, 8, c}, {8, b, c}, {8, a, b}};
    memcpy(mesh.triangles, split[0], sizeof(split[0]));
    memcpy(mesh.triangles + 36, split[1], 2 * sizeof(split[1]));
    percale_mesh_free(&box);
    return mesh;
}

/// A sharp pyramid on a triangle. One of its sides is a fan of many slices, which at the apex outnumber the
/// other two sides, but not outweigh them: their angles are small.
static PercaleMesh make_fan(void)
{
    enum { SLICES = 24, APEX = SLICES + 1, CORNER }; // vertices 0 .. SLICES run along the base of the fan
    PercaleMesh mesh = {.vertex_count = SLICES + 3, .triangle_count = 2 * SLICES + 2};
    mesh.positions = calloc(3 * (size_t)mesh.vertex_count, sizeof(float));
    mesh.triangles = calloc(3 * (size_t)mesh.triangle_count, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    for (uint32_t i = 0; i <= SLICES; i++) {
        const float base[3] = {(float)i / SLICES - 0.5f, -0.5f, 0.3f};
        memcpy(mesh.positions + 3 * (size_t)i, base, sizeof(base));
    }
    const float rest[2][3] = {{0.0f, 1.0f, 0.0f}, {0.0f, -0.5f, -0.6f}};
    memcpy(mesh.positions + 3 * (size_t)APEX, rest, sizeof(rest));
    for (uint32_t i = 0; i < SLICES; i++) {
        const uint32_t slice[6] = {APEX, i, i + 1, CORNER, i + 1, i};
        memcpy(mesh.triangles + 6 * (size_t)i, slice, sizeof(slice));
    }
    const uint32_t sides[6] = {APEX, CORNER, 0, APEX, SLICES, CORNER};
    memcpy(mesh.triangles + 6 * (size_t)SLICES, sides, sizeof(sides));
    return mesh;
}

enum { MESH_COUNT = 8, CLOSED_COUNT = 5 };

/// The first CLOSED_COUNT meshes are closed, and every ray from the origin meets them once.
static PercaleMesh make_mesh(int which)
{
    switch (which) {
    case 0:
        return percale_test_sphere(2, 1.0f);
    case 1:
        return percale_test_box(2.0f, 2.0f, 2.0f);
    case 2:
        return make_bumpy_sphere(11);
    case 3:
        return make_box_with_sliver();
    case 4:
        return make_fan();
    case 5:
        return make_grid();
    case 6:
        return make_soup(400, false, 3);
    default:
        return make_soup(333, true, 5);
    }
}

static Vec3 vertex_of(const PercaleMesh *mesh, uint32_t vertex)
{
    const float *x = mesh->positions + 3 * (size_t)vertex;
    return vec3((double)x[0], (double)x[1], (double)x[2]);
}

static void corners_of(const PercaleMesh *mesh, uint32_t triangle, Vec3 corners[3])
{
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = vertex_of(mesh, mesh->triangles[3 * (size_t)triangle + k]);
    }
}

/// A point that the tree may be asked about: anywhere near, on a vertex, or on or just off an edge.
static Vec3 make_query(const PercaleMesh *mesh, int i, uint64_t *seed)
{
    Vec3 corners[3];
    corners_of(mesh, (uint32_t)(percale_test_random(seed) * mesh->triangle_count), corners);
    float reach = mesh->triangle_count == 512 ? 9.0f : 2.0f;
    f32x4 anywhere = {random_float(seed, (double)reach), random_float(seed, (double)reach),
                      random_float(seed, (double)reach), 0.0f};
    f32x4 near_edge = f32x4_of(vscale(0.5, vadd(corners[0], corners[1])), 0.0f);
    near_edge[1] += 0.25f * (float)(i % 8 / 4);
    return i % 4 == 0 ? corners[0] : i % 4 == 1 ? vec3_of(near_edge) : vec3_of(anywhere);
}

// ---- slow twins ----

static PercaleNearest nearest_by_all_pairs(const PercaleMesh *mesh, Vec3 point, double radius)
{
    PercaleNearest best = {NO_TRIANGLE, {radius * radius, {0.0, 0.0, 0.0}, REGION_FACE}, {0.0, 0.0, 0.0}};
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        Vec3 c[3];
        corners_of(mesh, t, c);
        PercaleClosest closest = percale_closest_on_triangle(point, c[0], c[1], c[2]);
        bool is_first = best.triangle == NO_TRIANGLE;
        if (closest.distance2 < best.closest.distance2 ||
            (is_first && closest.distance2 <= best.closest.distance2)) {
            best.triangle = t;
            best.closest = closest;
        }
    }
    return best;
}

/// Signed solid angle of all triangles over 4 pi (Van Oosterom and Strackee 1983): 1 inside, 0 outside.
static double winding_number(const PercaleMesh *mesh, Vec3 point)
{
    double sum = 0.0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        Vec3 c[3];
        corners_of(mesh, t, c);
        for (int k = 0; k < 3; k++) {
            c[k] = vsub(c[k], point);
        }
        double la = vlength(c[0]);
        double lb = vlength(c[1]);
        double lc = vlength(c[2]);
        double volume = vdot(c[0], vcross(c[1], c[2]));
        double rest = la * lb * lc + vdot(c[0], c[1]) * lc + vdot(c[1], c[2]) * la + vdot(c[2], c[0]) * lb;
        sum += 2.0 * atan2(volume, rest);
    }
    return sum / (4.0 * 3.14159265358979323846);
}

/// Where the path from a to b passes a triangle from its front (Moeller and Trumbore 1997). *certain is false
/// when rounding could change the answer.
static bool crosses(const Vec3 c[3], Vec3 a, Vec3 b, double *time, bool *certain)
{
    const double MARGIN = 1e-9;
    Vec3 u = vsub(c[1], c[0]);
    Vec3 v = vsub(c[2], c[0]);
    Vec3 d = vsub(b, a);
    Vec3 h = vcross(d, v);
    double determinant = vdot(u, h); // > 0 against the normal
    *certain = true;
    if (!(determinant > 0.0)) {
        *certain = fabs(determinant) > MARGIN * vlength(u) * vlength(h) || vlength(vcross(u, v)) <= 0.0;
        return false;
    }
    Vec3 s = vsub(a, c[0]);
    double first = vdot(s, h) / determinant;
    double second = vdot(d, vcross(s, u)) / determinant;
    *time = vdot(v, vcross(s, u)) / determinant;
    double inside = fmin(fmin(first, second), 1.0 - first - second);
    double within = fmin(*time, 1.0 - *time);
    *certain = fabs(inside) > MARGIN && fabs(within) > MARGIN;
    return inside >= 0.0 && within >= 0.0;
}

static PercaleCrossing crossing_by_all_pairs(const PercaleMesh *mesh, Vec3 a, Vec3 b, bool *certain)
{
    PercaleCrossing best = {NO_TRIANGLE, 1.0, {0.0, 0.0, 0.0}};
    *certain = true;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        Vec3 c[3];
        corners_of(mesh, t, c);
        double time = 0.0;
        bool here;
        bool hit = crosses((const Vec3 *)c, a, b, &time, &here);
        *certain = *certain && here;
        if (hit && (best.triangle == NO_TRIANGLE || time < best.time)) {
            best.triangle = t;
            best.time = time;
        }
    }
    return best;
}

// ---- laws ----

enum { QUERIES = 600 };

static void expect_nearest(const Scene *scene, Vec3 point, double radius, uint32_t seed_triangle)
{
    PercaleNearest expected = nearest_by_all_pairs(&scene->mesh, point, radius);
    PercaleNearest found = percale_surface_nearest(&scene->surface, point, radius, seed_triangle);
    if (found.triangle != expected.triangle) {
        ck_abort_msg("(%.9g, %.9g, %.9g) within %g, seed %u: triangle %u, the twin says %u", point.x, point.y,
                     point.z, radius, seed_triangle, found.triangle, expected.triangle);
    }
    if (found.triangle == NO_TRIANGLE) {
        return;
    }
    ck_assert_mem_eq(&found.closest.distance2, &expected.closest.distance2, sizeof(double));
    ck_assert_mem_eq(found.closest.weights, expected.closest.weights, sizeof(found.closest.weights));
    ck_assert_int_eq((int)found.closest.region, (int)expected.closest.region);
    double distance = vlength(vsub(point, found.foot));
    ck_assert_double_eq_tol(distance, sqrt(found.closest.distance2), 1e-12);
}

START_TEST(nearest_equals_all_pairs)
{
    Scene scene;
    uint64_t seed = 17;
    open_scene(&scene, make_mesh(_i));
    for (int i = 0; i < QUERIES; i++) {
        Vec3 point = make_query(&scene.mesh, i, &seed);
        double radius = i % 3 == 0 ? 100.0 : percale_test_random(&seed);
        uint32_t any = (uint32_t)(percale_test_random(&seed) * scene.mesh.triangle_count);
        expect_nearest(&scene, point, radius, NO_TRIANGLE);
        expect_nearest(&scene, point, radius, any);
        expect_nearest(&scene, point, radius, scene.mesh.triangle_count - 1);
    }
    close_scene(&scene);
}
END_TEST

/// The triangles of the list in ascending order must be those of all pairs.
static void expect_gathered(const Scene *scene, Vec3 point, double radius, const PercaleFeatureList *list)
{
    size_t expected_count = 0;
    for (uint32_t t = 0; t < scene->mesh.triangle_count; t++) {
        Vec3 c[3];
        corners_of(&scene->mesh, t, c);
        PercaleClosest closest = percale_closest_on_triangle(point, c[0], c[1], c[2]);
        bool is_near = closest.distance2 <= radius * radius;
        size_t times = 0;
        for (size_t i = 0; i < list->count; i++) {
            if (list->items[i].triangle == t) {
                times++;
                ck_assert_mem_eq(&list->items[i].closest.distance2, &closest.distance2, sizeof(double));
                ck_assert_int_eq((int)list->items[i].closest.region, (int)closest.region);
            }
        }
        if (times != (size_t)is_near) {
            ck_abort_msg("(%.9g, %.9g, %.9g) within %.9g: triangle %u at %.17g is named %zu times", point.x,
                         point.y, point.z, radius, t, sqrt(closest.distance2), times);
        }
        expected_count += is_near;
    }
    ck_assert_uint_eq(list->count, expected_count);
}

START_TEST(gather_finds_each_triangle_within_the_radius_once)
{
    Scene scene;
    PercaleFeatureList list = {0};
    PercaleFeatureList again = {0};
    uint64_t seed = 23;
    open_scene(&scene, make_mesh(_i));
    for (int i = 0; i < QUERIES / 3; i++) {
        Vec3 point = make_query(&scene.mesh, i, &seed);
        double radius = i % 5 == 0 ? 1.0 : 0.5 * percale_test_random(&seed); // 1: exact on the grid
        ck_assert(percale_surface_gather(&scene.surface, point, radius, &scene.memory, &list));
        expect_gathered(&scene, point, radius, &list);
        ck_assert(percale_surface_gather(&scene.surface, point, radius, &scene.memory, &again));
        for (size_t k = 0; k < list.count; k++) {
            ck_assert_uint_eq(list.items[k].triangle, again.items[k].triangle);
        }
    }
    percale_memory_free(&scene.memory, list.items);
    percale_memory_free(&scene.memory, again.items);
    close_scene(&scene);
}
END_TEST

// A contact is looked for at points that only doubles can name. 100 m from the origin a float32 position is
// good for 4 um, 1 % of the distances asked for here.
START_TEST(points_between_floats_lose_no_triangle)
{
    Scene scene;
    PercaleFeatureList list = {0};
    uint64_t seed = 29;
    PercaleMesh mesh = percale_test_box(2.0f, 2.0f, 2.0f); // boxes as thin as their faces
    percale_test_translate(&mesh, 100.1f, -100.3f, 80.7f);
    open_scene(&scene, mesh);
    for (int i = 0; i < QUERIES; i++) {
        uint32_t triangle = (uint32_t)(percale_test_random(&seed) * mesh.triangle_count);
        Vec3 normal = percale_surface_face_normal(&scene.surface, triangle);
        const double MIDDLE[3] = {0.3, 0.3, 0.4};
        Vec3 foot = percale_surface_point(&scene.surface, triangle, MIDDLE);
        double height = 4e-4 * percale_test_random(&seed);
        Vec3 point = vadd(foot, vscale(height, normal));
        double radius = height * (1.0 + 1e-6);
        expect_nearest(&scene, point, radius + 1e-12, NO_TRIANGLE);
        ck_assert(percale_surface_gather(&scene.surface, point, radius + 1e-12, &scene.memory, &list));
        expect_gathered(&scene, point, radius + 1e-12, &list);
    }
    percale_memory_free(&scene.memory, list.items);
    close_scene(&scene);
}
END_TEST

START_TEST(a_refit_tree_equals_all_pairs)
{
    Scene scene;
    uint64_t seed = 31;
    open_scene(&scene, make_mesh(_i));
    for (int round = 0; round < 3; round++) {
        for (uint32_t i = 0; i < 3 * scene.mesh.vertex_count; i++) {
            scene.mesh.positions[i] += random_float(&seed, round == 2 ? 3.0 : 0.2); // at last, a crumple
        }
        refit(&scene, 1 + 2 * round);
        for (int i = 0; i < QUERIES / 6; i++) {
            expect_nearest(&scene, make_query(&scene.mesh, i, &seed), 100.0, NO_TRIANGLE);
        }
    }
    close_scene(&scene);
}
END_TEST

START_TEST(refit_gives_the_same_boxes_for_any_thread_count)
{
    enum { TRIANGLES = 20000 }; // enough for several threads
    Scene scene;
    open_scene(&scene, make_soup(TRIANGLES, true, 37));
    uint32_t top = scene.tree.level_count - 1;
    size_t size = (scene.tree.level_first[top] + scene.tree.level_size[top]) * sizeof(PercaleTreeNode);
    PercaleTreeNode *alone = malloc(size);
    ck_assert_ptr_nonnull(alone);
    memcpy(alone, scene.tree.nodes, size);
    memset(scene.tree.nodes, 0, size);
    refit(&scene, 7);
    ck_assert(memcmp(alone, scene.tree.nodes, size) == 0);
    free(alone);
    close_scene(&scene);
}
END_TEST

START_TEST(the_side_of_a_closed_mesh_is_its_winding_number)
{
    const double NEAR = 1e-9; // m; nearer to the surface the winding number itself is rounding
    Scene scene;
    uint64_t seed = 41;
    int inside_count = 0;
    int outside_count = 0;
    open_scene(&scene, make_mesh(_i));
    ck_assert(scene.surface.mesh->closed);
    for (int i = 0; i < 8 * QUERIES; i++) {
        Vec3 point = make_query(&scene.mesh, 2, &seed);
        if (i % 2 == 0) { // just off a vertex, an edge or a face
            point = make_query(&scene.mesh, i % 8 < 4 ? 0 : 1, &seed);
            point.x += (double)random_float(&seed, 1e-3);
            point.y += (double)random_float(&seed, 1e-3);
            point.z += (double)random_float(&seed, 1e-3);
        }
        PercaleNearest nearest = percale_surface_nearest(&scene.surface, point, 100.0, NO_TRIANGLE);
        if (nearest.closest.distance2 <= NEAR * NEAR) {
            continue;
        }
        bool inside = winding_number(&scene.mesh, point) > 0.5;
        inside_count += inside;
        outside_count += !inside;
        if (percale_surface_side(&scene.surface, point, &nearest) != (inside ? -1 : 1)) {
            ck_abort_msg("(%.9g, %.9g, %.9g) is %s, but not by triangle %u, region %d", point.x, point.y,
                         point.z, inside ? "inside" : "outside", nearest.triangle,
                         (int)nearest.closest.region);
        }
    }
    ck_assert_int_gt(inside_count, QUERIES);
    ck_assert_int_gt(outside_count, QUERIES);
    close_scene(&scene);
}
END_TEST

START_TEST(a_point_on_the_surface_is_outside)
{
    Scene scene;
    open_scene(&scene, percale_test_box(2.0f, 2.0f, 2.0f));
    for (uint32_t t = 0; t < scene.mesh.triangle_count; t++) {
        Vec3 c[3];
        corners_of(&scene.mesh, t, c);
        const Vec3 points[3] = {c[0], vscale(0.5, vadd(c[0], c[1])),
                                vadd(vscale(0.5, c[0]), vscale(0.25, vadd(c[1], c[2])))};
        for (int k = 0; k < 3; k++) {
            PercaleNearest nearest = percale_surface_nearest(&scene.surface, points[k], 1.0, NO_TRIANGLE);
            ck_assert_double_eq(nearest.closest.distance2, 0.0);
            ck_assert_int_eq(percale_surface_side(&scene.surface, points[k], &nearest), 1);
        }
    }
    close_scene(&scene);
}
END_TEST

START_TEST(first_crossing_equals_all_pairs)
{
    Scene scene;
    uint64_t seed = 43;
    int crossing_count = 0;
    open_scene(&scene, make_mesh(_i));
    for (int i = 0; i < 4 * QUERIES; i++) {
        Vec3 a = make_query(&scene.mesh, 2, &seed);
        Vec3 b = make_query(&scene.mesh, 2, &seed);
        bool certain;
        PercaleCrossing expected = crossing_by_all_pairs(&scene.mesh, a, b, &certain);
        PercaleCrossing found = percale_surface_first_crossing(&scene.surface, a, b);
        if (!certain) {
            continue;
        }
        ck_assert_uint_eq(found.triangle, expected.triangle);
        if (found.triangle != NO_TRIANGLE) {
            crossing_count++;
            ck_assert_double_eq_tol(found.time, expected.time, 1e-9);
            Vec3 met = percale_surface_point(&scene.surface, found.triangle, found.weights);
            Vec3 on_path = vadd(a, vscale(found.time, vsub(b, a)));
            ck_assert_double_lt(vlength(vsub(met, on_path)), 1e-9);
        }
    }
    ck_assert_int_gt(crossing_count, QUERIES / 2);
    close_scene(&scene);
}
END_TEST

/// A path from far outside to the inside, straight at `target`.
static void expect_crossing_at(const Scene *scene, Vec3 target, Vec3 inside)
{
    Vec3 outside = vadd(inside, vscale(4.0, vsub(target, inside)));
    PercaleCrossing crossing = percale_surface_first_crossing(&scene->surface, outside, inside);
    if (crossing.triangle == NO_TRIANGLE) {
        ck_abort_msg("a path from (%.17g, %.17g, %.17g) to (%.17g, %.17g, %.17g) slips through", outside.x,
                     outside.y, outside.z, inside.x, inside.y, inside.z);
    }
}

START_TEST(paths_at_edges_and_vertices_find_no_gap)
{
    Scene scene;
    uint64_t seed = 47;
    PercaleMesh mesh = make_mesh(_i);
    f32x4 shift = {0};
    for (int round = 0; round < 2; round++) { // at the origin, then 1 km away
        if (round == 1) {
            mesh = make_mesh(_i);
            shift = (f32x4){1000.0f, -700.0f, 300.0f, 0.0f};
            percale_test_translate(&mesh, shift[0], shift[1], shift[2]);
        }
        open_scene(&scene, mesh);
        Vec3 middle = vec3_of(shift);
        for (int i = 0; i < 20; i++) {
            Vec3 inside = middle; // at first the exact middle
            if (i > 0) {
                inside.x += (double)random_float(&seed, 0.05);
                inside.y += (double)random_float(&seed, 0.05);
                inside.z += (double)random_float(&seed, 0.05);
            }
            for (uint32_t side = 0; side < 3 * mesh.triangle_count; side++) {
                Vec3 c[3];
                corners_of(&mesh, side / 3, c);
                Vec3 p = c[side % 3];
                Vec3 q = c[(side + 1) % 3];
                double t = i % 4 == 0 ? 0.5 : percale_test_random(&seed);
                expect_crossing_at(&scene, p, inside);
                expect_crossing_at(&scene, vadd(vscale(1.0 - t, p), vscale(t, q)), inside);
            }
        }
        close_scene(&scene);
    }
}
END_TEST

// From the back nothing is crossed, and a path that ends on the surface has not passed it.
START_TEST(a_path_crosses_from_the_front_only)
{
    Scene scene;
    open_scene(&scene, percale_test_box(2.0f, 2.0f, 2.0f));
    Vec3 above = vec3(0.25, 3.0, 0.125);
    Vec3 on_top = vec3(0.25, 1.0, 0.125);
    Vec3 within = vec3(0.25, 0.5, 0.125);
    ck_assert_uint_eq(percale_surface_first_crossing(&scene.surface, within, above).triangle, NO_TRIANGLE);
    ck_assert_uint_eq(percale_surface_first_crossing(&scene.surface, above, on_top).triangle, NO_TRIANGLE);
    ck_assert_double_eq(percale_surface_first_crossing(&scene.surface, above, within).time, 0.8);
    ck_assert_double_eq(percale_surface_first_crossing(&scene.surface, on_top, within).time, 0.0);
    close_scene(&scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("tree");
    TCase *twins = tcase_create("twins");
    tcase_add_loop_test(twins, nearest_equals_all_pairs, 0, MESH_COUNT);
    tcase_add_loop_test(twins, gather_finds_each_triangle_within_the_radius_once, 0, MESH_COUNT);
    tcase_add_loop_test(twins, a_refit_tree_equals_all_pairs, 0, MESH_COUNT);
    tcase_add_test(twins, points_between_floats_lose_no_triangle);
    tcase_add_test(twins, refit_gives_the_same_boxes_for_any_thread_count);
    tcase_add_loop_test(twins, the_side_of_a_closed_mesh_is_its_winding_number, 0, CLOSED_COUNT);
    tcase_add_loop_test(twins, first_crossing_equals_all_pairs, 0, MESH_COUNT - 1);
    suite_add_tcase(suite, twins);
    TCase *surface = tcase_create("surface");
    tcase_add_test(surface, a_point_on_the_surface_is_outside);
    tcase_add_loop_test(surface, paths_at_edges_and_vertices_find_no_gap, 0, CLOSED_COUNT);
    tcase_add_test(surface, a_path_crosses_from_the_front_only);
    suite_add_tcase(suite, surface);
    return percale_test_run(suite);
}
