#include "bench_scene_run.h"

#include "bench_statistics.h"
#include "scene/scene_error.h"

#include <stdlib.h>
#include <string.h>

enum { LAST_FRAMES = 60 }; // of ms_last60: one second, after things have come to rest
static const double P90 = 0.9;
static const double MILLISECONDS = 1e3; // in a second

// Counters that the console's table has room for.
static const char *const SHOWN[] = {"ms_p90", "ms_last60", "penetration_max_mm", "stretch_p99", NULL};

/// Times of the frames: one array per stage, and the step as a whole.
typedef struct FrameTimes {
    double *real, *cpu;                  // [frame_count] s
    double *stages[PERCALE_STAGE_COUNT]; // [frame_count] s
    double *scratch;                     // [frame_count]
    uint32_t frame_count;
} FrameTimes;

typedef struct SceneRun {
    PercaleScene *scene;
    PercaleSolver *solver;
    FrameTimes times;
    uint64_t peak_bytes;
} SceneRun;

// ---- settings ----

static bool apply_setting(PercaleScene *scene, const char *text, PercaleSceneError *error)
{
    const char *equals = strchr(text, '=');
    char *key = strndup(text, (size_t)(equals - text));
    bool done =
        key == NULL ? percale_scene_out_of_memory(error) : percale_scene_set(scene, key, equals + 1, error);
    free(key);
    return done;
}

/// The table's settings, then the preset, then --set: the later one wins.
static PercaleScene *open_scene(const BenchEntry *entry, const BenchFlags *flags, PercaleSceneError *error)
{
    PercaleScene *scene = bench_scene_open(entry->scene, entry->size, error);
    bool done = scene != NULL;
    if (done && flags->preset != NULL) {
        done = percale_scene_set_preset(scene, flags->preset, error);
    }
    for (size_t index = 0; done && index < flags->settings.count; ++index) {
        done = apply_setting(scene, flags->settings.items[index], error);
    }
    if (!done) {
        percale_scene_close(scene);
        return NULL;
    }
    return scene;
}

bool bench_scene_check(const BenchEntry *entry, const BenchFlags *flags, PercaleSceneError *error)
{
    PercaleScene *scene = open_scene(entry, flags, error);
    percale_scene_close(scene);
    return scene != NULL;
}

// ---- stepping ----

static bool new_times(FrameTimes *times, uint32_t frame_count, PercaleSceneError *error)
{
    enum { ARRAYS = 3 + PERCALE_STAGE_COUNT };
    double *values = calloc((size_t)ARRAYS * frame_count, sizeof *values);
    if (values == NULL) {
        percale_scene_out_of_memory(error);
        return false;
    }
    *times = (FrameTimes){.real = values, .frame_count = frame_count};
    times->cpu = values + frame_count;
    times->scratch = times->cpu + frame_count;
    for (size_t stage = 0; stage < PERCALE_STAGE_COUNT; ++stage) {
        times->stages[stage] = values + (3 + stage) * frame_count;
    }
    return true;
}

static void note_peak(SceneRun *run)
{
    PercaleBytes bytes = percale_solver_bytes(run->solver);
    uint64_t sum = bytes.model + bytes.detect + bytes.color + bytes.solve + bytes.arena;
    run->peak_bytes = sum > run->peak_bytes ? sum : run->peak_bytes;
}

static bool step(SceneRun *run, uint32_t frame, PercaleSceneError *error)
{
    if (!percale_scene_move(run->scene, run->solver, frame + 1, error)) {
        return false;
    }
    double seconds = 1.0 / percale_scene_frame_rate(run->scene);
    BenchTime start = bench_now();
    PercaleResult result = percale_solver_step(run->solver, seconds);
    BenchTime time = bench_since(start);
    if (result != PERCALE_OK) {
        return percale_scene_fail(error, "frame %u: %s", (unsigned)frame + 1,
                                  percale_solver_last_error(run->solver));
    }
    PercaleProfile profile = percale_solver_profile(run->solver);
    run->times.real[frame] = time.real;
    run->times.cpu[frame] = time.cpu;
    for (int stage = 0; stage < PERCALE_STAGE_COUNT; ++stage) {
        run->times.stages[stage][frame] = profile.stage_seconds[stage];
    }
    note_peak(run);
    return true;
}

static bool simulate(SceneRun *run, const BenchEntry *entry, const BenchFlags *flags, BenchProgress *progress,
                     PercaleSceneError *error)
{
    uint32_t frame_count = flags->frames > 0 ? (uint32_t)flags->frames : entry->scene->frames;
    run->scene = open_scene(entry, flags, error);
    if (run->scene == NULL || !new_times(&run->times, frame_count, error)) {
        return false;
    }
    run->solver = percale_scene_build(run->scene, entry->thread_count, error);
    bool done = run->solver != NULL;
    for (uint32_t frame = 0; done && frame < frame_count; ++frame) {
        bench_progress_frame(progress, frame + 1, frame_count);
        done = step(run, frame, error);
    }
    return done;
}

// ---- figures ----

/// Median over the frames after the first, which also sets things up; over that one when there is no other.
static double median_after_first(const FrameTimes *times, const double *values)
{
    uint32_t skipped = times->frame_count > 1;
    uint32_t count = times->frame_count - skipped;
    memcpy(times->scratch, values + skipped, count * sizeof *values);
    return bench_quantile(times->scratch, count, 0.5);
}

static void add_times(const FrameTimes *times, BenchResult *result)
{
    uint32_t skipped = times->frame_count > 1;
    uint32_t count = times->frame_count - skipped;
    uint32_t last = count < LAST_FRAMES ? count : LAST_FRAMES;
    result->iterations = count;
    result->real_seconds = median_after_first(times, times->real);
    result->cpu_seconds = median_after_first(times, times->cpu);
    bench_result_add(result, "frames", (double)times->frame_count);
    bench_result_add(result, "ms_first", MILLISECONDS * times->real[0]);
    memcpy(times->scratch, times->real + skipped, count * sizeof *times->real);
    bench_result_add(result, "ms_min", MILLISECONDS * bench_quantile(times->scratch, count, 0.0));
    bench_result_add(result, "ms_p90", MILLISECONDS * bench_quantile(times->scratch, count, P90));
    memcpy(times->scratch, times->real + times->frame_count - last, last * sizeof *times->real);
    bench_result_add(result, "ms_last60", MILLISECONDS * bench_quantile(times->scratch, last, 0.5));
    for (int stage = 0; stage < PERCALE_STAGE_COUNT; ++stage) {
        char name[BENCH_COUNTER_NAME];
        (void)snprintf(name, sizeof name, "ms_%s", percale_stage_name((PercaleStage)stage));
        bench_result_add(result, name, MILLISECONDS * median_after_first(times, times->stages[stage]));
    }
}

static void add_work(const SceneRun *run, BenchResult *result)
{
    PercaleCounters work = percale_solver_counters(run->solver);
    bench_result_add(result, "projections_per_frame", (double)work.projections / run->times.frame_count);
#define ADD(name) bench_result_add(result, #name, (double)work.name);
    PERCALE_COUNTERS(ADD)
#undef ADD
}

static bool add_quality(const SceneRun *run, BenchResult *result, PercaleSceneError *error)
{
    PercaleQuality quality;
    if (percale_solver_quality(run->solver, &quality) != PERCALE_OK) {
        return percale_scene_fail(error, "audit: %s", percale_solver_last_error(run->solver));
    }
#define ADD(name) bench_result_add(result, #name, quality.name);
    PERCALE_QUALITIES(ADD)
#undef ADD
    return true;
}

static uint32_t vertex_count(const PercaleScene *scene)
{
    uint32_t count = 0;
    for (uint32_t index = 0; index < percale_scene_cloth_count(scene); ++index) {
        count += percale_scene_cloth(scene, index).vertex_count;
    }
    return count;
}

static bool report(SceneRun *run, BenchResult *result, PercaleSceneError *error)
{
    bench_result_add(result, "vertices", vertex_count(run->scene));
    add_times(&run->times, result);
    add_work(run, result);
    bench_result_add(result, "peak_bytes", (double)run->peak_bytes);
    bench_result_label(result, percale_solver_hash(run->solver));
    bool done = add_quality(run, result, error);
    bench_result_hide(result, 0, SHOWN);
    return done;
}

void bench_scene_run(const BenchEntry *entry, const BenchFlags *flags, BenchProgress *progress,
                     BenchResult *result)
{
    SceneRun run = {0};
    PercaleSceneError error = {""};
    *result = (BenchResult){0};
    if (!simulate(&run, entry, flags, progress, &error) || !report(&run, result, &error)) {
        *result = (BenchResult){.failed = true, .error = error};
    }
    free(run.times.real); // the first of all its arrays
    percale_solver_destroy(run.solver);
    percale_scene_close(run.scene);
}
