// kernel_triad.c: d = a + s b over three arrays, as in McCalpin's STREAM: how many bytes per second this
// machine moves at a footprint. The line that the solver's kernels are held against.
//
// The loop is repeated inside one parallel region. Each thread has a contiguous share that it was the first
// to touch, and doesn't wait for the others in between.

#include "bench_kernel.h"
#include "scene/scene_error.h"

#include <omp.h>
#include <stdlib.h>

enum {
    ARRAYS = 3,
    LINE_BYTES = 64,
    LINE = LINE_BYTES / sizeof(float) // elements: two threads share no cache line
};

static const uint64_t SMALLEST = UINT64_C(256) << 10; // bytes: inside one core's second-level cache
static const uint64_t LARGEST = UINT64_C(64) << 20;   // beyond the last one, mostly

typedef struct Triad {
    float *a, *b, *d; // [count]
    uint64_t count;
    int thread_count;
} Triad;

static size_t sizes_of(uint64_t sizes[BENCH_SIZES_MAX])
{
    size_t count = bench_sheet_sizes(sizes);
    for (size_t index = 0; index < count; ++index) {
        sizes[index] = bench_stretch_footprint(sizes[index]);
    }
    for (uint64_t bytes = SMALLEST; bytes <= LARGEST; bytes *= 4) {
        sizes[count++] = bytes;
    }
    return count;
}

static float *new_array(uint64_t count)
{
    uint64_t bytes = count * sizeof(float);
    return aligned_alloc(LINE_BYTES, (bytes + LINE_BYTES - 1) / LINE_BYTES * LINE_BYTES);
}

/// Where the share of `thread` begins, which is where that of the one before ends.
static uint64_t share(const Triad *triad, int thread, int team_size)
{
    if (thread == team_size) {
        return triad->count;
    }
    return triad->count * (uint64_t)thread / (uint64_t)team_size / LINE * LINE;
}

static void touch(Triad *triad)
{
#pragma omp parallel default(none) shared(triad) num_threads(triad->thread_count)
    {
        uint64_t end = share(triad, omp_get_thread_num() + 1, omp_get_num_threads());
        for (uint64_t i = share(triad, omp_get_thread_num(), omp_get_num_threads()); i < end; ++i) {
            triad->a[i] = 1.0f;
            triad->b[i] = 2.0f;
            triad->d[i] = 0.0f;
        }
    }
}

static void close_triad(void *state)
{
    Triad *triad = state;
    free(triad->a);
    free(triad->b);
    free(triad->d);
    free(triad);
}

static void *open_triad(uint64_t bytes, int thread_count, BenchBudget budget, PercaleSceneError *error)
{
    (void)budget;
    Triad *triad = calloc(1, sizeof *triad);
    if (triad == NULL) {
        percale_scene_out_of_memory(error);
        return NULL;
    }
    triad->count = bytes / (ARRAYS * sizeof(float));
    triad->thread_count = thread_count;
    triad->a = new_array(triad->count);
    triad->b = new_array(triad->count);
    triad->d = new_array(triad->count);
    if (triad->a == NULL || triad->b == NULL || triad->d == NULL) {
        close_triad(triad);
        percale_scene_out_of_memory(error);
        return NULL;
    }
    touch(triad);
    return triad;
}

static void add_scaled(float *restrict d, const float *restrict a, const float *restrict b, float scale,
                       uint64_t count)
{
    for (uint64_t i = 0; i < count; ++i) {
        d[i] = a[i] + scale * b[i];
    }
}

static void repeat(const Triad *triad, uint64_t first, uint64_t end, uint64_t iterations)
{
    for (uint64_t round = 0; round < iterations; ++round) {
        add_scaled(triad->d + first, triad->a + first, triad->b + first, 3.0f, end - first);
        __asm__ volatile("" ::: "memory"); // the next round has to read and write again
    }
}

static BenchTime run(void *state, uint64_t iterations)
{
    const Triad *triad = state;
    BenchTime time = {0.0, 0.0};
#pragma omp parallel default(none) shared(triad, iterations, time) num_threads(triad->thread_count)
    {
        int team_size = omp_get_num_threads();
        int thread = omp_get_thread_num();
        uint64_t first = share(triad, thread, team_size);
        uint64_t end = share(triad, thread + 1, team_size);
#pragma omp barrier
        BenchTime start = bench_now();
        repeat(triad, first, end, iterations);
#pragma omp barrier
        if (thread == 0) {
            time = bench_since(start);
        }
    }
    return time;
}

/// Two arrays read and one written. (The write's line is read as well, which STREAM does not count either.)
static double bytes_moved(const Triad *triad)
{
    return (double)triad->count * ARRAYS * sizeof(float);
}

static void report(const void *state, BenchResult *result)
{
    bench_result_add_rate(result, "bytes_per_second", bytes_moved(state));
}

double bench_triad_rate(uint64_t bytes, int thread_count, BenchBudget budget)
{
    PercaleSceneError error;
    Triad *triad = open_triad(bytes, thread_count, budget, &error);
    if (triad == NULL) {
        return 0.0;
    }
    uint64_t iterations;
    BenchTime time = bench_measure(run, triad, budget, &iterations);
    double rate = bytes_moved(triad) / time.real;
    close_triad(triad);
    return rate;
}

const BenchKernel bench_kernel_triad = {.name = "triad",
                                        .sizes = sizes_of,
                                        .open = open_triad,
                                        .body = run,
                                        .report = report,
                                        .close = close_triad};
