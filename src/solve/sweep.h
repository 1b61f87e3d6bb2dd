// sweep.h: runs the solver's sweeps over all constraints, colour after colour.
//
//   in   solve arrays, colour batches
//   out  predicted positions
//
// A sweep is bending once, stretch STRETCH_ROUNDS times, open seams, contacts. Stretch is a small part of a
// step's time where contact is looked for, and its error the largest: on `dress` (20,000 vertices, 20 x 1, 2
// threads, interleaved beside another process) 1, 3 and 4 rounds leave a 99th percentile of 27, 10.5 and 8.7
// % at frame 30, for 260, 305 and 336 ms a frame.
//
// One parallel region for all sweeps; within a colour each thread takes a contiguous share. Internal
// constraints come first and contacts last, so that they win.

#ifndef PERCALE_SWEEP_H
#define PERCALE_SWEEP_H

#include "solve/solve_arrays.h"

enum { STRETCH_ROUNDS = 3 };

typedef struct PercaleSweepPlan {
    PercaleSolveArrays arrays;
    PercaleBatches edges, hinges, contacts;
    uint32_t sweep_count;
    int thread_count;
} PercaleSweepPlan;

void percale_sweep_run(const PercaleSweepPlan *plan);

#endif
