#include "solve/solve_arrays.h"

/// C = |x - anchor| - l <= 0, for `count` (1 or 2) slots from `slot` on; the anchor is a pin and doesn't
/// move.
static inline void project(const PercaleSolveArrays *arrays, const uint32_t *anchors, const float *lengths,
                           uint32_t slot, uint32_t count)
{
    uint32_t last = slot + count - 1;
    f32x8 x = load_two(arrays->x + slot, count);
    f32x8 anchor = pair_of_points(*point_at(arrays->x, anchors[slot]), *point_at(arrays->x, anchors[last]));
    f32x8 limit = spread_two(lengths[slot], lengths[last]);
    f32x8 between = without_w(x - anchor);
    f32x8 length2 = dot3_pairs(between, between);
    i32x8 taut = greater8(length2, limit * limit) & greater8(SPREAD(x, 3), all8(0.0f));
    if (lane_bits(taut) != 0) {
        f32x8 held = x - between * (all8(1.0f) - limit / sqrt8(length2));
        store_two(arrays->x + slot, select8(taut, held, x), count);
    }
}

void percale_solve_tether(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    const PercaleModel *model = arrays->model;
    for (uint32_t layer = 0; layer < model->tether_layers; layer++) {
        const uint32_t *anchors = model->tether_anchors + (size_t)layer * model->slot_count;
        const float *lengths = model->tether_lengths + (size_t)layer * model->slot_count;
        uint32_t slot = begin;
        for (; slot + 2 <= end; slot += 2) {
            project(arrays, anchors, lengths, slot, 2);
        }
        if (slot < end) {
            project(arrays, anchors, lengths, slot, 1);
        }
    }
}
