// bench_progress.h: one line on stderr that rewrites itself, only where stderr is a terminal.

#ifndef PERCALE_BENCH_PROGRESS_H
#define PERCALE_BENCH_PROGRESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct BenchProgress {
    bool visible;
    size_t run, run_count;
    const char *name; ///< of the entry under way
    double shown;     ///< s; when the line was last drawn
} BenchProgress;

BenchProgress bench_progress_start(size_t run_count);
/// The next repetition of some entry begins.
void bench_progress_run(BenchProgress *progress, const char *name);
void bench_progress_frame(BenchProgress *progress, uint32_t frame, uint32_t frame_count);
/// Clears the line, so that something else can be printed.
void bench_progress_clear(const BenchProgress *progress);

#endif
