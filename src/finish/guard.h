// guard.h: nothing passes: after the last sweep no cloth vertex is left below an obstacle's surface, or it is
// counted.
//
//   in   final predicted positions, new velocities, the obstacle at the end pose, the active vertices
//   out  both corrected (a correction is no velocity), clearances for the next substep
//
// A vertex that has crossed the surface, by its path or by its end, is put back before it, at a small gap
// (with ccd=exact path_guard.h has seen to the paths). Where two obstacles leave no room it may come to lie
// in an earlier one: that one finds it, and counts it, in the next substep.

#ifndef PERCALE_GUARD_H
#define PERCALE_GUARD_H

#include "detect/contacts.h"
#include "detect/paths.h"

typedef struct PercaleGuardStage {
    const PercalePair *pair;
    PercaleProximity *proximity;
    const PercaleSurface *surface; // end pose
    const PercaleFrame *frame;
    f32x4 *predicted; // [slot_count] corrected in place
    f32x4 *velocity;  // [slot_count] m/s, too
    float dt;         // s
    bool test_paths;  // ccd=ray
    bool corrects;    // else it only counts, and keeps the clearances
    PercaleProximity *
        judged; // [judged_count] of the obstacles that have been before: what this one moves, they don't know
    uint32_t judged_count;
    PercaleTeam *team;
} PercaleGuardStage;

typedef struct PercaleGuardCounts {
    uint64_t left_inside; // vertices that are still below the surface
    uint64_t truncated;   // vertices that were put back
    uint64_t searches;    // exact distance queries
} PercaleGuardCounts;

PercaleGuardCounts percale_guard_run(const PercaleGuardStage *stage);

/// Who has been moved into a closed obstacle since is lifted out of it; what is known of others' distances is
/// as the first run left it.
PercaleGuardCounts percale_guard_lift(const PercaleGuardStage *stage);

/// Takes away what of the vertex's velocity goes against the surface at this place of it, relative to it.
void percale_guard_stop_approach(const PercalePair *pair, uint32_t slot, const PercaleCrossing *at,
                                 Vec3 normal, float dt, f32x4 *velocity);

#endif
