// The side of a point and the crossings of a path against slow twins; no path slips through a closed mesh.

#include "surface_testing.h"

enum { QUERIES = 600 };

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
    ck_assert_int_gt(crossing_count, QUERIES / 4);
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
    Suite *suite = suite_create("surface");
    TCase *side = tcase_create("side");
    tcase_add_loop_test(side, the_side_of_a_closed_mesh_is_its_winding_number, 0, CLOSED_COUNT);
    tcase_add_test(side, a_point_on_the_surface_is_outside);
    suite_add_tcase(suite, side);
    TCase *crossing = tcase_create("crossing");
    tcase_add_loop_test(crossing, first_crossing_equals_all_pairs, 0, MESH_COUNT - 1);
    tcase_add_loop_test(crossing, paths_at_edges_and_vertices_find_no_gap, 0, CLOSED_COUNT);
    tcase_add_test(crossing, a_path_crosses_from_the_front_only);
    suite_add_tcase(suite, crossing);
    return percale_test_run(suite);
}
