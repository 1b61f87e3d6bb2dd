// bench_rows.h: an entry's lines in a report: its repetitions, and what they come to together.
//
//   in   an entry whose repetitions are done
//   out  one row per repetition, then one per statistic when there are several good ones

#ifndef PERCALE_BENCH_ROWS_H
#define PERCALE_BENCH_ROWS_H

#include "bench_entry.h"
#include "bench_statistics.h"

typedef struct BenchRow {
    const BenchEntry *entry;
    char name[BENCH_ENTRY_NAME + 8]; ///< an aggregate's ends with its name
    const char *aggregate;           ///< NULL: a repetition
    bool is_fraction;                ///< its times and counters are shares of 1, not times and counts
    uint32_t repetition;
    BenchResult result;
} BenchRow;

typedef struct BenchRows {
    BenchRow *items;
    size_t count;
} BenchRows;

/// `aggregates_only` leaves the repetitions out where there are aggregates. False without memory.
bool bench_rows_make(const BenchEntry *entry, bool aggregates_only, BenchRows *rows);
void bench_rows_free(BenchRows *rows);

typedef struct BenchUnitName {
    const char *name;
    double per_second;
} BenchUnitName;

/// The unit that an entry's times are told in.
BenchUnitName bench_unit_of(const BenchEntry *entry, BenchUnit asked_for);

#endif
