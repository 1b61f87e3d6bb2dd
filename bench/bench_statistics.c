#include "bench_statistics.h"

#include <math.h>
#include <stdlib.h>

static int compare_numbers(const void *a, const void *b)
{
    const double *x = a;
    const double *y = b;
    return (*x > *y) - (*x < *y);
}

double bench_quantile(double *values, size_t count, double quantile)
{
    if (count == 0) {
        return 0.0;
    }
    qsort(values, count, sizeof *values, compare_numbers);
    if (quantile == 0.5) {
        return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
    }
    double rank = ceil(quantile * (double)count);
    return values[rank < 1.0 ? 0 : (size_t)rank - 1];
}

const char *bench_statistic_name(BenchStatistic statistic)
{
    static const char *const names[BENCH_STATISTIC_COUNT] = {"mean", "median", "stddev", "cv", "min"};
    return names[statistic];
}

static double mean_of(const double *values, size_t count)
{
    double sum = 0.0;
    for (size_t index = 0; index < count; ++index) {
        sum += values[index];
    }
    return count == 0 ? 0.0 : sum / (double)count;
}

static double deviation_of(const double *values, size_t count)
{
    double mean = mean_of(values, count);
    double sum = 0.0;
    for (size_t index = 0; index < count; ++index) {
        sum += (values[index] - mean) * (values[index] - mean);
    }
    return count < 2 ? 0.0 : sqrt(sum / (double)(count - 1));
}

double bench_statistic(BenchStatistic statistic, double *values, size_t count)
{
    switch (statistic) {
    case BENCH_MEAN:
        return mean_of(values, count);
    case BENCH_MEDIAN:
        return bench_quantile(values, count, 0.5);
    case BENCH_STDDEV:
        return deviation_of(values, count);
    case BENCH_CV: {
        double mean = mean_of(values, count);
        return mean == 0.0 ? 0.0 : deviation_of(values, count) / mean;
    }
    case BENCH_MIN:
        return bench_quantile(values, count, 0.0);
    case BENCH_STATISTIC_COUNT:
        break;
    }
    return 0.0;
}
