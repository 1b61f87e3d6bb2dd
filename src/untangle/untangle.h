// untangle.h: what is to move so that a tangle comes apart.
//
//   in   contours of the positions x, for how long each triangle has been in one
//   out  stencils; the resolution projects them, looks again, and so on
//
// Cloth inside closed obstacles is pushed out. Of other contours, what they cut off is pushed to the right
// side; one that cuts nothing off is made shorter. One that resists is tried the other way; one that resists
// for long is left, and the others go on.

#ifndef PERCALE_UNTANGLE_H
#define PERCALE_UNTANGLE_H

#include "untangle/tangle_stage.h"

typedef struct PercaleTangleAges {
    uint8_t *rounds;  // [triangle_count] that it has been in a contour without a break
    uint8_t *fails;   // [triangle_count] times that its contour has become worse and was put back
    uint8_t turns;    // how often all has got worse: contours are then treated the other way
    uint8_t patience; // rounds after which a contour is left
} PercaleTangleAges;

/// Counts the rounds on.
void percale_tangle_ages_count(PercaleTangleAges *ages, const PercaleTangleStage *stage);

/// Replaces the stage's stencils, but for those that still hold. False without memory.
bool percale_tangle_find_stencils(PercaleTangleStage *stage, const PercaleTangleAges *ages);

#endif
