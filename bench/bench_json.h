// bench_json.h: the report as Google Benchmark's JSON, strictly valid: a number that is not finite is written
// as 0.

#ifndef PERCALE_BENCH_JSON_H
#define PERCALE_BENCH_JSON_H

#include "bench_entry.h"

#include <jansson.h>

json_t *bench_json_number(double value);
/// JSON is UTF-8; in any other text the bytes above ASCII become '?'.
json_t *bench_json_text(const char *text);

/// False without memory or when the stream fails.
bool bench_json_write(FILE *stream, json_t *context, const BenchEntries *entries, const BenchFlags *flags,
                      bool aggregates_only);

#endif
