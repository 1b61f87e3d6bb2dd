// tangler.h: everything that is needed to look at a tangle and to find what has to move.
//
//   in   the model, positions
//   out  crossings, contours, and the stage on which stencils are made of them
//
// Untangling on request (step_untangle.c) and inside of steps (step_heal.c) work with it.

#ifndef PERCALE_TANGLER_H
#define PERCALE_TANGLER_H

#include "untangle/untangle.h"

typedef struct PercaleTangler {
    PercaleTangleMesh mesh;
    PercaleCrossingSearch *search; // aligned to cache lines
    PercaleTangleCrossings crossings;
    PercaleContours contours;
    PercaleRegionFlood flood;
    PercaleTangleStage stage;
    PercaleStencilList stencils;
    float *edge_lengths; // [edge_count] m, when it was opened
    PercaleMemory *memory;
} PercaleTangler;

/// x: where the points are now; `obstacles`: what is tangled with them counts, too. False without memory; to
/// be closed all the same.
bool percale_tangler_open(PercaleTangler *tangler, const PercaleModel *model, const f32x4 *x, bool obstacles,
                          PercaleTeam *team, PercaleMemory *memory);
void percale_tangler_close(PercaleTangler *tangler);

/// Finds crossings and contours of the positions x, which are the stage's then. False without memory.
bool percale_tangler_look(PercaleTangler *tangler, const f32x4 *x, PercaleTeam *team);

#endif
