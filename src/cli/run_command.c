// percale run: everything is checked first, then the scene is stepped, then the results are written.

#include "cli/commands.h"
#include "cli/complaint.h"
#include "cli/destination.h"
#include "cli/machine.h"
#include "cli/options.h"
#include "cli/progress.h"
#include "cli/report.h"
#include "cli/run_output.h"
#include "cli/run_picture.h"
#include "cli/table.h"
#include "percale/scene.h"

#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

static const uint64_t SIZE_RANGE[2] = {1, 100000000};  // cloth vertices; 1e8 fill 20 GB
static const uint64_t FRAMES_RANGE[2] = {1, 10000000}; // two days at 60 frames per second
static const uint64_t THREADS_RANGE[2] = {1, PERCALE_MAX_THREADS};
static const uint64_t AUDIT_RANGE[2] = {1, 10000000};
static const uint64_t AUDIT_DEFAULT = 10; // every how many frames
static const uint64_t KILOBYTE = 1024;    // getrusage's unit on Linux

static const PercaleOptionKind KINDS[] = {
    {"--size", PERCALE_OPTION_VALUE},        {"--frames", PERCALE_OPTION_VALUE},
    {"--threads", PERCALE_OPTION_VALUE},     {"--preset", PERCALE_OPTION_VALUE},
    {"--set", PERCALE_OPTION_VALUE},         {"--audit", PERCALE_OPTION_VALUE},
    {"--out", PERCALE_OPTION_VALUE},         {"--format", PERCALE_OPTION_VALUE},
    {"--json", PERCALE_OPTION_VALUE},        {"--picture", PERCALE_OPTION_VALUE},
    {"--heat", PERCALE_OPTION_VALUE},        {"--quiet", PERCALE_OPTION_SWITCH},
    {"--error-below", PERCALE_OPTION_VALUE}, {"--resume", PERCALE_OPTION_VALUE},
    {"--capsule", PERCALE_OPTION_VALUE},     {NULL, PERCALE_OPTION_SWITCH}};

static const char *const NOT_BUILT[] = {"--error-below", "--resume", "--capsule"};

/// What the arguments ask for.
typedef struct RunPlan {
    const char *scene;
    uint64_t size;   // 0: the scene's default
    uint64_t frames; // 0: the scene's default
    uint64_t threads;
    uint64_t audit;
    const char *out, *json, *picture; // NULL: not asked for
    bool as_obj;
    PercaleHeat heat;
    bool quiet;
} RunPlan;

/// A run under way.
typedef struct Run {
    const RunPlan *plan;
    PercaleScene *scene;
    PercaleSolver *solver;
    uint32_t frame_count;
    double *milliseconds; // [frame_count] of each step
    PercaleRunOutput output;
    PercaleReport report;
    bool audited; // has any frame been judged yet?
} Run;

static bool refuse(PercaleSceneError *error, const char *option, const char *text)
{
    (void)snprintf(error->text, sizeof error->text, "%s: %s", option, text);
    return false;
}

static bool read_words(const PercaleOptions *options, RunPlan *plan, PercaleSceneError *error)
{
    plan->scene = percale_options_value(options, NULL);
    if (!plan->scene)
        return refuse(error, "run", "which scene? A name of 'percale scenes' or a JSON file");
    if (percale_options_values(options, NULL, NULL) > 1) {
        (void)snprintf(error->text, sizeof error->text, "run: '%s' is one argument too many", plan->scene);
        return false;
    }
    return true;
}

static bool read_choices(const PercaleOptions *options, RunPlan *plan, PercaleSceneError *error)
{
    const char *format = percale_options_value(options, "--format");
    plan->as_obj = format && strcmp(format, "obj") == 0;
    if (format && !plan->as_obj && strcmp(format, "pc2") != 0) {
        (void)snprintf(error->text, sizeof error->text, "--format: '%s' is neither pc2 nor obj", format);
        return false;
    }
    const char *heat = percale_options_value(options, "--heat");
    if (heat && strcmp(heat, "stretch") == 0)
        plan->heat = PERCALE_HEAT_STRETCH;
    else if (heat && strcmp(heat, "penetration") == 0)
        plan->heat = PERCALE_HEAT_PENETRATION;
    else if (heat) {
        (void)snprintf(error->text, sizeof error->text, "--heat: '%s' is neither stretch nor penetration",
                       heat);
        return false;
    }
    return true;
}

static bool read_plan(const PercaleOptions *options, RunPlan *plan, PercaleSceneError *error)
{
    for (size_t index = 0; index < sizeof NOT_BUILT / sizeof NOT_BUILT[0]; ++index)
        if (percale_options_find(options, NOT_BUILT[index]))
            return refuse(error, NOT_BUILT[index], "not in this version of percale");
    *plan = (RunPlan){.threads = percale_machine_threads(), .audit = AUDIT_DEFAULT};
    plan->out = percale_options_value(options, "--out");
    plan->json = percale_options_value(options, "--json");
    plan->picture = percale_options_value(options, "--picture");
    plan->quiet = percale_options_find(options, "--quiet") != NULL;
    const struct {
        const char *name;
        const uint64_t *range;
        uint64_t *value;
    } numbers[] = {{"--size", SIZE_RANGE, &plan->size},
                   {"--frames", FRAMES_RANGE, &plan->frames},
                   {"--threads", THREADS_RANGE, &plan->threads},
                   {"--audit", AUDIT_RANGE, &plan->audit}};
    for (size_t index = 0; index < sizeof numbers / sizeof numbers[0]; ++index) {
        const char *text = percale_options_value(options, numbers[index].name);
        if (!percale_option_whole(numbers[index].name, text, numbers[index].range, numbers[index].value,
                                  error))
            return false;
    }
    return read_words(options, plan, error) && read_choices(options, plan, error);
}

/// "key=value" to the scene.
static bool apply_setting(PercaleScene *scene, const char *text, PercaleSceneError *error)
{
    char key[64]; // the longest setting has 20 letters; a longer key is unknown in any case
    size_t length = strcspn(text, "=");
    if (text[length] == '\0' || length == 0 || length >= sizeof key) {
        (void)snprintf(error->text, sizeof error->text, "--set: '%s' is not key=value", text);
        return false;
    }
    memcpy(key, text, length);
    key[length] = '\0';
    return percale_scene_set(scene, key, text + length + 1, error);
}

static bool apply_settings(const PercaleOptions *options, PercaleScene *scene, PercaleSceneError *error)
{
    const char *preset = percale_options_value(options, "--preset");
    if (preset && !percale_scene_set_preset(scene, preset, error))
        return false;
    for (size_t index = 0; index < options->count; ++index) {
        const PercaleOption *option = &options->items[index];
        if (option->name && strcmp(option->name, "--set") == 0 && !apply_setting(scene, option->value, error))
            return false;
    }
    return true;
}

static bool check_destinations(const RunPlan *plan, PercaleSceneError *error)
{
    return percale_destination_folder("--out", plan->out, error) &&
           percale_destination_file("--json", plan->json, error) &&
           percale_destination_file("--picture", plan->picture, error);
}

/// Everything that the user can get wrong; writes nothing.
static bool prepare(Run *run, const PercaleOptions *options, PercaleSceneError *error)
{
    const RunPlan *plan = run->plan;
    if (!check_destinations(plan, error))
        return false;
    run->scene = percale_scene_open(plan->scene, plan->size, error);
    if (!run->scene || !apply_settings(options, run->scene, error))
        return false;
    run->solver = percale_scene_build(run->scene, (int)plan->threads, error);
    if (!run->solver || (plan->out && !percale_run_output_check(run->scene, error)))
        return false;
    run->frame_count = plan->frames > 0 ? (uint32_t)plan->frames : percale_scene_default_frames(run->scene);
    run->milliseconds = calloc((size_t)run->frame_count + 1, sizeof *run->milliseconds);
    return run->milliseconds || refuse(error, "run", "out of memory");
}

static double crossings_of(const PercaleQuality *quality)
{
    return quality->ef_cloth_cloth + quality->ef_cloth_obstacle;
}

static bool audit(Run *run, PercaleSceneError *error)
{
    PercaleReport *report = &run->report;
    if (percale_solver_quality(run->solver, &report->quality_last) != PERCALE_OK)
        return refuse(error, "audit", percale_solver_last_error(run->solver));
    if (crossings_of(&report->quality_last) > (run->audited ? crossings_of(&report->quality) : 0.0))
        (void)snprintf(report->crossing, sizeof report->crossing, "frame %u: %.*s", (unsigned)report->frames,
                       (int)sizeof report->crossing - 32, percale_scene_log(run->scene));
    if (run->audited)
        percale_quality_worsen(&report->quality, &report->quality_last);
    else
        report->quality = report->quality_last;
    run->audited = true;
    return true;
}

static bool step(Run *run, uint32_t frame, PercaleSceneError *error)
{
    if (!percale_scene_move(run->scene, run->solver, frame, error))
        return false;
    PercaleResult result = percale_solver_step(run->solver, 1.0 / percale_scene_frame_rate(run->scene));
    if (result != PERCALE_OK) {
        (void)snprintf(error->text, sizeof error->text, "frame %u: %s", (unsigned)frame,
                       percale_solver_last_error(run->solver));
        return false;
    }
    PercaleProfile profile = percale_solver_profile(run->solver);
    run->milliseconds[frame - 1] = 1e3 * profile.step_seconds;
    for (int stage = 0; stage < PERCALE_STAGE_COUNT; ++stage)
        run->report.stage_ms[stage] += 1e3 * profile.stage_seconds[stage];
    run->report.frames = frame;
    return true;
}

static bool simulate(Run *run, PercaleSceneError *error)
{
    PercaleProgress progress = percale_progress_start(run->frame_count, run->plan->quiet);
    bool good = !run->plan->out || percale_run_output_add(&run->output, run->solver, 0, error);
    for (uint32_t frame = 1; good && frame <= run->frame_count; ++frame) {
        good = step(run, frame, error);
        if (!good)
            break;
        percale_progress_show(&progress, frame, run->milliseconds[frame - 1]);
        if (run->plan->out)
            good = percale_run_output_add(&run->output, run->solver, frame, error);
        if (good && (frame % run->plan->audit == 0 || frame == run->frame_count))
            good = audit(run, error);
    }
    percale_progress_end(&progress);
    return good;
}

static uint64_t peak_bytes(void)
{
    struct rusage usage = {0};
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (uint64_t)usage.ru_maxrss * KILOBYTE : 0;
}

static void start_report(Run *run)
{
    PercaleReport *report = &run->report;
    *report = (PercaleReport){.scene = run->plan->scene, .threads = (int)run->plan->threads};
    report->preset = percale_scene_preset(run->scene);
    report->isa = percale_solver_isa(run->solver);
    report->settings = percale_scene_settings(run->scene, &report->setting_count);
    for (uint32_t index = 0; index < percale_scene_cloth_count(run->scene); ++index) {
        PercaleSceneObject cloth = percale_scene_cloth(run->scene, index);
        report->vertices += cloth.vertex_count;
        report->triangles += cloth.triangle_count;
    }
    for (uint32_t index = 0; index < percale_scene_obstacle_count(run->scene); ++index)
        report->obstacle_triangles += percale_scene_obstacle(run->scene, index).triangle_count;
}

static void finish_report(Run *run)
{
    PercaleReport *report = &run->report;
    for (int stage = 0; stage < PERCALE_STAGE_COUNT && report->frames > 0; ++stage)
        report->stage_ms[stage] /= (double)report->frames;
    percale_report_times(report, run->milliseconds, report->frames);
    report->work = percale_solver_counters(run->solver);
    report->bytes = percale_solver_bytes(run->solver);
    report->peak_bytes = peak_bytes();
    report->state_hash = percale_solver_hash(run->solver);
}

/// Steps the scene and writes what was asked for; the report and the picture also after a failed step.
static int execute(Run *run)
{
    const RunPlan *plan = run->plan;
    PercaleSceneError error = {""};
    start_report(run);
    if (plan->out && !percale_run_output_open(&run->output, run->scene, plan->out, plan->as_obj,
                                              run->frame_count + 1, &error))
        return percale_complain(PERCALE_EXIT_FAILED, "%s", error.text);
    bool good = simulate(run, &error);
    int code = good ? PERCALE_EXIT_DONE : percale_complain(PERCALE_EXIT_FAILED, "%s", error.text);
    if (!good)
        (void)audit(run, &error); // the last good state
    finish_report(run);
    bool written = !plan->out || percale_run_output_close(&run->output, good, &error);
    written = written && (!plan->json || percale_report_write(&run->report, plan->json, &error));
    written = written && (!plan->picture ||
                          percale_run_picture(plan->picture, run->scene, run->solver, plan->heat, &error));
    if (!plan->quiet && !(plan->json && strcmp(plan->json, "-") == 0))
        percale_table_print(&run->report);
    if (!written && code == PERCALE_EXIT_DONE)
        code = percale_complain(PERCALE_EXIT_FAILED, "%s", error.text);
    return code;
}

int percale_command_run(int argument_count, char **arguments)
{
    PercaleSceneError error = {""};
    PercaleOptions options;
    if (!percale_options_parse(argument_count, arguments, KINDS, &options, &error))
        return percale_complain(PERCALE_EXIT_USAGE, "run: %s", error.text);
    RunPlan plan;
    Run run = {.plan = &plan};
    int code = read_plan(&options, &plan, &error) && prepare(&run, &options, &error)
                   ? execute(&run)
                   : percale_complain(PERCALE_EXIT_USAGE, "%s", error.text);
    free(run.milliseconds);
    percale_solver_destroy(run.solver);
    percale_scene_close(run.scene);
    percale_options_free(&options);
    return code;
}
