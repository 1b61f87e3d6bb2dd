// impact_time.h: until when a vertex and a face, or two edges, are proved to stay apart on straight ways.
//
//   in   the four points at the start and the end, and a separation to keep
//   out  whether they may come as near as that; if so, a time up to which they don't, with the closest points
//        and a plane between the features at that time
//
// Conservative: what comes within the separation is always found, and never later than it happens. What stays
// apart is found only when it is so near that rounding, or a fixed amount of work, can't tell. src/MATH.md,
// section 9.

#ifndef PERCALE_IMPACT_TIME_H
#define PERCALE_IMPACT_TIME_H

#include "base/simd.h"

#include <stdbool.h>

typedef struct PercaleImpact {
    double time;       // in [0, 1]; before it they are farther apart than the separation
    double weights[4]; // signed: the weighted sum of the points at `time` leads from the second feature's
                       // closest point to the first's; up to 1e-7 of the largest difference for
                       // triangles that are nearly a line and edges that are nearly parallel
    Vec3 normal;       // unit, from the second feature to the first: all of the first is on that side then;
                       // zero when there is no such plane, or the input is not finite: then time is 0
} PercaleImpact;

/// from, to: [4], vertex, face 0, 1, 2. `impact` is written when the answer is true.
bool percale_vertex_face_impact_time(const Vec3 *from, const Vec3 *to, double separation,
                                     PercaleImpact *impact);

/// from, to: [4], edge a 0, a 1, edge b 0, b 1.
bool percale_edge_edge_impact_time(const Vec3 *from, const Vec3 *to, double separation,
                                   PercaleImpact *impact);

#endif
