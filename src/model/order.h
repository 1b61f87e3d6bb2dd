// order.h: space-filling order of points, so that neighbours in space are neighbours in memory.
//
//   in   positions
//   out  curve, a permutation of the points along a Morton curve over their bounds

#ifndef PERCALE_ORDER_H
#define PERCALE_ORDER_H

#include "base/memory.h"

/// positions: [3 * count] finite. False without memory.
bool percale_order_along_curve(const float *positions, uint32_t count, PercaleMemory *memory,
                               uint32_t *curve);

#endif
