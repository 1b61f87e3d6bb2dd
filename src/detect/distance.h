// distance.h: closest points of a point and a triangle, and of two segments, in double.

#ifndef PERCALE_DISTANCE_H
#define PERCALE_DISTANCE_H

#include "base/simd.h"

/// Where on a triangle a closest point lies. Side k runs from corner k to corner k + 1.
typedef enum PercaleRegion {
    REGION_FACE = 0,
    REGION_SIDE_0,
    REGION_SIDE_1,
    REGION_SIDE_2,
    REGION_CORNER_0,
    REGION_CORNER_1,
    REGION_CORNER_2
} PercaleRegion;

typedef struct PercaleClosest {
    double distance2;  // m^2
    double weights[3]; // barycentric coordinates of the closest point
    PercaleRegion region;
} PercaleClosest;

// sin^2 of a triangle's angle below which the regions' determinants, whose rounding grows with 1 / sin^2,
// give way to the normal, whose rounding grows with 1 / sin
static const double THIN = 1e-4;

PercaleClosest percale_closest_on_triangle(Vec3 point, Vec3 a, Vec3 b, Vec3 c);

enum { CLOSEST_FOUR = 4 };

/// Of four triangles.
typedef struct PercaleFourClosest {
    double distance2[CLOSEST_FOUR];
    double weights[3][CLOSEST_FOUR];
    int64_t region[CLOSEST_FOUR]; // a PercaleRegion
} PercaleFourClosest;

/// Four triangles at once, of which corner k of number i is corners[k][i]: the same bits as one by one.
void percale_closest_on_four(Vec3 point, const f32x4 corners[3][CLOSEST_FOUR], PercaleFourClosest *closest);

static inline PercaleClosest one_of_four(const PercaleFourClosest *four, uint32_t k)
{
    return (PercaleClosest){four->distance2[k],
                            {four->weights[0][k], four->weights[1][k], four->weights[2][k]},
                            (PercaleRegion)four->region[k]};
}

/// A triangle without area may be nearest with several of its sides or corners at once: they lie on each
/// other.
enum { CLOSEST_MOST = 6 };

/// All that are, where closest[0] is one of them; returns their number. Which they are does not depend on the
/// order of the corners.
int percale_closest_features(Vec3 point, Vec3 a, Vec3 b, Vec3 c, PercaleClosest closest[CLOSEST_MOST]);

#endif
