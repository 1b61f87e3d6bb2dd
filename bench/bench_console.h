// bench_console.h: the report as a person reads it, in Google Benchmark's columns.

#ifndef PERCALE_BENCH_CONSOLE_H
#define PERCALE_BENCH_CONSOLE_H

#include "bench_entry.h"

#include <jansson.h>

typedef struct BenchConsole {
    FILE *stream;
    const BenchFlags *flags;
    bool aggregates_only, is_colored;
    int name_width;
    uint64_t heading; ///< hash of the counters that the last heading named; --benchmark_counters_tabular
} BenchConsole;

/// Prints machine and build.
BenchConsole bench_console_begin(FILE *stream, const BenchFlags *flags, const json_t *context,
                                 const BenchEntries *entries, bool aggregates_only);
/// Prints an entry whose repetitions are done. False without memory.
bool bench_console_entry(BenchConsole *console, const BenchEntry *entry);

#endif
