#include "detect/candidates.h"

#include "base/reduce.h"
#include "base/wide.h"
#include "detect/candidate_search.h"

// Share of the margin that a block may deviate from its anchors before it gets new ones: more makes blocks
// that are found anew begin with what those near them have deviated, less adds up what shakes to and fro.
static const float ANCHORED = 0.125f;

// Of the farthest bound, what adding and comparing bounds rounds away, and the distances' own rounding: they
// are computed from edges as long as a few of it.
static const float BOUND_ROUNDED = 1e-5f;

// ---- begin ----

/// What the chunks share.
typedef struct Lengths {
    const PercaleModel *model;
    ReducedUint longest2; // m^2
} Lengths;

static void measure_lengths(void *context, uint32_t first, uint32_t end)
{
    Lengths *lengths = context;
    const f32x4 *x = lengths->model->position;
    float longest2 = 0.0f;
    for (uint32_t e = first; e < end; e++) {
        const uint32_t *ends = lengths->model->cloth.edges.vertices[e];
        f32x4 along = x[ends[1]] - x[ends[0]];
        longest2 = fmaxf(longest2, dot3(along, along));
    }
    reduce_max_float(&lengths->longest2, longest2);
}

void percale_candidates_begin_step(PercaleCandidates *candidates, PercaleTeam *team)
{
    enum { GRAIN_EDGES = 4096 };
    Lengths lengths = {candidates->model, 0};
    bool any_flat = false;
    for (uint32_t o = 0; o < candidates->model->obstacle_count; o++) {
        any_flat = any_flat || candidates->flats[o].vertices != NULL;
    }
    if (!any_flat) {
        return;
    }
    percale_team_for(team, candidates->model->cloth.edges.edge_count, GRAIN_EDGES, measure_lengths, &lengths);
    candidates->longest = sqrtf(reduced_float(&lengths.longest2));
}

// ---- keep ----

/// The blocks that look for candidates: those of the cloth, of obstacles, or both.
static void searching_blocks(const PercaleCandidates *candidates, uint32_t range[2])
{
    const PercaleBlocks *blocks = &candidates->blocks;
    range[0] = candidates->cloth ? 0 : blocks->cloth_count;
    range[1] = candidates->obstacles ? blocks->count : blocks->cloth_count;
}

/// Lists the blocks whose pairs may not be all any longer, or whose moment is about to be forgotten.
static void list_spent(PercaleCandidates *candidates, const uint32_t range[2], float slack)
{
    const PercaleBlocks *blocks = &candidates->blocks;
    bool any = !candidates->known;
    for (uint32_t b = range[0]; b < range[1]; b++) {
        any = any || !(blocks->items[b].moved <= slack);
    }
    candidates->spent.count = 0;
    for (uint32_t b = range[0]; any && b < range[1]; b++) {
        if (!candidates->known || !(blocks->items[b].moved <= slack) ||
            blocks->items[b].moment == percale_blocks_oldest(blocks)) {
            candidates->spent.blocks[candidates->spent.count++] = b;
        }
    }
}

/// Numbers all pairs of each list, for those who share them out.
static void count_pairs(PercaleCandidates *candidates)
{
    for (uint32_t i = 0; i < candidates->list_count; i++) {
        PercaleCandidateList *list = &candidates->lists[i];
        for (uint32_t b = 0; b < list->block_count; b++) {
            list->first_pair[b + 1] = list->first_pair[b] + list->pairs[b].count;
        }
    }
}

static void forget_pairs(PercaleCandidates *candidates)
{
    for (uint32_t i = 0; i < candidates->list_count; i++) {
        for (uint32_t b = 0; b < candidates->lists[i].block_count; b++) {
            percale_pair_pages_give(&candidates->pool, &candidates->lists[i].pairs[b]);
        }
    }
}

/// Takes what a block has lost from its bounds themselves.
static void settle_bounds(PercaleBlockPairs *pairs)
{
    for (uint32_t page = 0; page < pairs->page_count; page++) {
        for (int k = 0; k < PAGE_PAIRS; k++) {
            pairs->pages[page]->bounds[k] -= pairs->lost;
        }
    }
    pairs->lost = 0.0f;
}

/// After the blocks have drifted: a pair of things that are not far from each other has come nearer by no
/// more. One of things that are far is farther apart than the farthest bound.
static void lose_bounds(PercaleCandidates *candidates, float far)
{
    const float MOST_LOST = 4.0f * far; // more would round away too much
    for (uint32_t i = 0; i < candidates->list_count; i++) {
        PercaleCandidateList *list = &candidates->lists[i];
        for (uint32_t b = 0; b < list->block_count; b++) {
            PercaleBlockPairs *pairs = &list->pairs[b];
            pairs->lost += candidates->blocks.items[list->first_block + b].drifted + BOUND_ROUNDED * far;
            if (pairs->lost > MOST_LOST) {
                settle_bounds(pairs);
            }
        }
    }
}

bool percale_candidates_keep(PercaleCandidates *candidates, const PercaleCandidateStage *stage,
                             uint64_t *tested)
{
    PercaleBlocks *blocks = &candidates->blocks;
    PercaleBlockReach reach = candidates->reach;
    uint32_t range[2];
    searching_blocks(candidates, range);
    if (range[0] == range[1]) {
        return true;
    }
    candidates->bounded = !stage->all_near;
    PercaleBlockWays ways = {stage->from, stage->to, stage->again};
    percale_blocks_measure(blocks, &ways, candidates->bounded, stage->team);
    percale_blocks_compare(blocks, range[0], range[1], reach, stage->team);
    if (candidates->bounded) {
        lose_bounds(candidates, reach.far);
    }
    list_spent(candidates, range, candidates->margin + stage->spare);
    if (candidates->spent.count == 0) {
        return true;
    }
    if (!candidates->known) {
        forget_pairs(candidates);
    }
    percale_blocks_begin(blocks, &candidates->spent, stage->from, stage->to, ANCHORED * candidates->margin,
                         reach, stage->team);
    candidates->known = percale_candidates_search(candidates, stage, tested);
    count_pairs(candidates);
    return candidates->known;
}

// ---- visit ----

PercaleNeighborhood percale_candidates_hood(const PercaleCandidates *candidates, uint32_t list)
{
    const PercaleModel *model = candidates->model;
    const PercaleModelSurface *cloth = &model->cloth;
    bool of_edges = list % 2 == 1;
    return (PercaleNeighborhood){.primitives = of_edges ? cloth->edges.vertices[0] : cloth->triangles,
                                 .arity = of_edges ? 2 : 3,
                                 .from = model->position,
                                 .to = model->predicted};
}

/// Some pairs of a block: all of some items.
typedef struct PairRange {
    const PercaleBlock *block;
    const PercaleBlockPairs *pairs;
    const uint32_t *ends; // of the pairs of each place
    uint32_t first_place; // of the first pair
    uint32_t first, end;
} PairRange;

/// Takes those that are no farther apart than the reach, less what the block has moved since they were found.
static void select_found(const PercaleVisiting *visiting, const PairRange *range, PercaleCollector *collector)
{
    const PercaleQueries *queries = &visiting->candidates->lists[visiting->list].queries;
    uint32_t place = range->first_place;
    size_t selected = 0;
    for (uint32_t i = range->first; i < range->end; i++) {
        while (range->ends[place] <= i) {
            place++;
        }
        float reach = visiting->hood.only_passing ? 0.0f : query_at(queries, place).reach;
        collector->numbers.items[selected] = i;
        float distance = page_of_pair(range->pairs, i)->distances[i % PAGE_PAIRS];
        selected += distance <= reach + range->block->moved;
    }
    collector->numbers.count = selected;
}

/// Takes those whose bounds say that they may end within reach, or have met on their ways: then they end no
/// farther apart than they have turned.
static void select_bounded(const PercaleVisiting *visiting, const PairRange *range,
                           PercaleCollector *collector)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    float reach = visiting->hood.only_passing ? 0.0f : visiting->none_waits ? list->widest : list->waiting;
    float turned = range->block->turned;
    float most = (reach > turned ? reach : turned) + range->pairs->lost +
                 BOUND_ROUNDED * visiting->candidates->reach.far;
    uint32_t *numbers = collector->numbers.items;
    size_t selected = 0;
    for (uint32_t i = range->first; i < range->end;) {
        const float *bounds = page_of_pair(range->pairs, i)->bounds + i % PAGE_PAIRS;
        if (i % PAGE_PAIRS + WIDE <= PAGE_PAIRS && i + WIDE <= range->end) {
            uint32_t bits = lane_bits(at_most8(load8(bounds), all8(most)));
            for (; bits != 0; bits &= bits - 1) {
                numbers[selected++] = i + (uint32_t)__builtin_ctz(bits);
            }
            i += WIDE;
        } else {
            numbers[selected] = i++;
            selected += bounds[0] <= most;
        }
    }
    collector->numbers.count = selected;
}

static bool is_bounded(const PercaleVisiting *visiting)
{
    return visiting->candidates->bounded && !visiting->hood.all_near;
}

/// Whether a pair has a touched point.
static bool is_touched(const PercaleVisiting *visiting, const PercaleItemPair *pair)
{
    const uint8_t *touched = visiting->touched;
    uint32_t arity = visiting->hood.arity;
    const PercaleQuery query = query_at(&visiting->candidates->lists[visiting->list].queries, pair->place);
    const uint32_t *corners = visiting->hood.primitives + (size_t)arity * pair->primitive;
    return (touched[query.points[0]] | touched[query.points[1]] | touched[corners[0]] | touched[corners[1]] |
            touched[corners[arity - 1]]) != 0;
}

/// The selected pairs as the collector's `touched`; of those only, where that is asked for, that have a
/// touched point.
static void name_pairs(const PercaleVisiting *visiting, const PairRange *range, PercaleCollector *collector)
{
    uint32_t *numbers = collector->numbers.items;
    uint32_t place = range->first_place;
    size_t kept = 0;
    for (size_t k = 0; k < collector->numbers.count; k++) {
        uint32_t i = numbers[k];
        while (range->ends[place] <= i) {
            place++;
        }
        const PercalePairPage *page = page_of_pair(range->pairs, i);
        PercaleItemPair pair = {place, page->primitives[i % PAGE_PAIRS] & ~PAIR_WATCHED,
                                page->distances[i % PAGE_PAIRS]};
        numbers[kept] = i;
        collector->touched.items[kept] = pair;
        kept += visiting->touched == NULL || is_touched(visiting, &pair);
    }
    collector->numbers.count = collector->touched.count = kept;
}

/// Those of the pairs that can be within reach of each other now, as the collector's `touched`. False without
/// memory.
static bool select_pairs(const PercaleVisiting *visiting, const PairRange *range, PercaleCollector *collector)
{
    PercaleItemPairList *touched = &collector->touched;
    PercaleNodeList *numbers = &collector->numbers;
    size_t most = range->end - range->first;
    if (!percale_memory_reserve(&collector->memory, &numbers->items, &numbers->capacity, most,
                                sizeof(numbers->items[0])) ||
        !percale_memory_reserve(&collector->memory, &touched->items, &touched->capacity, most,
                                sizeof(touched->items[0]))) {
        return false;
    }
    if (is_bounded(visiting)) {
        select_bounded(visiting, range, collector);
    } else {
        select_found(visiting, range, collector);
    }
    name_pairs(visiting, range, collector);
    return true;
}

/// What has been asked is known.
static void write_bounds(const PercaleVisiting *visiting, const PairRange *range,
                         const PercaleCollector *collector)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    float far = visiting->candidates->reach.far;
    for (size_t i = 0; i < collector->touched.count; i++) {
        uint32_t pair = collector->numbers.items[i];
        float distance = collector->touched.items[i].distance;
        PercalePairPage *page = page_of_pair(range->pairs, pair);
        bool waits = list->smooth != NULL && (page->primitives[pair % PAGE_PAIRS] & PAIR_WATCHED) == 0;
        float ahead = waits ? 0.0f : list->widest - list->waiting;
        page->bounds[pair % PAGE_PAIRS] = (distance < far ? distance : far) - ahead + range->pairs->lost;
    }
}

/// Drops those found that wait.
static void drop_waiting(const PercaleVisiting *visiting, const PairRange *range, PercaleCollector *collector)
{
    float waiting = visiting->candidates->lists[visiting->list].waiting;
    PercaleNeighborList *found = &collector->found;
    size_t kept = 0;
    for (size_t i = 0; i < found->count; i++) {
        PercaleNeighbor neighbor = found->items[i];
        found->items[kept] = neighbor;
        uint32_t pair = collector->numbers.items[neighbor.pair];
        kept += neighbor.may_pass || neighbor.distance <= waiting ||
                (page_of_pair(range->pairs, pair)->primitives[pair % PAGE_PAIRS] & PAIR_WATCHED) != 0;
    }
    found->count = kept;
}

/// Who was asked for its pairs has said which of them it wants to see again.
static void write_watched(const PercaleCandidateList *list, const PairRange *range,
                          const PercaleCollector *collector)
{
    for (size_t i = 0; i < collector->touched.count; i++) {
        uint32_t place = collector->touched.items[i].place;
        bool always = !list->smooth[query_item(&list->queries, place)];
        uint32_t pair = collector->numbers.items[i];
        page_of_pair(range->pairs, pair)->primitives[pair % PAGE_PAIRS] =
            collector->touched.items[i].primitive | (always ? PAIR_WATCHED : 0);
    }
    for (size_t i = 0; i < collector->found.count; i++) {
        const PercaleNeighbor *neighbor = &collector->found.items[i];
        uint32_t pair = collector->numbers.items[neighbor->pair];
        page_of_pair(range->pairs, pair)->primitives[pair % PAGE_PAIRS] |=
            neighbor->watched ? PAIR_WATCHED : 0;
    }
}

static void visit_pairs(const PercaleVisiting *visiting, PercaleCollector *collector, const PairRange *range)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    const PercaleItemPairList *touched = &collector->touched;
    PercaleNeighborList *found = &collector->found;
    found->count = 0;
    bool complete = select_pairs(visiting, range, collector) &&
                    percale_neighbors_find(&visiting->hood, &list->queries, touched->items, touched->count,
                                           &collector->memory, found);
    if (complete && list->smooth != NULL && is_bounded(visiting) && !visiting->none_waits) {
        drop_waiting(visiting, range, collector);
    }
    collector->candidates += touched->count;
    collector->complete = collector->complete && complete;
    collector->neighbors = (PercaleNeighborList){.items = found->items};
    while (collector->complete && percale_candidates_next(collector)) {
        uint32_t place = collector->neighbors.items[0].place;
        const PercaleQuery query = query_at(&list->queries, place);
        visiting->visit(visiting->context, collector, &query, place, query_item(&list->queries, place));
    }
    if (collector->complete && list->smooth != NULL && !visiting->hood.only_passing) {
        write_watched(list, range, collector);
    }
    if (collector->complete && is_bounded(visiting)) {
        write_bounds(visiting, range, collector);
    }
}

/// The block with that pair.
static uint32_t block_of_pair(const PercaleCandidateList *list, uint64_t pair)
{
    uint32_t low = 0;
    uint32_t high = list->block_count - 1;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (list->first_pair[middle + 1] > pair) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

/// The place with that pair of the block's, or the block's last and 1.
static uint32_t place_of_pair(const PercaleCandidateList *list, uint32_t b, uint32_t pair)
{
    uint32_t low = list->first_item[b];
    uint32_t high = list->first_item[b + 1];
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (list->ends[middle] <= pair) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/// The first pair of a place in those of its block.
static uint32_t begin_of_place(const PercaleCandidateList *list, uint32_t b, uint32_t place)
{
    return place > list->first_item[b] ? list->ends[place - 1] : 0;
}

/// The pairs of the items of a block that begin among the pairs [first, end).
static PairRange range_of(const PercaleCandidates *candidates, const PercaleCandidateList *list, uint32_t b,
                          const uint32_t bounds[2])
{
    const PercaleBlockPairs *pairs = &list->pairs[b];
    PairRange range = {&candidates->blocks.items[list->first_block + b], pairs, list->ends, 0, 0, 0};
    uint32_t places[2];
    for (int k = 0; k < 2; k++) {
        places[k] = place_of_pair(list, b, bounds[k]);
        places[k] += places[k] < list->first_item[b + 1] && begin_of_place(list, b, places[k]) < bounds[k];
    }
    range.first_place = places[0];
    range.first = begin_of_place(list, b, places[0]);
    range.end = begin_of_place(list, b, places[1]);
    return range;
}

void percale_candidates_visit(const PercaleVisiting *visiting, PercaleCollector *collector, uint64_t first,
                              uint64_t end)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    uint32_t b = first < end ? block_of_pair(list, first) : list->block_count;
    for (; collector->complete && b < list->block_count && list->first_pair[b] < end; b++) {
        uint32_t count = list->pairs[b].count;
        uint32_t from = first > list->first_pair[b] ? (uint32_t)(first - list->first_pair[b]) : 0;
        uint32_t to = end - list->first_pair[b] < count ? (uint32_t)(end - list->first_pair[b]) : count;
        PairRange range = range_of(visiting->candidates, list, b, (const uint32_t[2]){from, to});
        if (range.first < range.end) {
            visit_pairs(visiting, collector, &range);
        }
    }
}

void percale_candidates_visit_place(const PercaleVisiting *visiting, PercaleCollector *collector,
                                    uint32_t place)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    uint32_t b = 0;
    for (uint32_t high = list->block_count; b < high;) { // the block with that place
        uint32_t middle = b + (high - b) / 2;
        if (list->first_item[middle + 1] <= place) {
            b = middle + 1;
        } else {
            high = middle;
        }
    }
    if (b == list->block_count) {
        return;
    }
    PairRange range = {&visiting->candidates->blocks.items[list->first_block + b],
                       &list->pairs[b],
                       list->ends,
                       place,
                       begin_of_place(list, b, place),
                       list->ends[place]};
    if (range.first < range.end) {
        visit_pairs(visiting, collector, &range);
    }
}

// ---- what a pair is ----

bool percale_candidates_are_sewn(const PercaleModel *model, const uint32_t points[2], const uint32_t *corners,
                                 uint32_t corner_count)
{
    bool sewn = false;
    for (uint32_t corner = 0; model->open_seam_count > 0 && corner < corner_count; corner++) {
        sewn = sewn || !(near_distance(&model->near, points[0], corners[corner]) > 0.0f) ||
               !(near_distance(&model->near, points[1], corners[corner]) > 0.0f);
    }
    return sewn;
}

bool percale_candidates_collide(const PercaleCandidates *candidates, uint32_t point, uint32_t slot)
{
    const PercaleModel *model = candidates->model;
    uint32_t mask = model->cloths[model->cloth_of[slot]].mask;
    if (point < model->slot_count) {
        return (mask & model->cloths[model->cloth_of[point]].mask) != 0;
    }
    uint32_t o = 0;
    while (point - model->obstacles[o].first_point >= model->obstacles[o].vertex_count) {
        o++;
    }
    return (mask & model->obstacles[o].mask) != 0;
}

float percale_candidates_least_reach(const PercaleCandidates *candidates)
{
    const PercaleModel *model = candidates->model;
    float cloth = INFINITY;
    float obstacle = INFINITY;
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        cloth = fminf(cloth, model->cloths[c].thickness);
    }
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        obstacle = fminf(obstacle, model->obstacles[o].thickness);
    }
    return 0.5f * CONTACT_REACH * (cloth + fminf(cloth, obstacle));
}
