// bench_csv.h: the report as Google Benchmark's CSV: one line per row, one column per counter that any row
// has.

#ifndef PERCALE_BENCH_CSV_H
#define PERCALE_BENCH_CSV_H

#include "bench_entry.h"

/// False without memory.
bool bench_csv_write(FILE *stream, const BenchEntries *entries, const BenchFlags *flags,
                     bool aggregates_only);

#endif
