// held_bending.h: bending that is slow enough to act less often than every substep.
//
//   in   predicted points, where they were when the substep began, where they will be n substeps after that;
//        hinges in batches
//   out  predicted points and velocities, pushed; the pushes, for the substeps until bending is due again
//
// Its force is found in every n-th substep, where the points will be n substeps after its start. Between,
// predict adds it like gravity. As an impulse of n substeps at once it would hold up resting cloth only on
// the average, which falls and is thrown up again n substeps later (MATH.md, section 5).

#ifndef PERCALE_HELD_BENDING_H
#define PERCALE_HELD_BENDING_H

#include "solve/sweep.h"

typedef struct PercaleHeldBending {
    PercaleSweepPlan plan; // with the hinges; arrays.start, x and velocity of the substep
    uint32_t interval;     // n
    f32x4 *pushes; // [slot_count] in: the points ahead, m; out: what they are pushed by in a substep, m/s
} PercaleHeldBending;

/// In the n-th substeps. False without memory (in the arena).
bool percale_held_bending_run(const PercaleHeldBending *held, PercaleTeam *team, PercaleArena *arena);

#endif
