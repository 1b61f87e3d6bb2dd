#include "model/order.h"

#include "base/radix_sort.h"

#include <math.h>

static const double CELLS = 2097151.0; // 2^21 - 1 per axis: 63 bits of Morton code

/// Spreads the low 21 bits of x so that two zero bits follow each.
static uint64_t spread(uint64_t x)
{
    x = (x | x << 32) & 0x1f00000000ffffu;
    x = (x | x << 16) & 0x1f0000ff0000ffu;
    x = (x | x << 8) & 0x100f00f00f00f00fu;
    x = (x | x << 4) & 0x10c30c30c30c30c3u;
    return (x | x << 2) & 0x1249249249249249u;
}

bool percale_order_along_curve(const float *positions, uint32_t count, PercaleMemory *memory, uint32_t *curve)
{
    PercaleKeyed *items = percale_memory_new(memory, 2 * (size_t)count, sizeof(items[0]));
    if (items == NULL) {
        return false;
    }
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double extent = 0.0; // one cell size for all axes: a flat sheet stays a 2D curve
    for (int axis = 0; axis < 3; axis++) {
        double high = -HUGE_VAL;
        for (uint32_t i = 0; i < count; i++) {
            double p = (double)positions[3 * (size_t)i + (size_t)axis];
            low[axis] = p < low[axis] ? p : low[axis];
            high = p > high ? p : high;
        }
        extent = high - low[axis] > extent ? high - low[axis] : extent;
    }
    double scale = extent > 0.0 ? CELLS / extent : 0.0;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t key = 0;
        for (int axis = 0; axis < 3; axis++) {
            double cell = ((double)positions[3 * (size_t)i + (size_t)axis] - low[axis]) * scale;
            key |= spread((uint64_t)cell) << axis;
        }
        items[i] = (PercaleKeyed){key, i};
    }
    percale_radix_sort(items, items + count, count);
    for (uint32_t i = 0; i < count; i++) {
        curve[i] = items[i].value;
    }
    percale_memory_free(memory, items);
    return true;
}
