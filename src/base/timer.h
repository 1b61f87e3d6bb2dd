// timer.h: a monotonic clock in seconds.

#ifndef PERCALE_TIMER_H
#define PERCALE_TIMER_H

#include <time.h>

static inline double percale_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

#endif
