// bench_measure.h: how long one iteration takes, by Google Benchmark's rule: the number of iterations grows
// until they fill the minimum time.
//
//   in   a function that does n iterations and says how long they took
//   out  seconds per iteration and their number

#ifndef PERCALE_BENCH_MEASURE_H
#define PERCALE_BENCH_MEASURE_H

#include "base/timer.h"

#include <stdint.h>

/// Seconds since some moment, or between two.
typedef struct BenchTime {
    double real; ///< CLOCK_MONOTONIC
    double cpu;  ///< of all threads of the process
} BenchTime;

static inline BenchTime bench_now(void)
{
    struct timespec cpu;
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &cpu);
    return (BenchTime){percale_seconds(), (double)cpu.tv_sec + 1e-9 * (double)cpu.tv_nsec};
}

static inline BenchTime bench_since(BenchTime start)
{
    BenchTime now = bench_now();
    return (BenchTime){now.real - start.real, now.cpu - start.cpu};
}

/// How long to measure.
typedef struct BenchBudget {
    double min_seconds;
    uint64_t iterations; ///< not 0: exactly so many, whatever they take
} BenchBudget;

/// Does `iterations` iterations and returns the time of all of them, thread start and preparation left out.
typedef BenchTime BenchBody(void *state, uint64_t iterations);

/// Time per iteration; *iterations: how many it was measured over.
BenchTime bench_measure(BenchBody *body, void *state, BenchBudget budget, uint64_t *iterations);

#endif
