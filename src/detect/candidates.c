#include "detect/candidates.h"

#include "base/parallel.h"
#include "base/reduce.h"
#include "model/order.h"

#include <string.h>

// Share of the mean edge by which candidates may be farther apart than in reach: more makes the lists longer,
// less makes them anew more often.
static const float MARGIN = 0.25f;

// Of the sum of some coordinates, what a few operations of float32 round away.
static const float ROUNDED = 1e-6f;

enum {
    BLOCK_SLOTS = 64,  // at least: where it bends, a larger block deviates more from its mean
    BLOCKS_MOST = 512, // all are compared with each other
};

/// What a block has moved since the reference, at the start of a way and at its end.
struct PercaleBlock {
    f32x4 low, high;    // box of its ways, with all edges and triangles that have one of its points
    f32x4 mean[2];      // m
    float deviation[2]; // m, from the mean, at most
};

static float larger(float a, float b)
{
    return a > b ? a : b;
}

/// Farthest that a surface of this thickness is in reach of a cloth, m.
static float widest_reach(const PercaleCandidates *candidates, float thickness)
{
    return 1.001f * 0.5f * CONTACT_REACH * (thickness + candidates->thickest);
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

/// Slots of other blocks at the other ends of edges. Once to count, once to fill.
static uint32_t list_halo(PercaleCandidates *candidates, uint32_t *cursor, uint32_t *halo)
{
    const PercaleEdges *edges = &candidates->model->cloth.edges;
    uint32_t count = 0;
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        uint32_t blocks[2] = {edges->vertices[e][0] / candidates->block_size,
                              edges->vertices[e][1] / candidates->block_size};
        for (int end = 0; blocks[0] != blocks[1] && end < 2; end++) {
            uint32_t at = cursor[blocks[end]]++;
            if (halo != NULL) {
                halo[at] = edges->vertices[e][1 - end];
            }
            count++;
        }
    }
    return count;
}

static bool find_halo(PercaleCandidates *candidates, PercaleMemory *memory)
{
    candidates->halo_first =
        percale_memory_new(memory, (size_t)candidates->cloth_blocks + 2, sizeof(uint32_t));
    if (candidates->halo_first == NULL) {
        return false;
    }
    uint32_t *cursor = candidates->halo_first + 1;
    uint32_t count = list_halo(candidates, cursor, NULL);
    uint32_t before = 0;
    for (uint32_t b = 0; b <= candidates->cloth_blocks; b++) {
        uint32_t here = cursor[b];
        cursor[b] = before;
        before += here;
    }
    candidates->halo = percale_memory_new(memory, count, sizeof(uint32_t));
    if (candidates->halo == NULL) {
        return false;
    }
    (void)list_halo(candidates, cursor, candidates->halo);
    return true;
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

bool percale_candidates_create(PercaleCandidates *candidates, const PercaleModel *model, bool cloth,
                               bool edges, bool obstacles, PercaleMemory *memory)
{
    *candidates = (PercaleCandidates){.model = model, .cloth = cloth, .obstacles = obstacles};
    uint32_t mesh_count = 1 + model->obstacle_count;
    uint32_t size = (model->slot_count + BLOCKS_MOST - 1) / BLOCKS_MOST;
    candidates->margin = MARGIN * mean_edge(model);
    candidates->thickest = thickest_cloth(model);
    candidates->list_count = 2 * mesh_count;
    candidates->block_size = size > BLOCK_SLOTS ? size : BLOCK_SLOTS;
    candidates->cloth_blocks = (model->slot_count + candidates->block_size - 1) / candidates->block_size;
    uint32_t block_count = candidates->cloth_blocks + model->obstacle_count;
    candidates->lists = percale_memory_new(memory, candidates->list_count, sizeof(candidates->lists[0]));
    candidates->reference = percale_memory_new(memory, model->point_count, sizeof(f32x4));
    candidates->blocks = percale_memory_new(memory, block_count, sizeof(candidates->blocks[0]));
    candidates->moved =
        percale_memory_new(memory, (size_t)mesh_count * candidates->cloth_blocks, sizeof(float));
    bool complete = candidates->lists != NULL && candidates->reference != NULL &&
                    candidates->blocks != NULL && candidates->moved != NULL &&
                    find_halo(candidates, memory) &&
                    percale_tree_build(&candidates->faces, model->cloth.triangles, 3,
                                       model->cloth.triangle_count, model->position, memory) &&
                    (!edges || percale_tree_build(&candidates->edges, model->cloth.edges.vertices[0], 2,
                                                  model->cloth.edges.edge_count, model->position, memory));
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        PercaleCandidateList *list = &candidates->lists[i];
        list->mesh = i < 2 ? &model->cloth : &model->obstacles[i / 2 - 1];
        complete = i < 2 || !obstacles || (i % 2 == 1 && !edges) ||
                   order_items(list, i % 2 == 1, model->position, memory);
    }
    return complete;
}

void percale_candidates_free(PercaleCandidates *candidates, PercaleMemory *memory)
{
    for (uint32_t i = 0; candidates->lists != NULL && i < candidates->list_count; i++) {
        percale_memory_free(memory, candidates->lists[i].pairs.items);
        percale_memory_free(memory, candidates->lists[i].order);
    }
    percale_memory_free(memory, candidates->lists);
    percale_memory_free(memory, candidates->reference);
    percale_memory_free(memory, candidates->blocks);
    percale_memory_free(memory, candidates->moved);
    percale_memory_free(memory, candidates->halo_first);
    percale_memory_free(memory, candidates->halo);
    percale_tree_free(&candidates->faces, memory);
    percale_tree_free(&candidates->edges, memory);
    *candidates = (PercaleCandidates){0};
}

// ---- hold ----

/// What the chunks of a check share.
typedef struct Check {
    PercaleCandidates *candidates;
    const f32x4 *places[2]; // start and end of the ways
    float slack;
    ReducedUint spent; // the first block that has moved too far against another
} Check;

/// Points of a block: of the cloth, or all of an obstacle.
static void block_points(const PercaleCandidates *candidates, uint32_t block, uint32_t range[2])
{
    const PercaleModel *model = candidates->model;
    if (block >= candidates->cloth_blocks) {
        const PercaleModelSurface *obstacle = &model->obstacles[block - candidates->cloth_blocks];
        range[0] = obstacle->first_point;
        range[1] = obstacle->first_point + obstacle->vertex_count;
        return;
    }
    range[0] = block * candidates->block_size;
    range[1] = range[0] + candidates->block_size;
    range[1] = range[1] < model->slot_count ? range[1] : model->slot_count;
}

static void measure_motion(struct PercaleBlock *block, const f32x4 *x, const f32x4 *reference,
                           const uint32_t range[2], int place)
{
    f32x4 sum = {0};
    for (uint32_t i = range[0]; i < range[1]; i++) {
        sum += x[i] - reference[i];
        block->low = min4(block->low, x[i]);
        block->high = max4(block->high, x[i]);
    }
    block->mean[place] = sum / (float)(range[1] - range[0]);
    for (uint32_t i = range[0]; i < range[1]; i++) {
        block->deviation[place] =
            larger(block->deviation[place], length3(x[i] - reference[i] - block->mean[place]));
    }
}

static void measure_blocks(void *context, uint32_t first, uint32_t end)
{
    const Check *check = context;
    const PercaleCandidates *candidates = check->candidates;
    for (uint32_t b = first; b < end; b++) {
        uint32_t range[2];
        block_points(candidates, b, range);
        f32x4 at = check->places[0][range[0]];
        struct PercaleBlock block = {.low = at, .high = at};
        for (int i = 0; i < 2; i++) {
            const f32x4 *x = check->places[i];
            measure_motion(&block, x, candidates->reference, range, i);
            for (uint32_t h = b < candidates->cloth_blocks ? candidates->halo_first[b] : 0;
                 b < candidates->cloth_blocks && h < candidates->halo_first[b + 1]; h++) {
                block.low = min4(block.low, x[candidates->halo[h]]);
                block.high = max4(block.high, x[candidates->halo[h]]);
            }
        }
        candidates->blocks[b] = block;
    }
}

/// How far two points of the blocks have moved against each other, at most; 0 when they are far apart.
static float moved_against(const struct PercaleBlock *a, const struct PercaleBlock *b, float reach)
{
    f32x4 apart = max4(a->low - b->high, b->low - a->high);
    if (apart[0] > reach || apart[1] > reach || apart[2] > reach) {
        return 0.0f;
    }
    float moved[2];
    for (int i = 0; i < 2; i++) {
        moved[i] = length3(a->mean[i] - b->mean[i]) + a->deviation[i] + b->deviation[i];
    }
    float rounded = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        rounded += ROUNDED * (fabsf(a->low[axis]) + fabsf(a->high[axis]));
    }
    return larger(moved[0], moved[1]) + rounded;
}

static float widest_reach_of_all(const PercaleCandidates *candidates)
{
    const PercaleModel *model = candidates->model;
    float thickest = candidates->thickest;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        thickest = larger(thickest, model->obstacles[o].thickness);
    }
    return widest_reach(candidates, thickest);
}

static void compare_blocks(void *context, uint32_t first, uint32_t end)
{
    Check *check = context;
    PercaleCandidates *candidates = check->candidates;
    const struct PercaleBlock *blocks = candidates->blocks;
    uint32_t cloth_blocks = candidates->cloth_blocks;
    float reach = widest_reach_of_all(candidates);
    for (uint32_t a = first; a < end; a++) {
        float most = 0.0f;
        for (uint32_t b = 0; candidates->cloth && b < cloth_blocks; b++) {
            most = larger(most, moved_against(&blocks[a], &blocks[b], reach));
        }
        candidates->moved[a] = most;
        for (uint32_t o = 0; candidates->obstacles && o < candidates->model->obstacle_count; o++) {
            float moved = moved_against(&blocks[a], &blocks[cloth_blocks + o], reach);
            candidates->moved[(1 + o) * cloth_blocks + a] = moved;
            most = larger(most, moved);
        }
        if (!(most <= check->slack)) {
            reduce_min(&check->spent, a);
        }
    }
}

bool percale_candidates_hold(PercaleCandidates *candidates, const f32x4 *from, const f32x4 *to, float slack,
                             PercaleTeam *team)
{
    enum { GRAIN_BLOCKS = 16 };
    if (!candidates->known) {
        return false;
    }
    Check check = {candidates, {from, to}, slack, UINT32_MAX};
    uint32_t block_count = candidates->cloth_blocks + candidates->model->obstacle_count;
    PercalePhase phases[2] = {{measure_blocks, &check, 0, block_count, GRAIN_BLOCKS},
                              {compare_blocks, &check, 0, candidates->cloth_blocks, GRAIN_BLOCKS}};
    percale_team_run(team, phases, 2);
    return check.spent == UINT32_MAX;
}

/// How far what any of the cloth's points may touch has moved against them.
static float most_moved(const PercaleCandidates *candidates, uint32_t list, const uint32_t *points,
                        uint32_t count)
{
    const float *moved = candidates->moved + (size_t)(list / 2) * candidates->cloth_blocks;
    float most = 0.0f;
    for (uint32_t k = 0; k < count; k++) {
        most = larger(most, moved[points[k] / candidates->block_size]);
    }
    return most;
}

bool percale_candidates_select(const PercaleCandidates *candidates, uint32_t list, PercaleCandidateRun run,
                               float reach, PercaleCollector *collector)
{
    const PercaleModelSurface *cloth = &candidates->model->cloth;
    const PercaleItemPair *pairs = candidates->lists[list].pairs.items;
    PercaleItemPairList *touched = &collector->touched;
    bool of_edges = list % 2 == 1;
    bool of_cloth = list < 2;
    touched->count = 0;
    if (!percale_memory_reserve(&collector->memory, &touched->items, &touched->capacity, run.end - run.first,
                                sizeof(pairs[0]))) {
        return false;
    }
    float most = 0.0f;
    if (of_cloth) { // the item's own points say it for all
        const uint32_t *points = of_edges ? cloth->edges.vertices[run.item] : &run.item;
        most = most_moved(candidates, list, points, of_edges ? 2 : 1);
    }
    for (size_t i = run.first; i < run.end; i++) {
        if (!of_cloth) {
            uint32_t primitive = pairs[i].primitive;
            most = of_edges ? most_moved(candidates, list, cloth->edges.vertices[primitive], 2)
                            : most_moved(candidates, list, cloth->triangles + 3 * (size_t)primitive, 3);
        }
        if (pairs[i].distance <= reach + most) {
            touched->items[touched->count++] = pairs[i];
        }
    }
    return true;
}

// ---- find ----

/// The items of one list, to be asked for.
typedef struct Search {
    const PercaleCandidates *candidates;
    const PercaleCandidateList *list;
    PercaleNeighborhood hood;
    const PercaleTree *tree;
    const f32x4 *const *places;
    int place_count;
} Search;

/// Boxes of a few items' ways, wider by their reach, the margin, and what float32 may have rounded away.
typedef struct Group {
    uint32_t first, count; // places in the list's order
    PercaleQuery queries[TREE_WIDTH];
    f32x4 low[TREE_WIDTH], high[TREE_WIDTH];
    f32x4 least, most; // around all
} Group;

PercaleQuery percale_candidate_query(const PercaleCandidates *candidates, const PercaleModelSurface *mesh,
                                     bool edge, uint32_t item)
{
    const PercaleModel *model = candidates->model;
    uint32_t first = mesh->first_point;
    PercaleQuery query = {.points = {first + item, first + item}};
    if (edge) {
        query.points[0] = first + mesh->edges.vertices[item][0];
        query.points[1] = first + mesh->edges.vertices[item][1];
    }
    bool is_cloth = mesh == &model->cloth;
    float thickness = is_cloth ? model->cloths[model->cloth_of[query.points[0]]].thickness : mesh->thickness;
    query.reach = widest_reach(candidates, thickness);
    return query;
}

static void add_query(const Search *search, Group *group, uint32_t item)
{
    uint32_t k = group->count++;
    PercaleQuery *query = &group->queries[k];
    const PercaleCandidates *candidates = search->candidates;
    *query = percale_candidate_query(candidates, search->list->mesh, search->tree->arity == 2, item);
    query->reach += candidates->margin;
    f32x4 low = search->places[0][query->points[0]];
    f32x4 high = low;
    for (int i = 0; i < search->place_count; i++) {
        const f32x4 *x = search->places[i];
        low = min4(low, min4(x[query->points[0]], x[query->points[1]]));
        high = max4(high, max4(x[query->points[0]], x[query->points[1]]));
    }
    for (int axis = 0; axis < 3; axis++) {
        float slack = query->reach + 1e-6f * (fabsf(low[axis]) + fabsf(high[axis]));
        low[axis] -= slack;
        high[axis] += slack;
    }
    group->low[k] = low;
    group->high[k] = high;
    group->least = k == 0 ? low : min4(group->least, low);
    group->most = k == 0 ? high : max4(group->most, high);
}

/// Primitives whose boxes the query's touches; of the cloth's edges, those after it.
static bool list_touched(const Search *search, const Group *group, uint32_t k, PercaleCollector *collector)
{
    const PercaleTree *tree = search->tree;
    PercaleItemPairList *touched = &collector->touched;
    bool only_later = tree->arity == 2 && search->list->mesh == &search->candidates->model->cloth;
    uint32_t first = only_later ? group->first + k + 1 : 0; // the cloth's are in their own order
    touched->count = 0;
    for (size_t i = 0; i < collector->nodes.count; i++) {
        uint32_t node = collector->nodes.items[i];
        uint32_t bits = lane_bits(tree_box_overlaps(&tree->nodes[node], group->low[k], group->high[k]));
        if (bits == 0) {
            continue;
        }
        if (!percale_memory_reserve(&collector->memory, &touched->items, &touched->capacity,
                                    touched->count + TREE_WIDTH, sizeof(touched->items[0]))) {
            return false;
        }
        for (; bits != 0; bits &= bits - 1) {
            uint32_t primitive = tree->order[TREE_WIDTH * node + (uint32_t)__builtin_ctz(bits)];
            if (primitive >= first) {
                touched->items[touched->count++] = (PercaleItemPair){group->first + k, primitive, 0.0f};
            }
        }
    }
    return true;
}

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

static bool are_sewn(const Search *search, const PercaleQuery *query, uint32_t primitive)
{
    const PercaleModel *model = search->candidates->model;
    uint32_t arity = search->hood.arity;
    return search->list->mesh == &model->cloth &&
           percale_candidates_are_sewn(model, query->points,
                                       search->hood.primitives + (size_t)arity * primitive, arity);
}

/// Keeps the neighbours of an item, ascending.
static void keep_neighbors(const Search *search, const PercaleQuery *query, PercaleCollector *collector,
                           uint32_t place)
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
        if (!are_sewn(search, query, found->items[i].index)) {
            percale_collect_pair(collector,
                                 (PercaleItemPair){place, found->items[i].index, found->items[i].distance});
        }
    }
}

static void find_items(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Search *search = context;
    for (uint64_t i = first; collector->complete && i < end; i += TREE_WIDTH) {
        const uint32_t *order = search->list->order;
        Group group = {.first = (uint32_t)i};
        for (uint64_t k = i; k < end && k < i + TREE_WIDTH; k++) {
            add_query(search, &group, order != NULL ? order[k] : (uint32_t)k);
        }
        bool complete = percale_tree_overlap(search->tree, group.least, group.most, &collector->memory,
                                             &collector->nodes);
        for (uint32_t k = 0; complete && collector->nodes.count > 0 && k < group.count; k++) {
            collector->neighbors.count = 0;
            complete =
                list_touched(search, &group, k, collector) &&
                percale_neighbors_find(&search->hood, &group.queries[k], collector->touched.items,
                                       collector->touched.count, &collector->memory, &collector->neighbors);
            collector->candidates += collector->touched.count;
            if (complete) {
                keep_neighbors(search, &group.queries[k], collector, group.first + k);
            }
        }
        collector->complete = collector->complete && complete;
    }
}

bool percale_candidates_find(PercaleCandidates *candidates, const f32x4 *const *places, int place_count,
                             PercaleCollectors *collectors, PercaleMemory *memory, PercaleTeam *team,
                             uint64_t *tested)
{
    const PercaleModelSurface *cloth = &candidates->model->cloth;
    const uint32_t *primitives[2] = {cloth->triangles, cloth->edges.vertices[0]};
    const PercaleTree *trees[2] = {&candidates->faces, &candidates->edges};
    const f32x4 *reference = places[place_count - 1];
    candidates->known = false;
    percale_tree_refit_swept(&candidates->faces, primitives[0], places, place_count, team);
    if (candidates->edges.nodes != NULL) {
        percale_tree_refit_swept(&candidates->edges, primitives[1], places, place_count, team);
    }
    bool complete = true;
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        PercaleCandidateList *list = &candidates->lists[i];
        bool is_cloth = i < 2;
        bool of_edges = i % 2 == 1;
        list->pairs.count = 0;
        if ((of_edges && candidates->edges.nodes == NULL) ||
            !(is_cloth ? candidates->cloth : candidates->obstacles)) {
            continue;
        }
        Search search = {
            candidates,
            list,
            {primitives[of_edges], of_edges ? 2 : 3, places[0], reference, place_count > 2, true},
            trees[of_edges],
            places,
            place_count};
        uint32_t count = of_edges ? list->mesh->edges.edge_count : list->mesh->vertex_count;
        complete = percale_collect(team, count, find_items, &search, collectors, memory,
                                   &(PercaleCollected){.pairs = &list->pairs});
        *tested += collectors->candidates;
    }
    if (complete) {
        memcpy(candidates->reference, reference, candidates->model->point_count * sizeof(f32x4));
        candidates->known = true;
        (void)percale_candidates_hold(candidates, places[0], places[1], INFINITY, team);
    }
    return complete;
}

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

PercaleCandidateRun percale_candidates_run(const PercaleCandidateList *list, size_t first)
{
    const PercaleItemPair *pairs = list->pairs.items;
    while (first > 0 && first < list->pairs.count && pairs[first - 1].place == pairs[first].place) {
        first++;
    }
    PercaleCandidateRun run = {.first = first, .end = first};
    if (first < list->pairs.count) {
        run.place = pairs[first].place;
        run.item = list->order != NULL ? list->order[run.place] : run.place;
    }
    while (run.end < list->pairs.count && pairs[run.end].place == run.place) {
        run.end++;
    }
    return run;
}

PercaleCandidateRun percale_candidates_run_at(const PercaleCandidateList *list, uint32_t place)
{
    size_t low = 0;
    size_t high = list->pairs.count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (list->pairs.items[middle].place < place) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    PercaleCandidateRun run = percale_candidates_run(list, low);
    run.end = run.place == place ? run.end : run.first;
    return run;
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

void percale_candidates_ask(const PercaleCandidates *candidates, uint32_t list, PercaleCandidateRun run,
                            const PercaleNeighborhood *hood, const PercaleQuery *query,
                            PercaleCollector *collector)
{
    collector->neighbors.count = 0;
    bool complete = percale_candidates_select(candidates, list, run, query->reach, collector) &&
                    percale_neighbors_find(hood, query, collector->touched.items, collector->touched.count,
                                           &collector->memory, &collector->neighbors);
    collector->candidates += collector->touched.count;
    collector->complete = collector->complete && complete;
}
