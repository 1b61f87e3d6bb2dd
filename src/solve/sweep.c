#include "solve/sweep.h"

#include "base/parallel.h"

#include <omp.h>

enum { SMALL_COLOR = 256 }; // constraints; below it a barrier costs more than a second thread brings

/// The calling thread's share of [first, end).
static void run_share(const PercaleSolveArrays *arrays, uint32_t first, uint32_t end, PercaleKernel *kernel)
{
    uint64_t count = end - first;
    uint64_t thread = (uint64_t)omp_get_thread_num();
    uint64_t threads = (uint64_t)omp_get_num_threads();
    kernel(arrays, first + (uint32_t)(count * thread / threads),
           first + (uint32_t)(count * (thread + 1) / threads));
}

/// All colours of one kind. Small ones and the remainder run on the first thread, one after the other without
/// a barrier between them. Every thread takes the same decisions, so the barriers match.
static void run_batches(const PercaleSolveArrays *arrays, const PercaleBatches *batches,
                        PercaleKernel *kernel)
{
    bool pending = false; // the first thread may still be busy with small colours
    for (uint32_t color = 0; color < batches->color_count; color++) {
        uint32_t first = batches->first[color];
        uint32_t end = batches->first[color + 1];
        if (end - first < SMALL_COLOR) {
            if (omp_get_thread_num() == 0) {
                kernel(arrays, first, end);
            }
            pending = true;
            continue;
        }
        if (pending) {
#pragma omp barrier
            pending = false;
        }
        run_share(arrays, first, end, kernel);
#pragma omp barrier
    }
    uint32_t remainder = batches->first[batches->color_count];
    if (remainder < batches->count) {
        if (omp_get_thread_num() == 0) {
            kernel(arrays, remainder, batches->count);
        }
        pending = true;
    }
    if (pending) {
#pragma omp barrier
    }
}

static void run_sweep(const PercaleSweepPlan *plan)
{
    run_batches(&plan->arrays, &plan->hinges, percale_solve_bend);
    run_batches(&plan->arrays, &plan->edges, percale_solve_stretch);
    if (plan->arrays.model->open_seam_count > 0) { // few, and only until they have closed
        if (omp_get_thread_num() == 0) {
            percale_solve_seam(&plan->arrays, 0, plan->arrays.model->open_seam_count);
        }
#pragma omp barrier
    }
    run_batches(&plan->arrays, &plan->contacts, percale_solve_contact);
}

void percale_sweep_run(const PercaleSweepPlan *plan)
{
    size_t work = plan->edges.count + plan->hinges.count + plan->contacts.count;
#pragma omp parallel default(none) shared(plan, work) num_threads(threads_for(work, plan->thread_count))
    {
        uint32_t mode = float_mode_enter();
        for (uint32_t sweep = 0; sweep < plan->sweep_count; sweep++) {
            run_sweep(plan);
        }
        float_mode_leave(mode);
    }
}
