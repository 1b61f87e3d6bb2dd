// mannequin.h: a walking body, made from nothing but numbers.
//
//   in   a time, s
//   out  a closed triangle mesh of a woman of 1.70 m, y up, feet on y = 0, facing +z, walking on the spot
//
// At time 0 she stands still in an A-pose, within the first second she falls into a stride that repeats for
// ever. Her arms stay clear of the trunk and the skirt, and no two parts of the skin ever meet.

#ifndef PERCALE_MANNEQUIN_H
#define PERCALE_MANNEQUIN_H

#include "percale/scene.h"

typedef struct PercaleMannequin PercaleMannequin;

/// Makes the body; `mesh` is its pose at time 0 and the caller's to free. `jump`: she leaps sideways (+x) by
/// so many metres between the times 1 s and 1 s + 1/60 s; 0: never. `speed`: of the walk, 1: a stroll, 2: in
/// half the time, 0: she stands. NULL on failure.
PercaleMannequin *percale_mannequin_make(double jump, double speed, PercaleMesh *mesh,
                                         PercaleSceneError *error);

/// Where the vertices are at a time, s (before 0: as at 0). positions: [3 * vertex_count] m.
void percale_mannequin_pose(const PercaleMannequin *mannequin, double seconds, float *positions);

void percale_mannequin_free(PercaleMannequin *mannequin); ///< NULL is allowed

#endif
