// flat_passing.h: which features of the cloth have gone through an obstacle where it is flat (detect/flat.h).
//
//   in   start and predicted positions, lower bounds of the vertices' distances from the obstacle
//   out  of each passage the stencil that pushes it back, appended to the stage's `passing`
//
// These features are among no candidates, for the cloth's vertices keep it away from them. Where a vertex has
// come nearer than it ever should, its faces and edges are tested against what is near.

#ifndef PERCALE_FLAT_PASSING_H
#define PERCALE_FLAT_PASSING_H

#include "finish/passing.h"

/// `touched`: only what has such a point; NULL: all. `reach`: m, of contact. False without memory.
bool percale_flat_passages_find(const PercalePairGuardStage *stage, uint32_t obstacle, const uint8_t *touched,
                                double reach);

#endif
