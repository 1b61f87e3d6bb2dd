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

PercaleClosest percale_closest_on_triangle(Vec3 point, Vec3 a, Vec3 b, Vec3 c);

/// A triangle without area may be nearest with several of its sides or corners at once: they lie on each
/// other.
enum { CLOSEST_MOST = 6 };

/// All that are, where closest[0] is one of them; returns their number. Which they are does not depend on the
/// order of the corners.
int percale_closest_features(Vec3 point, Vec3 a, Vec3 b, Vec3 c, PercaleClosest closest[CLOSEST_MOST]);

#endif
