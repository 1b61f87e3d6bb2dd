#include "bench_run.h"

#include "bench_progress.h"
#include "bench_random.h"
#include "bench_scene_run.h"
#include "cli/complaint.h"

#include <stdlib.h>
#include <string.h>

// ---- the order ----

/// Index into the entries for every run.
static size_t *make_order(const BenchEntries *entries, const BenchFlags *flags)
{
    size_t count = entries->count * flags->repetitions;
    size_t *order = calloc(count, sizeof *order);
    for (size_t run = 0; order != NULL && run < count; ++run) {
        order[run] = run % entries->count;
    }
    return order;
}

static void shuffle(size_t *order, size_t count)
{
    uint64_t seed = (uint64_t)time(NULL);
    for (size_t place = count; place > 1; --place) {
        size_t other = (size_t)(bench_random(&seed) * (double)place);
        size_t kept = order[place - 1];
        order[place - 1] = order[other];
        order[other] = kept;
    }
}

// ---- the runs ----

static bool reserve_results(BenchEntries *entries, const BenchFlags *flags)
{
    for (size_t index = 0; index < entries->count; ++index) {
        BenchEntry *entry = &entries->items[index];
        entry->results = calloc(flags->repetitions, sizeof *entry->results);
        if (entry->results == NULL) {
            return false;
        }
    }
    return true;
}

/// As many iterations as the first repetition found, so that all do the same.
static void run_kernel(BenchEntry *entry, const BenchFlags *flags, BenchResult *result)
{
    BenchBudget budget = flags->budget;
    if (entry->iterations > 0) {
        budget.iterations = entry->iterations;
    }
    bench_kernel_run(entry->kernel, entry->size, entry->thread_count, budget, result);
    entry->iterations = result->iterations;
}

static void run_once(BenchEntry *entry, const BenchFlags *flags, BenchProgress *progress)
{
    BenchResult *result = &entry->results[entry->result_count++];
    bench_progress_run(progress, entry->name);
    if (entry->kernel != NULL) {
        run_kernel(entry, flags, result);
    } else {
        bench_scene_run(entry, flags, progress, result);
    }
}

bool bench_run(BenchEntries *entries, const BenchFlags *flags, BenchDone *done, void *user)
{
    size_t count = entries->count * flags->repetitions;
    size_t *order = make_order(entries, flags);
    if (order == NULL || !reserve_results(entries, flags)) {
        free(order);
        return false;
    }
    if (flags->random_interleaving) {
        shuffle(order, count);
    }
    BenchProgress progress = bench_progress_start(count);
    for (size_t run = 0; run < count; ++run) {
        BenchEntry *entry = &entries->items[order[run]];
        run_once(entry, flags, &progress);
        if (entry->result_count == flags->repetitions) {
            bench_progress_clear(&progress);
            done(user, entry);
        }
    }
    bench_progress_clear(&progress);
    free(order);
    return true;
}

// ---- what came out ----

bool bench_all_good(const BenchEntries *entries)
{
    bool good = true;
    for (size_t index = 0; index < entries->count; ++index) {
        const BenchEntry *entry = &entries->items[index];
        for (uint32_t repetition = 0; repetition < entry->result_count; ++repetition) {
            const BenchResult *result = &entry->results[repetition];
            if (result->failed) {
                (void)percale_complain(PERCALE_EXIT_FAILED, "bench: %s: %s", entry->name, result->error.text);
                good = false;
            }
        }
    }
    return good;
}

/// A good repetition, to hold others against.
typedef struct Witness {
    const BenchEntry *entry;
    uint32_t repetition;
} Witness;

static const char *label_of(Witness witness)
{
    return witness.entry->results[witness.repetition].label;
}

/// Compares an entry's repetitions with the first good one of the same work, which may be its own.
static bool agrees(const BenchEntry *entry, Witness *first)
{
    bool good = true;
    for (uint32_t repetition = 0; repetition < entry->result_count; ++repetition) {
        Witness witness = {entry, repetition};
        if (entry->results[repetition].failed) {
            continue;
        }
        if (first->entry == NULL || first->entry->work_index != entry->work_index) {
            *first = witness;
        }
        if (strcmp(label_of(*first), label_of(witness)) != 0) {
            (void)percale_complain(PERCALE_EXIT_FAILED,
                                   "bench: %s, repetition %u, has the hash %s, but %s, repetition %u, has %s",
                                   entry->name, (unsigned)repetition, label_of(witness), first->entry->name,
                                   (unsigned)first->repetition, label_of(*first));
            good = false;
        }
    }
    return good;
}

bool bench_labels_agree(const BenchEntries *entries)
{
    bool good = true;
    Witness first = {0};
    for (size_t index = 0; index < entries->count; ++index) {
        good = agrees(&entries->items[index], &first) && good;
    }
    return good;
}
