// coarse_sweep.h: once over the coarse levels of the cloth, from the coarsest to the cloth itself.
//
//   in   levels with their links in batches, predicted points
//   out  predicted points, moved
//
// At each level nodes stand where their vertices are, moved as the level above says; links that are too long
// are pulled to their length (C = |xa - xb| - l <= 0), colour after colour; what the nodes have moved is what
// the level below takes over. In the end the cloth's vertices do.

#ifndef PERCALE_COARSE_SWEEP_H
#define PERCALE_COARSE_SWEEP_H

#include "base/arena.h"
#include "base/team.h"
#include "color/batch.h"

/// links: [coarse->level_count]; x: [slot_count] predicted points. False without memory (in the arena).
bool percale_coarse_sweep(const PercaleCoarse *coarse, const PercaleBatches *links, f32x4 *x,
                          PercaleTeam *team, PercaleArena *arena);

#endif
