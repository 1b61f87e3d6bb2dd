// What source document B prints against what is right: the right form passes a central difference, the
// printed one fails it. The table is in MATH.md.

#include "errata_testing.h"

#include <math.h>

/// Weights that sum to 0 but are not those of the foot: only there do the forms of the gradient differ in N
/// d.
static void make_held_weights(uint64_t *seed, double weights[POINTS])
{
    double b[3];
    random_barycentrics(seed, b);
    const double shift = 0.2 + 0.3 * percale_test_random(seed);
    const double result[POINTS] = {1.0, -(b[0] + shift), -(b[1] - shift), -b[2]};
    memcpy(weights, result, sizeof(result));
}

// D = n . d with b held: its derivative by x1 is (dn/dx1)^T d - b1 n. dn/dx1 itself is taken by differences.
START_TEST(erratum_b1_the_jacobian_is_transposed)
{
    uint64_t seed = 6;
    for (int trial = 0; trial < TRIALS; trial++) {
        double b[3];
        Setting setting = {.side = 1.0};
        Vec3 x[POINTS];
        Vec3 expected[POINTS];
        random_barycentrics(&seed, b);
        make_face(&seed, b, 0.5, x);
        make_held_weights(&seed, setting.weights);
        differentiate(held_face_distance, &setting, x, STEP, expected);
        Vec3 d = weighted_sum(x, setting.weights);
        const Vec3 axes[3] = {{STEP, 0.0, 0.0}, {0.0, STEP, 0.0}, {0.0, 0.0, STEP}};
        double d_of[3] = {d.x, d.y, d.z};
        double transposed[3];
        Vec3 plain = {0.0, 0.0, 0.0};
        for (int axis = 0; axis < 3; axis++) {
            Vec3 ahead[POINTS] = {x[0], vadd(x[1], axes[axis]), x[2], x[3]};
            Vec3 back[POINTS] = {x[0], vsub(x[1], axes[axis]), x[2], x[3]};
            Vec3 column =
                vscale(0.5 / STEP, vsub(vunit(face_area_normal(ahead)), vunit(face_area_normal(back))));
            transposed[axis] = vdot(column, d);
            plain = vadd(plain, vscale(d_of[axis], column));
        }
        Vec3 moved = vscale(setting.weights[1], vunit(face_area_normal(x)));
        Vec3 right = vadd(vec3(transposed[0], transposed[1], transposed[2]), moved);
        ck_assert_double_lt(vlength(vsub(right, expected[1])), 1e-5 * vlength(expected[1]));
        ck_assert_double_gt(vlength(vsub(vadd(plain, moved), expected[1])), WRONG * vlength(expected[1]));
    }
}
END_TEST

START_TEST(erratum_b2_printed_face_gradients_fail)
{
    uint64_t seed = 7;
    double worst = 0.0;
    for (int trial = 0; trial < TRIALS; trial++) {
        double b[3];
        Setting setting = {.side = 1.0};
        Vec3 x[POINTS];
        Vec3 expected[POINTS];
        Vec3 right[POINTS];
        Vec3 printed[POINTS];
        random_barycentrics(&seed, b);
        make_face(&seed, b, 1.0, x);
        make_held_weights(&seed, setting.weights);
        differentiate(held_face_distance, &setting, x, STEP, expected);
        document_face_gradient(x, setting.weights, false, right);
        document_face_gradient(x, setting.weights, true, printed);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
        double error = error_of((const Vec3 *)printed, (const Vec3 *)expected);
        ck_assert_double_gt(error, WRONG);
        worst = fmax(worst, error);
    }
    ck_assert_double_gt(worst, 1.0); // off by more than all of it
}
END_TEST

/// The plane's distance with the foot's weights found anew for the moved points.
static double renewed_face_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    Setting renewed = *setting;
    foot_weights(x, renewed.weights);
    return held_face_distance(x, &renewed);
}

START_TEST(erratum_b3_at_the_foot_the_gradient_is_the_stencil)
{
    uint64_t seed = 8;
    for (int trial = 0; trial < TRIALS; trial++) {
        double b[3];
        Setting setting = {.side = 1.0};
        Vec3 x[POINTS];
        Vec3 expected[POINTS];
        Vec3 right[POINTS];
        random_barycentrics(&seed, b);
        make_face(&seed, b, 2.0 * percale_test_random(&seed) - 1.0, x);
        foot_weights(x, setting.weights);
        ck_assert_double_lt(vlength(normal_change(face_area_normal(x), weighted_sum(x, setting.weights))),
                            1e-13);
        stencil_gradient(vunit(face_area_normal(x)), setting.weights, right);
        differentiate(renewed_face_distance, &setting, x, STEP, expected);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
        differentiate(held_face_distance, &setting, x, STEP, expected);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
    }
}
END_TEST

/// One step of the mass-weighted problem with equal masses and target 0: the depth that is left and the area
/// that the triangle has grown to, both as shares.
static void step_out(double depth_in_altitudes, bool printed, double *depth_left, double *area)
{
    const double ALTITUDE = 0.86602540378443864676;
    Vec3 x[POINTS] = {{0.5, ALTITUDE / 3.0, 0.0}, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.5, ALTITUDE, 0.0}};
    Vec3 gradient[POINTS];
    double weights[POINTS];
    double depth = depth_in_altitudes * ALTITUDE;
    x[0].z = -depth;
    foot_weights(x, weights);
    document_face_gradient(x, weights, printed, gradient);
    double share = 0.0;
    for (int k = 0; k < POINTS; k++) {
        share += vdot(gradient[k], gradient[k]);
    }
    double before = vlength(face_area_normal(x));
    for (int k = 0; k < POINTS; k++) {
        x[k] = vadd(x[k], vscale(depth / share, gradient[k]));
    }
    Setting setting = {.side = 1.0};
    *depth_left = -plane_distance(x, &setting) / depth;
    *area = vlength(face_area_normal(x)) / before;
}

START_TEST(erratum_b4_the_printed_form_inflates_the_triangle)
{
    static const double EXPECTED[2][3] = {{1.0 / 3.0, 0.20, 1.21}, {1.0, 0.692, 1.81}};
    for (int i = 0; i < 2; i++) {
        double depth_left;
        double area;
        step_out(EXPECTED[i][0], true, &depth_left, &area);
        ck_assert_double_eq_tol(depth_left, EXPECTED[i][1], 0.005);
        ck_assert_double_eq_tol(area, EXPECTED[i][2], 0.005);
        step_out(EXPECTED[i][0], false, &depth_left, &area);
        ck_assert_double_eq_tol(depth_left, 0.0, 1e-12);
        ck_assert_double_eq_tol(area, 1.0, 1e-12);
    }
}
END_TEST

START_TEST(erratum_b5_printed_edge_gradients_fail)
{
    uint64_t seed = 9;
    for (int trial = 0; trial < TRIALS; trial++) {
        Setting setting = {.side = 1.0};
        Vec3 x[POINTS];
        Vec3 expected[POINTS];
        Vec3 right[POINTS];
        Vec3 printed[POINTS];
        make_edges(&seed, 0.5 + percale_test_random(&seed), 0.5, x);
        const double s = percale_test_random(&seed);
        const double held[POINTS] = {1.0 - s, s, -s, s - 1.0};
        memcpy(setting.weights, held, sizeof(held));
        differentiate(held_edge_distance, &setting, x, STEP, expected);
        document_edge_gradient(x, setting.weights, false, right);
        document_edge_gradient(x, setting.weights, true, printed);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
        ck_assert_double_gt(error_of((const Vec3 *)printed, (const Vec3 *)expected), WRONG);
        line_weights(x, setting.weights); // at the closest points it is just the stencil
        differentiate(held_edge_distance, &setting, x, STEP, expected);
        stencil_gradient(vunit(edges_normal(x)), setting.weights, right);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), RIGHT);
    }
    static const double ANGLES[] = {1e-2, 1e-3, 1e-4, 1e-5};
    for (int i = 0; i < 4; i++) { // towards parallel the printed form grows
        Vec3 x[POINTS];
        double weights[POINTS];
        Vec3 printed[POINTS];
        make_edges(&seed, ANGLES[i], 0.5, x);
        line_weights(x, weights);
        document_edge_gradient(x, weights, true, printed);
        ck_assert_double_gt(vlength(printed[0]), 0.4 / ANGLES[i]);
        ck_assert_double_lt(fabs(weights[0]), 1.0); // and the right one doesn't
    }
}
END_TEST

START_TEST(erratum_b6_the_sum_of_the_gradients_tells_nothing)
{
    uint64_t seed = 10;
    for (int trial = 0; trial < TRIALS; trial++) {
        double b[3];
        double weights[POINTS];
        Vec3 x[POINTS];
        random_barycentrics(&seed, b);
        make_face(&seed, b, 0.5, x);
        make_held_weights(&seed, weights);
        for (int printed = 0; printed < 2; printed++) {
            Vec3 gradient[POINTS];
            Vec3 sum = {0.0, 0.0, 0.0};
            Vec3 torque = {0.0, 0.0, 0.0};
            document_face_gradient(x, weights, printed == 1, gradient);
            for (int k = 0; k < POINTS; k++) {
                sum = vadd(sum, gradient[k]);
                torque = vadd(torque, vcross(x[k], gradient[k]));
            }
            ck_assert_double_lt(vlength(sum), 1e-13); // right and wrong alike
            if (printed == 1) {
                ck_assert_double_gt(vlength(torque), 1e-3);
            } else {
                ck_assert_double_lt(vlength(torque), 1e-13);
            }
        }
    }
}
END_TEST

START_TEST(erratum_b7_an_edges_direction_decides_the_sign)
{
    uint64_t seed = 11;
    for (int trial = 0; trial < TRIALS; trial++) {
        Vec3 x[POINTS];
        Setting setting = {.side = 1.0};
        make_edges(&seed, 0.3 + 2.0 * percale_test_random(&seed), 0.1, x);
        line_weights(x, setting.weights);
        double distance = held_edge_distance(x, &setting);
        Vec3 turned[POINTS] = {x[1], x[0], x[2], x[3]};
        line_weights(turned, setting.weights);
        ck_assert_double_eq_tol(fabs(distance), 0.1, 1e-12);
        ck_assert_double_eq_tol(held_edge_distance(turned, &setting), -distance, 1e-12);
    }
}
END_TEST

// Beside the face the distance is |d| to the clamped closest point, and the same kernel with d / |d| and the
// clamped weights is its gradient; the plane's distance is another function.
START_TEST(erratum_b8_clamped_points_take_their_own_direction)
{
    static const double BESIDE[3][3] = {{0.6, 0.9, -0.5}, {1.8, -0.4, -0.4}, {0.3, -0.4, 1.1}};
    uint64_t seed = 12;
    for (int trial = 0; trial < TRIALS; trial++) {
        Setting setting = {.side = 1.0};
        Vec3 x[POINTS];
        Vec3 expected[POINTS];
        Vec3 right[POINTS];
        Vec3 plane[POINTS];
        make_face(&seed, BESIDE[trial % 3], 0.2, x);
        differentiate(true_face_distance, &setting, x, STEP, expected);
        double points[POINTS][3];
        for (int k = 0; k < POINTS; k++) {
            const double place[3] = {x[k].x, x[k].y, x[k].z};
            memcpy(points[k], place, sizeof(place));
        }
        percale_vertex_face_closest((const double(*)[3])points, setting.weights);
        stencil_gradient(vunit(weighted_sum(x, setting.weights)), setting.weights, right);
        ck_assert_double_lt(error_of((const Vec3 *)right, (const Vec3 *)expected), 1e-6);
        foot_weights(x, setting.weights);
        stencil_gradient(vunit(face_area_normal(x)), setting.weights, plane);
        ck_assert_double_gt(error_of((const Vec3 *)plane, (const Vec3 *)expected), WRONG);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("errata of seed B");
    TCase *seed_b = tcase_create("seed B");
    tcase_add_test(seed_b, erratum_b1_the_jacobian_is_transposed);
    tcase_add_test(seed_b, erratum_b2_printed_face_gradients_fail);
    tcase_add_test(seed_b, erratum_b3_at_the_foot_the_gradient_is_the_stencil);
    tcase_add_test(seed_b, erratum_b4_the_printed_form_inflates_the_triangle);
    tcase_add_test(seed_b, erratum_b5_printed_edge_gradients_fail);
    tcase_add_test(seed_b, erratum_b6_the_sum_of_the_gradients_tells_nothing);
    tcase_add_test(seed_b, erratum_b7_an_edges_direction_decides_the_sign);
    tcase_add_test(seed_b, erratum_b8_clamped_points_take_their_own_direction);
    suite_add_tcase(suite, seed_b);
    return percale_test_run(suite);
}
