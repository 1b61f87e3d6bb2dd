// kernel_solve.c: the solver's projections on their own: all edges, or all hinges, of a square sheet that has
// been crumpled a little. One iteration projects every constraint once.
//
// The arrays are those of a solver that was built through the public API, so their order in memory and their
// colours are the real ones. Beside the time stands the line of the machine: the bytes per second that the
// triad moves over the same footprint with as many threads, measured just before.

#include "base/hash.h"
#include "bench_kernel.h"
#include "bench_random.h"
#include "scene/scene_error.h"
#include "solve/sweep.h"
#include "solver.h"

#include <stdlib.h>
#include <string.h>

// What a projection moves: its points, read and written, and what it reads of its own.
enum {
    EDGE_BYTES = 3 * 4,                               // two indices, length
    HINGE_BYTES = 4 * 4 + 4 * 4,                      // four indices, four weights
    STRETCH_BYTES = 2 * 2 * POINT_BYTES + EDGE_BYTES, // 76
    BEND_BYTES = 2 * 4 * POINT_BYTES + HINGE_BYTES    // 160
};

enum { LABEL_SWEEPS = 8 };                // after so many the hash is taken, whatever is measured later
static const float SUBSTEP = 1.0f / 1200; // s; 20 substeps of a sixtieth
static const PercaleBatches no_batches;
static const double CRUMPLE = 0.1; // of an edge: how far a vertex is off its place, along each axis

typedef struct SheetSolve {
    PercaleSolver *solver;
    PercaleSweepPlan plan; // of one kind of constraint
    PercaleArena arena;    // of the sweep's program
    f32x4 *bend_weights;
    int thread_count;
    uint32_t constraint_count, color_count;
    uint32_t projection_bytes, constraint_bytes;
    double triad_rate; // bytes per second
    uint64_t hash;
} SheetSolve;

uint64_t bench_stretch_footprint(uint64_t vertices)
{
    uint64_t side = bench_sheet_side(vertices);
    uint64_t edges = 2 * side * (side - 1) + (side - 1) * (side - 1); // along, across, diagonals
    return side * side * POINT_BYTES + edges * EDGE_BYTES;
}

// ---- the sheet ----

static PercaleResult add_sheet(PercaleSolver *solver, const PercaleMesh *mesh)
{
    PercaleClothDef def = percale_cloth_def_default();
    def.name = mesh->name;
    def.positions = mesh->positions;
    def.vertex_count = mesh->vertex_count;
    def.triangles = mesh->triangles;
    def.triangle_count = mesh->triangle_count;
    PercaleCloth cloth;
    PercaleResult result = percale_cloth_add(solver, &def, &cloth);
    return result == PERCALE_OK ? percale_solver_prepare(solver) : result;
}

static PercaleSolver *new_solver(const PercaleMesh *mesh, int thread_count, PercaleSceneError *error)
{
    PercaleSolver *solver = NULL;
    PercaleSolverDef def = percale_solver_def_default();
    def.thread_count = thread_count;
    if (percale_solver_create(def, &solver) != PERCALE_OK) {
        percale_scene_fail(error, "no solver could be created");
        return NULL;
    }
    if (add_sheet(solver, mesh) != PERCALE_OK) {
        percale_scene_fail(error, "%s", percale_solver_last_error(solver));
        percale_solver_destroy(solver);
        return NULL;
    }
    return solver;
}

/// Every point somewhat off its place: a constraint that holds already would leave nothing to compare.
static void crumple(PercaleModel *model, double edge)
{
    uint64_t seed = 1;
    for (uint32_t i = 0; i < model->point_count; ++i) {
        model->predicted[i] = model->position[i];
        for (int axis = 0; axis < 3; ++axis) {
            model->predicted[i][axis] += (float)(CRUMPLE * edge * bench_random_signed(&seed));
        }
    }
}

static void lead(PercaleTeam *team, void *context)
{
    SheetSolve *run = context;
    percale_arena_reset(&run->arena);
    if (!run->solver->engine->run_sweep(&run->plan, team, &run->arena)) {
        abort(); // a program of some kilobytes
    }
}

/// The team is there for all sweeps: opening it is part of a step, not of a sweep.
static void sweep(SheetSolve *run, uint64_t count)
{
    PercaleCrowding crowding = {0, 0};
    run->plan.sweep_count = (uint32_t)count;
    percale_team_open(run->thread_count, &crowding, lead, run);
}

static uint64_t hash_of_points(const PercaleModel *model)
{
    uint64_t hash = hash_start();
    for (uint32_t i = 0; i < model->point_count; ++i) {
        uint32_t words[3];
        memcpy(words, &model->predicted[i], sizeof words);
        for (size_t axis = 0; axis < 3; ++axis) {
            hash = hash_add(hash, words[axis]);
        }
    }
    return hash;
}

// ---- the kernel ----

static void close_sheet(void *state)
{
    SheetSolve *run = state;
    percale_arena_free(&run->arena);
    free(run->bend_weights);
    percale_solver_destroy(run->solver);
    free(run);
}

static SheetSolve *open_sheet(uint64_t vertices, int thread_count, PercaleSceneError *error)
{
    PercaleMesh mesh;
    if (!bench_sheet_make(vertices, &mesh, error)) {
        return NULL;
    }
    PercaleSolver *solver = new_solver(&mesh, thread_count, error);
    SheetSolve *run = solver == NULL ? NULL : calloc(1, sizeof *run);
    percale_mesh_free(&mesh);
    if (run == NULL) {
        percale_solver_destroy(solver);
        return NULL;
    }
    PercaleModel *model = &solver->model;
    crumple(model, 1.0 / (bench_sheet_side(vertices) - 1));
    run->solver = solver;
    run->plan.arrays =
        (PercaleSolveArrays){.model = model, .x = model->predicted, .start = model->position, .dt = SUBSTEP};
    run->plan.edges = run->plan.hinges = run->plan.contacts = &no_batches;
    run->arena.memory.allocator = &solver->allocator;
    run->thread_count = thread_count;
    return run;
}

/// The label's sweeps, which also warm up the threads, and the line of the machine.
static SheetSolve *begin(SheetSolve *run, BenchBudget budget)
{
    const PercaleModel *model = &run->solver->model;
    uint64_t footprint =
        (uint64_t)model->point_count * POINT_BYTES + (uint64_t)run->constraint_count * run->constraint_bytes;
    sweep(run, LABEL_SWEEPS);
    run->hash = hash_of_points(model);
    run->triad_rate = bench_triad_rate(footprint, run->thread_count, budget);
    return run;
}

static void *open_stretch(uint64_t vertices, int thread_count, BenchBudget budget, PercaleSceneError *error)
{
    SheetSolve *run = open_sheet(vertices, thread_count, error);
    if (run == NULL) {
        return NULL;
    }
    run->plan.edges = &run->solver->edges;
    run->constraint_count = run->plan.edges->count;
    run->color_count = run->plan.edges->color_count;
    run->projection_bytes = STRETCH_BYTES;
    run->constraint_bytes = EDGE_BYTES;
    return begin(run, budget);
}

static void *open_bend(uint64_t vertices, int thread_count, BenchBudget budget, PercaleSceneError *error)
{
    SheetSolve *run = open_sheet(vertices, thread_count, error);
    if (run == NULL) {
        return NULL;
    }
    run->bend_weights = calloc(run->solver->hinges.count, sizeof *run->bend_weights);
    if (run->bend_weights == NULL) {
        percale_scene_out_of_memory(error);
        close_sheet(run);
        return NULL;
    }
    percale_solve_bend_prepare(&run->solver->model, SUBSTEP, 1, run->bend_weights, NULL);
    run->plan.arrays.bend_weights = run->bend_weights;
    run->plan.hinges = &run->solver->hinges;
    run->constraint_count = run->plan.hinges->count;
    run->color_count = run->plan.hinges->color_count;
    run->projection_bytes = BEND_BYTES;
    run->constraint_bytes = HINGE_BYTES;
    return begin(run, budget);
}

static BenchTime run_sweeps(void *state, uint64_t iterations)
{
    BenchTime start = bench_now();
    sweep(state, iterations);
    return bench_since(start);
}

static void report(const void *state, BenchResult *result)
{
    const SheetSolve *run = state;
    double bytes = (double)run->constraint_count * run->projection_bytes;
    bench_result_label(result, run->hash);
    bench_result_add_rate(result, "items_per_second", (double)run->constraint_count);
    bench_result_add_rate(result, "bytes_per_second", bytes);
    bench_result_add(result, "triad_fraction", bytes / result->real_seconds / run->triad_rate);
    bench_result_add(result, "constraints", (double)run->constraint_count);
    bench_result_add(result, "colors", (double)run->color_count);
}

const BenchKernel bench_kernel_stretch = {.name = "stretch",
                                          .sizes = bench_sheet_sizes,
                                          .open = open_stretch,
                                          .body = run_sweeps,
                                          .report = report,
                                          .close = close_sheet};

const BenchKernel bench_kernel_bend = {.name = "bend",
                                       .sizes = bench_sheet_sizes,
                                       .open = open_bend,
                                       .body = run_sweeps,
                                       .report = report,
                                       .close = close_sheet};
