#include "detect/pairs.h"

#include "base/radix_sort.h"
#include "detect/pair_parts.h"
#include "detect/pinch.h"

/// The candidates of one kind of item, and what they are asked.
typedef struct Kind {
    const PercalePairStage *stage;
    PercaleVisiting visiting;
} Kind;

/// The stencils of the item at this place of the list.
static uint64_t source_of(const Kind *kind, uint32_t place)
{
    uint64_t group = kind->stage->model->obstacle_count + kind->visiting.list; // after the contacts'
    return group << 32 | place;
}

/// Edges and faces that are held between obstacles collide with none (pinch.h). Those that are in part go
/// around what is sharp: else what hangs beside a thin plate swings under it.
static void drop_pinched(const Kind *kind, PercaleCollector *collector, bool smooth)
{
    const uint8_t *states = kind->stage->pinches != NULL ? kind->stage->pinches->states : NULL;
    const PercaleNeighborhood *hood = &kind->visiting.hood;
    PercaleNeighbor *items = collector->neighbors.items;
    size_t kept = 0;
    for (size_t i = 0; states != NULL && i < collector->neighbors.count; i++) {
        const uint32_t *corners = hood->primitives + (size_t)hood->arity * items[i].index;
        bool is_held = smooth ? percale_pinched_any(states, PINCH_HELD, corners, hood->arity)
                              : percale_pinched_all(states, corners, hood->arity);
        if (!is_held) {
            items[kept++] = items[i];
        }
    }
    collector->neighbors.count = states != NULL ? kept : collector->neighbors.count;
}

/// What untangling has in hand is no pair.
static void drop_released(const Kind *kind, PercaleCollector *collector, const uint32_t points[2])
{
    const PercaleReleases *releases = kind->stage->releases;
    const PercaleNeighborhood *hood = &kind->visiting.hood;
    PercaleNeighbor *items = collector->neighbors.items;
    size_t kept = 0;
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        const uint32_t *corners = hood->primitives + (size_t)hood->arity * items[i].index;
        if (!are_released(releases, points, 2, corners, hood->arity)) {
            items[kept++] = items[i];
        }
    }
    collector->neighbors.count = kept;
}

static void find_item(const void *context, PercaleCollector *collector, const PercaleQuery *query,
                      uint32_t place, uint32_t item)
{
    const Kind *kind = context;
    const PercalePairStage *stage = kind->stage;
    const PercaleModelSurface *mesh = stage->candidates->lists[kind->visiting.list].mesh;
    bool edges = kind->visiting.hood.arity == 2;
    const PercaleNeighborList given = collector->neighbors; // the next item's come after these
    collector->source = source_of(kind, place);
    if (mesh != &stage->model->cloth) {
        drop_pinched(kind, collector, (edges ? mesh->smooth_edges : mesh->smooth_vertices)[item]);
    } else if (stage->releases != NULL) {
        drop_released(kind, collector, query->points);
    }
    if (mesh == &stage->model->cloth && edges) {
        percale_pair_find_edge(stage, collector, item);
    } else if (mesh == &stage->model->cloth) {
        percale_pair_find_vertex(stage, collector, item);
    } else if (edges) {
        percale_pair_find_obstacle_edge(stage, collector, mesh, item);
    } else {
        percale_pair_find_obstacle_vertex(stage, collector, mesh, query->points[0]);
    }
    collector->neighbors = given;
}

static void find_items(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Kind *kind = context;
    percale_candidates_visit(&kind->visiting, collector, first, end);
}

/// Those of some sources, as far as they are in this list. Items: sources.
static void find_sources(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Kind *kind = context;
    const uint64_t *sources = kind->stage->only->items;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        if (sources[i] == source_of(kind, (uint32_t)sources[i])) {
            percale_candidates_visit_place(&kind->visiting, collector, (uint32_t)sources[i]);
        }
    }
}

/// Items: edges of the cloth.
static void find_crossings(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const PercalePairStage *stage = context;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        percale_pair_find_crossings(stage, collector, (uint32_t)i);
    }
}

/// By key.
static bool sort_notes(PercaleNoteList *notes, PercaleArena *arena)
{
    PercaleKeyed *keyed = percale_arena_new(arena, notes->count, sizeof(keyed[0]));
    PercaleKeyed *scratch = percale_arena_new(arena, notes->count, sizeof(keyed[0]));
    PercalePairNote *unsorted = percale_arena_new(arena, notes->count, sizeof(unsorted[0]));
    if (keyed == NULL || scratch == NULL || unsorted == NULL) {
        return false;
    }
    for (size_t i = 0; i < notes->count; i++) {
        keyed[i] = (PercaleKeyed){notes->items[i].key, (uint32_t)i};
        unsorted[i] = notes->items[i];
    }
    percale_radix_sort(keyed, scratch, notes->count);
    for (size_t i = 0; i < notes->count; i++) {
        notes->items[i] = unsorted[keyed[i].value];
    }
    return true;
}

/// Leaves one of those with the same key.
static void drop_repeated(PercaleNoteList *notes)
{
    size_t count = 0;
    for (size_t i = 0; i < notes->count; i++) {
        if (count == 0 || notes->items[i].key != notes->items[count - 1].key) {
            notes->items[count++] = notes->items[i];
        }
    }
    notes->count = count;
}

/// Notes of the pairs that were born crossed, which then stand alone in `notes`.
static bool find_born(const PercalePairStage *stage, PercaleCollectors *collectors, PercaleMemory *memory,
                      PercaleNoteList *notes, PercalePairCounts *counts)
{
    const PercaleModel *model = stage->model;
    PercaleCandidates *candidates = stage->candidates;
    if (!stage->may_be_crossed || !candidates->cloth || candidates->edges.nodes == NULL) {
        return true;
    }
    const f32x4 *places[1] = {model->position};
    percale_tree_refit_swept(&candidates->faces, model->cloth.triangles, places, 1, stage->team);
    bool complete = percale_collect(stage->team, model->cloth.edges.edge_count, find_crossings, stage,
                                    collectors, memory, &(PercaleCollected){.notes = notes});
    counts->born_crossed += collectors->born_crossed;
    complete = complete && sort_notes(notes, stage->arena);
    drop_repeated(notes);
    counts->free_pairs = notes->count;
    return complete;
}

bool percale_pairs_are_free(const PercaleNoteList *notes, bool edges, uint32_t item, uint32_t primitive)
{
    const PercalePairNote *note =
        percale_pair_find_note(notes, edges ? edge_key(item, primitive) : face_key(item, primitive));
    return note != NULL && is_free(note);
}

/// Notes of the pairs that are not looked for anew.
static bool keep_notes(const PercalePairStage *stage, PercaleMemory *memory, PercaleNoteList *notes)
{
    const PercaleNoteList *known = stage->known;
    if (!percale_memory_reserve(memory, &notes->items, &notes->capacity, known->count,
                                sizeof(notes->items[0]))) {
        return false;
    }
    for (size_t i = 0; i < known->count; i++) {
        if (!percale_sources_contain(stage->only, known->items[i].source)) {
            notes->items[notes->count++] = known->items[i];
        }
    }
    return true;
}

bool percale_pairs_find(const PercalePairStage *given, PercaleCollectors *collectors, PercaleMemory *memory,
                        PercaleStencilList *stencils, PercaleNoteList *notes, PercalePairCounts *counts)
{
    const PercaleCandidates *candidates = given->candidates;
    PercaleCollected to = {.stencils = stencils, .notes = notes};
    notes->count = 0;
    bool complete = given->only != NULL ? keep_notes(given, memory, notes)
                                        : find_born(given, collectors, memory, notes, counts);
    PercalePairStage stage = *given;
    stage.born.count = given->only != NULL ? 0 : notes->count; // they stay the first of the notes
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        Kind kind = {&stage,
                     {candidates, i, percale_candidates_hood(candidates, i), NULL, !stage.edges_wait,
                      find_item, &kind}};
        kind.visiting.hood.to = stage.end;
        stage.born.items = notes->items;
        kind.visiting.hood.all_near = stage.later_substeps > 0.0f;
        size_t before = stencils->count;
        complete = stage.only == NULL
                       ? percale_collect(stage.team, percale_candidate_count(&candidates->lists[i]),
                                         find_items, &kind, collectors, memory, &to)
                       : percale_collect(stage.team, stage.only->count, find_sources, &kind, collectors,
                                         memory, &to);
        counts->candidates += collectors->candidates;
        *(i % 2 == 1 ? &counts->edge_edge : &counts->vertex_face) += stencils->count - before;
    }
    return complete && sort_notes(notes, stage.arena);
}

static bool is_same(const PercaleStencil *a, const PercaleStencil *b)
{
    bool same = true;
    for (int k = 0; k < 4; k++) {
        same = same && a->points[k] == b->points[k] && a->weights[k] == b->weights[k] &&
               a->normal[k] == b->normal[k];
    }
    return same;
}

uint64_t percale_pairs_count_missing(const PercaleStencilList *kept, const PercaleStencilList *anew)
{
    uint64_t missing = 0;
    size_t first = 0;
    for (size_t i = 0; i < anew->count; i++) {
        const PercaleStencil *wanted = &anew->items[i];
        while (first < kept->count && kept->items[first].source < wanted->source) {
            first++;
        }
        size_t at = first;
        while (at < kept->count && kept->items[at].source == wanted->source &&
               !is_same(&kept->items[at], wanted)) {
            at++;
        }
        missing += at == kept->count || kept->items[at].source != wanted->source;
    }
    return missing;
}
