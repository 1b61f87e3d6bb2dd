// bench_flags.h: the command line: Google Benchmark's flags and a few of our own.
//
//   in   argv after the program's name
//   out  BenchFlags; or one line that names the flag that is wrong

#ifndef PERCALE_BENCH_FLAGS_H
#define PERCALE_BENCH_FLAGS_H

#include "bench_kernel.h"

typedef enum BenchFormat { BENCH_CONSOLE = 0, BENCH_JSON, BENCH_CSV } BenchFormat;

typedef enum BenchColor { BENCH_COLOR_AUTO = 0, BENCH_COLOR_YES, BENCH_COLOR_NO } BenchColor;

typedef enum BenchUnit {
    BENCH_UNIT_OWN = 0, ///< ns for kernels, ms for scenes
    BENCH_UNIT_NS,
    BENCH_UNIT_US,
    BENCH_UNIT_MS,
    BENCH_UNIT_S
} BenchUnit;

/// Values of a flag that may be given more than once, in order.
typedef struct BenchTexts {
    const char **items;
    size_t count;
} BenchTexts;

typedef struct BenchNumbers {
    uint64_t items[BENCH_SIZES_MAX];
    size_t count; ///< 0: not given
} BenchNumbers;

typedef struct BenchFlags {
    bool help, version, list_tests;
    const char *filter;
    BenchBudget budget;
    uint64_t repetitions;
    bool random_interleaving, report_aggregates_only, display_aggregates_only, counters_tabular;
    int format, out_format; ///< BenchFormat
    int color;              ///< BenchColor
    int time_unit;          ///< BenchUnit
    const char *out;        ///< NULL: no file
    BenchTexts contexts;    ///< "key=value[,key=value]..."

    uint64_t frames; ///< 0: the table's
    BenchTexts settings;
    const char *preset; ///< NULL: none
    BenchNumbers sizes, threads;
} BenchFlags;

/// On failure there is nothing to free. Texts point into `arguments`.
bool bench_flags_parse(int argument_count, char **arguments, BenchFlags *flags, PercaleSceneError *error);
void bench_flags_free(BenchFlags *flags);

#endif
