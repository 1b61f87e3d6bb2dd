// barrier.h: a barrier between the threads of one parallel region that spins shortly and then yields.
//
// libgomp's own spins away whole scheduler slices when another process is busy on the machine: a colour that
// takes 5 us then waits 13-58 us.

#ifndef PERCALE_BARRIER_H
#define PERCALE_BARRIER_H

#include <sched.h>
#include <stdatomic.h>

typedef struct PercaleBarrier {
    _Alignas(64) atomic_int waiting;
    _Alignas(64) atomic_int round;
} PercaleBarrier;

static inline void barrier_init(PercaleBarrier *barrier)
{
    atomic_init(&barrier->waiting, 0);
    atomic_init(&barrier->round, 0);
}

/// Every one of team_size threads calls it; what they wrote before is visible to all after.
static inline void barrier_wait(PercaleBarrier *barrier, int team_size)
{
    enum { SPINS = 2000 }; // some microseconds: longer than a colour, shorter than a scheduler slice
    int round = atomic_load_explicit(&barrier->round, memory_order_relaxed);
    if (atomic_fetch_add_explicit(&barrier->waiting, 1, memory_order_acq_rel) == team_size - 1) {
        atomic_store_explicit(&barrier->waiting, 0, memory_order_relaxed);
        atomic_store_explicit(&barrier->round, round + 1, memory_order_release);
        return;
    }
    for (int spin = 0; atomic_load_explicit(&barrier->round, memory_order_acquire) == round; spin++) {
        if (spin >= SPINS) {
            sched_yield();
        } else {
#if defined(__SSE2__)
            __builtin_ia32_pause();
#endif
        }
    }
}

#endif
