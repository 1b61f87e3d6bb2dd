// bench_run.h: measures the entries, repetition by repetition.
//
//   in   entries, flags
//   out  each entry's results; whether equal work has given equal hashes
//
// Repetitions are interleaved: the first of all entries, then the second of all. A busy minute of the machine
// then touches every entry a little and none alone.

#ifndef PERCALE_BENCH_RUN_H
#define PERCALE_BENCH_RUN_H

#include "bench_entry.h"

/// Called when an entry's last repetition is done.
typedef void BenchDone(void *user, const BenchEntry *entry);

/// False without memory.
bool bench_run(BenchEntries *entries, const BenchFlags *flags, BenchDone *done, void *user);

/// Names on stderr the repetitions that have failed; true when there is none.
bool bench_all_good(const BenchEntries *entries);
/// Entries that differ only in their threads, and repetitions, must have the same label; says on stderr which
/// ones don't.
bool bench_labels_agree(const BenchEntries *entries);

#endif
