// reduce.h: what the chunks of a phase find together, in any order: the least, the greatest, the sum.

#ifndef PERCALE_REDUCE_H
#define PERCALE_REDUCE_H

#include <stdatomic.h>
#include <stdint.h>
#include <string.h>

typedef atomic_uint_least32_t ReducedUint;

static inline void reduce_min(ReducedUint *least, uint32_t value)
{
    uint32_t old = atomic_load_explicit(least, memory_order_relaxed);
    while (value < old && !atomic_compare_exchange_weak_explicit(least, &old, value, memory_order_relaxed,
                                                                 memory_order_relaxed)) {
    }
}

/// The greatest of floats that are not negative: their bits are in the same order. Starts at 0.
static inline void reduce_max_float(ReducedUint *greatest, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    uint32_t old = atomic_load_explicit(greatest, memory_order_relaxed);
    while (bits > old && !atomic_compare_exchange_weak_explicit(greatest, &old, bits, memory_order_relaxed,
                                                                memory_order_relaxed)) {
    }
}

static inline float reduced_float(ReducedUint *greatest)
{
    uint32_t bits = atomic_load_explicit(greatest, memory_order_relaxed);
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

#endif
