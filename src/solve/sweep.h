// sweep.h: runs the solver's sweeps over all constraints, colour after colour.
//
//   in   solve arrays, colour batches
//   out  predicted positions
//
// One parallel region for all sweeps; within a colour each thread takes a contiguous share. Internal
// constraints come first and contacts last, so that they win.

#ifndef PERCALE_SWEEP_H
#define PERCALE_SWEEP_H

#include "solve/solve_arrays.h"

typedef struct PercaleSweepPlan {
    PercaleSolveArrays arrays;
    PercaleBatches edges, hinges, contacts;
    uint32_t sweep_count;
    int thread_count;
} PercaleSweepPlan;

void percale_sweep_run(const PercaleSweepPlan *plan);

#endif
