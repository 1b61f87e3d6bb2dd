#include "detect/candidates.h"

#include "model/order.h"

#include <string.h>

// Share of the mean edge by which candidates may be farther apart than in reach: more makes the lists longer,
// less makes them anew more often. (Twice as much for blocks whose pairs don't last saves half of the
// searches and costs as much in asking.)
static const float MARGIN = 0.2f;

enum {
    BLOCK_SLOTS = 32,              // at most: where it bends, a larger block deviates more from its centre
    BLOCK_EDGES = 3 * BLOCK_SLOTS, // of a mesh, which has so many
};

// Mean edges that a block is wide at most: a square of BLOCK_SLOTS has 6 on a side.
static const float BLOCK_EDGES_WIDE = 7.0f;

// Thicknesses by which the cloth's edges and faces may go deeper than its vertices where an obstacle is flat
// to them.
static const double FLAT = 0.15;

/// Farthest that surfaces of these thicknesses are in reach of each other, m.
static float widest_reach(float a, float b)
{
    return REACH_SLACK * 0.5f * CONTACT_REACH * (a + b);
}

static float mean_edge(const PercaleModel *model)
{
    double sum = 0.0;
    for (uint32_t e = 0; e < model->edge_count; e++) {
        sum += (double)model->edge_lengths[e];
    }
    return model->edge_count > 0 ? (float)(sum / (double)model->edge_count) : 0.0f;
}

static double longest_edge(const PercaleModel *model)
{
    float longest = 0.0f;
    for (uint32_t e = 0; e < model->edge_count; e++) {
        longest = fmaxf(longest, model->edge_lengths[e]);
    }
    return (double)longest;
}

/// The least gap that any vertex of the cloth keeps from an obstacle, m.
static double least_gap(const PercaleModel *model, const PercaleModelSurface *obstacle)
{
    float thinnest = INFINITY;
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        thinnest = fminf(thinnest, model->cloths[c].thickness);
    }
    return 0.5 * ((double)thinnest + (double)obstacle->thickness);
}

/// An obstacle's vertices or edges along a curve, nobody else has ordered them, but for those that are flat.
static bool order_items(PercaleCandidateList *list, bool of_edges, const uint8_t *flat, const f32x4 *x,
                        PercaleMemory *memory)
{
    const PercaleModelSurface *mesh = list->mesh;
    uint32_t all = of_edges ? mesh->edges.edge_count : mesh->vertex_count;
    float *centroids = percale_memory_new(memory, 3 * (size_t)all, sizeof(float));
    uint32_t *items = percale_memory_new(memory, all, sizeof(uint32_t));
    list->order = percale_memory_new(memory, all, sizeof(uint32_t));
    bool complete = centroids != NULL && items != NULL && list->order != NULL;
    uint32_t count = 0;
    for (uint32_t i = 0; complete && i < all; i++) {
        const uint32_t *ends = of_edges ? mesh->edges.vertices[i] : NULL;
        f32x4 sum = x[mesh->first_point + (of_edges ? ends[0] : i)];
        sum += of_edges ? x[mesh->first_point + ends[1]] : sum;
        memcpy(centroids + 3 * (size_t)count, &sum, 3 * sizeof(float));
        items[count] = i;
        count += flat == NULL || flat[i] == 0;
    }
    complete = complete && percale_order_along_curve(centroids, count, memory, list->order);
    for (uint32_t place = 0; complete && place < count; place++) {
        list->order[place] = items[list->order[place]];
    }
    list->item_count = count;
    percale_memory_free(memory, centroids);
    percale_memory_free(memory, items);
    return complete;
}

/// What of an obstacle may come near anything of the cloth but its vertices.
static bool order_obstacle(PercaleCandidates *candidates, uint32_t o, bool edges, PercaleMemory *memory)
{
    const PercaleModel *model = candidates->model;
    const PercaleModelSurface *mesh = &model->obstacles[o];
    PercaleCandidateList *lists = &candidates->lists[2 + 2 * (size_t)o];
    PercaleFlat *flat = &candidates->flats[o];
    return (!mesh->rigid || percale_flat_find(mesh, model->position, longest_edge(model),
                                              FLAT * least_gap(model, mesh), flat, memory)) &&
           order_items(&lists[0], false, flat->vertices, model->position, memory) &&
           (!edges || order_items(&lists[1], true, flat->edges, model->position, memory));
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
                   list->item_count,
                   edges ? BLOCK_EDGES : BLOCK_SLOTS,
                   edges,
                   BLOCK_EDGES_WIDE * sum / fmaxf((float)mesh->edges.edge_count, 1.0f)};
}

static void points_of_item(const Items *items, uint32_t place, uint32_t points[2])
{
    const PercaleCandidateList *list = items->list;
    uint32_t item = list->order != NULL ? list->order[place] : place; // the queries come last
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
    list->ends = percale_memory_new(memory, list->item_count, sizeof(uint32_t));
    list->pairs = percale_memory_new(memory, list->block_count, sizeof(list->pairs[0]));
    list->first_pair = percale_memory_new(memory, (size_t)list->block_count + 1, sizeof(size_t));
    return list->first_item != NULL && list->ends != NULL && list->pairs != NULL && list->first_pair != NULL;
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

/// The thickness of an item of a list.
static float thickness_of(const PercaleCandidates *candidates, const Items *items, uint32_t place)
{
    const PercaleModel *model = candidates->model;
    uint32_t points[2];
    points_of_item(items, place, points);
    return items->list->mesh == &model->cloth ? model->cloths[model->cloth_of[points[0]]].thickness
                                              : items->list->mesh->thickness;
}

/// What the items of a list are asked as. False without memory.
static bool list_queries(const PercaleCandidates *candidates, const Items *items, PercaleMemory *memory)
{
    PercaleCandidateList *list = items->list;
    float thinnest = INFINITY;
    float thickest = 0.0f;
    for (uint32_t place = 0; place < items->count; place++) {
        float thickness = thickness_of(candidates, items, place);
        thinnest = fminf(thinnest, thickness);
        thickest = fmaxf(thickest, thickness);
    }
    if (thinnest < thickest) {
        list->reaches = percale_memory_new(memory, items->count, sizeof(float));
        for (uint32_t place = 0; list->reaches != NULL && place < items->count; place++) {
            list->reaches[place] = widest_reach(thickness_of(candidates, items, place), candidates->thickest);
        }
    }
    list->widest = items->count > 0 ? widest_reach(thickest, candidates->thickest) : 0.0f;
    list->smooth = items->edges ? list->mesh->smooth_edges : NULL;
    list->waiting = list->smooth != NULL ? EDGES_WAIT / CONTACT_REACH * list->widest : list->widest;
    list->queries = (PercaleQueries){
        .edges = items->edges ? (const uint32_t(*)[2])list->mesh->edges.vertices : NULL,
        .order = list->order,
        .first_point = list->mesh->first_point,
        .reaches = list->reaches,
        .reach = list->widest,
    };
    return list->reaches != NULL || !(thinnest < thickest);
}

static bool create_blocks(PercaleCandidates *candidates, bool edges, PercaleBlockLister *lister,
                          PercaleMemory *memory)
{
    const PercaleModel *model = candidates->model;
    PercaleCandidateList *lists = candidates->lists;
    lists[0].item_count = model->cloth.vertex_count;
    lists[1].item_count = model->cloth.edges.edge_count;
    Items slots = items_of(candidates, &lists[0], false);
    Items cloth_edges = items_of(candidates, &lists[1], true);
    bool complete = cut_list(&slots, 0, memory) && cut_cloth_edges(&lists[1], &lists[0], memory) &&
                    list_points(&slots, lister, memory) && list_queries(candidates, &slots, memory) &&
                    list_queries(candidates, &cloth_edges, memory);
    for (uint32_t i = 2; complete && candidates->obstacles && i < candidates->list_count; i++) {
        bool of_edges = i % 2 == 1;
        complete = of_edges || order_obstacle(candidates, i / 2 - 1, edges, memory);
        if (complete && (edges || !of_edges)) {
            Items items = items_of(candidates, &lists[i], of_edges);
            complete = cut_list(&items, lister->count, memory) && list_points(&items, lister, memory) &&
                       list_queries(candidates, &items, memory);
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
    float thickest = candidates->thickest;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        thickest = fmaxf(thickest, model->obstacles[o].thickness);
    }
    candidates->reach.near = widest_reach(thickest, candidates->thickest);
    candidates->reach.far = candidates->reach.near + candidates->margin;
    candidates->list_count = 2 + 2 * model->obstacle_count;
    candidates->lists = percale_memory_new(memory, candidates->list_count, sizeof(candidates->lists[0]));
    candidates->flats = percale_memory_new(memory, model->obstacle_count, sizeof(candidates->flats[0]));
    for (uint32_t i = 0; candidates->lists != NULL && i < candidates->list_count; i++) {
        candidates->lists[i].mesh = i < 2 ? &model->cloth : &model->obstacles[i / 2 - 1];
    }
    PercaleBlockLister lister = {.last = percale_memory_new(memory, model->point_count, sizeof(uint32_t))};
    bool complete = candidates->lists != NULL && candidates->flats != NULL && lister.last != NULL &&
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
            percale_memory_free(memory, list->pairs[b].pages);
        }
        percale_memory_free(memory, list->pairs);
        percale_memory_free(memory, list->first_pair);
        percale_memory_free(memory, list->first_item);
        percale_memory_free(memory, list->ends);
        percale_memory_free(memory, list->order);
        percale_memory_free(memory, list->reaches);
    }
    for (uint32_t o = 0; candidates->flats != NULL && o < candidates->model->obstacle_count; o++) {
        percale_flat_free(&candidates->flats[o], memory);
    }
    percale_pair_pool_free(&candidates->pool, memory);
    percale_memory_free(memory, candidates->lists);
    percale_memory_free(memory, candidates->flats);
    percale_memory_free(memory, candidates->spent.blocks);
    percale_memory_free(memory, candidates->last_edges);
    percale_blocks_free(&candidates->blocks, memory);
    percale_tree_free(&candidates->faces, memory);
    percale_tree_free(&candidates->edges, memory);
    *candidates = (PercaleCandidates){0};
}
