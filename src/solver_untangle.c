// solver_untangle.c: the state taken apart on request, outside of any step.

#include "solver.h"

#include "base/parallel.h"
#include "base/timer.h"
#include "step_untangle.h"

PercaleUntangleDef percale_untangle_def_default(void)
{
    return (PercaleUntangleDef){
        .size = sizeof(PercaleUntangleDef), .rounds = 60, .sweeps = 8, .patience = 24};
}

static bool is_within(int value, int most)
{
    return value >= 1 && value <= most;
}

/// Nothing moves but what is tangled, and everything collides.
static PercaleSolverDef at_rest(const PercaleSolverDef *own, int substeps)
{
    const float DAMPING = 5.0f; // 1/s
    PercaleSolverDef def = *own;
    for (int axis = 0; axis < 3; axis++) {
        def.gravity[axis] = def.wind[axis] = 0.0f;
    }
    def.damping = DAMPING;
    def.substeps = def.passes = substeps;
    def.iterations = 1;
    def.reuse = PERCALE_REUSE_AUTO;
    def.vertex_face = def.edge_edge = def.self_collision = def.guard = 1;
    def.guard_passes = def.tethers = def.bending = def.levels = 0;
    return def;
}

/// Of a solver that is prepared.
static PercaleResult run(PercaleSolver *solver, const PercaleUntangleDef *def, PercaleUntangleReport *report)
{
    double began = percale_seconds();
    PercaleUntangling untangling = {.solver = solver, .def = *def, .result = PERCALE_OK};
    size_t work = (size_t)solver->model.slot_count + solver->edges.count + solver->hinges.count;
    percale_team_open(threads_for(work, solver->def.thread_count), &solver->crowding,
                      solver->engine->run_untangling, &untangling);
    if (untangling.result != PERCALE_OK) {
        return untangling.result == PERCALE_OUT_OF_MEMORY ? percale_fail_memory(&solver->error)
                                                          : untangling.result;
    }
    *report = untangling.report;
    report->seconds = percale_seconds() - began;
    return PERCALE_OK;
}

static PercaleResult untangle(PercaleSolver *solver, const PercaleUntangleDef *def,
                              PercaleUntangleReport *report)
{
    const int MOST = 1000;
    const int MOST_PATIENCE = 100;
    if (def->size != sizeof(*def)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "the untangle Def did not come from percale_untangle_def_default");
    }
    if (!is_within(def->rounds, MOST) || !is_within(def->sweeps, MOST) ||
        !is_within(def->patience, MOST_PATIENCE)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "untangle: rounds %d, sweeps %d, patience %d: not in 1..%d, 1..%d, 1..%d",
                            def->rounds, def->sweeps, def->patience, MOST, MOST, MOST_PATIENCE);
    }
    percale_solver_release_model(solver);
    const PercaleSolverDef own = solver->def;
    const PercaleCounters counters = solver->counters;
    const PercaleProfile profile = solver->profile;
    solver->def = at_rest(&own, def->sweeps);
    solver->stands_still = true;
    PercaleResult result = percale_solver_prepare(solver);
    result = result == PERCALE_OK ? run(solver, def, report) : result;
    percale_solver_release_model(solver);
    solver->stands_still = false;
    solver->def = own;
    solver->counters = counters;
    solver->profile = profile;
    return result;
}

PercaleResult percale_solver_untangle(PercaleSolver *solver, const PercaleUntangleDef *def,
                                      PercaleUntangleReport *report)
{
    uint32_t mode = float_mode_enter(); // the host may round otherwise
    PercaleResult result = untangle(solver, def, report);
    float_mode_leave(mode);
    return percale_solver_logged(solver, result);
}
