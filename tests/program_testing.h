// program_testing.h: models to batch: a sheet, two that are sewn, a fan of more edges than colours.

#ifndef PERCALE_PROGRAM_TESTING_H
#define PERCALE_PROGRAM_TESTING_H

#include "kernel_testing.h"

#include "solver.h"

#include <math.h>

enum { SPOKES = COLORS_MAX + 36 }; // of the fan: more than there are colours

typedef enum Kind { SHEET, SEWN, FAN, KINDS } Kind;

/// A solver's model, batched anew.
typedef struct Bench {
    PercaleSolver *solver;
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleModel *model; // the solver's
    PercaleColoring coloring, contact_coloring;
    PercaleBatches edges, hinges, contacts;
} Bench;

// ---- scenes ----

static inline PercaleCloth add_cloth(PercaleSolver *solver, const PercaleMesh *mesh, float compliance)
{
    PercaleClothDef def = percale_test_cloth_def(mesh);
    PercaleCloth cloth = {0};
    def.material.stretch_compliance = compliance;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    return cloth;
}

static inline void add_pin(PercaleSolver *solver, PercaleCloth cloth, const uint32_t *vertices,
                           uint32_t count)
{
    PercalePinDef def = percale_pin_def_default();
    PercalePin pin;
    def.cloth = cloth;
    def.vertices = vertices;
    def.vertex_count = count;
    PERCALE_TEST_OK(solver, percale_pin_add(solver, &def, &pin));
}

/// Joins the last row of a with the first of b, sheets of `side` vertices: `pair_count` pairs from `first`
/// on.
static inline void add_seam(PercaleSolver *solver, PercaleCloth a, PercaleCloth b, uint32_t side,
                            uint32_t first)
{
    uint32_t in_a[64];
    uint32_t in_b[64];
    PercaleSeamDef def = percale_seam_def_default();
    PercaleSeam seam;
    for (uint32_t i = first; i < side; i++) {
        in_a[i - first] = side * (side - 1) + i;
        in_b[i - first] = i;
    }
    def.cloth_a = a;
    def.cloth_b = b;
    def.vertices_a = in_a;
    def.vertices_b = in_b;
    def.pair_count = side - first;
    PERCALE_TEST_OK(solver, percale_seam_add(solver, &def, &seam));
}

static inline void add_sheet(PercaleSolver *solver)
{
    const uint32_t pinned[3] = {0, 59, 1830};
    PercaleMesh sheet = percale_test_sheet(60, 1.0f);
    add_pin(solver, add_cloth(solver, &sheet, 0.0f), pinned, 3);
    percale_mesh_free(&sheet);
}

/// Two sheets of different compliance that have a row in common; its last pairs are apart.
static inline void add_sewn(PercaleSolver *solver)
{
    enum { SIDE = 44, CLOSED = 30 };
    const uint32_t pinned[2] = {0, SIDE - 1};
    PercaleMesh sheet = percale_test_sheet(SIDE, 1.0f);
    PercaleCloth a = add_cloth(solver, &sheet, 2e-5f);
    percale_test_translate(&sheet, 0.0f, 0.0f, 1.0f);
    for (size_t i = CLOSED; i < SIDE; i++) {
        sheet.positions[3 * i + 1] += 0.05f;
    }
    PercaleCloth b = add_cloth(solver, &sheet, 0.0f);
    add_seam(solver, a, b, SIDE, 0);
    add_pin(solver, a, pinned, 2);
    percale_mesh_free(&sheet);
}

/// A wheel: the rim's vertices around vertex 0.
static inline void add_fan(PercaleSolver *solver)
{
    float positions[3 * (SPOKES + 1)] = {0.0f};
    uint32_t triangles[3 * SPOKES];
    for (uint32_t i = 0; i < SPOKES; i++) {
        double angle = 2.0 * 3.14159265358979323846 * i / SPOKES;
        positions[3 * (i + 1)] = (float)cos(angle);
        positions[3 * (i + 1) + 2] = (float)sin(angle);
        triangles[3 * i] = 0;
        triangles[3 * i + 1] = 1 + (i + 1) % SPOKES;
        triangles[3 * i + 2] = 1 + i;
    }
    PercaleMesh fan = {.name = NULL,
                       .positions = positions,
                       .vertex_count = SPOKES + 1,
                       .triangles = triangles,
                       .triangle_count = SPOKES};
    (void)add_cloth(solver, &fan, 1e-4f);
}

/// A fresh model, whose constraints name slots as before they were batched.
static inline void assemble(Bench *bench)
{
    percale_solver_release_model(bench->solver);
    PERCALE_TEST_OK(bench->solver, percale_solver_prepare(bench->solver));
    bench->model = &bench->solver->model;
    for (uint32_t i = 0; i < 2 * bench->model->edge_count; i++) {
        bench->model->edges[i / 2][i % 2] = slot_at(bench->model->edges[i / 2][i % 2]);
    }
    for (uint32_t i = 0; i < 4 * bench->model->hinge_count; i++) {
        bench->model->hinges[i / 4][i % 4] = slot_at(bench->model->hinges[i / 4][i % 4]);
    }
}

static inline void open_bench(Bench *bench, Kind kind)
{
    *bench = (Bench){.allocator = percale_allocator_default()};
    bench->memory.allocator = &bench->allocator;
    bench->solver = percale_test_solver(percale_solver_def_default());
    void (*const add[KINDS])(PercaleSolver *) = {add_sheet, add_sewn, add_fan};
    add[kind](bench->solver);
    PercaleMesh floor = percale_test_box(4.0f, 0.1f, 4.0f);
    (void)percale_test_add_obstacle(bench->solver, &floor);
    percale_mesh_free(&floor);
    assemble(bench);
}

static inline void close_bench(Bench *bench)
{
    percale_coloring_free(&bench->coloring, &bench->memory);
    percale_coloring_free(&bench->contact_coloring, &bench->memory);
    percale_batches_free(&bench->edges, &bench->memory);
    percale_batches_free(&bench->hinges, &bench->memory);
    percale_batches_free(&bench->contacts, &bench->memory);
    percale_solver_destroy(bench->solver);
    ck_assert_uint_eq(bench->memory.bytes, 0);
}

/// Batches as they are built for each model anew: the same memory serves again.
static inline void batch(Bench *bench, uint32_t tile_points)
{
    ck_assert(
        percale_batch_edges(bench->model, tile_points, &bench->coloring, &bench->memory, &bench->edges));
    ck_assert(
        percale_batch_hinges(bench->model, tile_points, &bench->coloring, &bench->memory, &bench->hinges));
}

/// The first constraint of a tile; of the one past the last: the first that joins tiles.
static inline uint32_t tile_begin(const PercaleBatches *batches, uint32_t tile)
{
    return batches->run_first[batches->tile_first_run[tile]];
}

#endif
