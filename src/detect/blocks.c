#include "detect/blocks.h"

#include <string.h>

// Of a sum or a difference of vectors, what float32 rounds away.
static const float ROUNDED = 1e-6f;

enum { GRAIN_BLOCKS = 8 };

static float larger(float a, float b)
{
    return a > b ? a : b;
}

// ---- create ----

bool percale_blocks_open(PercaleBlockLister *lister, PercaleMemory *memory)
{
    if (!percale_memory_reserve(memory, &lister->first, &lister->first_capacity, (size_t)lister->count + 2,
                                sizeof(lister->first[0]))) {
        return false;
    }
    lister->first[lister->count++] = lister->point_count;
    lister->first[lister->count] = lister->point_count;
    return true;
}

bool percale_blocks_add(PercaleBlockLister *lister, uint32_t point, PercaleMemory *memory)
{
    if (lister->last[point] == lister->count) {
        return true;
    }
    if (!percale_memory_reserve(memory, &lister->points, &lister->point_capacity,
                                (size_t)lister->point_count + 1, sizeof(lister->points[0]))) {
        return false;
    }
    lister->last[point] = lister->count;
    lister->points[lister->point_count++] = point;
    lister->first[lister->count] = lister->point_count;
    return true;
}

bool percale_blocks_create(PercaleBlocks *blocks, PercaleBlockLister *lister, uint32_t cloth_count,
                           const f32x4 *x, PercaleMemory *memory)
{
    uint32_t count = lister->count;
    *blocks = (PercaleBlocks){
        .count = count, .cloth_count = cloth_count, .first = lister->first, .points = lister->points};
    lister->first = lister->points = NULL;
    blocks->items = percale_memory_new(memory, count, sizeof(blocks->items[0]));
    blocks->anchors = percale_memory_new(memory, lister->point_count, sizeof(f32x4));
    blocks->moments = percale_memory_new(memory, (size_t)BLOCK_MOMENTS * count, sizeof(f32x4));
    blocks->corners = percale_memory_new(memory, 2 * (size_t)cloth_count, sizeof(f32x4));
    blocks->corner_pairs = percale_memory_new(memory, 2 * (size_t)cloth_count, sizeof(uint32_t));
    if (blocks->items == NULL || blocks->anchors == NULL || blocks->moments == NULL ||
        blocks->corners == NULL || blocks->corner_pairs == NULL) {
        return false;
    }
    for (uint32_t b = 0; b < cloth_count; b++) {
        f32x4 low = x[blocks->points[blocks->first[b]]];
        f32x4 high = low;
        for (uint32_t i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
            low = min4(low, x[blocks->points[i]]);
            high = max4(high, x[blocks->points[i]]);
        }
        blocks->corners[2 * b] = low;
        blocks->corners[2 * b + 1] = high;
        blocks->corner_pairs[2 * b] = 2 * b;
        blocks->corner_pairs[2 * b + 1] = 2 * b + 1;
    }
    return percale_tree_build(&blocks->tree, blocks->corner_pairs, 2, cloth_count, blocks->corners, memory);
}

void percale_blocks_free(PercaleBlocks *blocks, PercaleMemory *memory)
{
    percale_memory_free(memory, blocks->items);
    percale_memory_free(memory, blocks->first);
    percale_memory_free(memory, blocks->points);
    percale_memory_free(memory, blocks->anchors);
    percale_memory_free(memory, blocks->moments);
    percale_memory_free(memory, blocks->corners);
    percale_memory_free(memory, blocks->corner_pairs);
    percale_tree_free(&blocks->tree, memory);
    *blocks = (PercaleBlocks){0};
}

// ---- measure ----

/// What the chunks share.
typedef struct Measuring {
    PercaleBlocks *blocks;
    const f32x4 *ways[2]; // where they start and end
    float most;           // m
    float reach;          // m
    const uint32_t *listed;
} Measuring;

/// Its points' mean at one end of their ways, and the box around them.
static void measure_place(const PercaleBlocks *blocks, uint32_t b, const f32x4 *x, int place)
{
    PercaleBlock *block = &blocks->items[b];
    f32x4 sum = {0};
    for (uint32_t i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
        f32x4 point = x[blocks->points[i]];
        sum += point;
        block->low = min4(block->low, point);
        block->high = max4(block->high, point);
    }
    block->centre[place] = sum / (float)(blocks->first[b + 1] - blocks->first[b]);
}

static void measure_deviation(const PercaleBlocks *blocks, uint32_t b, const f32x4 *x, int place)
{
    PercaleBlock *block = &blocks->items[b];
    f32x4 carried = block->centre[place] - block->anchor_centre;
    float most2 = 0.0f;
    for (uint32_t i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
        f32x4 deviation = x[blocks->points[i]] - blocks->anchors[i] - carried;
        most2 = larger(most2, dot3(deviation, deviation));
    }
    float most = sqrtf(most2);
    block->deviation[place] = most + 4.0f * ROUNDED * (most + length3(carried));
}

static void measure_range(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    const PercaleBlocks *blocks = measuring->blocks;
    for (uint32_t b = first; b < end; b++) {
        PercaleBlock *block = &blocks->items[b];
        block->low = block->high = measuring->ways[0][blocks->points[blocks->first[b]]];
        for (int place = 0; place < 2; place++) {
            measure_place(blocks, b, measuring->ways[place], place);
        }
        measure_deviation(blocks, b, measuring->ways[0], 0);
        measure_deviation(blocks, b, measuring->ways[1], 1);
        if (b < blocks->cloth_count) {
            blocks->corners[2 * b] = block->low;
            blocks->corners[2 * b + 1] = block->high;
        }
    }
}

void percale_blocks_measure(PercaleBlocks *blocks, const f32x4 *from, const f32x4 *to, PercaleTeam *team)
{
    Measuring measuring = {.blocks = blocks, .ways = {from, to}};
    percale_team_for(team, blocks->count, GRAIN_BLOCKS, measure_range, &measuring);
    percale_tree_refit(&blocks->tree, blocks->corner_pairs, blocks->corners, team);
}

// ---- compare ----

/// How far any point of one block has moved against any of another since the first one's moment, at both ends
/// of the ways, at most: between them it is no more.
static float moved_against(const PercaleBlocks *blocks, uint32_t a, uint32_t b)
{
    uint32_t moment = blocks->items[a].moment;
    f32x4 then_a = blocks->moments[(size_t)a * BLOCK_MOMENTS + moment];
    f32x4 then_b = blocks->moments[(size_t)b * BLOCK_MOMENTS + moment];
    float most = 0.0f;
    for (int place = 0; place < 2; place++) {
        f32x4 way_a = blocks->items[a].centre[place] - then_a;
        f32x4 way_b = blocks->items[b].centre[place] - then_b;
        float spread =
            then_a[3] + then_b[3] + blocks->items[a].deviation[place] + blocks->items[b].deviation[place];
        float rounded = ROUNDED * (length3(way_a) + length3(way_b) + spread);
        most = larger(most, length3(way_a - way_b) + spread + rounded);
    }
    return most;
}

/// How far a block has moved against the blocks of the cloth that are near it on its way.
static float find_moved(const PercaleBlocks *blocks, uint32_t a, float reach)
{
    const PercaleTree *tree = &blocks->tree;
    const f32x4 wider = {reach, reach, reach, 0.0f};
    f32x4 low = blocks->items[a].low - wider;
    f32x4 high = blocks->items[a].high + wider;
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    float most = 0.0f;
    stack[size++] = tree_root(tree);
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        uint32_t bits = lane_bits(tree_box_overlaps(tree_node(tree, entry), low, high));
        for (; bits != 0; bits &= bits - 1) {
            uint32_t child = TREE_WIDTH * entry.node + (uint32_t)__builtin_ctz(bits);
            if (entry.level > 0) {
                stack[size++] = (PercaleTreeEntry){entry.level - 1, child};
            } else {
                most = larger(most, moved_against(blocks, a, tree->order[child]));
            }
        }
    }
    return most;
}

static void compare_range(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    for (uint32_t a = first; a < end; a++) {
        measuring->blocks->items[a].moved = find_moved(measuring->blocks, a, measuring->reach);
    }
}

void percale_blocks_compare(PercaleBlocks *blocks, uint32_t first, uint32_t end, float reach,
                            PercaleTeam *team)
{
    Measuring measuring = {.blocks = blocks, .reach = reach};
    PercalePhase phase = {compare_range, &measuring, first, end, GRAIN_BLOCKS};
    percale_team_run(team, &phase, 1);
}

// ---- moments ----

/// The ends of the points' ways become the anchors; the spread since each moment keeps what they have
/// deviated until then.
static void set_anchors(const Measuring *measuring, uint32_t b)
{
    const PercaleBlocks *blocks = measuring->blocks;
    PercaleBlock *block = &blocks->items[b];
    for (uint32_t m = 0; m < BLOCK_MOMENTS; m++) {
        blocks->moments[(size_t)b * BLOCK_MOMENTS + m][3] += block->deviation[1];
    }
    for (uint32_t i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
        blocks->anchors[i] = measuring->ways[1][blocks->points[i]];
    }
    block->anchor_centre = block->centre[1];
    block->deviation[1] = 0.0f;
    measure_deviation(blocks, b, measuring->ways[0], 0);
}

static void begin_listed(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    const PercaleBlocks *blocks = measuring->blocks;
    for (uint32_t i = first; i < end; i++) {
        uint32_t b = measuring->listed[i];
        set_anchors(measuring, b);
        blocks->items[b].moment = blocks->newest;
    }
}

static void begin_all(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    const PercaleBlocks *blocks = measuring->blocks;
    for (uint32_t b = first; b < end; b++) {
        const PercaleBlock *block = &blocks->items[b];
        if (!(block->deviation[1] <= measuring->most)) {
            set_anchors(measuring, b);
        }
        f32x4 *moment = &blocks->moments[(size_t)b * BLOCK_MOMENTS + blocks->newest];
        *moment = with_w(block->centre[1], block->deviation[1]);
    }
}

static void compare_listed(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    for (uint32_t i = first; i < end; i++) {
        uint32_t a = measuring->listed[i];
        measuring->blocks->items[a].moved = find_moved(measuring->blocks, a, measuring->reach);
    }
}

void percale_blocks_begin(PercaleBlocks *blocks, const PercaleBlockList *listed, const f32x4 *from,
                          const f32x4 *to, float most, float reach, PercaleTeam *team)
{
    Measuring measuring = {
        .blocks = blocks, .ways = {from, to}, .most = most, .reach = reach, .listed = listed->blocks};
    blocks->newest = percale_blocks_oldest(blocks);
    PercalePhase phases[] = {{begin_listed, &measuring, 0, listed->count, GRAIN_BLOCKS},
                             {begin_all, &measuring, 0, blocks->count, GRAIN_BLOCKS},
                             {compare_listed, &measuring, 0, listed->count, GRAIN_BLOCKS}};
    percale_team_run(team, phases, sizeof(phases) / sizeof(phases[0]));
}
