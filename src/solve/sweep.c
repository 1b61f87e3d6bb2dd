#include "solve/sweep.h"

#include "base/barrier.h"
#include "base/parallel.h"

#include <omp.h>

enum { SMALL_COLOR = 256 }; // constraints; below it a barrier costs more than a second thread brings

/// The threads of one parallel region, as each of them sees it.
typedef struct Team {
    PercaleBarrier *barrier;
    int size, thread;
} Team;

/// The calling thread's share of [first, end).
static void run_share(const PercaleSolveArrays *arrays, Team team, uint32_t first, uint32_t end,
                      PercaleKernel *kernel)
{
    uint64_t count = end - first;
    uint64_t thread = (uint64_t)team.thread;
    uint64_t size = (uint64_t)team.size;
    kernel(arrays, first + (uint32_t)(count * thread / size),
           first + (uint32_t)(count * (thread + 1) / size));
}

/// All colours of one kind. Small ones and the remainder run on the first thread, one after the other without
/// a barrier between them. Every thread takes the same decisions, so the barriers match.
static void run_batches(const PercaleSolveArrays *arrays, Team team, const PercaleBatches *batches,
                        PercaleKernel *kernel)
{
    bool pending = false; // the first thread may still be busy with small colours
    for (uint32_t color = 0; color <= batches->color_count; color++) {
        uint32_t first = batches->first[color];
        bool is_remainder = color == batches->color_count;
        uint32_t end = is_remainder ? batches->count : batches->first[color + 1];
        if (is_remainder || end - first < SMALL_COLOR) {
            if (team.thread == 0) {
                kernel(arrays, first, end);
            }
            pending = pending || end > first;
            continue;
        }
        if (pending) {
            barrier_wait(team.barrier, team.size);
            pending = false;
        }
        run_share(arrays, team, first, end, kernel);
        barrier_wait(team.barrier, team.size);
    }
    if (pending) {
        barrier_wait(team.barrier, team.size);
    }
}

static void run_sweep(const PercaleSweepPlan *plan, Team team)
{
    const PercaleSolveArrays *arrays = &plan->arrays;
    run_batches(arrays, team, &plan->hinges, percale_solve_bend);
    for (int round = 0; round < STRETCH_ROUNDS; round++) {
        run_batches(arrays, team, &plan->edges, percale_solve_stretch);
    }
    if (arrays->model->open_seam_count > 0) { // few, and only until they have closed
        if (team.thread == 0) {
            percale_solve_seam(arrays, 0, arrays->model->open_seam_count);
        }
        barrier_wait(team.barrier, team.size);
    }
    run_batches(arrays, team, &plan->contacts, percale_solve_contact);
}

static size_t work_of(const PercaleSweepPlan *plan)
{
    return (size_t)plan->edges.count + plan->hinges.count + plan->contacts.count;
}

void percale_sweep_run(const PercaleSweepPlan *plan)
{
    PercaleBarrier barrier;
    barrier_init(&barrier);
#pragma omp parallel default(none) shared(plan, barrier) \
    num_threads(threads_for(work_of(plan), plan->thread_count))
    {
        uint32_t mode = float_mode_enter();
        Team team = {&barrier, omp_get_num_threads(), omp_get_thread_num()};
        for (uint32_t sweep = 0; sweep < plan->sweep_count; sweep++) {
            run_sweep(plan, team);
        }
        float_mode_leave(mode);
    }
}
