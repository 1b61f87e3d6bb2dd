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
    ck_assert(percale_tangle_mesh_build(&tangle->mesh, &solver->model, true, &tangle->memory));
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

/// Pairs that cross, as the audit counts them; nothing but numbers.
static inline double pairs_of(PercaleSolver *solver)
{
    PercaleQuality quality;
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    ck_assert(quality.nonfinite == 0.0);
    return quality.ef_cloth_cloth + quality.ef_cloth_obstacle;
}

/// Two level sheets, the second a little lower than the first in its middle third; of this layer.
static inline PercaleSolver *lay_two(PercaleSolverDef solver_def, float height, int32_t layer)
{
    PercaleSolver *solver = percale_test_solver(solver_def);
    for (int i = 0; i < 2; i++) {
        PercaleMesh mesh = percale_test_sheet(21, 0.4f);
        for (uint32_t v = 0; i == 1 && v < mesh.vertex_count; v++) {
            float *x = mesh.positions + 3 * (size_t)v;
            x[1] = x[0] > -0.09f && x[0] < 0.11f ? -height : height;
        }
        PercaleClothDef def = percale_test_cloth_def(&mesh);
        PercaleCloth cloth;
        def.layer = i == 1 ? layer : 0;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
        percale_mesh_free(&mesh);
    }
    return solver;
}

static inline double mean_height(PercaleSolver *solver, PercaleCloth cloth)
{
    float positions[3 * 21 * 21];
    double sum = 0.0;
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, positions, 0));
    for (size_t v = 0; v < sizeof positions / sizeof positions[0] / 3; v++) {
        sum += (double)positions[3 * v + 1];
    }
    return sum;
}

#endif
