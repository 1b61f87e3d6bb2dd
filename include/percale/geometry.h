// geometry.h: the distance functions on their own. Pure, in double, no state.
//
// Arrays are in the order vertex, face 0, face 1, face 2, or edge a 0, a 1, edge b 0, b 1. The weights are
// those of the signed stencil: with the closest points' difference d = sum weight[i] x[i], |d| is the
// distance, and the weights sum to 0.

#ifndef PERCALE_GEOMETRY_H
#define PERCALE_GEOMETRY_H

#include "percale/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Distance of a vertex to a triangle; weight = (1, -b0, -b1, -b2). A triangle without area counts as its
/// edges.
PERCALE_API double percale_vertex_face_closest(const double x[4][3], double weight[4]);

/// Distance of two segments; weight = (b0, b1, -b2, -b3). Parallel segments: the closest pair of smallest
/// index.
PERCALE_API double percale_edge_edge_closest(const double x[4][3], double weight[4]);

#ifdef __cplusplus
}
#endif

#endif
