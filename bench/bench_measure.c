#include "bench_measure.h"

#include <math.h>

static const double ITERATIONS_MAX = 1e9;
static const double SIGNIFICANT = 0.1; // of the minimum time: from here on a time tells how many will fill it
static const double GROWTH_MAX = 10.0; // as long as it doesn't
static const double ROOM = 1.4; // aimed that much beyond the minimum, so that the next attempt is the last

static uint64_t more_iterations(uint64_t iterations, double seconds, double min_seconds)
{
    double growth = min_seconds * ROOM / fmax(seconds, 1e-9);
    if (seconds < SIGNIFICANT * min_seconds) {
        growth = GROWTH_MAX;
    }
    double wanted = fmax(growth * (double)iterations, (double)iterations + 1.0);
    return (uint64_t)fmin(wanted, ITERATIONS_MAX);
}

BenchTime bench_measure(BenchBody *body, void *state, BenchBudget budget, uint64_t *iterations)
{
    uint64_t count = budget.iterations > 0 ? budget.iterations : 1;
    BenchTime time = body(state, count);
    while (budget.iterations == 0 && time.real < budget.min_seconds && (double)count < ITERATIONS_MAX) {
        count = more_iterations(count, time.real, budget.min_seconds);
        time = body(state, count);
    }
    *iterations = count;
    return (BenchTime){time.real / (double)count, time.cpu / (double)count};
}
