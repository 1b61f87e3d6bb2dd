#include "solve/solve_arrays.h"

/// Eight slots from `slot` on; pair k holds slots k and k + 4. Of a short block the first is repeated.
typedef struct Block {
    f32x8 x[4];
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

#define SHORTEN(k)                                                             \
    do {                                                                       \
        f32x8 share = SPREAD(shares, k);                                       \
        f32x8 held = block->x[k] - without_w(between[k]) * share;              \
        block->x[k] = select8(greater8(share, all8(0.0f)), held, block->x[k]); \
    } while (0)

/// C = |x - anchor| - l <= 0; the anchor is a pin and doesn't move. One bit for each slot that has moved.
static inline uint32_t project(const PercaleSolveArrays *arrays, Block *block, const uint32_t *anchors,
                               const float *lengths)
{
    f32x8 between[4];
    for (uint32_t k = 0; k < 4; k++) {
        f32x4 *low = point_at(arrays->x, anchors[slot_of(block, k)]);
        f32x4 *high = point_at(arrays->x, anchors[slot_of(block, k + 4)]);
        between[k] = block->x[k] - pair_of_points(*low, *high);
    }
    WidePoints d = transpose_pairs(between);
    f32x8 length2 = (d.x * d.x + d.y * d.y) + d.z * d.z;
    f32x8 limit = load_limits(block, lengths);
    i32x8 taut = greater8(length2, limit * limit);
    if (lane_bits(taut) == 0) {
        return 0;
    }
    taut &= greater8(transpose_w(block->x), all8(0.0f));
    f32x8 shares = where8(taut, all8(1.0f) - limit / sqrt8(length2));
    SHORTEN(0);
    SHORTEN(1);
    SHORTEN(2);
    SHORTEN(3);
    return lane_bits(taut);
}

static inline void project_layers(const PercaleSolveArrays *arrays, uint32_t slot, uint32_t count)
{
    const PercaleModel *model = arrays->model;
    Block block = {.slot = slot, .count = count};
    for (uint32_t k = 0; k < 4; k++) {
        block.x[k] = pair_of_points(arrays->x[slot_of(&block, k)], arrays->x[slot_of(&block, k + 4)]);
    }
    uint32_t moved = 0; // pins are not even written: other threads read them
    for (uint32_t layer = 0; layer < model->tether_layers; layer++) {
        size_t first = (size_t)layer * model->slot_count;
        moved |= project(arrays, &block, model->tether_anchors + first, model->tether_lengths + first);
    }
    moved &= (1u << count) - 1;
    for (; moved != 0; moved &= moved - 1) {
        uint32_t i = (uint32_t)__builtin_ctz(moved);
        arrays->x[slot + i] = i < 4 ? low_point(block.x[i]) : high_point(block.x[i - 4]);
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
