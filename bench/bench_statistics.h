// bench_statistics.h: what is said about several measurements of the same thing.

#ifndef PERCALE_BENCH_STATISTICS_H
#define PERCALE_BENCH_STATISTICS_H

#include <stddef.h>

/// The smallest value that the share `quantile` (0..1) of the values doesn't exceed (nearest rank); 0.5 is
/// the median, between the two in the middle. Sorts the values; 0 for none.
double bench_quantile(double *values, size_t count, double quantile);

/// The aggregates that are reported, in order.
typedef enum BenchStatistic {
    BENCH_MEAN = 0,
    BENCH_MEDIAN,
    BENCH_STDDEV, ///< of the sample: over count - 1
    BENCH_CV,     ///< stddev / mean
    BENCH_MIN,
    BENCH_STATISTIC_COUNT
} BenchStatistic;

const char *bench_statistic_name(BenchStatistic statistic);
/// May sort the values. Finite for finite values: the cv of a mean of 0 is 0.
double bench_statistic(BenchStatistic statistic, double *values, size_t count);

#endif
