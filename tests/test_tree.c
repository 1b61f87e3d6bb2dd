// The tree's nearest and gathered triangles against all pairs, on regular, random and degenerate meshes.

#include "surface_testing.h"

enum { QUERIES = 600 };

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

/// The same bits.
static bool is_same(const PercaleClosest *a, const PercaleClosest *b)
{
    bool same = a->region == b->region && a->distance2 == b->distance2;
    for (int k = 0; k < 3; k++) {
        same = same && a->weights[k] == b->weights[k];
    }
    return same;
}

static void expect_nearest(const Scene *scene, Vec3 point, double radius, uint32_t seed_triangle)
{
    PercaleNearest expected = nearest_by_all_pairs(&scene->mesh, point, radius);
    PercaleNearest found = percale_surface_nearest(&scene->surface, point, radius, seed_triangle);
    if (found.triangle != expected.triangle) {
        ck_abort_msg("(%.9g, %.9g, %.9g) within %g, seed %u: triangle %u, the twin says %u", point.x, point.y,
                     point.z, radius, seed_triangle, found.triangle, expected.triangle);
    }
    if (found.triangle ==
        NO_TRIANGLE) { // nothing is nearer than it says, and it says no less than it was asked
        double nearest2 = nearest_by_all_pairs(&scene->mesh, point, 1e6).closest.distance2;
        if (!(found.closest.distance2 <= nearest2) || !(found.closest.distance2 >= radius * radius)) {
            ck_abort_msg("(%.9g, %.9g, %.9g): nothing within %.9g, it says, beyond %.9g, the twin %.9g",
                         point.x, point.y, point.z, radius, sqrt(found.closest.distance2), sqrt(nearest2));
        }
        return;
    }
    double distance = vlength(vsub(point, found.foot));
    if (!is_same(&found.closest, &expected.closest) ||
        !(fabs(distance - sqrt(found.closest.distance2)) <= 1e-12)) {
        ck_abort_msg(
            "triangle %u is at %.17g in region %d, the twin says %.17g in region %d; its foot is %.17g",
            found.triangle, sqrt(found.closest.distance2), (int)found.closest.region,
            sqrt(expected.closest.distance2), (int)expected.closest.region, distance);
    }
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
            times += list->items[i].triangle == t && is_same(&list->items[i].closest, &closest);
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

int main(void)
{
    Suite *suite = suite_create("tree");
    TCase *twins = tcase_create("twins");
    tcase_add_loop_test(twins, nearest_equals_all_pairs, 0, MESH_COUNT);
    tcase_add_loop_test(twins, gather_finds_each_triangle_within_the_radius_once, 0, MESH_COUNT);
    tcase_add_loop_test(twins, a_refit_tree_equals_all_pairs, 0, MESH_COUNT);
    tcase_add_test(twins, points_between_floats_lose_no_triangle);
    tcase_add_test(twins, refit_gives_the_same_boxes_for_any_thread_count);
    suite_add_tcase(suite, twins);
    return percale_test_run(suite);
}
