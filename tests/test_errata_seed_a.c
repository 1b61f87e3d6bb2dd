// What source document A prints against what is right: the right form passes a central difference, the
// printed one fails it. The table is in MATH.md.

#include "errata_testing.h"

#include "solve/solve_arrays.h"

#include <math.h>

/// One projection of a contact by the engine: a vertex of 1 kg at `height` over a fixed face in the plane z =
/// 0 that keeps h; returns its new height.
static double project_height(double height, float h)
{
    f32x4 x[POINTS] = {{0.25f, 0.25f, (float)height, 1.0f},
                       {0.0f, 0.0f, 0.0f, 0.0f},
                       {1.0f, 0.0f, 0.0f, 0.0f},
                       {0.0f, 1.0f, 0.0f, 0.0f}};
    f32x4 start[POINTS];
    memcpy(start, x, sizeof(start));
    PercaleStencil stencil = {
        .points = {0, 1, 2, 3}, .weights = {1.0f, -0.5f, -0.25f, -0.25f}, .normal = {0.0f, 0.0f, 1.0f, h}};
    const uint32_t order = 0;
    PercaleSolveArrays arrays = {
        .x = x, .start = start, .dt = 1e-3f, .stencils = &stencil, .stencil_order = &order};
    percale_solve_contact(&arrays, 0, 1);
    return (double)x[0][2];
}

START_TEST(erratum_a1_printed_sign_doubles_the_penetration)
{
    const double H = 0.002;
    for (int i = 0; i < 7; i++) {
        double depth = 1e-4 * (1 << i);
        double d = H - depth;
        double printed = d + (d - H);
        ck_assert_double_eq_tol(project_height(d, (float)H), H, 1e-9);
        ck_assert_double_eq_tol(H - printed, 2.0 * depth, 1e-15);
    }
}
END_TEST

// Without the condition a projection pulls what is far away down to the surface.
START_TEST(erratum_a6_a_contact_only_pushes)
{
    const double H = 0.002;
    for (int i = 0; i < 14; i++) {
        double gap = 1e-4 * (1 << i);
        double d = (double)(float)(H + gap);
        double unconditional = d + (H - d);
        ck_assert_double_eq(project_height(d, (float)H), d);
        ck_assert_double_lt(unconditional, d - 0.9 * gap);
    }
}
END_TEST

/// Seed A's gradients of the vertex-face constraint, as printed or as they are.
static void seed_a_gradient(const Vec3 x[POINTS], double side, bool printed, Vec3 gradient[POINTS])
{
    Vec3 m = face_area_normal(x);
    Vec3 k = vunit(m);
    gradient[0] = vscale(side, k);
    if (printed) {
        Vec3 n = vscale(side, k);
        gradient[1] = vadd(vcross(x[3], x[0]), vscale(vdot(n, x[0]), vcross(n, x[3])));
        gradient[2] = vadd(vcross(x[2], x[0]), vscale(vdot(n, x[0]), vcross(n, x[2])));
        gradient[3] = vscale(-1.0, vadd(gradient[0], vadd(gradient[1], gradient[2])));
        return;
    }
    Vec3 q = vsub(x[0], x[1]);
    Vec3 p2 = vsub(x[2], x[1]);
    Vec3 p3 = vsub(x[3], x[1]);
    double scale = side / vlength(m);
    gradient[2] = vscale(scale, vadd(vcross(p3, q), vscale(vdot(k, q), vcross(k, p3))));
    gradient[3] = vscale(-scale, vadd(vcross(p2, q), vscale(vdot(k, q), vcross(k, p2))));
    gradient[1] = vscale(-1.0, vadd(gradient[0], vadd(gradient[2], gradient[3])));
}

START_TEST(erratum_a2_printed_face_gradients_fail)
{
    uint64_t seed = 2;
    for (int trial = 0; trial < TRIALS; trial++) {
        double b[3] = {2.0 * percale_test_random(&seed) - 0.5, 2.0 * percale_test_random(&seed) - 0.5, 0.0};
        b[2] = 1.0 - b[0] - b[1];
        Setting setting = {.side = trial % 2 == 0 ? 1.0 : -1.0};
        Vec3 x[POINTS];
        make_face(&seed, b, percale_test_random(&seed) - 0.5, x);
        Vec3 expected[POINTS];
        Vec3 right[POINTS];
        Vec3 printed[POINTS];
        differentiate(plane_distance, &setting, x, STEP, expected);
        seed_a_gradient(x, setting.side, false, right);
        seed_a_gradient(x, setting.side, true, printed);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
        ck_assert_double_gt(error_of((const Vec3 *)printed, (const Vec3 *)expected), WRONG);
        // at the foot of the perpendicular it is just the signed weights times the normal
        foot_weights(x, setting.weights);
        stencil_gradient(vscale(setting.side, vunit(face_area_normal(x))), setting.weights, right);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
    }
}
END_TEST

// Equation 1 doesn't depend on which point of the plane is taken, and so sees contacts beside the face.
START_TEST(erratum_a4_printed_distance_is_a_half_space)
{
    const double H = 0.002;
    uint64_t seed = 4;
    for (int trial = 0; trial < TRIALS; trial++) {
        const double BESIDE[3] = {0.7, 0.6, -0.3}; // outside the third corner's side
        Vec3 x[POINTS];
        make_face(&seed, BESIDE, 0.5 * H, x);
        Vec3 n = vunit(face_area_normal(x));
        Setting setting = {.side = 1.0};
        double nearest = true_face_distance(x, &setting);
        for (int k = 0; k < 5; k++) {
            double s = 4.0 * percale_test_random(&seed) - 2.0;
            double t = 4.0 * percale_test_random(&seed) - 2.0;
            Vec3 any = vadd(x[1], vadd(vscale(s, vsub(x[2], x[1])), vscale(t, vsub(x[3], x[1]))));
            ck_assert_double_eq_tol(vdot(vsub(x[0], any), n), vdot(vsub(x[0], x[1]), n), 1e-14);
        }
        ck_assert_double_lt(vdot(vsub(x[0], x[1]), n) - H, 0.0); // the half-space says: contact
        ck_assert_double_gt(nearest, 10.0 * H);                  // the face is far away
    }
}
END_TEST

// Once two edges have crossed, the unsigned distance grows by pushing them on; with the side kept it brings
// them back.
START_TEST(erratum_a5_unsigned_edges_are_pushed_through)
{
    const double H = 0.002;
    const double CROSSED = 0.004;
    uint64_t seed = 5;
    for (int trial = 0; trial < TRIALS; trial++) {
        Vec3 x[POINTS];
        double weights[POINTS];
        make_edges(&seed, 1.0 + percale_test_random(&seed), CROSSED, x); // the second has come to lie above
        line_weights(x, weights);
        Vec3 d = weighted_sum(x, weights);
        Vec3 start_side = vscale(-1.0, vunit(d)); // from where they came: the second lay below
        double unsigned_value = vlength(d) - H;
        double signed_value = vdot(start_side, d) - H;
        ck_assert_double_gt(unsigned_value, 0.0); // nothing to do, or, within h, further apart
        ck_assert_double_eq_tol(signed_value, -(CROSSED + H), 1e-12);
        double share = weights[0] * weights[0] + weights[1] * weights[1] + weights[2] * weights[2] +
                       weights[3] * weights[3];
        for (int k = 0; k < POINTS; k++) {
            x[k] = vadd(x[k], vscale(-signed_value * weights[k] / share, start_side));
        }
        ck_assert_double_eq_tol(vdot(start_side, weighted_sum(x, weights)), H, 1e-12);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("errata of seed A");
    TCase *seed_a = tcase_create("seed A");
    tcase_add_test(seed_a, erratum_a1_printed_sign_doubles_the_penetration);
    tcase_add_test(seed_a, erratum_a2_printed_face_gradients_fail);
    tcase_add_test(seed_a, erratum_a4_printed_distance_is_a_half_space);
    tcase_add_test(seed_a, erratum_a5_unsigned_edges_are_pushed_through);
    tcase_add_test(seed_a, erratum_a6_a_contact_only_pushes);
    suite_add_tcase(suite, seed_a);
    return percale_test_run(suite);
}
