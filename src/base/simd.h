// simd.h: the vector types of the engine and small three-component arithmetic.
//
// Compiler vector types: one source gives the same bits with gcc, clang, SSE2 and AVX2 as long as no
// contraction is allowed. A point is an f32x4: x, y, z and the inverse mass.

#ifndef PERCALE_SIMD_H
#define PERCALE_SIMD_H

#include <math.h>
#include <stdint.h>
#if defined(__SSE2__)
#include <immintrin.h>
#endif

typedef float f32x4 __attribute__((vector_size(16)));
typedef float f32x8 __attribute__((vector_size(32)));
typedef int32_t i32x8 __attribute__((vector_size(32)));
typedef double f64x4 __attribute__((vector_size(32)));
typedef int64_t i64x4 __attribute__((vector_size(32)));

static inline float dot3(f32x4 a, f32x4 b)
{
    f32x4 p = a * b;
    return (p[0] + p[1]) + p[2];
}

static inline float length3(f32x4 a)
{
    return sqrtf(dot3(a, a));
}

/// Smaller and larger of two by component, for numbers. The machine's own instruction answers as the masks
/// do: the first where it is smaller, else the second.
static inline f32x4 min4(f32x4 a, f32x4 b)
{
#if defined(__SSE2__)
    return (f32x4)_mm_min_ps((__m128)a, (__m128)b);
#else
    typedef int32_t Mask __attribute__((vector_size(16)));
    Mask less = a < b;
    return (f32x4)(((Mask)a & less) | ((Mask)b & ~less));
#endif
}

static inline f32x4 max4(f32x4 a, f32x4 b)
{
#if defined(__SSE2__)
    return (f32x4)_mm_max_ps((__m128)a, (__m128)b);
#else
    typedef int32_t Mask __attribute__((vector_size(16)));
    Mask more = a > b;
    return (f32x4)(((Mask)a & more) | ((Mask)b & ~more));
#endif
}

/// x, y and z are numbers: 0 times each is 0, and not a number else.
static inline int is_finite3(f32x4 x)
{
    f32x4 zero = x * 0.0f;
    return (zero[0] + zero[1]) + zero[2] == 0.0f;
}

/// a with its fourth component replaced.
static inline f32x4 with_w(f32x4 a, float w)
{
    a[3] = w;
    return a;
}

// Without AVX gcc compares eight lanes one by one; in halves it doesn't.
#if defined(__AVX__)
#define COMPARE8(a, operator, b) return a operator b
#else
typedef int32_t i32x4 __attribute__((vector_size(16)));
typedef union WideHalves {
    f32x8 whole;
    i32x8 mask;
    f32x4 half[2];
    i32x4 half_mask[2];
} WideHalves;

#define COMPARE8(a, operator, b)                                                                    \
    WideHalves left = {.whole = (a)};                                                               \
    WideHalves right = {.whole = (b)};                                                              \
    WideHalves mask = {                                                                             \
        .half_mask = {left.half[0] operator right.half[0], left.half[1] operator right.half[1] } }; \
    return mask.mask
#endif

static inline i32x8 greater8(f32x8 a, f32x8 b)
{
    COMPARE8(a, >, b);
}

static inline i32x8 at_most8(f32x8 a, f32x8 b)
{
    COMPARE8(a, <=, b);
}

static inline i32x8 differs8(f32x8 a, f32x8 b)
{
    COMPARE8(a, !=, b);
}

static inline f32x8 all8(float a)
{
    return (f32x8){a, a, a, a, a, a, a, a};
}

/// Larger and smaller of two, by component; for numbers only.
static inline f32x8 max8(f32x8 a, f32x8 b)
{
#if defined(__AVX__)
    return (f32x8)_mm256_max_ps((__m256)a, (__m256)b);
#else
    WideHalves left = {.whole = a};
    WideHalves right = {.whole = b};
    WideHalves most = {.half = {max4(left.half[0], right.half[0]), max4(left.half[1], right.half[1])}};
    return most.whole;
#endif
}

static inline f32x8 min8(f32x8 a, f32x8 b)
{
#if defined(__AVX__)
    return (f32x8)_mm256_min_ps((__m256)a, (__m256)b);
#else
    WideHalves left = {.whole = a};
    WideHalves right = {.whole = b};
    WideHalves least = {.half = {min4(left.half[0], right.half[0]), min4(left.half[1], right.half[1])}};
    return least.whole;
#endif
}

/// One bit per lane of a comparison's result.
static inline uint32_t lane_bits(i32x8 mask)
{
#if defined(__AVX__)
    return (uint32_t)__builtin_ia32_movmskps256((f32x8)mask);
#elif defined(__SSE2__)
    WideHalves halves = {.mask = mask};
    return (uint32_t)__builtin_ia32_movmskps(halves.half[0]) |
           (uint32_t)__builtin_ia32_movmskps(halves.half[1]) << 4;
#else
    uint32_t bits = 0;
    for (uint32_t k = 0; k < 8; k++) {
        bits |= (uint32_t)(mask[k] != 0) << k;
    }
    return bits;
#endif
}

/// Three doubles: what every sign-critical decision is computed in.
typedef struct Vec3 {
    double x, y, z;
} Vec3;

static inline Vec3 vec3(double x, double y, double z)
{
    return (Vec3){x, y, z};
}

static inline Vec3 vec3_of(f32x4 a)
{
    return (Vec3){(double)a[0], (double)a[1], (double)a[2]};
}

static inline f32x4 f32x4_of(Vec3 a, float w)
{
    return (f32x4){(float)a.x, (float)a.y, (float)a.z, w};
}

static inline Vec3 vadd(Vec3 a, Vec3 b)
{
    return (Vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline Vec3 vsub(Vec3 a, Vec3 b)
{
    return (Vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline Vec3 vscale(double s, Vec3 a)
{
    return (Vec3){s * a.x, s * a.y, s * a.z};
}

static inline double vdot(Vec3 a, Vec3 b)
{
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

static inline Vec3 vcross(Vec3 a, Vec3 b)
{
    return (Vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double vlength(Vec3 a)
{
    return sqrt(vdot(a, a));
}

/// a / |a|, or zero for zero.
static inline Vec3 vunit(Vec3 a)
{
    double length = vlength(a);
    return length > 0.0 ? vscale(1.0 / length, a) : a;
}

#endif
