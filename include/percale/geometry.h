// geometry.h: the distances and the impact times on their own. Pure, in double, no state.
//
// Arrays are in the order vertex, face 0, face 1, face 2, or edge a 0, a 1, edge b 0, b 1. The weights are
// those of the signed stencil: with the closest points' difference d = sum weight[i] x[i], |d| is the
// distance, and the weights sum to 0.

#ifndef PERCALE_GEOMETRY_H
#define PERCALE_GEOMETRY_H

#include "percale/types.h"

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Distance of a vertex to a triangle; weight = (1, -b0, -b1, -b2). A triangle without area counts as its
/// edges.
PERCALE_API double percale_vertex_face_closest(const double x[4][3], double weight[4]);

/// Distance of two segments; weight = (b0, b1, -b2, -b3). Parallel segments: the closest pair of smallest
/// index.
PERCALE_API double percale_edge_edge_closest(const double x[4][3], double weight[4]);

// Impacts: each point goes straight from `start` at time 0 to `end` at time 1. False proves that the features
// don't touch at any time from 0 to 1. True: they do, or come so near that rounding can't tell; then *time,
// in [0, 1], is never later than the first touch, and 0 when they touch at the start. Never a miss, whatever
// the shape: triangles and edges without area or length, motion in one plane, parallel edges, no motion at
// all. What stays farther apart than 1e-9 of the largest difference of coordinates is told apart, but for
// rare queries that would take more than a bounded amount of work. Where the features close in, the time is
// less than 1e-6 early. Far from the origin nothing changes: only differences count.
//
// Coordinates that are not finite or differ by 1e60 or more, and a separation that is negative, not finite or
// as large, give true and time 0: nothing is proved. `time` is written only with true.
//
// The method is this project's, separating directions that turn with time (src/MATH.md, section 9). For the
// task and other ways see Wang et al. 2021, "A Large-Scale Benchmark and an Inclusion-Based Algorithm for
// Continuous Collision Detection", and Li et al. 2021, "Codimensional Incremental Potential Contact",
// section 5.

/// A vertex and a triangle.
PERCALE_API bool percale_vertex_face_impact(const double start[4][3], const double end[4][3], double *time);

/// Two segments.
PERCALE_API bool percale_edge_edge_impact(const double start[4][3], const double end[4][3], double *time);

/// The same for coming within `separation` (>= 0, in the unit of the coordinates) of each other.
PERCALE_API bool percale_vertex_face_approach(const double start[4][3], const double end[4][3],
                                              double separation, double *time);
PERCALE_API bool percale_edge_edge_approach(const double start[4][3], const double end[4][3],
                                            double separation, double *time);

#ifdef __cplusplus
}
#endif

#endif
