// substep.h: what the files of the step share: step.c, which knows the order of the stages, and
// step_detect.c, step_heal.c, step_solve.c, which hand the solver's arrays to three of them.

#ifndef PERCALE_SUBSTEP_H
#define PERCALE_SUBSTEP_H

#include "base/timer.h"
#include "finish/guard.h"
#include "solve/sweep.h"
#include "solver.h"

/// One substep of a step.
typedef struct Substep {
    PercaleSolver *solver;
    PercaleTeam *team;
    int index;       // 0 .. substeps - 1
    float dt;        // s
    double fraction; // of the step, at this substep's end
    bool has_pass;   // a collision pass falls into it
    bool any_leaves; // a contact opens fast
    bool renewed;    // stencils of pairs between passes
    double since;    // clock when the running stage began, s
} Substep;

static inline void end_stage(Substep *substep, PercaleStage stage)
{
    double now = percale_seconds();
    substep->solver->profile.stage_seconds[stage] += now - substep->since;
    substep->since = now;
}

/// Substeps after this one until the next pass, at most.
static inline float later_substeps(const PercaleSolverDef *def)
{
    int between = (def->substeps + def->passes - 1) / def->passes;
    return (float)(between - 1);
}

/// The same for pairs: where the guard waits, too, they don't look ahead.
static inline float later_substeps_of_pairs(const PercaleSolverDef *def)
{
    return def->guard_passes ? 0.0f : later_substeps(def);
}

static inline PercalePair pair_of(const Substep *substep, uint32_t obstacle)
{
    const PercaleSolver *solver = substep->solver;
    return (PercalePair){&solver->model, &solver->model.obstacles[obstacle],
                         substep->has_pass ? later_substeps(&solver->def) : 0.0f, substep->has_pass,
                         substep->has_pass && solver->def.reuse == PERCALE_REUSE_ALWAYS};
}

/// Whether bending's force is found anew in this substep, where it acts less often than in each.
static inline bool is_bending_due(const Substep *substep)
{
    return (uint32_t)substep->index % substep->solver->bend_interval == 0;
}

static inline bool is_bending_held(const PercaleSolver *solver)
{
    return solver->model.hinge_count > 0 && solver->bend_interval > 1;
}

/// PercalePinchState of each vertex of the cloth; NULL: none is pinched.
static inline const uint8_t *pinched_or_none(const PercaleSolver *solver)
{
    return solver->pinches.count > 0 ? solver->pinches.states : NULL;
}

/// The same, with where it is pinched.
static inline const PercalePinches *pinches_or_none(const PercaleSolver *solver)
{
    return solver->pinches.count > 0 ? &solver->pinches : NULL;
}

/// What contact and guards have to let through; NULL: nothing.
static inline const PercaleReleases *releases_or_none(const PercaleSolver *solver)
{
    return solver->healing.is_tangled ? &solver->healing.releases : NULL;
}

/// Where obstacles leave no room.
static inline PercalePinchStage pinch_stage_of(const Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    return (PercalePinchStage){&solver->model,   solver->proximities, solver->crossings,
                               &solver->pinches, substep->dt,         substep->team};
}

// ---- step.c ----

/// All substeps of a step.
void percale_run_on(PercaleSubsteps *substeps, PercaleTeam *team);

// ---- step_detect.c ----

/// Moves the obstacles; finds the vertices that can touch them and the paths that lead through.
PercaleResult percale_detect_obstacles(Substep *substep);

/// A collision pass generates all stencils anew; between passes only those of vertices that have crossed are
/// added, and pairs that have slid on renewed. `first`: in the substep.
PercaleResult percale_detect_contacts(Substep *substep, bool pass, bool first);

// ---- step_heal.c ----

/// Looks at the whole tangle from now on; `obstacles`: what is tangled with them is part of it. False without
/// memory.
bool percale_healing_open(PercaleSolver *solver, bool obstacles, PercaleTeam *team);
/// What crosses now, and what has to move. False without memory.
bool percale_healing_look(PercaleSolver *solver, PercaleTeam *team);
/// At the begin of a step.
PercaleResult percale_begin_healing(PercaleSolver *solver, PercaleTeam *team);
/// Appends the stencils of what is tangled to those of a pass. False without memory.
bool percale_add_healing(Substep *substep);
/// In a substep without a pass: they open a little further.
void percale_raise_healing(Substep *substep);

// ---- step_solve.c ----

/// Multipliers start at zero in every substep; open seams are asked to close a little further.
void percale_begin_solve(Substep *substep);

/// What the kernels work on.
PercaleSolveArrays percale_solve_arrays(const Substep *substep);

/// Slow bending is a force, like gravity, that is found anew in some substeps.
PercaleResult percale_hold_bending(Substep *substep);

PercaleResult percale_color_contacts(Substep *substep, bool pass);

/// Once over the coarse levels, before the first sweep.
PercaleResult percale_solve_coarse(Substep *substep);
PercaleResult percale_solve(Substep *substep, uint32_t sweep_count);

/// After the last sweep: outer layers give way; the slip that friction still owes. False without memory.
bool percale_end_solve(Substep *substep);

#endif
