// tangle_testing.h: a solver's model with its crossings and contours, for tests of the untangling.

#ifndef PERCALE_TANGLE_TESTING_H
#define PERCALE_TANGLE_TESTING_H

#include "solver.h"
#include "tangle_cases.h"
#include "testing.h"
#include "untangle/contours.h"

/// A tangle, looked at.
typedef struct Tangle {
    PercaleCrossingSearch search; // first: aligned to cache lines
    PercaleSolver *solver;
    PercaleMemory memory;
    PercaleTangleMesh mesh;
    PercaleTangleCrossings crossings;
    PercaleContours contours;
} Tangle;

static inline void look_with(PercaleTeam *team, void *context)
{
    Tangle *tangle = context;
    const f32x4 *x = tangle->solver->model.position;
    ck_assert(
        percale_crossing_search_open(&tangle->search, &tangle->mesh, x, team, &tangle->memory) &&
        percale_crossing_search_run(&tangle->search, x, team, &tangle->memory, &tangle->crossings) &&
        percale_contours_build(&tangle->contours, &tangle->mesh, &tangle->crossings, x, &tangle->memory));
}

/// Takes the solver, whose scene is complete.
static inline Tangle *look(PercaleSolver *solver, int thread_count)
{
    Tangle *tangle = aligned_alloc(_Alignof(Tangle), sizeof(*tangle));
    ck_assert_ptr_nonnull(tangle);
    memset(tangle, 0, sizeof(*tangle));
    tangle->solver = solver;
    tangle->memory = (PercaleMemory){&solver->allocator, 0};
    PERCALE_TEST_OK(solver, percale_solver_prepare(solver));
    ck_assert(percale_tangle_mesh_build(&tangle->mesh, &solver->model, &tangle->memory));
    PercaleCrowding crowding = {0, 0};
    percale_team_open(thread_count, &crowding, look_with, tangle);
    return tangle;
}

static inline void look_away(Tangle *tangle)
{
    percale_contours_free(&tangle->contours, &tangle->memory);
    percale_memory_free(&tangle->memory, tangle->crossings.items);
    percale_crossing_search_close(&tangle->search, &tangle->memory);
    percale_tangle_mesh_free(&tangle->mesh, &tangle->memory);
    ck_assert_uint_eq(tangle->memory.bytes, 0);
    percale_solver_destroy(tangle->solver);
    free(tangle);
}

/// A solver with the case's cloths and body.
static inline PercaleSolver *solver_of_case(const TangleCase *tangle)
{
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    for (uint32_t i = 0; i < tangle->cloth_count; i++) {
        PercaleClothDef def = percale_test_cloth_def(&tangle->cloths[i]);
        PercaleCloth cloth;
        def.material.thickness = tangle->thickness;
        def.layer = tangle->layers[i];
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    }
    if (tangle->body.vertex_count > 0) {
        (void)percale_test_add_obstacle(solver, &tangle->body);
    }
    return solver;
}

#endif
