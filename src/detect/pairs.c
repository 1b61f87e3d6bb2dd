#include "detect/pairs.h"

#include "base/radix_sort.h"
#include "detect/pair_parts.h"

#include <string.h>

/// Items: points from `first` on; both kinds in the order of the arrays.
typedef struct Points {
    const PercalePairStage *stage;
    uint32_t first;
} Points;

static void find_points(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Points *points = context;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        uint32_t point = points->first + (uint32_t)i;
        if (point < points->stage->model->slot_count) {
            percale_pair_find_vertex(points->stage, collector, point);
        } else {
            percale_pair_find_obstacle_vertex(points->stage, collector, point);
        }
    }
}

/// Items: edges of the cloth, or of an obstacle.
typedef struct Edges {
    const PercalePairStage *stage;
    const PercaleModelSurface *obstacle; // NULL: the cloth
} Edges;

static void find_edges(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Edges *edges = context;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        if (edges->obstacle == NULL) {
            percale_pair_find_edge(edges->stage, collector, (uint32_t)i);
        } else {
            percale_pair_find_obstacle_edge(edges->stage, collector, edges->obstacle, (uint32_t)i);
        }
    }
}

/// By key, which is unique.
static bool sort_notes(PercaleNoteList *notes, PercaleMemory *memory)
{
    PercaleKeyed *keyed = percale_memory_new(memory, notes->count, sizeof(keyed[0]));
    PercaleKeyed *scratch = percale_memory_new(memory, notes->count, sizeof(keyed[0]));
    PercalePairNote *sorted = percale_memory_new(memory, notes->count, sizeof(sorted[0]));
    bool complete = keyed != NULL && scratch != NULL && sorted != NULL;
    if (complete) {
        for (size_t i = 0; i < notes->count; i++) {
            keyed[i] = (PercaleKeyed){notes->items[i].key, (uint32_t)i};
        }
        percale_radix_sort(keyed, scratch, notes->count);
        for (size_t i = 0; i < notes->count; i++) {
            sorted[i] = notes->items[keyed[i].value];
        }
        if (notes->count > 0) {
            memcpy(notes->items, sorted, notes->count * sizeof(sorted[0]));
        }
    }
    percale_memory_free(memory, keyed);
    percale_memory_free(memory, scratch);
    percale_memory_free(memory, sorted);
    return complete;
}

bool percale_pairs_find(const PercalePairStage *stage, PercaleCollectors *collectors, PercaleMemory *memory,
                        PercaleStencilList *stencils, PercaleNoteList *notes, PercalePairCounts *counts)
{
    const PercaleModel *model = stage->model;
    Points points = {stage, stage->cloth ? 0 : model->slot_count};
    uint32_t point_end = stage->obstacles ? model->point_count : model->slot_count;
    size_t before = stencils->count;
    notes->count = 0;
    bool complete = percale_collect(stage->team, point_end - points.first, find_points, &points, collectors,
                                    memory, stencils, notes);
    counts->candidates += collectors->candidates;
    counts->vertex_face += stencils->count - before;
    before = stencils->count;
    if (complete && stage->edges && stage->cloth) {
        Edges cloth = {stage, NULL};
        complete = percale_collect(stage->team, model->cloth.edges.edge_count, find_edges, &cloth, collectors,
                                   memory, stencils, notes);
        counts->candidates += collectors->candidates;
    }
    for (uint32_t o = 0; complete && stage->obstacles && o < model->obstacle_count; o++) {
        Edges edges = {stage, &model->obstacles[o]};
        complete = percale_collect(stage->team, model->obstacles[o].edges.edge_count, find_edges, &edges,
                                   collectors, memory, stencils, notes);
        counts->candidates += collectors->candidates;
    }
    counts->edge_edge += stencils->count - before;
    return complete && sort_notes(notes, memory);
}
