// bench_entry.h: the list of what can be measured, and which of it was asked for.
//
//   in   the kernels, the named scenes, sizes and threads from the flags
//   out  entries `kernel/<name>/<size>/threads:<n>` and `scene/<name>/<size>/threads:<n>`, filtered

#ifndef PERCALE_BENCH_ENTRY_H
#define PERCALE_BENCH_ENTRY_H

#include "bench_flags.h"
#include "bench_scenes.h"

enum { BENCH_ENTRY_NAME = 96 }; ///< bytes

typedef struct BenchEntry {
    char name[BENCH_ENTRY_NAME];
    uint32_t family_index;     ///< of the kernel or scene
    uint32_t instance_index;   ///< within the family
    uint32_t work_index;       ///< entries with the same one differ in nothing but their threads
    const BenchKernel *kernel; ///< NULL: a scene
    const BenchScene *scene;   ///< NULL: a kernel
    uint64_t size;
    int thread_count;
    uint64_t iterations;  ///< of the first repetition; the others do as many
    BenchResult *results; ///< [result_count] repetitions so far
    uint32_t result_count;
} BenchEntry;

typedef struct BenchEntries {
    BenchEntry *items;
    size_t count, capacity;
} BenchEntries;

/// All entries that the flags' sizes and threads give. On failure there is nothing to free.
bool bench_entries_make(const BenchFlags *flags, BenchEntries *entries, PercaleSceneError *error);
/// Keeps those whose name matches a POSIX extended regular expression ("all": any; a leading '-': those that
/// don't match). Fails on an expression that can't be read. NULL keeps all.
bool bench_entries_filter(BenchEntries *entries, const char *filter, PercaleSceneError *error);
void bench_entries_free(BenchEntries *entries);

#endif
