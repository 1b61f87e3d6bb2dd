// push.h: puts what is on the wrong side of a surface back, as a whole.
//
//   in   a contour, whose side is known or whose smaller part is wrong
//   out  stencils of the points that it cuts off against the other surface's nearest faces
//
// A point's side is that of the contour: it does not depend on how deep the point is. Of a closed obstacle
// all is wrong that is inside, whatever the contours.

#ifndef PERCALE_PUSH_H
#define PERCALE_PUSH_H

#include "untangle/tangle_stage.h"

/// *pushed: whether it has cut off anything. False without memory.
bool percale_push_region(PercaleTangleStage *stage, uint32_t contour, bool *pushed);

/// Cloth that is inside of closed obstacles, and obstacles' edges that stand out through cloth. False without
/// memory.
bool percale_push_out(PercaleTangleStage *stage);

#endif
