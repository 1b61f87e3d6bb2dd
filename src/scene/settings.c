#include "scene/settings.h"

#include "scene/grow.h"
#include "scene/number_text.h"
#include "scene/scene_error.h"

#include <math.h>
#include <string.h>

enum { SWEEP_LIMIT = 1000 };    // substeps, and iterations, that percale.h allows
enum { KEY_LIST_BYTES = 1024 }; // all keys of a scene, joined by '|'

// clang-format off
// name, kind, {default}, minimum, maximum, unit, choices, help; what is not built yet, and its value
static const PercaleSettingRow common_rows[PERCALE_SET_COUNT] = {
    [PERCALE_SET_FRAME_RATE] = {{"frame_rate", PERCALE_SETTING_NUMBER, {60}, 0.1, 1e5, "1/s", NULL,
        "frames (solver steps) per second of the scene"}, NULL, 0},
    [PERCALE_SET_SUBSTEPS] = {{"substeps", PERCALE_SETTING_INTEGER, {20}, 1, SWEEP_LIMIT, "", NULL,
        "equal parts of a frame"}, NULL, 0},
    [PERCALE_SET_ITERATIONS] = {{"iterations", PERCALE_SETTING_INTEGER, {1}, 1, SWEEP_LIMIT, "", NULL,
        "solver sweeps per substep"}, NULL, 0},
    [PERCALE_SET_ITERATIONS_PER_FRAME] = {{"iterations_per_frame", PERCALE_SETTING_INTEGER, {20}, 1, 1e6, "", NULL,
        "substeps x iterations; setting it gives as many substeps as can be"}, NULL, 0},
    [PERCALE_SET_PASSES] = {{"passes", PERCALE_SETTING_INTEGER, {0}, 0, 1e6, "", NULL,
        "collision passes per frame, up to substeps x iterations; 0: one per substep"}, NULL, 0},
    [PERCALE_SET_REUSE] = {{"reuse", PERCALE_SETTING_CHOICE, {PERCALE_REUSE_AUTO}, 0, PERCALE_REUSE_AUDIT, "", "auto|always|audit",
        "auto: contact candidates are kept while they hold; always: never; audit: auto, and what it misses is counted"}, NULL, 0},
    [PERCALE_SET_CCD] = {{"ccd", PERCALE_SETTING_CHOICE, {PERCALE_CCD_RAY}, 0, PERCALE_CCD_EXACT, "", "off|ray|exact",
        "swept tests: rays for cloth vertices and obstacles; exact: conservative ones for these and for cloth and cloth"}, NULL, 0},
    [PERCALE_SET_HERMITE] = {{"hermite", PERCALE_SETTING_SWITCH, {0}, 0, 1, "", NULL,
        "moving obstacles go along cubics through their frames, not along straight lines"}, NULL, 0},
    [PERCALE_SET_EE] = {{"ee", PERCALE_SETTING_SWITCH, {0}, 0, 1, "", NULL,
        "edges collide with edges, and the obstacles' vertices with the cloth's faces"}, NULL, 0},
    [PERCALE_SET_SELF] = {{"self", PERCALE_SETTING_SWITCH, {0}, 0, 1, "", NULL,
        "cloth collides with cloth"}, NULL, 0},
    [PERCALE_SET_OBSTACLE] = {{"obstacle", PERCALE_SETTING_SWITCH, {1}, 0, 1, "", NULL,
        "the obstacles are there"}, NULL, 0},
    [PERCALE_SET_GUARD] = {{"guard", PERCALE_SETTING_SWITCH, {1}, 0, 1, "", NULL,
        "what has passed after the last sweep is put back"}, NULL, 0},
    [PERCALE_SET_GUARD_PASSES] = {{"guard_passes", PERCALE_SETTING_SWITCH, {0}, 0, 1, "", NULL,
        "cloth is guarded from cloth before each collision pass only, over the way since the last"}, NULL, 0},
    [PERCALE_SET_UNTANGLE] = {{"untangle", PERCALE_SETTING_SWITCH, {1}, 0, 1, "", NULL,
        "cloth that goes through cloth is taken apart, a little in each step"}, NULL, 0},
    [PERCALE_SET_TETHERS] = {{"tethers", PERCALE_SETTING_SWITCH, {1}, 0, 1, "", NULL,
        "no vertex is farther from a pin than the cloth is long"}, NULL, 0},
    [PERCALE_SET_BENDING] = {{"bending", PERCALE_SETTING_SWITCH, {1}, 0, 1, "", NULL,
        "cloth resists bending"}, NULL, 0},
    [PERCALE_SET_LEVELS] = {{"levels", PERCALE_SETTING_INTEGER, {0}, 0, PERCALE_MAX_LEVELS, "", NULL,
        "coarse levels of the cloth, through which a pull reaches 4, 16, 64.. edges far in one sweep"}, NULL, 0},
    [PERCALE_SET_THICKNESS] = {{"thickness", PERCALE_SETTING_NUMBER, {0.002}, 0, 1, "m", NULL,
        "distance kept between two surfaces; 0: a fifth of the median rest edge"}, NULL, 0},
    [PERCALE_SET_FRICTION] = {{"friction", PERCALE_SETTING_NUMBER, {0.3}, 0, 10, "", NULL,
        "Coulomb coefficient"}, NULL, 0},
    [PERCALE_SET_STRETCH_COMPLIANCE] = {{"stretch_compliance", PERCALE_SETTING_NUMBER, {0}, 0, 1, "m/N", NULL,
        "along each edge; 0: inextensible"}, NULL, 0},
    [PERCALE_SET_BENDING_STIFFNESS] = {{"bending_stiffness", PERCALE_SETTING_NUMBER, {1e-6}, 0, 1, "N m", NULL,
        "flexural rigidity"}, NULL, 0},
    [PERCALE_SET_DENSITY] = {{"density", PERCALE_SETTING_NUMBER, {0.2}, 1e-6, 1e3, "kg/m^2", NULL,
        "mass per area of the rest shape"}, NULL, 0},
    [PERCALE_SET_DAMPING] = {{"damping", PERCALE_SETTING_NUMBER, {0.02}, 0, 1e3, "1/s", NULL,
        "velocities decay as exp(-damping t)"}, NULL, 0},
    [PERCALE_SET_GRAVITY] = {{"gravity", PERCALE_SETTING_VECTOR, {0.0, -9.81}, -1e4, 1e4, "m/s^2", NULL,
        "acceleration of everything"}, NULL, 0},
    [PERCALE_SET_WIND] = {{"wind", PERCALE_SETTING_VECTOR, {0}, -1e3, 1e3, "m/s", NULL,
        "velocity of the air; 0,0,0: no air"}, NULL, 0},
    [PERCALE_SET_SPEED_MAX] = {{"speed_max", PERCALE_SETTING_NUMBER, {100}, 1e-3, 1e6, "m/s", NULL,
        "a vertex is never faster"}, NULL, 0},
    [PERCALE_SET_ORIGIN] = {{"origin", PERCALE_SETTING_VECTOR, {0}, -1e9, 1e9, "m", NULL,
        "world position that the coordinates inside are relative to"}, NULL, 0},
    [PERCALE_SET_ISA] = {{"isa", PERCALE_SETTING_CHOICE, {PERCALE_ISA_AUTO}, 0, PERCALE_ISA_AVX512, "", "auto|sse2|avx2|avx512",
        "instruction set of the kernels; the bits are the same"}, NULL, 0},
    [PERCALE_SET_SEED] = {{"seed", PERCALE_SETTING_INTEGER, {0}, 0, 4294967295.0, "", NULL,
        "not 0: every free cloth vertex starts up to 0.1 mm off, at random"}, NULL, 0},
};
// clang-format on

typedef struct Preset {
    const char *name;
    double substeps, iterations;
} Preset;

// Provisional until they are chosen from the measured front of speed against quality.
static const Preset presets[] = {{"swift", 2.0, 5.0}, {"balanced", 20.0, 1.0}, {"accurate", 80.0, 1.0}};
enum { PRESET_COUNT = sizeof presets / sizeof presets[0], PRESET_DEFAULT = 1 };

static const PercaleSettingRow *row_of(const PercaleSettings *settings, uint32_t index)
{
    return index < PERCALE_SET_COUNT ? &common_rows[index] : &settings->extra[index - PERCALE_SET_COUNT];
}

static bool asks_for_unbuilt(const PercaleSettingRow *row, double value)
{
    return row->unbuilt != NULL && value == row->unbuilt_value;
}

bool percale_settings_create(PercaleSettings *settings, const PercaleSettingRow *extra, uint32_t extra_count,
                             PercaleSceneError *error)
{
    *settings = (PercaleSettings){
        .count = PERCALE_SET_COUNT + extra_count, .extra = extra, .preset = presets[PRESET_DEFAULT].name};
    settings->items = percale_array_new(settings->count, sizeof *settings->items);
    if (settings->items == NULL) {
        return percale_scene_out_of_memory(error);
    }
    for (uint32_t index = 0; index < settings->count; ++index) {
        const PercaleSettingRow *row = row_of(settings, index);
        settings->items[index] = row->setting;
        if (asks_for_unbuilt(row, row->setting.value[0])) {
            settings->items[index].value[0] = 0.0;
        }
    }
    return true;
}

void percale_settings_free(PercaleSettings *settings)
{
    free(settings->items);
    *settings = (PercaleSettings){0};
}

uint32_t percale_settings_find(const PercaleSettings *settings, const char *key, PercaleSceneError *error)
{
    char names[KEY_LIST_BYTES] = "";
    size_t used = 0;
    for (uint32_t index = 0; index < settings->count; ++index) {
        const char *name = settings->items[index].name;
        if (strcmp(name, key) == 0) {
            return index;
        }
        const int length = snprintf(names + used, sizeof names - used, "%s|", name);
        used += length > 0 && (size_t)length < sizeof names - used ? (size_t)length : 0;
    }
    names[used] = '\0';
    int length;
    const char *nearest = percale_nearest_name(names, key, &length);
    percale_scene_fail(error, "unknown setting \"%s\" (did you mean \"%.*s\"?)", key, length, nearest);
    return settings->count;
}

// ---- assignment ----

static bool check_range(const PercaleSetting *setting, const double value[3], PercaleSceneError *error)
{
    const int count = setting->kind == PERCALE_SETTING_VECTOR ? 3 : 1;
    for (int axis = 0; axis < count; ++axis) {
        // Written so that NaN is outside as well.
        if (!(value[axis] >= setting->minimum && value[axis] <= setting->maximum)) {
            return percale_scene_fail(error, "%s=%.9g is out of range: %.9g to %.9g%s%s", setting->name,
                                      value[axis], setting->minimum, setting->maximum,
                                      setting->unit[0] != '\0' ? " " : "", setting->unit);
        }
    }
    const bool whole = setting->kind != PERCALE_SETTING_NUMBER && setting->kind != PERCALE_SETTING_VECTOR;
    return !whole || value[0] == floor(value[0]) ||
           percale_scene_fail(error, "%s=%.9g is not a whole number", setting->name, value[0]);
}

static void choice_text(const PercaleSetting *setting, int value, char *text, size_t size)
{
    const char *choice = setting->choices != NULL ? setting->choices : "off|on";
    for (int k = 0; k < value; ++k) {
        choice += strcspn(choice, "|");
        choice += *choice == '|';
    }
    (void)snprintf(text, size, "%.*s", (int)strcspn(choice, "|"), choice);
}

// As many substeps as there can be: small substeps come before iterations.
static bool split_sweeps(PercaleSettings *settings, double sweeps, PercaleSceneError *error)
{
    const int total = (int)sweeps;
    for (int iterations = 1; iterations <= SWEEP_LIMIT && iterations <= total; ++iterations) {
        const int substeps = total / iterations;
        if (substeps * iterations == total && substeps <= SWEEP_LIMIT) {
            settings->items[PERCALE_SET_SUBSTEPS].value[0] = substeps;
            settings->items[PERCALE_SET_ITERATIONS].value[0] = iterations;
            return true;
        }
    }
    return percale_scene_fail(
        error, "iterations_per_frame=%d is not substeps x iterations with both up to %d", total, SWEEP_LIMIT);
}

bool percale_settings_assign(PercaleSettings *settings, uint32_t index, const double value[3],
                             PercaleSceneError *error)
{
    PercaleSetting *setting = &settings->items[index];
    const PercaleSettingRow *row = row_of(settings, index);
    if (!check_range(setting, value, error)) {
        return false;
    }
    if (asks_for_unbuilt(row, value[0])) {
        char text[64];
        choice_text(setting, (int)value[0], text, sizeof text);
        return percale_scene_fail(error, "%s=%s: %s is not in this version", setting->name, text,
                                  row->unbuilt);
    }
    if (index == PERCALE_SET_ITERATIONS_PER_FRAME && !split_sweeps(settings, value[0], error)) {
        return false;
    }
    const size_t count = setting->kind == PERCALE_SETTING_VECTOR ? 3 : 1;
    memcpy(setting->value, value, count * sizeof *value);
    settings->items[PERCALE_SET_ITERATIONS_PER_FRAME].value[0] =
        percale_settings_number(settings, PERCALE_SET_SUBSTEPS) *
        percale_settings_number(settings, PERCALE_SET_ITERATIONS);
    return true;
}

static bool parse_choice(const PercaleSetting *setting, const char *choices, const char *text, double *value,
                         PercaleSceneError *error)
{
    const size_t length = strlen(text);
    int index = 0;
    for (const char *choice = choices; *choice != '\0'; ++index) {
        const size_t choice_length = strcspn(choice, "|");
        if (choice_length == length && strncmp(choice, text, length) == 0) {
            *value = index;
            return true;
        }
        choice += choice_length;
        choice += *choice == '|';
    }
    return percale_scene_fail(error, "%s=%s: expected one of %s", setting->name, text, choices);
}

static bool parse_numbers(const PercaleSetting *setting, const char *text, int count, double *value,
                          PercaleSceneError *error)
{
    const char *at = text;
    const char *end = text + strlen(text);
    bool read = true;
    for (int axis = 0; axis < count && read; ++axis) {
        read = axis == 0 || (at < end && *at++ == ',');
        read = read && percale_number_parse(&at, end, &value[axis]);
    }
    if (read && at == end) {
        return true;
    }
    return percale_scene_fail(error, "%s=%s: expected %s", setting->name, text,
                              count == 3 ? "three numbers \"x,y,z\"" : "a number");
}

bool percale_settings_assign_text(PercaleSettings *settings, uint32_t index, const char *text,
                                  PercaleSceneError *error)
{
    const PercaleSetting *setting = &settings->items[index];
    double value[3] = {0.0, 0.0, 0.0};
    bool parsed = false;
    switch (setting->kind) {
    case PERCALE_SETTING_SWITCH:
        parsed = parse_choice(setting, "off|on", text, &value[0], error);
        break;
    case PERCALE_SETTING_CHOICE:
        parsed = parse_choice(setting, setting->choices, text, &value[0], error);
        break;
    case PERCALE_SETTING_INTEGER:
    case PERCALE_SETTING_NUMBER:
        parsed = parse_numbers(setting, text, 1, value, error);
        break;
    case PERCALE_SETTING_VECTOR:
        parsed = parse_numbers(setting, text, 3, value, error);
        break;
    }
    return parsed && percale_settings_assign(settings, index, value, error);
}

bool percale_settings_assign_preset(PercaleSettings *settings, const char *preset, PercaleSceneError *error)
{
    for (int k = 0; k < PRESET_COUNT; ++k) {
        if (strcmp(presets[k].name, preset) == 0) {
            settings->preset = presets[k].name;
            return percale_settings_assign(settings, PERCALE_SET_SUBSTEPS,
                                           (const double[3]){presets[k].substeps}, error) &&
                   percale_settings_assign(settings, PERCALE_SET_ITERATIONS,
                                           (const double[3]){presets[k].iterations}, error);
        }
    }
    return percale_scene_fail(error, "unknown preset \"%s\": expected one of swift, balanced, accurate",
                              preset);
}

// ---- values ----

double percale_settings_number(const PercaleSettings *settings, PercaleSettingIndex index)
{
    return settings->items[index].value[0];
}

bool percale_settings_switch(const PercaleSettings *settings, PercaleSettingIndex index)
{
    return settings->items[index].value[0] != 0.0;
}

double percale_settings_extra(const PercaleSettings *settings, const char *name)
{
    uint32_t index = PERCALE_SET_COUNT;
    while (strcmp(settings->items[index].name, name) != 0) {
        ++index;
    }
    return settings->items[index].value[0];
}

bool percale_settings_check(const PercaleSettings *settings, PercaleSceneError *error)
{
    const double passes = percale_settings_number(settings, PERCALE_SET_PASSES);
    const double sweeps = percale_settings_number(settings, PERCALE_SET_ITERATIONS_PER_FRAME);
    return passes <= sweeps ||
           percale_scene_fail(error, "passes=%.0f is more than substeps x iterations = %.0f", passes, sweeps);
}

static void copy_vector(const PercaleSettings *settings, PercaleSettingIndex index, float vector[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        vector[axis] = (float)settings->items[index].value[axis];
    }
}

PercaleSolverDef percale_settings_solver_def(const PercaleSettings *settings, int thread_count)
{
    PercaleSolverDef def = percale_solver_def_default();
    memcpy(def.origin, settings->items[PERCALE_SET_ORIGIN].value, sizeof def.origin);
    copy_vector(settings, PERCALE_SET_GRAVITY, def.gravity);
    copy_vector(settings, PERCALE_SET_WIND, def.wind);
    def.damping = (float)percale_settings_number(settings, PERCALE_SET_DAMPING);
    def.speed_max = (float)percale_settings_number(settings, PERCALE_SET_SPEED_MAX);
    def.substeps = (int)percale_settings_number(settings, PERCALE_SET_SUBSTEPS);
    def.iterations = (int)percale_settings_number(settings, PERCALE_SET_ITERATIONS);
    def.passes = (int)percale_settings_number(settings, PERCALE_SET_PASSES);
    def.thread_count = thread_count;
    def.reuse = (PercaleReuse)percale_settings_number(settings, PERCALE_SET_REUSE);
    def.ccd = (PercaleCcd)percale_settings_number(settings, PERCALE_SET_CCD);
    def.isa = (PercaleIsa)percale_settings_number(settings, PERCALE_SET_ISA);
    def.vertex_face = percale_settings_switch(settings, PERCALE_SET_OBSTACLE);
    def.edge_edge = percale_settings_switch(settings, PERCALE_SET_EE);
    def.self_collision = percale_settings_switch(settings, PERCALE_SET_SELF);
    def.guard = percale_settings_switch(settings, PERCALE_SET_GUARD);
    def.guard_passes = percale_settings_switch(settings, PERCALE_SET_GUARD_PASSES);
    def.untangle = percale_settings_switch(settings, PERCALE_SET_UNTANGLE);
    def.tethers = percale_settings_switch(settings, PERCALE_SET_TETHERS);
    def.bending = percale_settings_switch(settings, PERCALE_SET_BENDING);
    def.levels = (int)percale_settings_number(settings, PERCALE_SET_LEVELS);
    return def;
}

PercaleMaterial percale_settings_material(const PercaleSettings *settings)
{
    PercaleMaterial material = percale_material_default();
    material.density = (float)percale_settings_number(settings, PERCALE_SET_DENSITY);
    material.stretch_compliance = (float)percale_settings_number(settings, PERCALE_SET_STRETCH_COMPLIANCE);
    material.bending_stiffness = (float)percale_settings_number(settings, PERCALE_SET_BENDING_STIFFNESS);
    material.thickness = (float)percale_settings_number(settings, PERCALE_SET_THICKNESS);
    material.friction = (float)percale_settings_number(settings, PERCALE_SET_FRICTION);
    return material;
}
