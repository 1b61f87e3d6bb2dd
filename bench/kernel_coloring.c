// kernel_coloring.c: colouring the edges of a sheet whose vertices stand along the solver's curve.

#include "base/hash.h"
#include "bench_kernel.h"
#include "color/coloring.h"
#include "model/mesh.h"
#include "model/order.h"
#include "scene/scene_error.h"

#include <stdlib.h>

typedef struct ColoringRun {
    PercaleAllocator allocator;
    PercaleMemory memory;
    f32x4 *points; // [vertex_count] only the inverse mass counts
    uint32_t vertex_count;
    PercaleEdges edges;
    PercaleColoring coloring;
} ColoringRun;

/// Renumbers the mesh's triangles along the curve.
static bool renumber(PercaleMesh *mesh, PercaleMemory *memory)
{
    uint32_t *curve = percale_memory_new(memory, mesh->vertex_count, sizeof *curve);
    uint32_t *place = percale_memory_new(memory, mesh->vertex_count, sizeof *place);
    bool done = curve != NULL && place != NULL &&
                percale_order_along_curve(mesh->positions, mesh->vertex_count, memory, curve);
    for (uint32_t i = 0; done && i < mesh->vertex_count; ++i) {
        place[curve[i]] = i;
    }
    for (size_t k = 0; done && k < 3 * (size_t)mesh->triangle_count; ++k) {
        mesh->triangles[k] = place[mesh->triangles[k]];
    }
    percale_memory_free(memory, curve);
    percale_memory_free(memory, place);
    return done;
}

static bool prepare(ColoringRun *run, PercaleMesh *mesh)
{
    run->vertex_count = mesh->vertex_count;
    run->points = percale_memory_new(&run->memory, mesh->vertex_count, sizeof *run->points);
    if (run->points == NULL || !renumber(mesh, &run->memory)) {
        return false;
    }
    for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
        run->points[i][3] = 1.0f;
    }
    return percale_edges_build(mesh->triangles, mesh->triangle_count, &run->memory, &run->edges);
}

static void close_run(void *state)
{
    ColoringRun *run = state;
    percale_coloring_free(&run->coloring, &run->memory);
    percale_edges_free(&run->edges, &run->memory);
    percale_memory_free(&run->memory, run->points);
    free(run);
}

static bool color(ColoringRun *run)
{
    PercaleConstraints constraints = {&run->edges.vertices[0][0], 2,    NULL, 0, 2,
                                      run->edges.edge_count,      true, NULL};
    return percale_coloring_run(&run->coloring, &run->memory, &constraints, run->points, run->vertex_count);
}

static void *open_run(uint64_t vertices, int thread_count, BenchBudget budget, PercaleSceneError *error)
{
    (void)thread_count;
    (void)budget;
    PercaleMesh mesh;
    ColoringRun *run = calloc(1, sizeof *run);
    if (run == NULL || !bench_sheet_make(vertices, &mesh, error)) {
        free(run);
        percale_scene_out_of_memory(error);
        return NULL;
    }
    run->allocator = percale_allocator_default();
    run->memory.allocator = &run->allocator;
    bool done = prepare(run, &mesh) && color(run); // the first run has the memory from the allocator
    percale_mesh_free(&mesh);
    if (!done) {
        close_run(run);
        percale_scene_out_of_memory(error);
        return NULL;
    }
    return run;
}

static BenchTime color_again(void *state, uint64_t iterations)
{
    BenchTime start = bench_now();
    for (uint64_t round = 0; round < iterations; ++round) {
        (void)color(state); // allocates nothing: the first run has
    }
    return bench_since(start);
}

static void report(const void *state, BenchResult *result)
{
    const ColoringRun *run = state;
    uint64_t hash = hash_start();
    for (uint32_t i = 0; i < run->coloring.count; ++i) {
        hash = hash_add(hash, run->coloring.order[i]);
    }
    bench_result_label(result, hash);
    bench_result_add_rate(result, "items_per_second", (double)run->edges.edge_count);
    bench_result_add(result, "constraints", (double)run->edges.edge_count);
    bench_result_add(result, "colors", (double)run->coloring.color_count);
}

const BenchKernel bench_kernel_coloring = {.name = "coloring",
                                           .one_thread = true,
                                           .sizes = bench_sheet_sizes,
                                           .open = open_run,
                                           .body = color_again,
                                           .report = report,
                                           .close = close_run};
