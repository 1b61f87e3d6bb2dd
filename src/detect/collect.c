#include "detect/collect.h"

#include <string.h>

enum {
    SHARES_PER_THREAD = 8, // contact is dense here and sparse there
    ITEM_WORK = 16         // an item is some 16 small ones
};

/// A point without weight is replaced by one that has some: stencils of one colour may share the former, and
/// one may move what the other would read.
static PercaleStencil without_idle_points(PercaleStencil stencil)
{
    uint32_t kept = 0;
    while (kept < 3 && stencil.weights[kept] == 0.0f) {
        kept++;
    }
    for (uint32_t k = 0; k < 4; k++) {
        if (stencil.weights[k] == 0.0f) {
            stencil.points[k] = stencil.points[kept];
        }
    }
    return stencil;
}

void percale_collect_stencil(PercaleCollector *collector, const PercaleStencil *stencil)
{
    PercaleStencilList *list = &collector->stencils;
    if (percale_memory_reserve(&collector->memory, &list->items, &list->capacity, list->count + 1,
                               sizeof(*stencil))) {
        list->items[list->count] = without_idle_points(*stencil);
        list->items[list->count++].source = collector->source;
    } else {
        collector->complete = false;
    }
}

void percale_collect_note(PercaleCollector *collector, PercalePairNote note)
{
    PercaleNoteList *list = &collector->notes;
    if (percale_memory_reserve(&collector->memory, &list->items, &list->capacity, list->count + 1,
                               sizeof(note))) {
        list->items[list->count] = note;
        list->items[list->count++].source = collector->source;
    } else {
        collector->complete = false;
    }
}

void percale_collect_pair(PercaleCollector *collector, PercaleItemPair pair)
{
    PercaleItemPairList *list = &collector->pairs;
    if (percale_memory_reserve(&collector->memory, &list->items, &list->capacity, list->count + 1,
                               sizeof(pair))) {
        list->items[list->count++] = pair;
    } else {
        collector->complete = false;
    }
}

/// What the chunks share. Items are divided by the number of shares, not by the team, which the host may make
/// smaller.
typedef struct Collection {
    PercaleFind *find;
    const void *context;
    PercaleCollectors *collectors;
    uint64_t item_count, share_count;
} Collection;

static void run_shares(void *context, uint32_t first, uint32_t end)
{
    const Collection *collection = context;
    for (uint32_t s = first; s < end; s++) {
        collection->find(collection->context, &collection->collectors->shares[s],
                         collection->item_count * s / collection->share_count,
                         collection->item_count * (s + 1) / collection->share_count);
    }
}

/// Appends one list to another.
static bool append_all(PercaleMemory *memory, void *items, size_t *count, size_t *capacity, const void *added,
                       size_t added_count, size_t size)
{
    if (!percale_memory_reserve(memory, items, capacity, *count + added_count, size)) {
        return false;
    }
    if (added_count > 0) {
        char *to;
        memcpy(&to, items, sizeof(to));
        memcpy(to + *count * size, added, added_count * size);
    }
    *count += added_count;
    return true;
}

/// Appends what a share has found.
static bool append_share(PercaleMemory *memory, const PercaleCollector *share, const PercaleCollected *to)
{
    return (to->stencils == NULL ||
            append_all(memory, &to->stencils->items, &to->stencils->count, &to->stencils->capacity,
                       share->stencils.items, share->stencils.count, sizeof(PercaleStencil))) &&
           (to->notes == NULL ||
            append_all(memory, &to->notes->items, &to->notes->count, &to->notes->capacity, share->notes.items,
                       share->notes.count, sizeof(PercalePairNote))) &&
           (to->pairs == NULL ||
            append_all(memory, &to->pairs->items, &to->pairs->count, &to->pairs->capacity, share->pairs.items,
                       share->pairs.count, sizeof(PercaleItemPair)));
}

bool percale_collect(PercaleTeam *team, uint64_t item_count, PercaleFind *find, const void *context,
                     PercaleCollectors *collectors, PercaleMemory *memory, const PercaleCollected *to)
{
    collectors->candidates = 0;
    collectors->born_crossed = 0;
    int thread_count = threads_for(item_count * ITEM_WORK, percale_team_size(team));
    int share_count = thread_count > 1 ? SHARES_PER_THREAD * thread_count : 1;
    share_count = share_count < PERCALE_MAX_THREADS ? share_count : PERCALE_MAX_THREADS;
    for (int s = 0; s < share_count; s++) {
        PercaleCollector *share = &collectors->shares[s];
        share->stencils.count = 0;
        share->notes.count = 0;
        share->pairs.count = 0;
        share->memory = (PercaleMemory){memory->allocator, 0};
        share->candidates = 0;
        share->born_crossed = 0;
        share->complete = true;
    }
    Collection collection = {find, context, collectors, item_count, (uint64_t)share_count};
    percale_team_for(team, (uint32_t)share_count, 1, run_shares, &collection);
    bool complete = true;
    for (int s = 0; s < share_count; s++) {
        const PercaleCollector *share = &collectors->shares[s];
        memory->bytes += share->memory.bytes;
        collectors->candidates += share->candidates;
        collectors->born_crossed += share->born_crossed;
        complete = complete && share->complete && append_share(memory, share, to);
    }
    return complete;
}

void percale_collectors_free(PercaleCollectors *collectors, PercaleMemory *memory)
{
    for (int s = 0; s < PERCALE_MAX_THREADS; s++) {
        PercaleCollector *share = &collectors->shares[s];
        percale_memory_free(memory, share->features.items);
        percale_memory_free(memory, share->nodes.items);
        percale_memory_free(memory, share->found.items);
        percale_memory_free(memory, share->numbers.items);
        percale_memory_free(memory, share->stencils.items);
        percale_memory_free(memory, share->touched.items);
        percale_memory_free(memory, share->notes.items);
        percale_memory_free(memory, share->pairs.items);
        *share = (PercaleCollector){0};
    }
}
