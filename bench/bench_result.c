#include "bench_result.h"

#include <assert.h>
#include <inttypes.h>
#include <string.h>

void bench_result_add(BenchResult *result, const char *name, double value)
{
    assert(result->counter_count < BENCH_COUNTERS_MAX);
    BenchCounter *counter = &result->counters[result->counter_count++];
    *counter = (BenchCounter){.value = value};
    (void)snprintf(counter->name, sizeof counter->name, "%s", name);
}

void bench_result_add_rate(BenchResult *result, const char *name, double per_iteration)
{
    bench_result_add(result, name, per_iteration / result->real_seconds);
    result->counters[result->counter_count - 1].is_rate = true;
}

static bool is_listed(const char *const *names, const char *name)
{
    while (*names != NULL && strcmp(*names, name) != 0) {
        ++names;
    }
    return *names != NULL;
}

void bench_result_hide(BenchResult *result, size_t first, const char *const *shown)
{
    for (size_t index = first; index < result->counter_count; ++index) {
        result->counters[index].is_detail = !is_listed(shown, result->counters[index].name);
    }
}

void bench_result_label(BenchResult *result, uint64_t hash)
{
    (void)snprintf(result->label, sizeof result->label, "%016" PRIx64, hash);
}
