#include "detect/pairs.h"

#include "base/radix_sort.h"
#include "detect/pair_parts.h"

#include <string.h>

/// The candidates of one kind of item, and what they are asked.
typedef struct Kind {
    const PercalePairStage *stage;
    const PercaleCandidateList *list;
    uint32_t number; // of the list
    PercaleNeighborhood hood;
} Kind;

static void find_item(const Kind *kind, PercaleCollector *collector, uint32_t item)
{
    const PercalePairStage *stage = kind->stage;
    const PercaleModelSurface *mesh = kind->list->mesh;
    bool edges = kind->hood.arity == 2;
    if (mesh == &stage->model->cloth && edges) {
        percale_pair_find_edge(stage, collector, item);
    } else if (mesh == &stage->model->cloth) {
        percale_pair_find_vertex(stage, collector, item);
    } else if (edges) {
        percale_pair_find_obstacle_edge(stage, collector, mesh, item);
    } else {
        percale_pair_find_obstacle_vertex(stage, collector, mesh, mesh->first_point + item);
    }
}

/// The items whose first pair is in the range.
static void find_items(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Kind *kind = context;
    PercaleCandidateRun run = percale_candidates_run(kind->list, first);
    for (; collector->complete && run.first < end; run = percale_candidates_run(kind->list, run.end)) {
        PercaleQuery query = percale_candidate_query(kind->stage->candidates, kind->list->mesh,
                                                     kind->hood.arity == 2, run.item);
        collector->neighbors.count = 0;
        bool complete =
            percale_candidates_select(kind->stage->candidates, kind->number, run, query.reach, collector) &&
            percale_neighbors_find(&kind->hood, &query, collector->touched.items, collector->touched.count,
                                   &collector->memory, &collector->neighbors);
        collector->candidates += collector->touched.count;
        if (!complete) {
            collector->complete = false;
        } else if (collector->neighbors.count > 0) {
            uint64_t group = kind->stage->model->obstacle_count + kind->number; // after the contacts'
            collector->source = group << 32 | run.item;
            find_item(kind, collector, run.item);
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
    const PercaleCandidates *candidates = stage->candidates;
    PercaleCollected to = {.stencils = stencils, .notes = notes};
    notes->count = 0;
    bool complete = true;
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        Kind kind = {stage, &candidates->lists[i], i, percale_candidates_hood(candidates, i)};
        kind.hood.all_near = stage->later_substeps > 0.0f;
        size_t before = stencils->count;
        complete =
            percale_collect(stage->team, kind.list->pairs.count, find_items, &kind, collectors, memory, &to);
        counts->candidates += collectors->candidates;
        *(kind.hood.arity == 2 ? &counts->edge_edge : &counts->vertex_face) += stencils->count - before;
    }
    return complete && sort_notes(notes, memory);
}
