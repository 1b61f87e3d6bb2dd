#include "detect/candidate_search.h"

/// The items of one list, to be asked for.
typedef struct Search {
    const PercaleCandidates *candidates;
    const PercaleCandidateList *list;
    PercaleNeighborhood hood;
    const PercaleTree *tree;
    PercalePairPool *pool;
    PercaleMemory *pool_memory;
    const uint32_t *spent; // blocks of the list
    float farthest;        // m, that a pair's bound may be
} Search;

/// Boxes of a few items' ways, wider by their reach, the margin, and what float32 may have rounded away.
typedef struct Group {
    uint32_t first, count; // places in the list's order
    f32x4 low[TREE_WIDTH], high[TREE_WIDTH];
    f32x4 least, most; // around all
} Group;

static void add_query(const Search *search, Group *group)
{
    uint32_t k = group->count++;
    const PercaleQuery query = query_at(&search->list->queries, group->first + k);
    const uint32_t *points = query.points;
    const f32x4 *from = search->hood.from;
    const f32x4 *to = search->hood.to;
    f32x4 low = min4(min4(from[points[0]], from[points[1]]), min4(to[points[0]], to[points[1]]));
    f32x4 high = max4(max4(from[points[0]], from[points[1]]), max4(to[points[0]], to[points[1]]));
    for (int axis = 0; axis < 3; axis++) {
        float slack = (query.reach + search->hood.wider) + 1e-6f * (fabsf(low[axis]) + fabsf(high[axis]));
        low[axis] -= slack;
        high[axis] += slack;
    }
    group->low[k] = low;
    group->high[k] = high;
    group->least = k == 0 ? low : min4(group->least, low);
    group->most = k == 0 ? high : max4(group->most, high);
}

/// Whether a primitive has one of the query's points: then the two are no pair.
static inline bool is_own(const Search *search, const PercaleQuery *query, uint32_t primitive)
{
    const uint32_t *corners = search->hood.primitives + (size_t)search->hood.arity * primitive;
    bool own = false;
    for (uint32_t k = 0; k < search->hood.arity; k++) {
        own = own || corners[k] == query->points[0] || corners[k] == query->points[1];
    }
    return own;
}

/// Whether a list's items are the cloth's edges: asked against each other, each pair once.
static bool asks_only_later(const Search *search)
{
    return search->tree->arity == 2 && search->list->mesh == &search->candidates->model->cloth;
}

/// Drops the nodes whose edges all come before the group's.
static void drop_earlier(const Search *search, const Group *group, PercaleNodeList *nodes)
{
    const uint32_t *last = search->candidates->last_edges;
    size_t count = 0;
    for (size_t i = 0; i < nodes->count; i++) {
        uint32_t node = nodes->items[i];
        nodes->items[count] = node;
        count += last[node] > group->first;
    }
    nodes->count = count;
}

/// Adds the primitives whose boxes the query's touches; of the cloth's edges, those after it.
static bool list_touched(const Search *search, const Group *group, uint32_t k, PercaleCollector *collector)
{
    const PercaleTree *tree = search->tree;
    const PercaleQuery query = query_at(&search->list->queries, group->first + k);
    PercaleItemPairList *touched = &collector->touched;
    uint32_t first = asks_only_later(search) ? group->first + k + 1 : 0; // the cloth's are in their own order
    size_t most = touched->count + TREE_WIDTH * collector->nodes.count;
    if (!percale_memory_reserve(&collector->memory, &touched->items, &touched->capacity, most,
                                sizeof(touched->items[0]))) {
        return false;
    }
    for (size_t i = 0; i < collector->nodes.count; i++) {
        uint32_t node = collector->nodes.items[i];
        uint32_t bits = lane_bits(tree_box_overlaps(&tree->nodes[node], group->low[k], group->high[k]));
        for (; bits != 0; bits &= bits - 1) {
            uint32_t primitive = tree->order[TREE_WIDTH * node + (uint32_t)__builtin_ctz(bits)];
            if (primitive >= first && !is_own(search, &query, primitive)) {
                touched->items[touched->count++] = (PercaleItemPair){group->first + k, primitive, 0.0f};
            }
        }
    }
    return true;
}

/// Distance of a point and an edge at the ends of their ways, m; a point twice is one, too.
static float to_edge(const f32x4 *x, uint32_t point, uint32_t a, uint32_t b)
{
    f32x4 along = x[b] - x[a];
    f32x4 from = x[point] - x[a];
    float length2 = dot3(along, along);
    float t = length2 > 0.0f ? fminf(fmaxf(dot3(from, along) / length2, 0.0f), 1.0f) : 0.0f;
    return length3(from - t * along);
}

/// How much farther apart two features of the cloth are than in reach of each other, m: less where they are
/// near on the rest shape, too, than where they aren't. `way` is that between them.
static float beyond_reach(const PercaleQuery *query, float distance, float way)
{
    return distance - fminf(query->reach, allowed_thickness(INFINITY, way) * REACH_SLACK * CONTACT_REACH);
}

/// Whether two features of the cloth may come within a reach of their own before their block is searched
/// again: an edge and another, or a vertex and one of a face's features, each of which is as thick as its
/// nearest corner allows.
static bool may_keep_apart(const Search *search, const PercaleQuery *query, const PercaleNeighbor *neighbor)
{
    const PercaleNear *near = &search->candidates->model->near;
    const uint32_t *corners = search->hood.primitives + (size_t)search->hood.arity * neighbor->index;
    const uint32_t *own = query->points;
    float margin = search->hood.wider;
    if (search->hood.arity == 2) {
        return beyond_reach(query, neighbor->distance, near_features(near, own, 2, corners, 2)) <= margin;
    }
    float ways[3];
    uint32_t far[3]; // corners, the farthest on the rest shape first
    for (uint32_t k = 0; k < 3; k++) {
        float way = near_distance(near, own[0], corners[k]);
        uint32_t at = k;
        for (; at > 0 && ways[at - 1] < way; at--) {
            ways[at] = ways[at - 1];
            far[at] = far[at - 1];
        }
        ways[at] = way;
        far[at] = corners[k];
    }
    const float SLACK = 0.99f; // what float32 may be wrong by
    const f32x4 *x = search->hood.to;
    return beyond_reach(query, neighbor->distance, ways[2]) <= margin ||
           beyond_reach(query, SLACK * to_edge(x, own[0], far[0], far[1]), ways[1]) <= margin ||
           beyond_reach(query, SLACK * to_edge(x, own[0], far[0], far[0]), ways[0]) <= margin;
}

/// Whether a neighbour is no pair after all.
static bool is_no_pair(const Search *search, const PercaleNeighbor *neighbor)
{
    const PercaleModel *model = search->candidates->model;
    const PercaleQuery query = query_at(&search->list->queries, neighbor->place);
    if (search->list->mesh != &model->cloth) {
        return false;
    }
    uint32_t arity = search->hood.arity;
    return percale_candidates_are_sewn(model, query.points,
                                       search->hood.primitives + (size_t)arity * neighbor->index, arity) ||
           (!neighbor->may_pass && !search->hood.all_near && !may_keep_apart(search, &query, neighbor));
}

/// Keeps the neighbours of an item, ascending.
static void keep_neighbors(const Search *search, PercaleCollector *collector)
{
    PercaleNeighborList *found = &collector->neighbors;
    for (size_t i = 1; i < found->count; i++) {
        PercaleNeighbor neighbor = found->items[i];
        size_t at = i;
        for (; at > 0 && found->items[at - 1].index > neighbor.index; at--) {
            found->items[at] = found->items[at - 1];
        }
        found->items[at] = neighbor;
    }
    for (size_t i = 0; i < found->count; i++) {
        const PercaleNeighbor *neighbor = &found->items[i];
        if (!is_no_pair(search, neighbor)) {
            percale_collect_pair(collector,
                                 (PercaleItemPair){neighbor->place, neighbor->index, neighbor->distance});
        }
    }
}

/// Finds the pairs of some items, of one block.
static bool find_group(const Search *search, PercaleCollector *collector, uint32_t first, uint32_t end)
{
    Group group = {.first = first};
    while (first + group.count < end) {
        add_query(search, &group);
    }
    const PercaleItemPairList *touched = &collector->touched;
    PercaleNeighborList *found = &collector->found;
    collector->touched.count = found->count = 0;
    bool complete =
        percale_tree_overlap(search->tree, group.least, group.most, &collector->memory, &collector->nodes);
    if (asks_only_later(search)) {
        drop_earlier(search, &group, &collector->nodes);
    }
    for (uint32_t k = 0; complete && collector->nodes.count > 0 && k < group.count; k++) {
        complete = list_touched(search, &group, k, collector);
    }
    complete = complete && percale_neighbors_find(&search->hood, &search->list->queries, touched->items,
                                                  touched->count, &collector->memory, found);
    collector->candidates += touched->count;
    collector->neighbors = (PercaleNeighborList){.items = found->items};
    while (complete && percale_candidates_next(collector)) {
        keep_neighbors(search, collector);
    }
    return complete;
}

/// Finds the pairs of a block's items.
static bool find_block(const Search *search, PercaleCollector *collector, uint32_t b)
{
    const PercaleCandidates *candidates = search->candidates;
    const PercaleCandidateList *list = search->list;
    PercaleBlockPairs *pairs = &list->pairs[b];
    uint32_t end = list->first_item[b + 1];
    bool complete = true;
    collector->pairs.count = 0;
    for (uint32_t i = list->first_item[b]; complete && i < end; i += TREE_WIDTH) {
        complete = find_group(search, collector, i, i + TREE_WIDTH < end ? i + TREE_WIDTH : end);
    }
    const PercaleItemPairList *found = &collector->pairs;
    if (!complete || !collector->complete ||
        !percale_pair_pages_take(search->pool, pairs, found->count, &collector->memory,
                                 search->pool_memory)) {
        return false;
    }
    float since = candidates->bounded ? 0.0f : candidates->blocks.items[list->first_block + b].drifted;
    float ahead = list->widest - list->waiting;
    uint32_t watched = list->smooth != NULL ? PAIR_WATCHED : 0; // as far as is known
    pairs->lost = 0.0f;
    for (uint32_t item = list->first_item[b]; item < end; item++) {
        while (pairs->count < found->count && found->items[pairs->count].place == item) {
            uint32_t i = pairs->count++;
            PercalePairPage *page = page_of_pair(pairs, i);
            float distance = found->items[i].distance;
            page->primitives[i % PAGE_PAIRS] = found->items[i].primitive | watched;
            page->distances[i % PAGE_PAIRS] = distance;
            page->bounds[i % PAGE_PAIRS] = fminf(distance, search->farthest) - ahead - since;
        }
        list->ends[item] = pairs->count;
    }
    return true;
}

enum { BLOCK_WORK = 64 }; // a block is as much to look for as so many items

/// The blocks whose first of BLOCK_WORK is in the range.
static void find_blocks(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Search *search = context;
    uint64_t block = (first + BLOCK_WORK - 1) / BLOCK_WORK;
    for (; collector->complete && block * BLOCK_WORK < end; block++) {
        collector->complete = find_block(search, collector, search->spent[block] - search->list->first_block);
    }
}

/// The spent blocks of a list.
static uint32_t spent_of(const PercaleCandidates *candidates, const PercaleCandidateList *list,
                         const uint32_t **spent)
{
    uint32_t first = 0;
    while (first < candidates->spent.count && candidates->spent.blocks[first] < list->first_block) {
        first++;
    }
    uint32_t end = first;
    while (end < candidates->spent.count &&
           candidates->spent.blocks[end] < list->first_block + list->block_count) {
        end++;
    }
    *spent = candidates->spent.blocks + first;
    return end - first;
}

bool percale_candidates_search(PercaleCandidates *candidates, const PercaleCandidateStage *stage,
                               uint64_t *tested)
{
    const PercaleModelSurface *cloth = &candidates->model->cloth;
    const uint32_t *primitives[2] = {cloth->triangles, cloth->edges.vertices[0]};
    PercaleTree *trees[2] = {&candidates->faces, &candidates->edges};
    const f32x4 *places[2] = {stage->from, stage->to};
    bool complete = true;
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        uint32_t kind = i % 2;
        PercaleCandidateList *list = &candidates->lists[i];
        if (trees[kind]->nodes == NULL) {
            continue;
        }
        if (i < 2) {
            percale_tree_refit_swept(trees[kind], primitives[kind], places, 2, stage->team);
        }
        Search search = {candidates,
                         list,
                         {primitives[kind], trees[kind]->arity, stage->from, stage->to, candidates->margin,
                          false, stage->all_near, true},
                         trees[kind],
                         &candidates->pool,
                         stage->memory,
                         NULL,
                         list->widest + candidates->margin};
        uint64_t count = spent_of(candidates, list, &search.spent);
        for (uint64_t b = 0; b < count; b++) { // before any takes some: so it doesn't matter who is first
            percale_pair_pages_give(&candidates->pool, &list->pairs[search.spent[b] - list->first_block]);
        }
        complete = percale_collect(stage->team, count * BLOCK_WORK, find_blocks, &search, stage->collectors,
                                   stage->memory, &(PercaleCollected){0});
        *tested += stage->collectors->candidates;
    }
    return complete;
}
