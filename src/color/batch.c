#include "color/batch.h"

#include <string.h>

PercaleBatches percale_batches_of(const PercaleColoring *coloring)
{
    PercaleBatches batches = {.color_count = coloring->color_count, .count = coloring->count};
    memcpy(batches.first, coloring->first, sizeof(batches.first));
    return batches;
}

/// array[i] = old array[order[i]]; scratch has room for the array.
static void permute(void *array, void *scratch, const uint32_t *order, uint32_t count, size_t element_size)
{
    memcpy(scratch, array, count * element_size);
    for (uint32_t i = 0; i < count; i++) {
        memcpy((char *)array + i * element_size, (const char *)scratch + order[i] * element_size,
               element_size);
    }
}

bool percale_batch_edges(PercaleModel *model, PercaleColoring *coloring, PercaleMemory *memory,
                         PercaleBatches *batches)
{
    uint32_t count = model->edge_count;
    void *scratch = percale_memory_new(memory, count, sizeof(model->edges[0]));
    PercaleConstraints constraints = {&model->edges[0][0], 2, NULL, 0, 2, count};
    bool complete = scratch != NULL &&
                    percale_coloring_run(coloring, memory, &constraints, model->position, model->point_count);
    if (complete) {
        permute(model->edges, scratch, coloring->order, count, sizeof(model->edges[0]));
        permute(model->edge_lengths, scratch, coloring->order, count, sizeof(float));
        if (model->edge_compliances != NULL) {
            permute(model->edge_compliances, scratch, coloring->order, count, sizeof(float));
        }
        *batches = percale_batches_of(coloring);
    }
    percale_memory_free(memory, scratch);
    return complete;
}

bool percale_batch_hinges(PercaleModel *model, PercaleColoring *coloring, PercaleMemory *memory,
                          PercaleBatches *batches)
{
    uint32_t count = model->hinge_count;
    void *scratch = percale_memory_new(memory, count, sizeof(model->hinges[0]));
    PercaleConstraints constraints = {&model->hinges[0][0], 4, NULL, 0, 4, count};
    bool complete = scratch != NULL &&
                    percale_coloring_run(coloring, memory, &constraints, model->position, model->point_count);
    if (complete) {
        permute(model->hinges, scratch, coloring->order, count, sizeof(model->hinges[0]));
        permute(model->hinge_weights, scratch, coloring->order, count, sizeof(f32x4));
        permute(model->hinge_stiffnesses, scratch, coloring->order, count, sizeof(float));
        *batches = percale_batches_of(coloring);
    }
    percale_memory_free(memory, scratch);
    return complete;
}
