// bench_result.h: what one repetition of an entry measured.

#ifndef PERCALE_BENCH_RESULT_H
#define PERCALE_BENCH_RESULT_H

#include "percale/scene.h"

enum {
    BENCH_COUNTER_NAME = 40, ///< bytes
    BENCH_LABEL = 24         ///< bytes; a state hash takes 17
};

/// Room for the longest list there is: a scene's own figures, one time per stage, all work, all quality.
enum {
    BENCH_COUNTERS_MAX = 16 + PERCALE_STAGE_COUNT + (int)(sizeof(PercaleCounters) / sizeof(uint64_t)) +
                         (int)(sizeof(PercaleQuality) / sizeof(double))
};

typedef struct BenchCounter {
    char name[BENCH_COUNTER_NAME];
    double value;
    bool is_rate;   ///< per second
    bool is_detail; ///< left out of the console's table
} BenchCounter;

typedef struct BenchResult {
    bool failed;
    PercaleSceneError error; ///< why
    uint64_t iterations;
    double real_seconds; ///< per iteration, of a monotonic clock
    double cpu_seconds;  ///< per iteration, of all threads of the process
    char label[BENCH_LABEL];
    BenchCounter counters[BENCH_COUNTERS_MAX];
    size_t counter_count;
} BenchResult;

void bench_result_add(BenchResult *result, const char *name, double value);
/// A counter per second: `per_iteration` over the time that an iteration took.
void bench_result_add_rate(BenchResult *result, const char *name, double per_iteration);
/// Keeps the counters from `first` on out of the console's table, but for those in `shown`, which NULL ends.
void bench_result_hide(BenchResult *result, size_t first, const char *const *shown);
/// The label is a hash: 16 hex digits. Equal work has to give an equal one.
void bench_result_label(BenchResult *result, uint64_t hash);

#endif
