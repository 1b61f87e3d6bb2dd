#include "detect/blocks.h"

#include "base/wide.h"

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

static uint32_t node_count(const PercaleTree *tree)
{
    return tree->level_first[tree->level_count - 1] + 1;
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
    blocks->lasts = percale_memory_new(memory, lister->point_count, sizeof(f32x4));
    blocks->moments = percale_memory_new(memory, (size_t)BLOCK_MOMENTS * count, sizeof(f32x4));
    blocks->corners = percale_memory_new(memory, 2 * (size_t)cloth_count, sizeof(f32x4));
    blocks->corner_pairs = percale_memory_new(memory, 2 * (size_t)cloth_count, sizeof(uint32_t));
    if (blocks->items == NULL || blocks->anchors == NULL || blocks->lasts == NULL ||
        blocks->moments == NULL || blocks->corners == NULL || blocks->corner_pairs == NULL) {
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
    if (!percale_tree_build(&blocks->tree, blocks->corner_pairs, 2, cloth_count, blocks->corners, memory)) {
        return false;
    }
    blocks->changed = percale_memory_new(memory, node_count(&blocks->tree), sizeof(blocks->changed[0]));
    return blocks->changed != NULL;
}

void percale_blocks_free(PercaleBlocks *blocks, PercaleMemory *memory)
{
    percale_memory_free(memory, blocks->items);
    percale_memory_free(memory, blocks->first);
    percale_memory_free(memory, blocks->points);
    percale_memory_free(memory, blocks->anchors);
    percale_memory_free(memory, blocks->lasts);
    percale_memory_free(memory, blocks->moments);
    percale_memory_free(memory, blocks->corners);
    percale_memory_free(memory, blocks->corner_pairs);
    percale_memory_free(memory, blocks->changed);
    percale_tree_free(&blocks->tree, memory);
    *blocks = (PercaleBlocks){0};
}

// ---- measure ----

/// What the chunks share.
typedef struct Measuring {
    PercaleBlocks *blocks;
    const f32x4 *ways[2]; // where they start and end
    bool remember;
    bool again;              // where a block's points were remembered, all of it is known
    float most;              // m
    PercaleBlockReach reach; // m
    const uint32_t *listed;
} Measuring;

/// Its points' mean at one end of their ways, and the box around them.
static void measure_place(const PercaleBlocks *blocks, uint32_t b, const f32x4 *x, int place)
{
    PercaleBlock *block = &blocks->items[b];
    f32x4 sum = {0};
    f32x4 low = block->low;
    f32x4 high = block->high;
    for (uint32_t i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
        f32x4 point = x[blocks->points[i]];
        sum += point;
        low = min4(low, point);
        high = max4(high, point);
    }
    block->low = low;
    block->high = high;
    block->centre[place] = sum / (float)(blocks->first[b + 1] - blocks->first[b]);
}

/// Squared, that far (x - before) deviates from what is carried.
static inline f32x8 deviation2(WidePoints x, WidePoints before, f32x4 carried)
{
    WidePoints d = {x.x - before.x - carried[0], x.y - before.y - carried[1], x.z - before.z - carried[2]};
    return (d.x * d.x + d.y * d.y) + d.z * d.z;
}

/// The farthest that any point deviates, and what float32 may have rounded away.
static float deviation_of(f32x8 most2, f32x4 carried)
{
    float farthest2 = 0.0f;
    for (uint32_t k = 0; k < WIDE; k++) {
        farthest2 = larger(farthest2, most2[k]);
    }
    float most = sqrtf(farthest2);
    return most + 4.0f * ROUNDED * (most + length3(carried));
}

/// Eight places from this one on in the lists of a block's points; beyond the block's end the last repeats.
static inline void name_places(uint32_t first, uint32_t end, uint32_t places[WIDE])
{
    for (uint32_t k = 0; k < WIDE; k++) {
        places[k] = first + k < end ? first + k : end - 1;
    }
}

static inline void name_points(const PercaleBlocks *blocks, const uint32_t places[WIDE],
                               uint32_t points[WIDE])
{
    for (uint32_t k = 0; k < WIDE; k++) {
        points[k] = blocks->points[places[k]];
    }
}

/// How far points deviate from their anchors at one end of their ways.
static void measure_deviation(const PercaleBlocks *blocks, uint32_t b, const f32x4 *x, int place)
{
    PercaleBlock *block = &blocks->items[b];
    f32x4 carried = block->centre[place] - block->anchor_centre;
    uint32_t end = blocks->first[b + 1];
    f32x8 most2 = all8(0.0f);
    for (uint32_t i = blocks->first[b]; i < end; i += WIDE) {
        uint32_t places[WIDE];
        uint32_t points[WIDE];
        name_places(i, end, places);
        name_points(blocks, places, points);
        most2 = max8(most2,
                     deviation2(gather_points(x, points), gather_points(blocks->anchors, places), carried));
    }
    block->deviation[place] = deviation_of(most2, carried);
}

/// How far a centre goes, with how far any point deviates from that; twice what a sum of these rounds away.
static f32x4 with_deviation(f32x4 carried, f32x8 most2)
{
    float deviation = deviation_of(most2, carried);
    return with_w(carried, deviation + 2.0f * ROUNDED * (length3(carried) + deviation));
}

/// All that points deviate on their ways, from their anchors and from where they were last.
static void measure_deviations(const Measuring *measuring, uint32_t b)
{
    const PercaleBlocks *blocks = measuring->blocks;
    PercaleBlock *block = &blocks->items[b];
    const f32x4 from_anchors[2] = {block->centre[0] - block->anchor_centre,
                                   block->centre[1] - block->anchor_centre};
    f32x4 way = block->centre[1] - block->centre[0];
    f32x4 drift = block->centre[1] - block->last_centre;
    uint32_t end = blocks->first[b + 1];
    f32x8 most2[4] = {all8(0.0f), all8(0.0f), all8(0.0f), all8(0.0f)};
    for (uint32_t i = blocks->first[b]; i < end; i += WIDE) {
        uint32_t places[WIDE];
        uint32_t points[WIDE];
        name_places(i, end, places);
        name_points(blocks, places, points);
        WidePoints start = gather_points(measuring->ways[0], points);
        WidePoints now = gather_points(measuring->ways[1], points);
        WidePoints anchor = gather_points(blocks->anchors, places);
        most2[0] = max8(most2[0], deviation2(start, anchor, from_anchors[0]));
        most2[1] = max8(most2[1], deviation2(now, anchor, from_anchors[1]));
        most2[2] = max8(most2[2], deviation2(now, start, way));
        most2[3] = max8(most2[3], deviation2(now, gather_points(blocks->lasts, places), drift));
    }
    block->deviation[0] = deviation_of(most2[0], from_anchors[0]);
    block->deviation[1] = deviation_of(most2[1], from_anchors[1]);
    block->way = with_deviation(way, most2[2]);
    block->drift = with_deviation(drift, most2[3]);
}

static void remember(const Measuring *measuring, uint32_t b)
{
    const PercaleBlocks *blocks = measuring->blocks;
    for (uint32_t i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
        blocks->lasts[i] = measuring->ways[1][blocks->points[i]];
    }
    blocks->items[b].last_centre = blocks->items[b].centre[1];
}

/// Whether all points are where they were remembered.
static bool stands(const Measuring *measuring, uint32_t b)
{
    const PercaleBlocks *blocks = measuring->blocks;
    bool same = true;
    for (uint32_t i = blocks->first[b]; same && i < blocks->first[b + 1]; i++) {
        f32x4 now = measuring->ways[1][blocks->points[i]];
        same =
            now[0] == blocks->lasts[i][0] && now[1] == blocks->lasts[i][1] && now[2] == blocks->lasts[i][2];
    }
    return same;
}

static void measure_range(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    const PercaleBlocks *blocks = measuring->blocks;
    for (uint32_t b = first; b < end; b++) {
        PercaleBlock *block = &blocks->items[b];
        block->fresh = block->fresh && measuring->again;
        block->changed = !measuring->again || !stands(measuring, b);
        if (!block->changed) {
            block->drift = (f32x4){0};
            continue;
        }
        block->low = block->high = measuring->ways[0][blocks->points[blocks->first[b]]];
        for (int place = 0; place < 2; place++) {
            measure_place(blocks, b, measuring->ways[place], place);
        }
        measure_deviations(measuring, b);
        if (measuring->remember) {
            remember(measuring, b);
        }
        if (b < blocks->cloth_count) {
            blocks->corners[2 * b] = block->low;
            blocks->corners[2 * b + 1] = block->high;
        }
    }
}

/// Marks which nodes of the tree have changed blocks below them. They are few: blocks, not points.
static void mark_changed(PercaleBlocks *blocks)
{
    const PercaleTree *tree = &blocks->tree;
    for (uint32_t level = 0; level < tree->level_count; level++) {
        uint32_t below = level == 0 ? tree->primitive_count : tree->level_size[level - 1];
        for (uint32_t node = 0; node < tree->level_size[level]; node++) {
            uint32_t bits = 0;
            for (uint32_t k = 0; k < TREE_WIDTH && TREE_WIDTH * node + k < below; k++) {
                uint32_t child = TREE_WIDTH * node + k;
                bool changed = level == 0 ? blocks->items[tree->order[child]].changed
                                          : blocks->changed[tree->level_first[level - 1] + child] != 0;
                bits |= (uint32_t)changed << k;
            }
            blocks->changed[tree->level_first[level] + node] = (uint8_t)bits;
        }
    }
}

void percale_blocks_measure(PercaleBlocks *blocks, const PercaleBlockWays *ways, bool remember,
                            PercaleTeam *team)
{
    Measuring measuring = {.blocks = blocks,
                           .ways = {ways->from, ways->to},
                           .remember = remember,
                           .again = ways->again && blocks->remembered};
    percale_team_for(team, blocks->count, GRAIN_BLOCKS, measure_range, &measuring);
    percale_tree_refit(&blocks->tree, blocks->corner_pairs, blocks->corners, team);
    if (measuring.again) { // else all have changed
        mark_changed(blocks);
    }
    blocks->remembered = remember;
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
    for (int place = blocks->remembered && blocks->items[a].fresh ? 1 : 0; place < 2; place++) {
        f32x4 way_a = blocks->items[a].centre[place] - then_a;
        f32x4 way_b = blocks->items[b].centre[place] - then_b;
        float spread =
            then_a[3] + then_b[3] + blocks->items[a].deviation[place] + blocks->items[b].deviation[place];
        float rounded = ROUNDED * (length3(way_a) + length3(way_b) + spread);
        most = larger(most, length3(way_a - way_b) + spread + rounded);
    }
    return most;
}

/// Of two vectors with a deviation each: how far apart their ends may be.
static inline float between_ways(f32x4 a, f32x4 b)
{
    return length3(a - b) + a[3] + b[3];
}

/// Compares a block with some that are not far from it, and with those of them that are near.
static void compare_with(PercaleBlocks *blocks, uint32_t a, const uint32_t *others, uint32_t far,
                         uint32_t near)
{
    PercaleBlock *block = &blocks->items[a];
    for (; far != 0; far &= far - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(far);
        const PercaleBlock *other = &blocks->items[others[k]];
        block->turned = larger(block->turned, between_ways(block->way, other->way));
        block->drifted = larger(block->drifted, between_ways(block->drift, other->drift));
        if ((near >> k & 1) != 0) {
            block->moved = larger(block->moved, moved_against(blocks, a, others[k]));
        }
    }
}

static f32x4 reaching(float reach)
{
    return (f32x4){reach, reach, reach, 0.0f};
}

/// Whether a block has changed, or one of the cloth that is not far from it.
static bool has_changed(const PercaleBlocks *blocks, uint32_t a, PercaleBlockReach reach)
{
    const PercaleTree *tree = &blocks->tree;
    const PercaleBlock *block = &blocks->items[a];
    f32x4 low = block->low - reaching(reach.far);
    f32x4 high = block->high + reaching(reach.far);
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    bool changed = block->changed;
    stack[size++] = tree_root(tree);
    while (!changed && size > 0) {
        PercaleTreeEntry entry = stack[--size];
        uint32_t bits = blocks->changed[tree->level_first[entry.level] + entry.node];
        bits = bits == 0 ? 0 : bits & lane_bits(tree_box_overlaps(tree_node(tree, entry), low, high));
        changed = entry.level == 0 && bits != 0;
        for (; !changed && bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + k};
        }
    }
    return changed;
}

/// How far a block has moved against the blocks of the cloth that are near it on its way, or not far.
static void find_moved(PercaleBlocks *blocks, uint32_t a, PercaleBlockReach reach)
{
    const PercaleTree *tree = &blocks->tree;
    PercaleBlock *block = &blocks->items[a];
    f32x4 low = block->low - reaching(reach.far);
    f32x4 high = block->high + reaching(reach.far);
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    block->moved = block->turned = block->drifted = 0.0f;
    stack[size++] = tree_root(tree);
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        const PercaleTreeNode *node = tree_node(tree, entry);
        uint32_t bits = lane_bits(tree_box_overlaps(node, low, high));
        if (entry.level == 0) {
            i32x8 near = tree_box_overlaps(node, block->low - reaching(reach.near),
                                           block->high + reaching(reach.near));
            compare_with(blocks, a, tree->order + (size_t)TREE_WIDTH * entry.node, bits, lane_bits(near));
            continue;
        }
        for (; bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + k};
        }
    }
}

static void compare_range(void *context, uint32_t first, uint32_t end)
{
    const Measuring *measuring = context;
    for (uint32_t a = first; a < end; a++) {
        if (has_changed(measuring->blocks, a, measuring->reach)) {
            find_moved(measuring->blocks, a, measuring->reach);
        } else { // nor has anything there drifted
            measuring->blocks->items[a].drifted = 0.0f;
        }
    }
}

void percale_blocks_compare(PercaleBlocks *blocks, uint32_t first, uint32_t end, PercaleBlockReach reach,
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
        blocks->items[b].fresh = true;
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
        find_moved(measuring->blocks, measuring->listed[i], measuring->reach);
    }
}

void percale_blocks_begin(PercaleBlocks *blocks, const PercaleBlockList *listed, const f32x4 *from,
                          const f32x4 *to, float most, PercaleBlockReach reach, PercaleTeam *team)
{
    Measuring measuring = {
        .blocks = blocks, .ways = {from, to}, .most = most, .reach = reach, .listed = listed->blocks};
    blocks->newest = percale_blocks_oldest(blocks);
    PercalePhase phases[] = {{begin_listed, &measuring, 0, listed->count, GRAIN_BLOCKS},
                             {begin_all, &measuring, 0, blocks->count, GRAIN_BLOCKS},
                             {compare_listed, &measuring, 0, listed->count, GRAIN_BLOCKS}};
    percale_team_run(team, phases, sizeof(phases) / sizeof(phases[0]));
}
