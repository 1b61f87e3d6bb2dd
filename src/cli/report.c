#include "cli/report.h"

#include "cli/setting_text.h"
#include "scene/output_file.h"

#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LAST_FRAMES = 60, // of ms_per_frame_last60: one second, after things have come to rest
    DIGITS = 15       // of a number: every decimal that a user wrote comes back as written
};

const char *percale_isa_name(PercaleIsa isa)
{
    switch (isa) {
    case PERCALE_ISA_AUTO:
        return "auto";
    case PERCALE_ISA_SSE2:
        return "sse2";
    case PERCALE_ISA_AVX2:
        return "avx2";
    case PERCALE_ISA_AVX512:
        return "avx512";
    }
    return "";
}

static int compare_numbers(const void *a, const void *b)
{
    const double *x = a;
    const double *y = b;
    return (*x > *y) - (*x < *y);
}

static double median_of_sorted(const double *values, uint32_t count)
{
    return count == 0 ? 0.0 : 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

void percale_report_times(PercaleReport *report, double *milliseconds, uint32_t count)
{
    uint32_t last = count < LAST_FRAMES ? count : LAST_FRAMES;
    double tail[LAST_FRAMES] = {0.0};
    for (uint32_t index = 0; index < last; ++index)
        tail[index] = milliseconds[count - last + index];
    qsort(tail, last, sizeof *tail, compare_numbers);
    qsort(milliseconds, count, sizeof *milliseconds, compare_numbers);
    report->ms_per_frame_median = median_of_sorted(milliseconds, count);
    report->ms_per_frame_last60 = median_of_sorted(tail, last);
    uint32_t rank =
        (uint32_t)(((uint64_t)count * 9 + 9) / 10); // nearest rank: 90 % of the frames are no slower
    report->ms_per_frame_p90 = count == 0 ? 0.0 : milliseconds[rank - 1];
}

void percale_quality_worsen(PercaleQuality *worst, const PercaleQuality *quality)
{
    double contact_fraction = fmin(worst->contact_fraction, quality->contact_fraction); // less is worse
#define TAKE_LARGER(name) worst->name = fmax(worst->name, quality->name);
    PERCALE_QUALITIES(TAKE_LARGER)
#undef TAKE_LARGER
    worst->contact_fraction = contact_fraction;
}

static json_t *number(double value)
{
    static const double WHOLE_MAX = 9007199254740992.0; // 2^53: up to here a double holds every whole number
    if (!isfinite(value))
        return json_integer(0);
    if (value == floor(value) && fabs(value) < WHOLE_MAX)
        return json_integer((json_int_t)value);
    return json_real(value);
}

static json_t *whole(uint64_t value)
{
    return json_integer((json_int_t)value);
}

/// JSON is UTF-8; in any other text the bytes above ASCII become '?'.
static json_t *text_of(const char *text)
{
    json_t *string = json_string(text);
    char *plain = string ? NULL : strdup(text);
    if (!plain)
        return string;
    for (char *character = plain; *character; ++character)
        if ((unsigned char)*character >= 0x80)
            *character = '?';
    string = json_string(plain);
    free(plain);
    return string;
}

static json_t *setting_value(const PercaleSetting *setting)
{
    char text[PERCALE_SETTING_TEXT];
    switch (setting->kind) {
    case PERCALE_SETTING_INTEGER:
    case PERCALE_SETTING_NUMBER:
        return number(setting->value[0]);
    case PERCALE_SETTING_VECTOR:
        return json_pack("[o, o, o]", number(setting->value[0]), number(setting->value[1]),
                         number(setting->value[2]));
    case PERCALE_SETTING_SWITCH:
    case PERCALE_SETTING_CHOICE:
        break;
    }
    percale_setting_text(setting, text);
    return text_of(text);
}

static json_t *settings_of(const PercaleReport *report)
{
    json_t *object = json_object();
    for (uint32_t index = 0; index < report->setting_count; ++index)
        json_object_set_new(object, report->settings[index].name, setting_value(&report->settings[index]));
    return object;
}

static json_t *stages_of(const PercaleReport *report)
{
    json_t *object = json_object();
    for (int stage = 0; stage < PERCALE_STAGE_COUNT; ++stage)
        json_object_set_new(object, percale_stage_name((PercaleStage)stage), number(report->stage_ms[stage]));
    return object;
}

static json_t *work_of(const PercaleCounters *work)
{
    json_t *object = json_object();
#define ADD(name) json_object_set_new(object, #name, whole(work->name));
    PERCALE_COUNTERS(ADD)
#undef ADD
    return object;
}

static json_t *quality_of(const PercaleQuality *quality)
{
    json_t *object = json_object();
#define ADD(name) json_object_set_new(object, #name, number(quality->name));
    PERCALE_QUALITIES(ADD)
#undef ADD
    return object;
}

static json_t *bytes_of(const PercaleBytes *bytes)
{
    json_t *object = json_object();
    json_object_set_new(object, "model", whole(bytes->model));
    json_object_set_new(object, "detect", whole(bytes->detect));
    json_object_set_new(object, "color", whole(bytes->color));
    json_object_set_new(object, "solve", whole(bytes->solve));
    json_object_set_new(object, "arena", whole(bytes->arena));
    return object;
}

static json_t *json_of_report(const PercaleReport *report)
{
    char hash[17];
    (void)snprintf(hash, sizeof hash, "%016" PRIx64, report->state_hash);
    json_t *object = json_object();
    json_object_set_new(object, "percale", text_of(percale_version()));
    json_object_set_new(object, "scene", text_of(report->scene));
    json_object_set_new(object, "preset", text_of(report->preset));
    json_object_set_new(object, "threads", json_integer(report->threads));
    json_object_set_new(object, "isa", text_of(percale_isa_name(report->isa)));
    json_object_set_new(object, "frames", whole(report->frames));
    json_object_set_new(object, "vertices", whole(report->vertices));
    json_object_set_new(object, "triangles", whole(report->triangles));
    json_object_set_new(object, "obstacle_triangles", whole(report->obstacle_triangles));
    json_object_set_new(object, "settings", settings_of(report));
    json_object_set_new(object, "ms_per_frame_median", number(report->ms_per_frame_median));
    json_object_set_new(object, "ms_per_frame_p90", number(report->ms_per_frame_p90));
    json_object_set_new(object, "ms_per_frame_last60", number(report->ms_per_frame_last60));
    json_object_set_new(object, "stage_ms", stages_of(report));
    json_object_set_new(object, "work", work_of(&report->work));
    json_object_set_new(object, "quality", quality_of(&report->quality));
    json_object_set_new(object, "quality_last", quality_of(&report->quality_last));
    json_object_set_new(object, "bytes", bytes_of(&report->bytes));
    json_object_set_new(object, "peak_bytes", whole(report->peak_bytes));
    json_object_set_new(object, "state_hash", text_of(hash));
    return object;
}

static json_t *json_of_audit(const PercaleAuditReport *report)
{
    json_t *object = json_object();
    json_object_set_new(object, "percale", text_of(percale_version()));
    json_object_set_new(object, "cloths", whole(report->cloths));
    json_object_set_new(object, "obstacles", whole(report->obstacles));
    json_object_set_new(object, "vertices", whole(report->vertices));
    json_object_set_new(object, "triangles", whole(report->triangles));
    json_object_set_new(object, "obstacle_triangles", whole(report->obstacle_triangles));
    json_object_set_new(object, "thickness", number(report->thickness));
    json_object_set_new(object, "quality", quality_of(&report->quality));
    return object;
}

static json_t *json_of_untangling(const PercaleUntangleCommandReport *report)
{
    const double MILLI = 1e3;
    char hash[17];
    (void)snprintf(hash, sizeof hash, "%016" PRIx64, report->state_hash);
    json_t *settings = json_object();
    json_object_set_new(settings, "thickness", number(report->settings.thickness));
    json_object_set_new(settings, "layers", json_boolean(report->settings.layers > 0.0));
    json_object_set_new(settings, "rounds", number(report->settings.rounds));
    json_object_set_new(settings, "sweeps", number(report->settings.sweeps));
    json_object_set_new(settings, "patience", number(report->settings.patience));
    json_t *object = json_object();
    json_object_set_new(object, "percale", text_of(percale_version()));
    json_object_set_new(object, "threads", json_integer(report->threads));
    json_object_set_new(object, "isa", text_of(percale_isa_name(report->isa)));
    json_object_set_new(object, "cloths", whole(report->cloths));
    json_object_set_new(object, "obstacles", whole(report->obstacles));
    json_object_set_new(object, "vertices", whole(report->vertices));
    json_object_set_new(object, "triangles", whole(report->triangles));
    json_object_set_new(object, "obstacle_triangles", whole(report->obstacle_triangles));
    json_object_set_new(object, "settings", settings);
    json_object_set_new(object, "ef_before", number(report->ef_before));
    json_object_set_new(object, "ef_after", number(report->ef_after));
    json_object_set_new(object, "iterations", json_integer(report->work.iterations));
    json_object_set_new(object, "momentum_drift", number(report->work.momentum_drift));
    json_object_set_new(object, "displacement_max_mm", number(MILLI * report->work.displacement_max));
    json_object_set_new(object, "contours_before", whole(report->work.contours_before));
    json_object_set_new(object, "contours_after", whole(report->work.contours_after));
    json_object_set_new(object, "contour_length_before_mm", number(MILLI * report->work.length_before));
    json_object_set_new(object, "contour_length_after_mm", number(MILLI * report->work.length_after));
    json_object_set_new(object, "ms", number(MILLI * report->work.seconds));
    json_object_set_new(object, "quality_before", quality_of(&report->quality_before));
    json_object_set_new(object, "quality", quality_of(&report->quality));
    json_object_set_new(object, "state_hash", text_of(hash));
    return object;
}

static bool dump(const json_t *object, FILE *stream)
{
    return json_dumpf(object, stream, JSON_INDENT(2) | JSON_REAL_PRECISION(DIGITS)) == 0 &&
           fputc('\n', stream) != EOF;
}

/// Writes and releases.
static bool write_json(json_t *object, const char *path, PercaleSceneError *error)
{
    if (strcmp(path, "-") == 0) {
        bool written = dump(object, stdout) && fflush(stdout) == 0;
        json_decref(object);
        if (!written)
            (void)snprintf(error->text, sizeof error->text, "standard output can't be written");
        return written;
    }
    PercaleOutputFile file;
    if (!percale_output_open(&file, path, error)) {
        json_decref(object);
        return false;
    }
    bool written = dump(object, file.stream);
    json_decref(object);
    if (written)
        return percale_output_commit(&file, error);
    percale_output_discard(&file);
    (void)snprintf(error->text, sizeof error->text, "%s: can't be written", path);
    return false;
}

bool percale_report_write(const PercaleReport *report, const char *path, PercaleSceneError *error)
{
    return write_json(json_of_report(report), path, error);
}

bool percale_audit_report_write(const PercaleAuditReport *report, const char *path, PercaleSceneError *error)
{
    return write_json(json_of_audit(report), path, error);
}

bool percale_untangle_report_write(const PercaleUntangleCommandReport *report, const char *path,
                                   PercaleSceneError *error)
{
    return write_json(json_of_untangling(report), path, error);
}
