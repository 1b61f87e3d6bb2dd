// untangle.h: what is to move so that a tangle comes apart.
//
//   in   contours of the positions x
//   out  stencils, and what has to be released from contact for them
//
// Cloth inside closed obstacles is pushed out. Of other contours, what they cut off is pushed to the right
// side; one that cuts nothing off is made shorter.

#ifndef PERCALE_UNTANGLE_H
#define PERCALE_UNTANGLE_H

#include "untangle/tangle_stage.h"

/// Replaces the stage's stencils. False without memory.
bool percale_tangle_find_stencils(PercaleTangleStage *stage);

#endif
