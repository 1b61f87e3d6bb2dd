#include "bench_entry.h"

#include "scene/scene_error.h"

#include <inttypes.h>
#include <regex.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/// Where the list of entries has got to.
typedef struct Maker {
    BenchEntries *entries;
    BenchNumbers threads;
    uint32_t family_index, work_index;
    PercaleSceneError *error;
} Maker;

static BenchNumbers default_threads(void)
{
    BenchNumbers threads = {{1, 2}, 2};
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    if (cores > 2) {
        threads.items[threads.count++] = cores < PERCALE_MAX_THREADS ? (uint64_t)cores : PERCALE_MAX_THREADS;
    }
    return threads;
}

static BenchEntry *append(BenchEntries *entries, PercaleSceneError *error)
{
    if (entries->count == entries->capacity) {
        size_t capacity = entries->capacity == 0 ? 64 : 2 * entries->capacity;
        BenchEntry *items = realloc(entries->items, capacity * sizeof *items);
        if (items == NULL) {
            percale_scene_out_of_memory(error);
            return NULL;
        }
        entries->items = items;
        entries->capacity = capacity;
    }
    BenchEntry *entry = &entries->items[entries->count++];
    *entry = (BenchEntry){0};
    return entry;
}

/// One entry per number of threads. `prefix`: the name up to "/threads:".
static bool add_work(Maker *maker, const char *prefix, const BenchEntry *what)
{
    bool one_thread = what->kernel != NULL && what->kernel->one_thread;
    size_t count = one_thread ? 1 : maker->threads.count;
    for (size_t index = 0; index < count; ++index) {
        BenchEntry *entry = append(maker->entries, maker->error);
        if (entry == NULL) {
            return false;
        }
        *entry = *what;
        entry->thread_count = one_thread ? 1 : (int)maker->threads.items[index];
        entry->family_index = maker->family_index;
        entry->work_index = maker->work_index;
        (void)snprintf(entry->name, sizeof entry->name, "%s/threads:%d", prefix, entry->thread_count);
    }
    ++maker->work_index;
    return true;
}

static bool add_kernel(Maker *maker, const BenchKernel *kernel)
{
    char prefix[BENCH_ENTRY_NAME / 2];
    uint64_t sizes[BENCH_SIZES_MAX];
    size_t count = kernel->sizes == NULL ? 0 : kernel->sizes(sizes);
    (void)snprintf(prefix, sizeof prefix, "kernel/%s", kernel->name);
    bool done = count > 0 || add_work(maker, prefix, &(BenchEntry){.kernel = kernel});
    for (size_t index = 0; done && index < count; ++index) {
        (void)snprintf(prefix, sizeof prefix, "kernel/%s/%" PRIu64, kernel->name, sizes[index]);
        done = add_work(maker, prefix, &(BenchEntry){.kernel = kernel, .size = sizes[index]});
    }
    ++maker->family_index;
    return done;
}

static bool add_scene(Maker *maker, const BenchScene *scene, const BenchNumbers *sizes)
{
    char prefix[BENCH_ENTRY_NAME / 2];
    bool replaced = sizes->count > 0;
    bool done = true;
    for (size_t index = 0; done && (replaced ? index < sizes->count : scene->sizes[index] != 0); ++index) {
        uint64_t size = replaced ? sizes->items[index] : scene->sizes[index];
        (void)snprintf(prefix, sizeof prefix, "scene/%s/%" PRIu64, scene->name, size);
        done = add_work(maker, prefix, &(BenchEntry){.scene = scene, .size = size});
    }
    ++maker->family_index;
    return done;
}

static void number_instances(BenchEntries *entries)
{
    for (size_t index = 1; index < entries->count; ++index) {
        const BenchEntry *before = &entries->items[index - 1];
        BenchEntry *entry = &entries->items[index];
        bool same = entry->family_index == before->family_index;
        entry->instance_index = same ? before->instance_index + 1 : 0;
    }
}

bool bench_entries_make(const BenchFlags *flags, BenchEntries *entries, PercaleSceneError *error)
{
    *entries = (BenchEntries){0};
    Maker maker = {.entries = entries, .threads = flags->threads, .error = error};
    if (maker.threads.count == 0) {
        maker.threads = default_threads();
    }
    bool done = true;
    for (uint32_t index = 0; done && bench_kernel(index) != NULL; ++index) {
        done = add_kernel(&maker, bench_kernel(index));
    }
    for (uint32_t index = 0; done && bench_scene(index) != NULL; ++index) {
        done = add_scene(&maker, bench_scene(index), &flags->sizes);
    }
    if (!done) {
        bench_entries_free(entries);
        return false;
    }
    number_instances(entries);
    return true;
}

bool bench_entries_filter(BenchEntries *entries, const char *filter, PercaleSceneError *error)
{
    if (filter == NULL || strcmp(filter, "all") == 0) {
        return true;
    }
    bool negative = filter[0] == '-';
    regex_t expression;
    int code = regcomp(&expression, filter + negative, REG_EXTENDED | REG_NOSUB);
    if (code != 0) {
        char reason[128];
        (void)regerror(code, &expression, reason, sizeof reason);
        return percale_scene_fail(error, "--benchmark_filter: '%s': %s", filter, reason);
    }
    size_t kept = 0;
    for (size_t index = 0; index < entries->count; ++index) {
        bool matches = regexec(&expression, entries->items[index].name, 0, NULL, 0) == 0;
        if (matches != negative) {
            entries->items[kept++] = entries->items[index];
        }
    }
    regfree(&expression);
    entries->count = kept;
    return true;
}

void bench_entries_free(BenchEntries *entries)
{
    for (size_t index = 0; index < entries->count; ++index) {
        free(entries->items[index].results);
    }
    free(entries->items);
    *entries = (BenchEntries){0};
}
