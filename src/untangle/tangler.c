#include "untangle/tangler.h"

static bool allocate(PercaleTangler *tangler, const PercaleModel *model)
{
    PercaleMemory *memory = tangler->memory;
    const PercaleTangleMesh *mesh = &tangler->mesh;
    PercaleTangleStage *stage = &tangler->stage;
    tangler->search = percale_memory_new(memory, 1, sizeof(*tangler->search));
    tangler->edge_lengths = percale_memory_new(memory, mesh->edges.edge_count, sizeof(float));
    stage->labels = percale_memory_new(memory, model->point_count, sizeof(uint32_t));
    stage->queue = percale_memory_new(memory, model->point_count, sizeof(uint32_t));
    stage->is_inside = percale_memory_new(memory, model->point_count, sizeof(uint8_t));
    return tangler->search != NULL && tangler->edge_lengths != NULL && stage->labels != NULL &&
           stage->queue != NULL && stage->is_inside != NULL;
}

bool percale_tangler_open(PercaleTangler *tangler, const PercaleModel *model, const f32x4 *x, bool obstacles,
                          PercaleTeam *team, PercaleMemory *memory)
{
    *tangler = (PercaleTangler){.memory = memory};
    bool complete = percale_tangle_mesh_build(&tangler->mesh, model, obstacles, memory) &&
                    allocate(tangler, model) &&
                    percale_region_flood_open(&tangler->flood, &tangler->mesh, x, memory) &&
                    percale_crossing_search_open(tangler->search, &tangler->mesh, x, team, memory);
    if (!complete) {
        return false;
    }
    for (uint32_t e = 0; e < tangler->mesh.edges.edge_count; e++) {
        const uint32_t *ends = tangler->mesh.edges.vertices[e];
        tangler->edge_lengths[e] = length3(x[ends[0]] - x[ends[1]]);
    }
    tangler->flood.crossings = &tangler->crossings;
    tangler->flood.contours = &tangler->contours;
    tangler->stage.mesh = &tangler->mesh;
    tangler->stage.search = tangler->search;
    tangler->stage.crossings = &tangler->crossings;
    tangler->stage.contours = &tangler->contours;
    tangler->stage.flood = &tangler->flood;
    tangler->stage.edge_lengths = tangler->edge_lengths;
    tangler->stage.stencils = &tangler->stencils;
    tangler->stage.memory = memory;
    return true;
}

void percale_tangler_close(PercaleTangler *tangler)
{
    PercaleMemory *memory = tangler->memory;
    if (memory == NULL) {
        return; // it was never opened
    }
    if (tangler->search != NULL) {
        percale_crossing_search_close(tangler->search, memory);
    }
    percale_region_flood_close(&tangler->flood, memory);
    percale_contours_free(&tangler->contours, memory);
    percale_tangle_mesh_free(&tangler->mesh, memory);
    void *arrays[] = {tangler->search,        tangler->edge_lengths,    tangler->stage.labels,
                      tangler->stage.queue,   tangler->stage.is_inside, tangler->crossings.items,
                      tangler->stencils.items};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); i++) {
        percale_memory_free(memory, arrays[i]);
    }
    *tangler = (PercaleTangler){0};
}

bool percale_tangler_look(PercaleTangler *tangler, const f32x4 *x, PercaleTeam *team)
{
    tangler->stage.x = x;
    return percale_crossing_search_run(tangler->search, x, team, tangler->memory, &tangler->crossings) &&
           percale_contours_build(&tangler->contours, &tangler->mesh, &tangler->crossings, x,
                                  tangler->memory);
}
