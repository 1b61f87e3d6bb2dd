// bench_context.h: on what was measured: the machine, the build, and what the user wants noted.

#ifndef PERCALE_BENCH_CONTEXT_H
#define PERCALE_BENCH_CONTEXT_H

#include "bench_flags.h"

#include <jansson.h>

/// The "context" of a report; release with json_decref.
json_t *bench_context(const char *executable, const BenchFlags *flags);

#endif
