// bench_kernel.h: the kernels that are measured on their own, and what the measurement asks of each.

#ifndef PERCALE_BENCH_KERNEL_H
#define PERCALE_BENCH_KERNEL_H

#include "bench_measure.h"
#include "bench_result.h"

enum { BENCH_SIZES_MAX = 32 }; ///< sizes, or thread counts, of an entry

typedef struct BenchKernel {
    const char *name;
    bool one_thread; ///< it has no parallel form
    /// Writes the sizes to measure, returns their number; NULL: it has none.
    size_t (*sizes)(uint64_t sizes[BENCH_SIZES_MAX]);
    /// Prepares the arrays; NULL with the error set.
    void *(*open)(uint64_t size, int thread_count, BenchBudget budget, PercaleSceneError *error);
    BenchBody *body;
    /// Adds counters and label; the times in `result` are there already.
    void (*report)(const void *state, BenchResult *result);
    void (*close)(void *state);
} BenchKernel;

/// NULL past the last.
const BenchKernel *bench_kernel(uint32_t index);

/// Measures one repetition; a failure is noted in the result.
void bench_kernel_run(const BenchKernel *kernel, uint64_t size, int thread_count, BenchBudget budget,
                      BenchResult *result);

extern const BenchKernel bench_kernel_triad;
extern const BenchKernel bench_kernel_stretch;
extern const BenchKernel bench_kernel_bend;
extern const BenchKernel bench_kernel_barrier;
extern const BenchKernel bench_kernel_coloring;
extern const BenchKernel bench_kernel_rays;

/// Vertices of the sheets that kernels work on: 200 x 200, 400 x 400, 800 x 800.
size_t bench_sheet_sizes(uint64_t sizes[BENCH_SIZES_MAX]);
/// Vertices on a side.
uint32_t bench_sheet_side(uint64_t vertices);
/// A square sheet with a side of 1 m.
bool bench_sheet_make(uint64_t vertices, PercaleMesh *mesh, PercaleSceneError *error);

/// What `kernel/stretch` touches in a sweep.
uint64_t bench_stretch_footprint(uint64_t vertices);
/// Bytes per second that the triad moves over a footprint; 0: no memory.
double bench_triad_rate(uint64_t bytes, int thread_count, BenchBudget budget);

#endif
