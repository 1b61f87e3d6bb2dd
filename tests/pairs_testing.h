// pairs_testing.h: what the tests of pairs of features share: one pass over a solver's model as it stands.

#ifndef PERCALE_PAIRS_TESTING_H
#define PERCALE_PAIRS_TESTING_H

#include "detect/pairs.h"
#include "solver.h"
#include "testing.h"

/// Finds the stencils and notes of the solver's model, as of substeps of 1 ms; `obstacles` with those or
/// without.
static inline PercalePairCounts percale_test_find_pairs(PercaleSolver *solver, const f32x4 *earlier,
                                                        const PercaleNoteList *known, bool obstacles)
{
    PercaleModel *model = &solver->model;
    PercalePairCounts counts = {0};
    const f32x4 *places[3] = {earlier, model->position, model->predicted};
    percale_tree_refit_swept(&solver->cloth_tree, model->cloth.triangles, places, 3, percale_team_alone());
    PercalePairStage stage = {.model = model,
                              .tree = &solver->cloth_tree,
                              .earlier = earlier,
                              .ahead = model->predicted,
                              .known = known,
                              .dt = 1e-3f,
                              .cloth = !obstacles,
                              .edges = true,
                              .obstacles = obstacles,
                              .team = percale_team_alone()};
    solver->stencils.count = 0;
    ck_assert(percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                 &solver->notes[1], &counts));
    return counts;
}

#endif
