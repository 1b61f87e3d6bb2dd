#include "solve/solve_arrays.h"

#include <stdbool.h>
#include <string.h>

enum { ALL_SLOTS = (1 << WIDE) - 1 };

/// Eight slots from `slot` on, by component; of a short block the first is repeated. Lane order: 0 .. 7.
typedef struct Block {
    WidePoints x;
    f32x8 movable; // inverse masses
    uint32_t slot, count;
} Block;

static inline uint32_t slot_of(const Block *block, uint32_t i)
{
    return block->slot + (i < block->count ? i : 0);
}

static inline f32x8 load_limits(const Block *block, const float *lengths)
{
    if (block->count == WIDE) {
        return load8(lengths + block->slot);
    }
    f32x8 limits = all8(lengths[block->slot]);
    for (uint32_t i = 0; i < block->count; i++) {
        limits[i] = lengths[block->slot + i];
    }
    return limits;
}

static inline bool are_equal(const uint32_t values[WIDE])
{
    i32x8 eight;
    memcpy(&eight, values, sizeof(eight));
    return lane_bits(eight != eight[0]) == 0;
}

/// The anchors of the block's slots; mostly it is one for all.
static inline WidePoints load_anchors(const PercaleSolveArrays *arrays, const Block *block,
                                      const uint32_t *anchors)
{
    if (block->count == WIDE && are_equal(anchors + block->slot)) {
        f32x4 anchor = *point_at(arrays->x, anchors[block->slot]);
        return (WidePoints){all8(anchor[0]), all8(anchor[1]), all8(anchor[2])};
    }
    f32x8 pairs[4];
    for (uint32_t k = 0; k < 4; k++) {
        pairs[k] = pair_of_points(*point_at(arrays->x, anchors[slot_of(block, k)]),
                                  *point_at(arrays->x, anchors[slot_of(block, k + 4)]));
    }
    return transpose_pairs(pairs);
}

/// C = |x - anchor| - l <= 0; the anchor is a pin and doesn't move. One bit for each slot that has moved.
static inline uint32_t project(const PercaleSolveArrays *arrays, Block *block, const uint32_t *anchors,
                               const float *lengths)
{
    WidePoints *x = &block->x;
    WidePoints anchor = load_anchors(arrays, block, anchors);
    WidePoints d = {x->x - anchor.x, x->y - anchor.y, x->z - anchor.z};
    f32x8 length2 = (d.x * d.x + d.y * d.y) + d.z * d.z;
    f32x8 limit = load_limits(block, lengths);
    i32x8 taut = greater8(length2, limit * limit) & greater8(block->movable, all8(0.0f));
    uint32_t moved = lane_bits(taut);
    if (moved == 0) {
        return 0;
    }
    f32x8 share = all8(1.0f) - limit / sqrt8(length2);
    x->x = select8(taut, x->x - d.x * share, x->x);
    x->y = select8(taut, x->y - d.y * share, x->y);
    x->z = select8(taut, x->z - d.z * share, x->z);
    return moved;
}

/// Pins are not even written: other threads read them. All others are, moved or not: eight stores cost less
/// than a branch for each slot, which depends on the folds of the cloth.
static inline void store_movable(f32x4 *x, const Block *block)
{
    f32x8 pairs[4];
    transpose_points(&block->x, block->movable, pairs);
    uint32_t written = lane_bits(greater8(block->movable, all8(0.0f))) & ((1u << block->count) - 1);
    for (uint32_t k = 0; k < 4; k++) {
        if (written == ALL_SLOTS || (written >> k & 1) != 0) {
            x[k] = low_point(pairs[k]);
        }
        if (written == ALL_SLOTS || (written >> (k + 4) & 1) != 0) {
            x[k + 4] = high_point(pairs[k]);
        }
    }
}

__attribute__((always_inline)) static inline void project_layers(const PercaleSolveArrays *arrays,
                                                                 uint32_t slot, uint32_t count)
{
    const PercaleModel *model = arrays->model;
    Block block = {.slot = slot, .count = count};
    f32x8 pairs[4];
    for (uint32_t k = 0; k < 4; k++) {
        pairs[k] = pair_of_points(arrays->x[slot_of(&block, k)], arrays->x[slot_of(&block, k + 4)]);
    }
    block.x = transpose_pairs(pairs);
    block.movable = transpose_w(pairs);
    uint32_t moved = 0;
    for (uint32_t layer = 0; layer < model->tether_layers; layer++) {
        size_t first = (size_t)layer * model->slot_count;
        moved |= project(arrays, &block, model->tether_anchors + first, model->tether_lengths + first);
    }
    if (moved != 0) {
        store_movable(arrays->x + slot, &block);
    }
}

void percale_solve_tether(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    uint32_t slot = begin;
    for (; slot + WIDE <= end; slot += WIDE) {
        project_layers(arrays, slot, WIDE);
    }
    if (slot < end) {
        project_layers(arrays, slot, end - slot);
    }
}
