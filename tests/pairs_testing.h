// pairs_testing.h: what the tests of pairs of features share: one pass over a solver's model as it stands.

#ifndef PERCALE_PAIRS_TESTING_H
#define PERCALE_PAIRS_TESTING_H

#include "detect/pairs.h"
#include "solver.h"
#include "testing.h"

/// Finds the stencils and notes of the solver's model, as of substeps of 1 ms; `obstacles` with those or
/// without. `only`: those of some sources, where nothing is crossed; NULL: all.
static inline PercalePairCounts percale_test_find_pairs(PercaleSolver *solver, const PercaleNoteList *known,
                                                        bool obstacles, const PercaleSources *only)
{
    PercaleModel *model = &solver->model;
    PercaleCandidates *candidates = &solver->candidates;
    PercalePairCounts counts = {0};
    PercaleTeam *alone = percale_team_alone();
    PercaleCandidateStage ways = {.from = model->position,
                                  .to = model->predicted,
                                  .collectors = &solver->collectors,
                                  .memory = &solver->detect_memory,
                                  .team = alone};
    candidates->cloth = !obstacles;
    candidates->obstacles = obstacles;
    candidates->known = false;
    ck_assert(percale_candidates_keep(candidates, &ways, &counts.candidates));
    PercalePairStage stage = {.model = model,
                              .end = model->predicted,
                              .candidates = candidates,
                              .known = known,
                              .dt = 1e-3f,
                              .may_be_crossed = only == NULL,
                              .only = only,
                              .arena = &solver->arena,
                              .team = alone};
    percale_arena_reset(&solver->arena);
    solver->stencils.count = 0;
    ck_assert(percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                 &solver->notes[1], &counts));
    return counts;
}

#endif
