// What the two source documents print against what is right: the right form passes a central difference, the
// printed one fails it. The tables are in MATH.md.

#include "kernel_testing.h"

#include "percale/geometry.h"
#include "solve/solve_arrays.h"

#include <math.h>

enum { TRIALS = 200 };
static const double RIGHT = 1e-8; // of the gradient's size: what a difference of fourth order leaves
static const double WRONG = 0.05; // the same; printed forms are off by far more
static const double STEP = 2e-4; // of the differences, for points about 1 apart: error and rounding are 1e-12

// ---- functions of four points and their gradients ----

/// What the points' distance is, with everything that is held fixed in it.
typedef struct Setting {
    double weights[POINTS]; // signed, sum 0
    double side;
} Setting;

static Vec3 random_vector(uint64_t *seed)
{
    double x = 2.0 * percale_test_random(seed) - 1.0;
    double y = 2.0 * percale_test_random(seed) - 1.0;
    return vec3(x, y, 2.0 * percale_test_random(seed) - 1.0);
}

static Vec3 weighted_sum(const Vec3 x[POINTS], const double weights[POINTS])
{
    Vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < POINTS; k++) {
        sum = vadd(sum, vscale(weights[k], x[k]));
    }
    return sum;
}

/// |a - b| over all points in relation to |b|.
static double error_of(const Vec3 a[POINTS], const Vec3 b[POINTS])
{
    double difference = 0.0;
    double size = 0.0;
    for (int k = 0; k < POINTS; k++) {
        Vec3 d = vsub(a[k], b[k]);
        difference += vdot(d, d);
        size += vdot(b[k], b[k]);
    }
    return sqrt(difference / size);
}

/// n . sum a_k x_k with the weights held.
static void stencil_gradient(Vec3 normal, const double weights[POINTS], Vec3 gradient[POINTS])
{
    for (int k = 0; k < POINTS; k++) {
        gradient[k] = vscale(weights[k], normal);
    }
}

// ---- vertex and face: x0 against x1, x2, x3 ----

static Vec3 face_area_normal(const Vec3 x[POINTS])
{
    return vcross(vsub(x[2], x[1]), vsub(x[3], x[1]));
}

static double plane_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    return setting->side * vdot(vunit(face_area_normal(x)), vsub(x[0], x[1]));
}

/// n . (x0 - sum b_k x_k) with b held: the document's D, which is the plane's distance for any b of sum 1.
static double held_face_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    return vdot(vunit(face_area_normal(x)), weighted_sum(x, setting->weights));
}

static double true_face_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    double points[POINTS][3];
    double weights[POINTS];
    for (int k = 0; k < POINTS; k++) {
        points[k][0] = x[k].x;
        points[k][1] = x[k].y;
        points[k][2] = x[k].z;
    }
    return setting->side * percale_vertex_face_closest((const double(*)[3])points, weights);
}

/// Signed weights of the foot of the perpendicular, clamped or not.
static void foot_weights(const Vec3 x[POINTS], double weights[POINTS])
{
    Vec3 m = face_area_normal(x);
    weights[0] = 1.0;
    for (int k = 0; k < 3; k++) {
        Vec3 p = x[1 + (k + 1) % 3];
        Vec3 q = x[1 + (k + 2) % 3];
        weights[1 + k] = -vdot(m, vcross(vsub(q, p), vsub(x[0], p))) / vdot(m, m);
    }
}

/// A triangle of a decent shape and a vertex that stands `height` over the place with the weights b.
static void make_face(uint64_t *seed, const double b[3], double height, Vec3 x[POINTS])
{
    do {
        for (int k = 1; k < POINTS; k++) {
            x[k] = random_vector(seed);
        }
    } while (vlength(face_area_normal(x)) < 0.5);
    const double weights[POINTS] = {0.0, b[0], b[1], b[2]};
    x[0] = vec3(0.0, 0.0, 0.0);
    x[0] = vadd(weighted_sum(x, weights), vscale(height, vunit(face_area_normal(x))));
}

static void random_barycentrics(uint64_t *seed, double b[3])
{
    b[0] = 0.2 + 0.3 * percale_test_random(seed);
    b[1] = 0.2 + 0.3 * percale_test_random(seed);
    b[2] = 1.0 - b[0] - b[1];
}

/// N w = (w - n (n . w)) / |m|.
static Vec3 normal_change(Vec3 m, Vec3 w)
{
    Vec3 n = vunit(m);
    return vscale(1.0 / vlength(m), vsub(w, vscale(vdot(n, w), n)));
}

/// Seed B, equations 4 to 7, as printed or with the Jacobian transposed.
static void document_face_gradient(const Vec3 x[POINTS], const double weights[POINTS], bool printed,
                                   Vec3 gradient[POINTS])
{
    Vec3 m = face_area_normal(x);
    Vec3 d = weighted_sum(x, weights);
    stencil_gradient(vunit(m), weights, gradient);
    for (int k = 1; k < POINTS; k++) {
        Vec3 opposite = vsub(x[1 + (k + 1) % 3], x[1 + k % 3]); // x23, x31, x12
        Vec3 turn = printed ? normal_change(m, vcross(opposite, d)) : vcross(normal_change(m, d), opposite);
        gradient[k] = vadd(gradient[k], turn);
    }
}

// ---- edge and edge: x0 x1 against x2 x3 ----

static Vec3 edges_normal(const Vec3 x[POINTS])
{
    return vcross(vsub(x[1], x[0]), vsub(x[3], x[2]));
}

static double held_edge_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    return vdot(vunit(edges_normal(x)), weighted_sum(x, setting->weights));
}

/// Seed B, equations 11 to 14, as printed or with the Jacobian transposed.
static void document_edge_gradient(const Vec3 x[POINTS], const double weights[POINTS], bool printed,
                                   Vec3 gradient[POINTS])
{
    Vec3 m = edges_normal(x);
    Vec3 d = weighted_sum(x, weights);
    Vec3 x01 = vsub(x[1], x[0]);
    Vec3 x23 = vsub(x[3], x[2]);
    Vec3 turn_a = printed ? normal_change(m, vcross(x23, d)) : vcross(normal_change(m, d), x23);
    Vec3 turn_b = printed ? normal_change(m, vcross(x01, d)) : vcross(normal_change(m, d), x01);
    stencil_gradient(vunit(m), weights, gradient);
    gradient[0] = vadd(gradient[0], turn_a);
    gradient[1] = vsub(gradient[1], turn_a);
    gradient[2] = vsub(gradient[2], turn_b);
    gradient[3] = vadd(gradient[3], turn_b);
}

/// Weights of the closest points on the two lines.
static void line_weights(const Vec3 x[POINTS], double weights[POINTS])
{
    Vec3 a = vsub(x[1], x[0]);
    Vec3 b = vsub(x[3], x[2]);
    Vec3 m = vcross(a, b);
    Vec3 between = vsub(x[2], x[0]);
    double s = vdot(m, vcross(between, b)) / vdot(m, m);
    double t = vdot(m, vcross(between, a)) / vdot(m, m);
    const double result[POINTS] = {1.0 - s, s, t - 1.0, -t};
    memcpy(weights, result, sizeof(result));
}

/// Two edges whose lines are `height` apart and turned against each other by `angle`.
static void make_edges(uint64_t *seed, double angle, double height, Vec3 x[POINTS])
{
    Vec3 a = vunit(random_vector(seed));
    Vec3 up = vunit(vcross(a, random_vector(seed)));
    Vec3 b = vadd(vscale(cos(angle), a), vscale(sin(angle), vcross(up, a)));
    Vec3 middle = random_vector(seed);
    double s = 0.3 + 0.4 * percale_test_random(seed);
    double t = 0.3 + 0.4 * percale_test_random(seed);
    x[0] = vadd(middle, vscale(-s, a));
    x[1] = vadd(middle, vscale(1.0 - s, a));
    middle = vadd(middle, vscale(height, up));
    x[2] = vadd(middle, vscale(-t, b));
    x[3] = vadd(middle, vscale(1.0 - t, b));
}

// ---- seed A ----

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

// ---- seed B ----

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
    Suite *suite = suite_create("errata");
    TCase *seed_a = tcase_create("seed A");
    tcase_add_test(seed_a, erratum_a1_printed_sign_doubles_the_penetration);
    tcase_add_test(seed_a, erratum_a2_printed_face_gradients_fail);
    tcase_add_test(seed_a, erratum_a4_printed_distance_is_a_half_space);
    tcase_add_test(seed_a, erratum_a5_unsigned_edges_are_pushed_through);
    tcase_add_test(seed_a, erratum_a6_a_contact_only_pushes);
    suite_add_tcase(suite, seed_a);
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
