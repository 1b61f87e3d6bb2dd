#include "bench_rows.h"

#include <stdlib.h>
#include <string.h>

/// The good repetitions of an entry.
typedef struct Sample {
    const BenchEntry *entry;
    const BenchResult *first; // NULL: there is none
    size_t count;
    double *values; // [count] scratch
} Sample;

static void add_repetitions(const BenchEntry *entry, BenchRows *rows)
{
    for (uint32_t index = 0; index < entry->result_count; ++index) {
        BenchRow *row = &rows->items[rows->count++];
        *row = (BenchRow){.entry = entry, .repetition = index, .result = entry->results[index]};
        (void)snprintf(row->name, sizeof row->name, "%s", entry->name);
    }
}

static double statistic_of_field(BenchStatistic statistic, const Sample *sample, size_t offset)
{
    size_t count = 0;
    for (uint32_t index = 0; index < sample->entry->result_count; ++index) {
        const BenchResult *result = &sample->entry->results[index];
        if (!result->failed) {
            memcpy(&sample->values[count++], (const char *)result + offset, sizeof(double));
        }
    }
    return bench_statistic(statistic, sample->values, count);
}

static bool have_one_label(const Sample *sample)
{
    for (uint32_t index = 0; index < sample->entry->result_count; ++index) {
        const BenchResult *result = &sample->entry->results[index];
        if (!result->failed && strcmp(result->label, sample->first->label) != 0) {
            return false;
        }
    }
    return true;
}

static void add_aggregate(BenchStatistic statistic, const Sample *sample, BenchRows *rows)
{
    const BenchEntry *entry = sample->entry;
    BenchRow *row = &rows->items[rows->count++];
    *row = (BenchRow){
        .entry = entry, .aggregate = bench_statistic_name(statistic), .is_fraction = statistic == BENCH_CV};
    (void)snprintf(row->name, sizeof row->name, "%s_%s", entry->name, row->aggregate);
    BenchResult *result = &row->result;
    *result = *sample->first; // names and kinds of the counters
    result->iterations = sample->count;
    if (!have_one_label(sample)) {
        result->label[0] = '\0';
    }
    result->real_seconds = statistic_of_field(statistic, sample, offsetof(BenchResult, real_seconds));
    result->cpu_seconds = statistic_of_field(statistic, sample, offsetof(BenchResult, cpu_seconds));
    for (size_t index = 0; index < result->counter_count; ++index) {
        size_t offset =
            offsetof(BenchResult, counters) + index * sizeof(BenchCounter) + offsetof(BenchCounter, value);
        result->counters[index].value = statistic_of_field(statistic, sample, offset);
        result->counters[index].is_rate = result->counters[index].is_rate && !row->is_fraction;
    }
}

static Sample take_sample(const BenchEntry *entry, double *values)
{
    Sample sample = {.entry = entry, .values = values};
    for (uint32_t index = 0; index < entry->result_count; ++index) {
        const BenchResult *result = &entry->results[index];
        if (!result->failed) {
            sample.first = sample.first == NULL ? result : sample.first;
            ++sample.count;
        }
    }
    return sample;
}

bool bench_rows_make(const BenchEntry *entry, bool aggregates_only, BenchRows *rows)
{
    size_t room = (size_t)entry->result_count + BENCH_STATISTIC_COUNT;
    double *values = calloc(room, sizeof *values);
    *rows = (BenchRows){.items = calloc(room, sizeof *rows->items)};
    bool done = values != NULL && rows->items != NULL;
    if (done) {
        Sample sample = take_sample(entry, values);
        if (!aggregates_only || sample.count < 2) {
            add_repetitions(entry, rows);
        }
        for (int statistic = 0; sample.count > 1 && statistic < BENCH_STATISTIC_COUNT; ++statistic) {
            add_aggregate((BenchStatistic)statistic, &sample, rows);
        }
    } else {
        bench_rows_free(rows);
    }
    free(values);
    return done;
}

void bench_rows_free(BenchRows *rows)
{
    free(rows->items);
    *rows = (BenchRows){0};
}

BenchUnitName bench_unit_of(const BenchEntry *entry, BenchUnit asked_for)
{
    static const BenchUnitName units[] = {[BENCH_UNIT_NS] = {"ns", 1e9},
                                          [BENCH_UNIT_US] = {"us", 1e6},
                                          [BENCH_UNIT_MS] = {"ms", 1e3},
                                          [BENCH_UNIT_S] = {"s", 1.0}};
    if (asked_for != BENCH_UNIT_OWN) {
        return units[asked_for];
    }
    return units[entry->kernel != NULL ? BENCH_UNIT_NS : BENCH_UNIT_MS];
}
