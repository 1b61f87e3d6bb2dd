#include "detect/tree.h"

#include "base/parallel.h"
#include "model/order.h"

#include <string.h>

/// Fills tree->order with the primitives along the curve of their centroids.
static bool order_primitives(PercaleTree *tree, const uint32_t *primitives, const f32x4 *points,
                             PercaleMemory *memory)
{
    float *centroids = percale_memory_new(memory, 3 * (size_t)tree->primitive_count, sizeof(float));
    if (centroids == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < tree->primitive_count; i++) {
        const uint32_t *corners = primitives + (size_t)tree->arity * i;
        f32x4 sum = points[corners[0]];
        for (uint32_t k = 1; k < tree->arity; k++) {
            sum += points[corners[k]];
        }
        memcpy(centroids + 3 * (size_t)i, &sum, 3 * sizeof(float));
    }
    bool complete = percale_order_along_curve(centroids, tree->primitive_count, memory, tree->order);
    percale_memory_free(memory, centroids);
    return complete;
}

bool percale_tree_build(PercaleTree *tree, const uint32_t *primitives, uint32_t arity,
                        uint32_t primitive_count, const f32x4 *points, PercaleMemory *memory)
{
    *tree = (PercaleTree){.arity = arity, .primitive_count = primitive_count};
    uint32_t total = 0;
    uint32_t count = primitive_count;
    do {
        count = (count + TREE_WIDTH - 1) / TREE_WIDTH;
        tree->level_first[tree->level_count] = total;
        tree->level_size[tree->level_count++] = count;
        total += count;
    } while (count > 1);
    tree->order = percale_memory_new(memory, primitive_count, sizeof(uint32_t));
    tree->nodes = percale_memory_new(memory, total, sizeof(tree->nodes[0]));
    if (tree->order == NULL || tree->nodes == NULL || !order_primitives(tree, primitives, points, memory)) {
        percale_tree_free(tree, memory);
        return false;
    }
    return true;
}

void percale_tree_free(PercaleTree *tree, PercaleMemory *memory)
{
    percale_memory_free(memory, tree->order);
    percale_memory_free(memory, tree->nodes);
    *tree = (PercaleTree){0};
}

static void set_child(PercaleTreeNode *node, uint32_t child, f32x4 low, f32x4 high)
{
    for (int axis = 0; axis < 3; axis++) {
        node->low[axis][child] = low[axis];
        node->high[axis][child] = high[axis];
    }
}

static const f32x4 ABSENT_LOW = {INFINITY, INFINITY, INFINITY, 0.0f};
static const f32x4 ABSENT_HIGH = {-INFINITY, -INFINITY, -INFINITY, 0.0f};

/// What the chunks of a refit share.
typedef struct Refit {
    PercaleTree *tree;
    const uint32_t *primitives;
    const f32x4 *const *places;
    int place_count;
    uint32_t level;
} Refit;

static void refit_lowest(const Refit *refit, uint32_t node)
{
    PercaleTree *tree = refit->tree;
    for (uint32_t child = 0; child < TREE_WIDTH; child++) {
        uint32_t place = TREE_WIDTH * node + child;
        f32x4 low = ABSENT_LOW;
        f32x4 high = ABSENT_HIGH;
        for (uint32_t k = 0; place < tree->primitive_count && k < tree->arity; k++) {
            uint32_t point = refit->primitives[(size_t)tree->arity * tree->order[place] + k];
            for (int i = 0; i < refit->place_count; i++) {
                low = min4(low, refit->places[i][point]);
                high = max4(high, refit->places[i][point]);
            }
        }
        set_child(&tree->nodes[node], child, low, high);
    }
}

static void refit_inner(PercaleTree *tree, uint32_t level, uint32_t node)
{
    const PercaleTreeNode *below = tree->nodes + tree->level_first[level - 1];
    for (uint32_t child = 0; child < TREE_WIDTH; child++) {
        uint32_t index = TREE_WIDTH * node + child;
        f32x4 low = ABSENT_LOW;
        f32x4 high = ABSENT_HIGH;
        for (int k = 0; index < tree->level_size[level - 1] && k < TREE_WIDTH; k++) {
            f32x4 child_low = {below[index].low[0][k], below[index].low[1][k], below[index].low[2][k], 0.0f};
            f32x4 child_high = {below[index].high[0][k], below[index].high[1][k], below[index].high[2][k],
                                0.0f};
            low = min4(low, child_low);
            high = max4(high, child_high);
        }
        set_child(&tree->nodes[tree->level_first[level] + node], child, low, high);
    }
}

static void refit_range(void *context, uint32_t first, uint32_t end)
{
    const Refit *refit = context;
    for (uint32_t node = first; node < end; node++) {
        if (refit->level == 0) {
            refit_lowest(refit, node);
        } else {
            refit_inner(refit->tree, refit->level, node);
        }
    }
}

void percale_tree_refit(PercaleTree *tree, const uint32_t *primitives, const f32x4 *points, PercaleTeam *team)
{
    percale_tree_refit_swept(tree, primitives, &points, 1, team);
}

void percale_tree_refit_swept(PercaleTree *tree, const uint32_t *primitives, const f32x4 *const *places,
                              int place_count, PercaleTeam *team)
{
    enum { GRAIN_NODES = GRAIN / (4 * TREE_WIDTH) };
    Refit levels[TREE_LEVELS_MAX];
    PercalePhase phases[TREE_LEVELS_MAX];
    for (uint32_t level = 0; level < tree->level_count; level++) {
        levels[level] = (Refit){tree, primitives, places, place_count, level};
        phases[level] = (PercalePhase){refit_range, &levels[level], 0, tree->level_size[level], GRAIN_NODES};
    }
    percale_team_run(team, phases, tree->level_count);
}

bool percale_tree_overlap(const PercaleTree *tree, f32x4 low, f32x4 high, PercaleMemory *memory,
                          PercaleNodeList *list)
{
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    stack[size++] = tree_root(tree);
    list->count = 0;
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        uint32_t bits = lane_bits(tree_box_overlaps(tree_node(tree, entry), low, high));
        if (entry.level == 0 && bits != 0) {
            if (!percale_memory_reserve(memory, &list->items, &list->capacity, list->count + 1,
                                        sizeof(uint32_t))) {
                return false;
            }
            list->items[list->count++] = entry.node;
            continue;
        }
        for (; bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + k};
        }
    }
    return true;
}
