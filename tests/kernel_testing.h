// kernel_testing.h: what the tests of kernels and formulas share: central differences, random points, and the
// judgement of a movement.

#ifndef PERCALE_KERNEL_TESTING_H
#define PERCALE_KERNEL_TESTING_H

#include "testing.h"

#include "base/simd.h"

#include <string.h>

enum { POINTS = 4 };

/// A function of four points; `given` is what it holds fixed.
typedef double PercaleTestFunction(const Vec3 x[POINTS], const void *given);

static inline double shifted(PercaleTestFunction *function, const void *given, const Vec3 x[POINTS],
                             int point, Vec3 shift)
{
    Vec3 moved[POINTS];
    memcpy(moved, x, sizeof(moved));
    moved[point] = vadd(moved[point], shift);
    return function(moved, given);
}

/// Central difference of fourth order.
static inline void differentiate(PercaleTestFunction *function, const void *given, const Vec3 x[POINTS],
                                 double step, Vec3 gradient[POINTS])
{
    const Vec3 axes[3] = {{step, 0.0, 0.0}, {0.0, step, 0.0}, {0.0, 0.0, step}};
    for (int k = 0; k < POINTS; k++) {
        double slope[3];
        for (int axis = 0; axis < 3; axis++) {
            Vec3 one = axes[axis];
            Vec3 two = vscale(2.0, one);
            double near =
                shifted(function, given, x, k, one) - shifted(function, given, x, k, vscale(-1.0, one));
            double far =
                shifted(function, given, x, k, two) - shifted(function, given, x, k, vscale(-1.0, two));
            slope[axis] = (8.0 * near - far) / (12.0 * step);
        }
        gradient[k] = vec3(slope[0], slope[1], slope[2]);
    }
}

static inline float random_float(uint64_t *seed, double low, double high)
{
    return (float)(low + (high - low) * percale_test_random(seed));
}

static inline uint32_t random_below(uint64_t *seed, uint32_t limit)
{
    return (uint32_t)(percale_test_random(seed) * limit);
}

/// For what == can't tell: NaNs and the sign of zeros.
static inline bool same_bits(const void *a, const void *b, size_t size)
{
    return size == 0 || memcmp(a, b, size) == 0;
}

/// Mostly a metre and less, sometimes exactly on an axis, from either side.
static inline f32x4 place_of(uint64_t *seed)
{
    f32x4 x = {random_float(seed, -1.0, 1.0), random_float(seed, -1.0, 1.0), random_float(seed, -1.0, 1.0),
               random_float(seed, 0.1, 10.0)};
    if (percale_test_random(seed) < 0.3) {
        x[random_below(seed, 3)] = percale_test_random(seed) < 0.7 ? -0.0f : 0.0f;
    }
    if (percale_test_random(seed) < 0.2) {
        x[3] = 0.0f;
    }
    return x;
}

/// Four points about a metre apart, every fourth of them immovable; the rest weigh 0.1 to 10 kg.
static inline void random_points(uint64_t *seed, f32x4 x[POINTS])
{
    for (int k = 0; k < POINTS; k++) {
        x[k] = (f32x4){random_float(seed, -1.0, 1.0), random_float(seed, -1.0, 1.0),
                       random_float(seed, -1.0, 1.0), random_float(seed, 0.1, 10.0)};
        if (percale_test_random(seed) < 0.25) {
            x[k][3] = 0.0f;
        }
    }
}

static inline void load_points(const f32x4 x[POINTS], Vec3 points[POINTS])
{
    for (int k = 0; k < POINTS; k++) {
        points[k] = vec3_of(x[k]);
    }
}

/// Each point has to have moved by `factor` * inverse mass * gradient.
static inline void expect_moved_along(const f32x4 before[POINTS], const f32x4 after[POINTS],
                                      const Vec3 gradient[POINTS], double factor)
{
    double size = 0.0;
    double error = 0.0;
    for (int k = 0; k < POINTS; k++) {
        Vec3 expected = vscale(factor * (double)before[k][3], gradient[k]);
        Vec3 moved = vsub(vec3_of(after[k]), vec3_of(before[k]));
        size = fmax(size, vlength(expected));
        error = fmax(error, vlength(vsub(moved, expected)));
        ck_assert_msg(before[k][3] > 0.0f || vlength(moved) <= 0.0, "point %d can't move, but did", k);
    }
    const double kernel_error = 5e-5; // of the movement: float32 positions of 1 m that move by centimetres
    ck_assert_msg(error <= kernel_error * size + 3e-7, "moved by %.6g, off by %.3g", size, error);
}

static inline double mobility(const f32x4 x[POINTS], const Vec3 gradient[POINTS])
{
    double sum = 0.0;
    for (int k = 0; k < POINTS; k++) {
        sum += (double)x[k][3] * vdot(gradient[k], gradient[k]);
    }
    return sum;
}

#endif
