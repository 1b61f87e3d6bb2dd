// settings.h: the settings of a scene by name: one table, values from text or JSON, and the solver's Def.
//
//   in   key=value, a preset
//   out  PercaleSetting per name (what the program lists and reports), a PercaleSolverDef
//
// A feature that is not built yet keeps its name here: it is off, and asking for it is refused.

#ifndef PERCALE_SETTINGS_H
#define PERCALE_SETTINGS_H

#include "percale/scene.h"

/// The settings that every scene has, in the order of the table.
typedef enum PercaleSettingIndex {
    PERCALE_SET_FRAME_RATE = 0,
    PERCALE_SET_SUBSTEPS,
    PERCALE_SET_ITERATIONS,
    PERCALE_SET_ITERATIONS_PER_FRAME,
    PERCALE_SET_PASSES,
    PERCALE_SET_REUSE,
    PERCALE_SET_CCD,
    PERCALE_SET_HERMITE,
    PERCALE_SET_EE,
    PERCALE_SET_SELF,
    PERCALE_SET_OBSTACLE,
    PERCALE_SET_GUARD,
    PERCALE_SET_GUARD_PASSES,
    PERCALE_SET_UNTANGLE,
    PERCALE_SET_TETHERS,
    PERCALE_SET_BENDING,
    PERCALE_SET_LEVELS,
    PERCALE_SET_THICKNESS,
    PERCALE_SET_FRICTION,
    PERCALE_SET_STRETCH_COMPLIANCE,
    PERCALE_SET_BENDING_STIFFNESS,
    PERCALE_SET_DENSITY,
    PERCALE_SET_DAMPING,
    PERCALE_SET_GRAVITY,
    PERCALE_SET_WIND,
    PERCALE_SET_SPEED_MAX,
    PERCALE_SET_ORIGIN,
    PERCALE_SET_ISA,
    PERCALE_SET_SEED,
    PERCALE_SET_COUNT
} PercaleSettingIndex;

/// A row of the table: the setting with its default value, and what it can't do yet.
typedef struct PercaleSettingRow {
    PercaleSetting setting;
    const char *unbuilt;  ///< what is missing ("cloth-cloth contact"); NULL: everything is built
    double unbuilt_value; ///< the value that asks for it; a default that does counts as 0
} PercaleSettingRow;

typedef struct PercaleSettings {
    PercaleSetting *items; ///< [count]: the common ones, then the scene's own
    uint32_t count;
    const PercaleSettingRow *extra; ///< rows of the scene's own
    const char *preset;             ///< the last one chosen
} PercaleSettings;

/// All settings at their defaults, with the rows that the scene adds.
bool percale_settings_create(PercaleSettings *settings, const PercaleSettingRow *extra, uint32_t extra_count,
                             PercaleSceneError *error);
void percale_settings_free(PercaleSettings *settings);

/// Index of a key; settings->count: unknown, and the error names the nearest known key.
uint32_t percale_settings_find(const PercaleSettings *settings, const char *key, PercaleSceneError *error);
/// Checks kind and range, and that the value asks for nothing that is not built.
bool percale_settings_assign(PercaleSettings *settings, uint32_t index, const double value[3],
                             PercaleSceneError *error);
bool percale_settings_assign_text(PercaleSettings *settings, uint32_t index, const char *text,
                                  PercaleSceneError *error);
bool percale_settings_assign_preset(PercaleSettings *settings, const char *preset, PercaleSceneError *error);

double percale_settings_number(const PercaleSettings *settings, PercaleSettingIndex index);
bool percale_settings_switch(const PercaleSettings *settings, PercaleSettingIndex index);
/// Value of one of the scene's own settings, which must exist.
double percale_settings_extra(const PercaleSettings *settings, const char *name);

/// Refuses more collision passes than sweeps; only then is the order of the settings past.
bool percale_settings_check(const PercaleSettings *settings, PercaleSceneError *error);
PercaleSolverDef percale_settings_solver_def(const PercaleSettings *settings, int thread_count);
PercaleMaterial percale_settings_material(const PercaleSettings *settings);

/// The name in a '|'-separated list that is nearest to `word`; its length in *length.
const char *percale_nearest_name(const char *names, const char *word, int *length);

#endif
