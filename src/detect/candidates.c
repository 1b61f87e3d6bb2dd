#include "detect/candidates.h"

#include "base/wide.h"
#include "detect/candidate_search.h"
#include "model/order.h"

#include <string.h>

// Share of the mean edge by which candidates may be farther apart than in reach: more makes the lists longer,
// less makes them anew more often. (Twice as much for blocks whose pairs don't last saves half of the
// searches and costs as much in asking.)
static const float MARGIN = 0.25f;

// Share of the margin that a block may deviate from its anchors before it gets new ones: more makes blocks
// that are found anew begin with what those near them have deviated, less adds up what shakes to and fro.
static const float ANCHORED = 0.125f;

enum {
    BLOCK_SLOTS = 32,              // at most: where it bends, a larger block deviates more from its centre
    BLOCK_EDGES = 3 * BLOCK_SLOTS, // of a mesh, which has so many
};

// Of the farthest bound, what adding and comparing bounds rounds away, and the distances' own rounding: they
// are computed from edges as long as a few of it.
static const float BOUND_ROUNDED = 1e-5f;

// Mean edges that a block is wide at most: a square of BLOCK_SLOTS has 6 on a side.
static const float BLOCK_EDGES_WIDE = 7.0f;

/// Farthest that a surface of this thickness is in reach of a cloth, m.
static float widest_reach(const PercaleCandidates *candidates, float thickness)
{
    return 1.001f * 0.5f * CONTACT_REACH * (thickness + candidates->thickest);
}

static float widest_reach_of_all(const PercaleCandidates *candidates)
{
    const PercaleModel *model = candidates->model;
    float thickest = candidates->thickest;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        thickest = fmaxf(thickest, model->obstacles[o].thickness);
    }
    return widest_reach(candidates, thickest);
}

/// The farthest that a bound may be, m: what is farther apart is not compared.
static float farthest_bound(const PercaleCandidates *candidates)
{
    return widest_reach_of_all(candidates) + candidates->margin;
}

// ---- create ----

static float mean_edge(const PercaleModel *model)
{
    double sum = 0.0;
    for (uint32_t e = 0; e < model->edge_count; e++) {
        sum += (double)model->edge_lengths[e];
    }
    return model->edge_count > 0 ? (float)(sum / (double)model->edge_count) : 0.0f;
}

/// An obstacle's vertices or edges along a curve: nobody else has ordered them.
static bool order_items(PercaleCandidateList *list, bool of_edges, const f32x4 *x, PercaleMemory *memory)
{
    const PercaleModelSurface *mesh = list->mesh;
    uint32_t count = of_edges ? mesh->edges.edge_count : mesh->vertex_count;
    float *centroids = percale_memory_new(memory, 3 * (size_t)count, sizeof(float));
    list->order = percale_memory_new(memory, count, sizeof(uint32_t));
    bool complete = centroids != NULL && list->order != NULL;
    for (uint32_t i = 0; complete && i < count; i++) {
        const uint32_t *ends = of_edges ? mesh->edges.vertices[i] : NULL;
        f32x4 sum = x[mesh->first_point + (of_edges ? ends[0] : i)];
        sum += of_edges ? x[mesh->first_point + ends[1]] : sum;
        memcpy(centroids + 3 * (size_t)i, &sum, 3 * sizeof(float));
    }
    complete = complete && percale_order_along_curve(centroids, count, memory, list->order);
    percale_memory_free(memory, centroids);
    return complete;
}

/// The items of a list, while they are cut into blocks.
typedef struct Items {
    PercaleCandidateList *list;
    const f32x4 *x;
    uint32_t count, most; // of all, of a block
    bool edges;           // else vertices
    float widest;         // m; where the curve jumps, a block ends
} Items;

static Items items_of(const PercaleCandidates *candidates, PercaleCandidateList *list, bool edges)
{
    const PercaleModelSurface *mesh = list->mesh;
    const f32x4 *x = candidates->model->position;
    float sum = 0.0f;
    for (uint32_t e = 0; e < mesh->edges.edge_count; e++) {
        const uint32_t *ends = mesh->edges.vertices[e];
        sum += length3(x[mesh->first_point + ends[0]] - x[mesh->first_point + ends[1]]);
    }
    return (Items){list,
                   x,
                   edges ? mesh->edges.edge_count : mesh->vertex_count,
                   edges ? BLOCK_EDGES : BLOCK_SLOTS,
                   edges,
                   BLOCK_EDGES_WIDE * sum / fmaxf((float)mesh->edges.edge_count, 1.0f)};
}

static void points_of_item(const Items *items, uint32_t place, uint32_t points[2])
{
    const PercaleCandidateList *list = items->list;
    uint32_t item = list->order != NULL ? list->order[place] : place;
    for (int k = 0; k < 2; k++) {
        points[k] = list->mesh->first_point + (items->edges ? list->mesh->edges.vertices[item][k] : item);
    }
}

static uint32_t end_of_block(const Items *items, uint32_t first)
{
    uint32_t points[2];
    points_of_item(items, first, points);
    f32x4 low = items->x[points[0]];
    f32x4 high = low;
    uint32_t end = first;
    for (; end < items->count && end < first + items->most; end++) {
        points_of_item(items, end, points);
        low = min4(low, min4(items->x[points[0]], items->x[points[1]]));
        high = max4(high, max4(items->x[points[0]], items->x[points[1]]));
        f32x4 size = high - low;
        if (end > first && fmaxf(size[0], fmaxf(size[1], size[2])) > items->widest) {
            break;
        }
    }
    return end;
}

/// What a list keeps of each of its blocks. False without memory.
static bool open_list(PercaleCandidateList *list, PercaleMemory *memory)
{
    list->first_item = percale_memory_new(memory, (size_t)list->block_count + 1, sizeof(uint32_t));
    list->pairs = percale_memory_new(memory, list->block_count, sizeof(list->pairs[0]));
    list->first_pair = percale_memory_new(memory, (size_t)list->block_count + 1, sizeof(size_t));
    return list->first_item != NULL && list->pairs != NULL && list->first_pair != NULL;
}

/// Cuts a list into blocks, the first of which has this number.
static bool cut_list(const Items *items, uint32_t first_block, PercaleMemory *memory)
{
    PercaleCandidateList *list = items->list;
    list->first_block = first_block;
    for (uint32_t i = 0; i < items->count; i = end_of_block(items, i)) {
        list->block_count++;
    }
    if (!open_list(list, memory)) {
        return false;
    }
    for (uint32_t b = 0; b < list->block_count; b++) {
        list->first_item[b + 1] = end_of_block(items, list->first_item[b]);
    }
    return true;
}

/// The cloth's edges are in the order of their first slots, and in the same blocks as these.
static bool cut_cloth_edges(PercaleCandidateList *edges, const PercaleCandidateList *slots,
                            PercaleMemory *memory)
{
    edges->block_count = slots->block_count;
    if (!open_list(edges, memory)) {
        return false;
    }
    const PercaleEdges *all = &edges->mesh->edges;
    uint32_t edge = 0;
    for (uint32_t b = 0; b < edges->block_count; b++) {
        while (edge < all->edge_count && all->vertices[edge][0] < slots->first_item[b + 1]) {
            edge++;
        }
        edges->first_item[b + 1] = edge;
    }
    return true;
}

/// Points of the blocks: those of the items, and with the cloth's slots all triangles that have one of them.
static bool list_points(const Items *items, PercaleBlockLister *lister, PercaleMemory *memory)
{
    const PercaleCandidateList *list = items->list;
    bool is_cloth = list->mesh->first_point == 0;
    bool complete = true;
    for (uint32_t b = 0; complete && b < list->block_count; b++) {
        complete = percale_blocks_open(lister, memory);
        for (uint32_t i = list->first_item[b]; complete && i < list->first_item[b + 1]; i++) {
            uint32_t points[2];
            points_of_item(items, i, points);
            complete = percale_blocks_add(lister, points[0], memory) &&
                       percale_blocks_add(lister, points[1], memory);
        }
        const uint32_t *faces = list->mesh->vertex_first_face;
        uint32_t end = is_cloth ? faces[list->first_item[b + 1]] : 0;
        for (uint32_t i = is_cloth ? faces[list->first_item[b]] : 0; complete && i < end; i++) {
            const uint32_t *corners = list->mesh->triangles + 3 * (size_t)list->mesh->vertex_faces[i];
            complete = percale_blocks_add(lister, corners[0], memory) &&
                       percale_blocks_add(lister, corners[1], memory) &&
                       percale_blocks_add(lister, corners[2], memory);
        }
    }
    return complete;
}

static PercaleQuery query_of(const PercaleCandidates *candidates, const Items *items, uint32_t place)
{
    const PercaleModel *model = candidates->model;
    const PercaleModelSurface *mesh = items->list->mesh;
    PercaleQuery query;
    points_of_item(items, place, query.points);
    bool is_cloth = mesh == &model->cloth;
    float thickness = is_cloth ? model->cloths[model->cloth_of[query.points[0]]].thickness : mesh->thickness;
    query.reach = widest_reach(candidates, thickness);
    return query;
}

/// What the items of a list are asked as. False without memory.
static bool list_queries(const PercaleCandidates *candidates, const Items *items, PercaleMemory *memory)
{
    PercaleQuery *queries = percale_memory_new(memory, items->count, sizeof(queries[0]));
    items->list->queries = queries;
    for (uint32_t place = 0; queries != NULL && place < items->count; place++) {
        queries[place] = query_of(candidates, items, place);
        items->list->widest = fmaxf(items->list->widest, queries[place].reach);
    }
    return queries != NULL;
}

static bool create_blocks(PercaleCandidates *candidates, bool edges, PercaleBlockLister *lister,
                          PercaleMemory *memory)
{
    const PercaleModel *model = candidates->model;
    PercaleCandidateList *lists = candidates->lists;
    Items slots = items_of(candidates, &lists[0], false);
    Items cloth_edges = items_of(candidates, &lists[1], true);
    bool complete = cut_list(&slots, 0, memory) && cut_cloth_edges(&lists[1], &lists[0], memory) &&
                    list_points(&slots, lister, memory) && list_queries(candidates, &slots, memory) &&
                    list_queries(candidates, &cloth_edges, memory);
    for (uint32_t i = 2; complete && candidates->obstacles && i < candidates->list_count; i++) {
        bool of_edges = i % 2 == 1;
        if (edges || !of_edges) {
            complete = order_items(&lists[i], of_edges, model->position, memory);
            Items items = items_of(candidates, &lists[i], of_edges);
            complete = complete && cut_list(&items, lister->count, memory) &&
                       list_points(&items, lister, memory) && list_queries(candidates, &items, memory);
        }
    }
    complete = complete && percale_blocks_create(&candidates->blocks, lister, lists[0].block_count,
                                                 model->position, memory);
    candidates->spent.blocks = percale_memory_new(memory, candidates->blocks.count, sizeof(uint32_t));
    return complete && candidates->spent.blocks != NULL;
}

/// The tree over the cloth's edges, and the last one in each of its lowest nodes. False without memory.
static bool create_edges(PercaleCandidates *candidates, PercaleMemory *memory)
{
    const PercaleEdges *edges = &candidates->model->cloth.edges;
    PercaleTree *tree = &candidates->edges;
    if (!percale_tree_build(tree, edges->vertices[0], 2, edges->edge_count, candidates->model->position,
                            memory)) {
        return false;
    }
    uint32_t *last = percale_memory_new(memory, tree->level_size[0], sizeof(uint32_t));
    for (uint32_t i = 0; last != NULL && i < edges->edge_count; i++) {
        uint32_t node = i / TREE_WIDTH;
        last[node] = tree->order[i] > last[node] ? tree->order[i] : last[node];
    }
    candidates->last_edges = last;
    return last != NULL;
}

bool percale_candidates_create(PercaleCandidates *candidates, const PercaleModel *model, bool cloth,
                               bool edges, bool obstacles, PercaleMemory *memory)
{
    *candidates = (PercaleCandidates){.model = model, .cloth = cloth, .obstacles = obstacles};
    candidates->margin = MARGIN * mean_edge(model);
    candidates->thickest = thickest_cloth(model);
    candidates->list_count = 2 + 2 * model->obstacle_count;
    candidates->lists = percale_memory_new(memory, candidates->list_count, sizeof(candidates->lists[0]));
    for (uint32_t i = 0; candidates->lists != NULL && i < candidates->list_count; i++) {
        candidates->lists[i].mesh = i < 2 ? &model->cloth : &model->obstacles[i / 2 - 1];
    }
    PercaleBlockLister lister = {.last = percale_memory_new(memory, model->point_count, sizeof(uint32_t))};
    bool complete = candidates->lists != NULL && lister.last != NULL &&
                    create_blocks(candidates, edges, &lister, memory) &&
                    percale_tree_build(&candidates->faces, model->cloth.triangles, 3,
                                       model->cloth.triangle_count, model->position, memory) &&
                    (!edges || create_edges(candidates, memory));
    percale_memory_free(memory, lister.last);
    percale_memory_free(memory, lister.first);
    percale_memory_free(memory, lister.points);
    return complete;
}

void percale_candidates_free(PercaleCandidates *candidates, PercaleMemory *memory)
{
    for (uint32_t i = 0; candidates->lists != NULL && i < candidates->list_count; i++) {
        PercaleCandidateList *list = &candidates->lists[i];
        for (uint32_t b = 0; list->pairs != NULL && b < list->block_count; b++) {
            percale_memory_free(memory, list->pairs[b].items);
            percale_memory_free(memory, list->pairs[b].bounds);
        }
        percale_memory_free(memory, list->pairs);
        percale_memory_free(memory, list->first_pair);
        percale_memory_free(memory, list->first_item);
        percale_memory_free(memory, list->order);
        percale_memory_free(memory, list->queries);
    }
    percale_memory_free(memory, candidates->lists);
    percale_memory_free(memory, candidates->spent.blocks);
    percale_memory_free(memory, candidates->last_edges);
    percale_blocks_free(&candidates->blocks, memory);
    percale_tree_free(&candidates->faces, memory);
    percale_tree_free(&candidates->edges, memory);
    *candidates = (PercaleCandidates){0};
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
            candidates->lists[i].pairs[b].count = 0;
        }
    }
}

/// Takes what a block has lost from its bounds themselves.
static void settle_bounds(PercaleBlockPairs *pairs)
{
    for (size_t k = 0; k < pairs->count; k++) {
        pairs->bounds[k] -= pairs->lost;
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
    PercaleBlockReach reach = {widest_reach_of_all(candidates), farthest_bound(candidates)};
    uint32_t range[2];
    searching_blocks(candidates, range);
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
    size_t first, end;
} PairRange;

/// Takes those that are no farther apart than the reach, less what the block has moved since they were found.
static void select_found(const PercaleVisiting *visiting, const PairRange *range, PercaleCollector *collector)
{
    const PercaleQuery *queries = visiting->candidates->lists[visiting->list].queries;
    const PercaleItemPair *items = range->pairs->items;
    size_t selected = 0;
    for (size_t i = range->first; i < range->end; i++) {
        float reach = visiting->hood.only_passing ? 0.0f : queries[items[i].place].reach;
        collector->numbers.items[selected] = (uint32_t)i;
        selected += items[i].distance <= reach + range->block->moved;
    }
    collector->numbers.count = selected;
}

/// Takes those whose bounds say that they may end within reach, or have met on their ways: then they end no
/// farther apart than they have turned.
static void select_bounded(const PercaleVisiting *visiting, const PairRange *range,
                           PercaleCollector *collector)
{
    const float *bounds = range->pairs->bounds;
    float reach = visiting->hood.only_passing ? 0.0f : visiting->candidates->lists[visiting->list].widest;
    float turned = range->block->turned;
    float most = (reach > turned ? reach : turned) + range->pairs->lost +
                 BOUND_ROUNDED * farthest_bound(visiting->candidates);
    uint32_t *numbers = collector->numbers.items;
    size_t selected = 0;
    size_t i = range->first;
    for (; i + WIDE <= range->end; i += WIDE) {
        uint32_t bits = lane_bits(at_most8(load8(bounds + i), all8(most)));
        for (; bits != 0; bits &= bits - 1) {
            numbers[selected++] = (uint32_t)i + (uint32_t)__builtin_ctz(bits);
        }
    }
    for (; i < range->end; i++) {
        numbers[selected] = (uint32_t)i;
        selected += bounds[i] <= most;
    }
    collector->numbers.count = selected;
}

static bool is_bounded(const PercaleVisiting *visiting)
{
    return visiting->candidates->bounded && !visiting->hood.all_near;
}

/// Drops the selected pairs without a touched point.
static void drop_untouched(const PercaleVisiting *visiting, const PairRange *range,
                           PercaleCollector *collector)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    const uint8_t *touched = visiting->touched;
    uint32_t *numbers = collector->numbers.items;
    uint32_t arity = visiting->hood.arity;
    size_t kept = 0;
    for (size_t i = 0; i < collector->numbers.count; i++) {
        const PercaleItemPair *pair = &range->pairs->items[numbers[i]];
        const uint32_t *points = list->queries[pair->place].points;
        const uint32_t *corners = visiting->hood.primitives + (size_t)arity * pair->primitive;
        numbers[kept] = numbers[i];
        kept += (touched[points[0]] | touched[points[1]] | touched[corners[0]] | touched[corners[1]] |
                 touched[corners[arity - 1]]) != 0;
    }
    collector->numbers.count = kept;
}

/// Those of the pairs that can be within reach of each other now, as the collector's `touched`. False without
/// memory.
static bool select_pairs(const PercaleVisiting *visiting, const PairRange *range, PercaleCollector *collector)
{
    PercaleItemPairList *touched = &collector->touched;
    PercaleNodeList *numbers = &collector->numbers;
    size_t most = range->end - range->first;
    touched->count = 0;
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
    if (visiting->touched != NULL) {
        drop_untouched(visiting, range, collector);
    }
    touched->count = numbers->count;
    for (size_t i = 0; i < numbers->count; i++) {
        touched->items[i] = range->pairs->items[numbers->items[i]];
    }
    return true;
}

/// What has been asked is known.
static void write_bounds(const PercaleVisiting *visiting, const PairRange *range,
                         const PercaleCollector *collector)
{
    float far = farthest_bound(visiting->candidates);
    for (size_t i = 0; i < collector->touched.count; i++) {
        float distance = collector->touched.items[i].distance;
        range->pairs->bounds[collector->numbers.items[i]] =
            (distance < far ? distance : far) + range->pairs->lost;
    }
}

static void visit_pairs(const PercaleVisiting *visiting, PercaleCollector *collector, const PairRange *range)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    const PercaleItemPairList *touched = &collector->touched;
    PercaleNeighborList *found = &collector->found;
    found->count = 0;
    bool complete = select_pairs(visiting, range, collector) &&
                    percale_neighbors_find(&visiting->hood, list->queries, touched->items, touched->count,
                                           &collector->memory, found);
    if (complete && is_bounded(visiting)) {
        write_bounds(visiting, range, collector);
    }
    collector->candidates += touched->count;
    collector->complete = collector->complete && complete;
    collector->neighbors = (PercaleNeighborList){.items = found->items};
    while (collector->complete && percale_candidates_next(collector)) {
        uint32_t place = collector->neighbors.items[0].place;
        visiting->visit(visiting->context, collector, &list->queries[place], place,
                        list->order != NULL ? list->order[place] : place);
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

/// The first pair from this one on that begins an item.
static size_t begin_of_item(const PercaleBlockPairs *pairs, size_t i)
{
    while (i > 0 && i < pairs->count && pairs->items[i - 1].place == pairs->items[i].place) {
        i++;
    }
    return i;
}

void percale_candidates_visit(const PercaleVisiting *visiting, PercaleCollector *collector, uint64_t first,
                              uint64_t end)
{
    const PercaleCandidateList *list = &visiting->candidates->lists[visiting->list];
    uint32_t b = first < end ? block_of_pair(list, first) : list->block_count;
    for (; collector->complete && b < list->block_count && list->first_pair[b] < end; b++) {
        const PercaleBlockPairs *pairs = &list->pairs[b];
        size_t from = first > list->first_pair[b] ? first - list->first_pair[b] : 0;
        size_t to = end - list->first_pair[b] < pairs->count ? end - list->first_pair[b] : pairs->count;
        PairRange range = {&visiting->candidates->blocks.items[list->first_block + b], pairs,
                           begin_of_item(pairs, from), begin_of_item(pairs, to)};
        if (range.first < range.end) {
            visit_pairs(visiting, collector, &range);
        }
    }
}

/// The first pair whose place is not before this one.
static size_t find_place(const PercaleBlockPairs *pairs, uint32_t place)
{
    size_t low = 0;
    size_t high = pairs->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (pairs->items[middle].place < place) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
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
    const PercaleBlockPairs *pairs = &list->pairs[b];
    PairRange range = {&visiting->candidates->blocks.items[list->first_block + b], pairs,
                       find_place(pairs, place), find_place(pairs, place + 1)};
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
