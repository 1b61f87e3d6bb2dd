#include "bench_kernel.h"

#include "scene/shapes.h"

#include <math.h>

const BenchKernel *bench_kernel(uint32_t index)
{
    static const BenchKernel *const kernels[] = {&bench_kernel_triad,    &bench_kernel_stretch,
                                                 &bench_kernel_bend,     &bench_kernel_barrier,
                                                 &bench_kernel_coloring, &bench_kernel_rays};
    return index < sizeof kernels / sizeof kernels[0] ? kernels[index] : NULL;
}

void bench_kernel_run(const BenchKernel *kernel, uint64_t size, int thread_count, BenchBudget budget,
                      BenchResult *result)
{
    *result = (BenchResult){0};
    void *state = kernel->open(size, thread_count, budget, &result->error);
    result->failed = state == NULL;
    if (state == NULL) {
        return;
    }
    BenchTime time = bench_measure(kernel->body, state, budget, &result->iterations);
    result->real_seconds = time.real;
    result->cpu_seconds = time.cpu;
    kernel->report(state, result);
    kernel->close(state);
}

// ---- sheets ----

size_t bench_sheet_sizes(uint64_t sizes[BENCH_SIZES_MAX])
{
    static const uint64_t vertices[] = {40000, 160000, 640000};
    size_t count = sizeof vertices / sizeof vertices[0];
    for (size_t index = 0; index < count; ++index) {
        sizes[index] = vertices[index];
    }
    return count;
}

uint32_t bench_sheet_side(uint64_t vertices)
{
    return (uint32_t)lround(sqrt((double)vertices));
}

bool bench_sheet_make(uint64_t vertices, PercaleMesh *mesh, PercaleSceneError *error)
{
    const double corner[3] = {0.0, 0.0, 0.0};
    const double along[3] = {1.0, 0.0, 0.0};
    const double across[3] = {0.0, 0.0, -1.0};
    uint32_t side = bench_sheet_side(vertices);
    return percale_sheet_make("sheet", side, side, corner, along, across, mesh, error);
}
