// sweep.h: runs the solver's sweeps over all constraints, as a program of phases.
//
//   in   solve arrays, batches of each kind
//   out  predicted positions
//
// A sweep takes the tiles side by side, in each bending and then stretch, colour after colour; so the tiles
// of each further level, which hold what joins smaller ones; then what joins the last level's; tethers; open
// seams; contacts. Internal constraints come first and contacts last, so that they
// win. Whatever the program looks like (tiles, colours over the whole cloth, short runs on one thread), it is
// a list of phases.

#ifndef PERCALE_SWEEP_H
#define PERCALE_SWEEP_H

#include "base/arena.h"
#include "base/team.h"
#include "solve/solve_arrays.h"

typedef struct PercaleSweepPlan {
    PercaleSolveArrays arrays;
    const PercaleBatches *edges, *hinges, *contacts;
    uint32_t sweep_count;
} PercaleSweepPlan;

/// False without memory (the program's, in the arena).
bool percale_sweep_run(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena);

/// Contacts once more, layer by layer outwards, while all cloths of lower layers stand still: an inner layer
/// that the body has pushed out pushes the outer ones on, and they don't push it back into the body (shock
/// propagation: Guendelman et al. 2003, section 7.2). False without memory.
bool percale_sweep_outwards(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena);

/// The hinges alone. False without memory.
bool percale_sweep_hinges(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena);

/// After the velocities are known: those of corrections are taken away. False without memory.
bool percale_sweep_exits(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena);

#endif
