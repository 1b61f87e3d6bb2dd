// path_guard.h: no cloth vertex has come through an obstacle's front on its way, or it is counted: ccd=exact.
//
//   in   start and end of the substep of cloth and obstacles, clearances at the start or ways known to be
//   free out  final predicted positions and velocities of those that had come through, corrected
//
// A vertex that may have touched a front goes to the point of the touch, which the obstacle has carried on,
// a gap in front of it, and is tested again, against all obstacles. In a corner it goes half of that way,
// then none of it: it is carried along by the obstacle from where it started, which can't be wrong with one
// that keeps its shape. What obstacles leave no way at all is counted.

#ifndef PERCALE_PATH_GUARD_H
#define PERCALE_PATH_GUARD_H

#include "detect/paths.h"

typedef struct PercalePathGuardStage {
    PercaleModel *model; // predicted and next_velocity are corrected in place
    PercaleProximity *proximities;
    const PercaleFrame *frames; // [obstacle_count] as proximities
    f32x4 *proved;              // [slot_count] where the ways were last tested to; written
    bool again; // proved is from before, and clearances are at the end: what has moved since is tested
    float dt;   // s
    PercaleTeam *team;
} PercalePathGuardStage;

typedef struct PercalePathGuardCounts {
    uint64_t truncated; // vertices that were put back
    uint64_t left;      // of them, those that still come through
} PercalePathGuardCounts;

PercalePathGuardCounts percale_path_guard_run(const PercalePathGuardStage *stage);

#endif
