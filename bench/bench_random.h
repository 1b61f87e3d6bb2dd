// bench_random.h: numbers that look random and are the same in every run.

#ifndef PERCALE_BENCH_RANDOM_H
#define PERCALE_BENCH_RANDOM_H

#include "base/hash.h"

/// The next number, 0 <= r < 1; `seed` moves on.
static inline double bench_random(uint64_t *seed)
{
    *seed = hash_add(*seed, 1);
    return (double)(*seed >> 11) * 0x1p-53;
}

/// The next number within -1 .. 1.
static inline double bench_random_signed(uint64_t *seed)
{
    return 2.0 * bench_random(seed) - 1.0;
}

#endif
