// descent.h: makes a contour shorter (intersection contour minimisation: Volino and Magnenat-Thalmann 2006).
//
//   in   a contour
//   out  stencils that move each of its edges against the face that it goes through
//
// With E the edge's direction, N the face's normal and R the sum of the unit vectors to the crossing from its
// neighbours along the contour, moving the edge by t against the face makes the contour longer by
// (R - (E . R) / (E . N) N) . t: MATH.md, section 10. So the edge goes the other way.

#ifndef PERCALE_DESCENT_H
#define PERCALE_DESCENT_H

#include "untangle/tangle_stage.h"

/// Change of the contour's length with the way of the edge of step `index` (of the contour) against its face.
Vec3 percale_descent_gradient(const PercaleTangleStage *stage, const PercaleContour *contour, uint32_t index);

/// step: way of an edge where the gradient is steep, in lengths of the edge. False without memory.
bool percale_descend(PercaleTangleStage *stage, uint32_t contour, double step);

#endif
