// wide.h: eight floats at a time, as two points or as one number of eight constraints.
//
// A *pair* is two points in one f32x8: (x y z w | x y z w). Four pairs transpose to one component of eight
// points each: pairs (0, 4) (1, 5) (2, 6) (3, 7) give the components in order 0 .. 7. All shuffles stay
// inside the halves of a register, which is one instruction with AVX and two with SSE2.
//
// The kernels are compiled once for each instruction set; the arithmetic is the same, so the bits are.

#ifndef PERCALE_WIDE_H
#define PERCALE_WIDE_H

#include "base/simd.h"

enum { WIDE = 8 };

#if defined(__AVX__)

static inline f32x8 pair_of_points(f32x4 low, f32x4 high)
{
    return (f32x8)_mm256_insertf128_ps(_mm256_castps128_ps256((__m128)low), (__m128)high, 1);
}

static inline f32x4 low_point(f32x8 pair)
{
    return (f32x4)_mm256_castps256_ps128((__m256)pair);
}

static inline f32x4 high_point(f32x8 pair)
{
    return (f32x4)_mm256_extractf128_ps((__m256)pair, 1);
}

static inline f32x8 sqrt8(f32x8 a)
{
    return (f32x8)_mm256_sqrt_ps((__m256)a);
}

#define HALF_LANE(k) ((k) < 4 ? (k) : (k) + 4)
/// In both halves: components i and j of a, k and l of b; b's are numbered 4 .. 7 (all four may name either).
#define SHUFFLE_HALVES(a, b, i, j, k, l)                                                                    \
    __builtin_shufflevector(a, b, HALF_LANE(i), HALF_LANE(j), HALF_LANE(k), HALF_LANE(l), HALF_LANE(i) + 4, \
                            HALF_LANE(j) + 4, HALF_LANE(k) + 4, HALF_LANE(l) + 4)

#else

static inline f32x8 pair_of_points(f32x4 low, f32x4 high)
{
    WideHalves halves = {.half = {low, high}};
    return halves.whole;
}

static inline f32x4 low_point(f32x8 pair)
{
    WideHalves halves = {.whole = pair};
    return halves.half[0];
}

static inline f32x4 high_point(f32x8 pair)
{
    WideHalves halves = {.whole = pair};
    return halves.half[1];
}

static inline f32x4 sqrt4(f32x4 a)
{
#if defined(__SSE2__)
    return (f32x4)_mm_sqrt_ps((__m128)a);
#else
    return (f32x4){sqrtf(a[0]), sqrtf(a[1]), sqrtf(a[2]), sqrtf(a[3])};
#endif
}

static inline f32x8 sqrt8(f32x8 a)
{
    return pair_of_points(sqrt4(low_point(a)), sqrt4(high_point(a)));
}

#define SHUFFLE_HALVES(a, b, i, j, k, l)                                            \
    pair_of_points(__builtin_shufflevector(low_point(a), low_point(b), i, j, k, l), \
                   __builtin_shufflevector(high_point(a), high_point(b), i, j, k, l))

#endif

/// Component k of each point, in all four places.
#define SPREAD(pair, k) SHUFFLE_HALVES(pair, pair, k, k, k, k)

static inline f32x8 load8(const float *values)
{
    f32x8 wide;
    __builtin_memcpy(&wide, values, sizeof(wide));
    return wide;
}

static inline void store8(float *values, f32x8 wide)
{
    __builtin_memcpy(values, &wide, sizeof(wide));
}

/// `count` (1 or 2) consecutive points; one alone stands in both halves.
static inline f32x8 load_two(const f32x4 points[], uint32_t count)
{
    return count == 2 ? load8((const float *)points) : pair_of_points(points[0], points[0]);
}

static inline void store_two(f32x4 *points, f32x8 pair, uint32_t count)
{
    if (count == 2) {
        store8((float *)points, pair);
    } else {
        points[0] = low_point(pair);
    }
}

/// One number for each of two points.
static inline f32x8 spread_two(float low, float high)
{
    return (f32x8){low, low, low, low, high, high, high, high};
}

/// Set where a component is NaN or infinite.
static inline i32x8 not_finite8(f32x8 a)
{
    return differs8(a * all8(0.0f), all8(0.0f));
}

/// a where the mask is set, else 0.
static inline f32x8 where8(i32x8 mask, f32x8 a)
{
    return (f32x8)((i32x8)a & mask);
}

static inline f32x8 select8(i32x8 mask, f32x8 a, f32x8 b)
{
    return (f32x8)(((i32x8)a & mask) | ((i32x8)b & ~mask));
}

/// The pair with both fourth components 0.
static inline f32x8 without_w(f32x8 pair)
{
    return where8((i32x8){-1, -1, -1, 0, -1, -1, -1, 0}, pair);
}

/// The product by component, with both fourth components 0.
static inline f32x8 product3(f32x8 a, f32x8 b)
{
#if defined(__AVX512VL__)
    return (f32x8)_mm256_maskz_mul_ps(0x77, (__m256)a, (__m256)b);
#else
    return without_w(a * b);
#endif
}

/// Dot products of the first three components of two pairs, each in all four places of its half.
static inline f32x8 dot3_pairs(f32x8 a, f32x8 b)
{
    f32x8 p = a * b;
    return (SPREAD(p, 0) + SPREAD(p, 1)) + SPREAD(p, 2);
}

/// One component of eight points each.
typedef struct WidePoints {
    f32x8 x, y, z;
} WidePoints;

static inline WidePoints transpose_pairs(const f32x8 pairs[4])
{
    f32x8 xy_low = SHUFFLE_HALVES(pairs[0], pairs[1], 0, 4, 1, 5);
    f32x8 xy_high = SHUFFLE_HALVES(pairs[2], pairs[3], 0, 4, 1, 5);
    f32x8 zw_low = SHUFFLE_HALVES(pairs[0], pairs[1], 2, 6, 3, 7);
    f32x8 zw_high = SHUFFLE_HALVES(pairs[2], pairs[3], 2, 6, 3, 7);
    return (WidePoints){SHUFFLE_HALVES(xy_low, xy_high, 0, 1, 4, 5),
                        SHUFFLE_HALVES(xy_low, xy_high, 2, 3, 6, 7),
                        SHUFFLE_HALVES(zw_low, zw_high, 0, 1, 4, 5)};
}

/// Eight points by number.
static inline WidePoints gather_points(const f32x4 *x, const uint32_t numbers[WIDE])
{
    f32x8 pairs[4];
    for (uint32_t k = 0; k < 4; k++) {
        pairs[k] = pair_of_points(x[numbers[k]], x[numbers[k + 4]]);
    }
    return transpose_pairs(pairs);
}

/// Back: eight points, given by component, as four pairs.
static inline void transpose_points(const WidePoints *points, f32x8 w, f32x8 pairs[4])
{
    f32x8 xy_low = SHUFFLE_HALVES(points->x, points->y, 0, 4, 1, 5);
    f32x8 xy_high = SHUFFLE_HALVES(points->x, points->y, 2, 6, 3, 7);
    f32x8 zw_low = SHUFFLE_HALVES(points->z, w, 0, 4, 1, 5);
    f32x8 zw_high = SHUFFLE_HALVES(points->z, w, 2, 6, 3, 7);
    pairs[0] = SHUFFLE_HALVES(xy_low, zw_low, 0, 1, 4, 5);
    pairs[1] = SHUFFLE_HALVES(xy_low, zw_low, 2, 3, 6, 7);
    pairs[2] = SHUFFLE_HALVES(xy_high, zw_high, 0, 1, 4, 5);
    pairs[3] = SHUFFLE_HALVES(xy_high, zw_high, 2, 3, 6, 7);
}

/// The fourth components of eight points.
static inline f32x8 transpose_w(const f32x8 pairs[4])
{
    f32x8 low = SHUFFLE_HALVES(pairs[0], pairs[1], 2, 6, 3, 7);
    f32x8 high = SHUFFLE_HALVES(pairs[2], pairs[3], 2, 6, 3, 7);
    return SHUFFLE_HALVES(low, high, 2, 3, 6, 7);
}

/// |a - b| of eight points each, as length3 computes it.
static inline f32x8 distances8(const f32x4 a[], const f32x4 b[])
{
    f32x8 between[4];
    for (uint32_t k = 0; k < 4; k++) {
        between[k] = pair_of_points(a[k], a[k + 4]) - pair_of_points(b[k], b[k + 4]);
    }
    WidePoints d = transpose_pairs(between);
    return sqrt8((d.x * d.x + d.y * d.y) + d.z * d.z);
}

/// Eight bytes at once: flags, sides.
static inline uint64_t load_bytes8(const void *bytes)
{
    uint64_t eight;
    __builtin_memcpy(&eight, bytes, sizeof(eight));
    return eight;
}

/// Of eight signed bytes: a 1 in each that is above zero, and in each that is below.
typedef struct ByteSigns {
    uint64_t positive, negative;
} ByteSigns;

static const uint64_t EVERY_BYTE = 0x0101010101010101u; // a 1 in each

static inline ByteSigns signs_of(uint64_t eight)
{
    const uint64_t BELOW_SIGN = 0x7f * EVERY_BYTE;
    uint64_t negative = eight >> 7 & EVERY_BYTE;
    uint64_t not_zero = (((eight & BELOW_SIGN) + BELOW_SIGN) | eight) >> 7 & EVERY_BYTE;
    return (ByteSigns){not_zero & ~negative, negative};
}

/// One bit for each of eight bytes that are 0 or 1, like lane_bits.
static inline uint32_t byte_bits(uint64_t eight)
{
    return (uint32_t)(eight * 0x0102040810204080u >> 56); // byte i moves up by 56 - 7 i bits
}

#endif
