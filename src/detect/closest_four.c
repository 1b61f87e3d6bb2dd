#include "detect/distance.h"

#include <string.h>

// Four triangles at a time, in the same operations and so the same bits as closest_by_region in distance.c:
// every region's answer is prepared, and the first region that fits says which is taken.

/// One component of four points each.
typedef struct FourPoints {
    f64x4 x, y, z;
} FourPoints;

#if defined(__AVX__)
#define COMPARE4(a, operator, b) return a operator b
#else // in halves, else gcc compares one lane after the other
typedef double f64x2 __attribute__((vector_size(16)));
typedef int64_t i64x2 __attribute__((vector_size(16)));
typedef union FourHalves {
    f64x4 whole;
    i64x4 mask;
    f64x2 half[2];
    i64x2 half_mask[2];
} FourHalves;

#define COMPARE4(a, operator, b)                                                                    \
    FourHalves left = {.whole = (a)};                                                               \
    FourHalves right = {.whole = (b)};                                                              \
    FourHalves mask = {                                                                             \
        .half_mask = {left.half[0] operator right.half[0], left.half[1] operator right.half[1] } }; \
    return mask.mask
#endif

static inline i64x4 at_most(f64x4 a, f64x4 b)
{
    COMPARE4(a, <=, b);
}

static inline f64x4 all4(double a)
{
    return (f64x4){a, a, a, a};
}

static inline FourPoints minus(FourPoints a, FourPoints b)
{
    return (FourPoints){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline f64x4 dot(FourPoints a, FourPoints b)
{
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

static inline FourPoints cross(FourPoints a, FourPoints b)
{
    return (FourPoints){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline FourPoints transpose(const f32x4 points[CLOSEST_FOUR])
{
    f32x4 xy_low = __builtin_shufflevector(points[0], points[1], 0, 4, 1, 5);
    f32x4 xy_high = __builtin_shufflevector(points[2], points[3], 0, 4, 1, 5);
    f32x4 z_low = __builtin_shufflevector(points[0], points[1], 2, 6, 2, 6);
    f32x4 z_high = __builtin_shufflevector(points[2], points[3], 2, 6, 2, 6);
    f32x4 x = __builtin_shufflevector(xy_low, xy_high, 0, 1, 4, 5);
    f32x4 y = __builtin_shufflevector(xy_low, xy_high, 2, 3, 6, 7);
    f32x4 z = __builtin_shufflevector(z_low, z_high, 0, 1, 4, 5);
    return (FourPoints){__builtin_convertvector(x, f64x4), __builtin_convertvector(y, f64x4),
                        __builtin_convertvector(z, f64x4)};
}

static inline f64x4 where(i64x4 mask, f64x4 a)
{
    return (f64x4)((i64x4)a & mask);
}

/// Lanes of one answer or another; no lane of both.
static inline f64x4 either(f64x4 a, f64x4 b)
{
    return (f64x4)((i64x4)a | (i64x4)b);
}

/// In which region each closest point lies; no lane is set twice.
typedef struct Regions {
    i64x4 face, sides[3], corners[3];
} Regions;

/// Dot products of the sides ab and ac with the offsets from a, b and c, and the regions' determinants.
typedef struct Products {
    f64x4 d1, d2, d3, d4, d5, d6;
    f64x4 va, vb, vc;
} Products;

/// In the order of closest_by_region: what one has taken is no longer free for the next.
static inline Regions find_regions(const Products *s)
{
    const f64x4 ZERO = all4(0.0);
    Regions regions;
    i64x4 free = ~(i64x4){0};
    i64x4 *const TAKEN[] = {&regions.corners[0], &regions.corners[1], &regions.sides[0],
                            &regions.corners[2], &regions.sides[2],   &regions.sides[1]};
    const i64x4 fits[] = {
        at_most(s->d1, ZERO) & at_most(s->d2, ZERO),
        at_most(ZERO, s->d3) & at_most(s->d4, s->d3),
        at_most(s->vc, ZERO) & at_most(ZERO, s->d1) & at_most(s->d3, ZERO),
        at_most(ZERO, s->d6) & at_most(s->d5, s->d6),
        at_most(s->vb, ZERO) & at_most(ZERO, s->d2) & at_most(s->d6, ZERO),
        at_most(s->va, ZERO) & at_most(ZERO, s->d4 - s->d3) & at_most(ZERO, s->d5 - s->d6),
    };
    for (int i = 0; i < 6; i++) {
        *TAKEN[i] = fits[i] & free;
        free &= ~fits[i];
    }
    regions.face = free;
    return regions;
}

static inline void find_weights(const Products *s, const Regions *in, f64x4 weights[3])
{
    const f64x4 ONE = all4(1.0);
    f64x4 along_1 = s->d4 - s->d3;
    i64x4 corners = in->corners[0] | in->corners[1] | in->corners[2];
    f64x4 numerator = either(either(where(in->face, ONE), where(in->sides[0], s->d1)),
                             either(where(in->sides[1], along_1), where(in->sides[2], s->d2)));
    f64x4 denominator =
        either(either(where(in->face, s->va + s->vb + s->vc), where(in->sides[0], s->d1 - s->d3)),
               either(where(in->sides[1], along_1 + (s->d5 - s->d6)),
                      either(where(in->sides[2], s->d2 - s->d6), where(corners, ONE))));
    f64x4 t = numerator / denominator;
    f64x4 rest = ONE - t;
    f64x4 second = s->vb * t;
    f64x4 third = s->vc * t;
    weights[0] =
        either(either(where(in->face, ONE - second - third), where(in->sides[0] | in->sides[2], rest)),
               where(in->corners[0], ONE));
    weights[1] = either(either(where(in->face, second), where(in->sides[0], t)),
                        either(where(in->sides[1], rest), where(in->corners[1], ONE)));
    weights[2] = either(either(where(in->face, third), where(in->sides[1] | in->sides[2], t)),
                        where(in->corners[2], ONE));
}

static inline i64x4 number_regions(const Regions *in)
{
    i64x4 numbers = {0};
    for (int k = 0; k < 3; k++) {
        numbers |= (in->sides[k] & (REGION_SIDE_0 + k)) | (in->corners[k] & (REGION_CORNER_0 + k));
    }
    return numbers;
}

/// Weighted sum of the corners, as distance2_at has it.
static inline f64x4 distances2(FourPoints p, FourPoints a, FourPoints b, FourPoints c, const f64x4 w[3])
{
    FourPoints d = {p.x - ((a.x * w[0] + b.x * w[1]) + c.x * w[2]),
                    p.y - ((a.y * w[0] + b.y * w[1]) + c.y * w[2]),
                    p.z - ((a.z * w[0] + b.z * w[1]) + c.z * w[2])};
    return dot(d, d);
}

/// The thin ones are not decided by regions.
static void correct_thin(Vec3 point, const f32x4 corners[3][CLOSEST_FOUR], i64x4 thin,
                         PercaleFourClosest *closest)
{
    for (uint32_t i = 0; i < CLOSEST_FOUR; i++) {
        if (thin[i] != 0) {
            PercaleClosest one = percale_closest_on_triangle(point, vec3_of(corners[0][i]),
                                                             vec3_of(corners[1][i]), vec3_of(corners[2][i]));
            closest->distance2[i] = one.distance2;
            closest->region[i] = one.region;
            for (int k = 0; k < 3; k++) {
                closest->weights[k][i] = one.weights[k];
            }
        }
    }
}

void percale_closest_on_four(Vec3 point, const f32x4 corners[3][CLOSEST_FOUR], PercaleFourClosest *closest)
{
    FourPoints p = {all4(point.x), all4(point.y), all4(point.z)};
    FourPoints a = transpose(corners[0]);
    FourPoints b = transpose(corners[1]);
    FourPoints c = transpose(corners[2]);
    FourPoints ab = minus(b, a);
    FourPoints ac = minus(c, a);
    FourPoints ap = minus(p, a);
    FourPoints bp = minus(p, b);
    FourPoints cp = minus(p, c);
    Products s = {.d1 = dot(ab, ap),
                  .d2 = dot(ac, ap),
                  .d3 = dot(ab, bp),
                  .d4 = dot(ac, bp),
                  .d5 = dot(ab, cp),
                  .d6 = dot(ac, cp)};
    s.va = s.d3 * s.d6 - s.d5 * s.d4;
    s.vb = s.d5 * s.d2 - s.d1 * s.d6;
    s.vc = s.d1 * s.d4 - s.d3 * s.d2;
    Regions regions = find_regions(&s);
    f64x4 weights[3];
    find_weights(&s, &regions, weights);
    i64x4 numbers = number_regions(&regions);
    f64x4 distance2 = distances2(p, a, b, c, weights);
    memcpy(closest->distance2, &distance2, sizeof(distance2));
    memcpy(closest->weights, weights, sizeof(weights));
    memcpy(closest->region, &numbers, sizeof(numbers));
    FourPoints normal = cross(ab, ac);
    i64x4 thin = at_most(dot(normal, normal), all4(THIN) * (dot(ab, ab) * dot(ac, ac)));
    if ((thin[0] | thin[1] | thin[2] | thin[3]) != 0) {
        correct_thin(point, corners, thin, closest);
    }
}
