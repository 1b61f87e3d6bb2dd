// errata_testing.h: what the errata of both source documents need: functions of four points, the forms of
// their gradients, random faces and edges.

#ifndef PERCALE_ERRATA_TESTING_H
#define PERCALE_ERRATA_TESTING_H

#include "kernel_testing.h"

#include "percale/geometry.h"

#include <math.h>
#include <string.h>

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

static inline Vec3 random_vector(uint64_t *seed)
{
    double x = 2.0 * percale_test_random(seed) - 1.0;
    double y = 2.0 * percale_test_random(seed) - 1.0;
    return vec3(x, y, 2.0 * percale_test_random(seed) - 1.0);
}

static inline Vec3 weighted_sum(const Vec3 x[POINTS], const double weights[POINTS])
{
    Vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < POINTS; k++) {
        sum = vadd(sum, vscale(weights[k], x[k]));
    }
    return sum;
}

/// |a - b| over all points in relation to |b|.
static inline double error_of(const Vec3 a[POINTS], const Vec3 b[POINTS])
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
static inline void stencil_gradient(Vec3 normal, const double weights[POINTS], Vec3 gradient[POINTS])
{
    for (int k = 0; k < POINTS; k++) {
        gradient[k] = vscale(weights[k], normal);
    }
}

// ---- vertex and face: x0 against x1, x2, x3 ----

static inline Vec3 face_area_normal(const Vec3 x[POINTS])
{
    return vcross(vsub(x[2], x[1]), vsub(x[3], x[1]));
}

static inline double plane_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    return setting->side * vdot(vunit(face_area_normal(x)), vsub(x[0], x[1]));
}

/// n . (x0 - sum b_k x_k) with b held: the document's D, which is the plane's distance for any b of sum 1.
static inline double held_face_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    return vdot(vunit(face_area_normal(x)), weighted_sum(x, setting->weights));
}

static inline double true_face_distance(const Vec3 x[POINTS], const void *given)
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
static inline void foot_weights(const Vec3 x[POINTS], double weights[POINTS])
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
static inline void make_face(uint64_t *seed, const double b[3], double height, Vec3 x[POINTS])
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

static inline void random_barycentrics(uint64_t *seed, double b[3])
{
    b[0] = 0.2 + 0.3 * percale_test_random(seed);
    b[1] = 0.2 + 0.3 * percale_test_random(seed);
    b[2] = 1.0 - b[0] - b[1];
}

/// N w = (w - n (n . w)) / |m|.
static inline Vec3 normal_change(Vec3 m, Vec3 w)
{
    Vec3 n = vunit(m);
    return vscale(1.0 / vlength(m), vsub(w, vscale(vdot(n, w), n)));
}

/// Seed B, equations 4 to 7, as printed or with the Jacobian transposed.
static inline void document_face_gradient(const Vec3 x[POINTS], const double weights[POINTS], bool printed,
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

static inline Vec3 edges_normal(const Vec3 x[POINTS])
{
    return vcross(vsub(x[1], x[0]), vsub(x[3], x[2]));
}

static inline double held_edge_distance(const Vec3 x[POINTS], const void *given)
{
    const Setting *setting = given;
    return vdot(vunit(edges_normal(x)), weighted_sum(x, setting->weights));
}

/// Seed B, equations 11 to 14, as printed or with the Jacobian transposed.
static inline void document_edge_gradient(const Vec3 x[POINTS], const double weights[POINTS], bool printed,
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
static inline void line_weights(const Vec3 x[POINTS], double weights[POINTS])
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
static inline void make_edges(uint64_t *seed, double angle, double height, Vec3 x[POINTS])
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

#endif
