// watch.h: whether the cloth goes through itself, looked for a little at a time.
//
//   in   positions, a range of the cloth's edges
//   out  whether one of them goes through a face, and so two triangles cross that share no point
//
// It asks the tree that contact is found with.

#ifndef PERCALE_WATCH_H
#define PERCALE_WATCH_H

#include "detect/candidates.h"

typedef struct PercaleWatchStage {
    const PercaleModel *model;
    PercaleTree *faces; // of the cloth; refitted to x
    const f32x4 *x;     // positions
    PercaleCollectors *collectors;
    PercaleMemory *memory;
    PercaleTeam *team;
} PercaleWatchStage;

/// Asks the edges [first, end). False without memory.
bool percale_watch_run(const PercaleWatchStage *stage, uint32_t first, uint32_t end, bool *crossed);

#endif
