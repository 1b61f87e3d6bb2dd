// kernel_barrier.c: what it costs a team to go from one phase to the next, when the phases are empty. The
// solver pays it once per colour.

#include "base/team.h"
#include "bench_kernel.h"
#include "scene/scene_error.h"

#include <stdlib.h>

enum { JOB_PHASES = 64 }; // posted at once, as the colours of a sweep are

typedef struct Barrier {
    int thread_count;
    uint64_t iterations; // phases to run
    BenchTime time;
} Barrier;

static void *open_barrier(uint64_t size, int thread_count, BenchBudget budget, PercaleSceneError *error)
{
    (void)size;
    (void)budget;
    Barrier *barrier = calloc(1, sizeof *barrier);
    if (barrier == NULL) {
        percale_scene_out_of_memory(error);
        return NULL;
    }
    barrier->thread_count = thread_count;
    return barrier;
}

static void nothing(void *context, uint32_t first, uint32_t end)
{
    (void)context;
    (void)first;
    (void)end;
}

static void lead(PercaleTeam *team, void *context)
{
    Barrier *barrier = context;
    PercalePhase phases[JOB_PHASES];
    for (int i = 0; i < JOB_PHASES; ++i) {
        phases[i] = (PercalePhase){nothing, NULL, 0, (uint32_t)percale_team_size(team), 1};
    }
    percale_team_run(team, phases, JOB_PHASES); // until everybody is there
    BenchTime start = bench_now();
    for (uint64_t left = barrier->iterations; left > 0;) {
        uint64_t count = left < JOB_PHASES ? left : JOB_PHASES;
        percale_team_run(team, phases, count);
        left -= count;
    }
    barrier->time = bench_since(start);
}

static BenchTime run(void *state, uint64_t iterations)
{
    Barrier *barrier = state;
    PercaleCrowding crowding = {0, 0};
    barrier->iterations = iterations;
    percale_team_open(barrier->thread_count, &crowding, lead, barrier);
    return barrier->time;
}

static void report(const void *state, BenchResult *result)
{
    (void)state;
    bench_result_add_rate(result, "items_per_second", 1.0);
}

const BenchKernel bench_kernel_barrier = {
    .name = "barrier", .open = open_barrier, .body = run, .report = report, .close = free};
