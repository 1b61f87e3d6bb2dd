// passage.h: whether a vertex goes through a face, or an edge through an edge, when all four points move on
// straight lines.
//
//   in   the four points at the start and the end
//   out  where and when they last met, and which way is back
//
// The points are a vertex and a triangle, or two edges. They are in a plane at the roots of a cubic (Provot
// 1997); at each it is asked whether the features meet. An even number of times is no passage: it has come
// back.

#ifndef PERCALE_PASSAGE_H
#define PERCALE_PASSAGE_H

#include "base/simd.h"

#include <stdbool.h>

// A path this share of a feature's size beside it still goes through it: neighbours leave no gap.
static const double SEAMLESS = 1e-6;

typedef struct PercalePassage {
    double time;       // of the last meeting, in [0, 1]
    double weights[4]; // of the points that met; their weighted sum was zero
    Vec3 normal;       // unit: across face or edges when they met, to the side from which the first came;
                       // zero where there is none
} PercalePassage;

bool percale_vertex_passes(const Vec3 *from, const Vec3 *to, PercalePassage *passage);
bool percale_edges_pass(const Vec3 *from, const Vec3 *to, PercalePassage *passage);

/// Weights of the closest points of two lines, when both are inside their edges (`slack` of the lengths
/// beyond); else false, as for parallel edges.
bool percale_weigh_edges(const Vec3 *x, double slack, double weights[4]);

/// The sum of the weighted points.
static inline Vec3 weigh_points(const Vec3 *x, const double weights[4])
{
    Vec3 sum = vscale(weights[0], x[0]);
    for (int k = 1; k < 4; k++) {
        sum = vadd(sum, vscale(weights[k], x[k]));
    }
    return sum;
}

#endif
