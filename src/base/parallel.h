// parallel.h: how many threads a loop gets, and the floating-point mode of a worker.

#ifndef PERCALE_PARALLEL_H
#define PERCALE_PARALLEL_H

#include <stddef.h>
#include <stdint.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

enum { GRAIN = 2048 }; // items below which a second thread costs more than it brings (a region is about 1 us)

/// Threads for `count` small items: 1 below GRAIN, never more than `most`.
static inline int threads_for(size_t count, int most)
{
    size_t wanted = count / GRAIN + 1;
    int granted = wanted < (size_t)most ? (int)wanted : most;
    return granted > 1 ? granted : 1;
}

/// Flushes denormals to zero in this thread (they cost up to 2x) and returns the mode to restore. Every
/// parallel region does it in each of its threads, so that results don't depend on which thread ran what.
static inline uint32_t float_mode_enter(void)
{
#if defined(__SSE__)
    uint32_t mode = _mm_getcsr();
    _mm_setcsr((mode & ~0x6000u) | 0x9fc0u); // FTZ, DAZ, round to nearest, no traps
    return mode;
#else
    return 0;
#endif
}

static inline void float_mode_leave(uint32_t mode)
{
#if defined(__SSE__)
    _mm_setcsr(mode);
#else
    (void)mode;
#endif
}

#endif
