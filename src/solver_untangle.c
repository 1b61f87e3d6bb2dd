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
    PercaleResult result = percale_solver_prepare(solver);
    if (result != PERCALE_OK) {
        return result;
    }
    double began = percale_seconds();
    PercaleUntangling untangling = {.solver = solver, .def = *def, .result = PERCALE_OK};
    size_t work = (size_t)solver->model.slot_count + solver->edges.count + solver->hinges.count;
    percale_team_open(threads_for(work, solver->def.thread_count), &solver->crowding,
                      solver->engine->run_untangling, &untangling);
    percale_solver_release_model(solver); // trees, notes and candidates are those of before
    if (untangling.result != PERCALE_OK) {
        return percale_fail_memory(&solver->error);
    }
    *report = untangling.report;
    report->seconds = percale_seconds() - began;
    return PERCALE_OK;
}

PercaleResult percale_solver_untangle(PercaleSolver *solver, const PercaleUntangleDef *def,
                                      PercaleUntangleReport *report)
{
    uint32_t mode = float_mode_enter(); // the host may round otherwise
    PercaleResult result = untangle(solver, def, report);
    float_mode_leave(mode);
    return percale_solver_logged(solver, result);
}
