// Opening, settings and read-out of scenes. The table of built-in scenes is here.

#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"

#include <string.h>
#include <unistd.h>

enum { DEFAULT_FRAMES = 120 };                // of a scene file that doesn't say
static const uint64_t size_limit = 100000000; // vertices of a made cloth: its indices must fit into 32 bits

// Those that are not in this version stand at the end; they are known by name, so that asking is answered.
static const PercaleSceneKind unbuilt_kinds[] = {
    {.name = "cantilever"},
};
enum {
    UNBUILT_COUNT = sizeof unbuilt_kinds / sizeof unbuilt_kinds[0],
    BUILT_COUNT = 8,
    NAME_LIST_BYTES = 128
};

static const PercaleSceneKind *built_kind(uint32_t index)
{
    static const PercaleSceneKind *const kinds[BUILT_COUNT] = {
        &percale_scene_drape,  &percale_scene_dress, &percale_scene_layers, &percale_scene_flag,
        &percale_scene_funnel, &percale_scene_twist, &percale_scene_cards,  &percale_scene_incline};
    return index < BUILT_COUNT ? kinds[index] : NULL;
}

const char *percale_scene_name(uint32_t index)
{
    return index < BUILT_COUNT ? built_kind(index)->name : NULL;
}

const char *percale_scene_summary(uint32_t index)
{
    return index < BUILT_COUNT ? built_kind(index)->summary : NULL;
}

// ---- opening ----

static const PercaleSceneKind *find_kind(const char *name)
{
    for (uint32_t index = 0; index < BUILT_COUNT; ++index) {
        if (strcmp(built_kind(index)->name, name) == 0) {
            return built_kind(index);
        }
    }
    for (uint32_t index = 0; index < UNBUILT_COUNT; ++index) {
        if (strcmp(unbuilt_kinds[index].name, name) == 0) {
            return &unbuilt_kinds[index];
        }
    }
    return NULL;
}

static bool apply_defaults(PercaleSettings *settings, const char *const *defaults, PercaleSceneError *error)
{
    for (; defaults != NULL && *defaults != NULL; defaults += 2) {
        const uint32_t index = percale_settings_find(settings, defaults[0], error);
        if (index == settings->count || !percale_settings_assign_text(settings, index, defaults[1], error)) {
            return false;
        }
    }
    return true;
}

static bool open_kind(PercaleScene *scene, const PercaleSceneKind *kind, uint64_t size,
                      PercaleSceneError *error)
{
    if (kind->make == NULL) {
        return percale_scene_fail(error, "scene %s is not in this version", kind->name);
    }
    if (size > size_limit) {
        return percale_scene_fail(error, "size %llu is too large: up to %llu vertices",
                                  (unsigned long long)size, (unsigned long long)size_limit);
    }
    scene->kind = kind;
    scene->size = size != 0 ? size : kind->default_size;
    scene->default_frames = kind->default_frames;
    return percale_settings_create(&scene->settings, kind->extra, kind->extra_count, error) &&
           apply_defaults(&scene->settings, kind->defaults, error);
}

static bool fail_unknown(const char *name, PercaleSceneError *error)
{
    char names[NAME_LIST_BYTES] = "";
    for (uint32_t index = 0; index < BUILT_COUNT; ++index) {
        const size_t used = strlen(names);
        (void)snprintf(names + used, sizeof names - used, "%s|", built_kind(index)->name);
    }
    int length;
    const char *nearest = percale_nearest_name(names, name, &length);
    return percale_scene_fail(
        error, "no scene \"%s\": not built in (did you mean \"%.*s\"?), and no such scene file", name, length,
        nearest);
}

static bool open_file(PercaleScene *scene, const char *path, uint64_t size, PercaleSceneError *error)
{
    if (access(path, F_OK) != 0) {
        return fail_unknown(path, error);
    }
    if (size != 0) {
        return percale_scene_fail(error, "%s: a scene file has the size of its meshes, none can be asked for",
                                  path);
    }
    scene->default_frames = DEFAULT_FRAMES;
    return percale_settings_create(&scene->settings, NULL, 0, error) &&
           percale_scene_read_json(scene, path, error);
}

PercaleScene *percale_scene_open(const char *name_or_path, uint64_t size, PercaleSceneError *error)
{
    PercaleScene *scene = calloc(1, sizeof *scene);
    if (scene == NULL) {
        percale_scene_out_of_memory(error);
        return NULL;
    }
    const PercaleSceneKind *kind = find_kind(name_or_path);
    const bool opened =
        kind != NULL ? open_kind(scene, kind, size, error) : open_file(scene, name_or_path, size, error);
    if (!opened) {
        percale_scene_close(scene);
        return NULL;
    }
    return scene;
}

void percale_scene_close(PercaleScene *scene)
{
    if (scene == NULL) {
        return;
    }
    percale_scene_clear(scene);
    free(scene->cloths);
    free(scene->obstacles);
    percale_settings_free(&scene->settings);
    free(scene);
}

// ---- settings ----

bool percale_scene_set_preset(PercaleScene *scene, const char *preset, PercaleSceneError *error)
{
    return percale_settings_assign_preset(&scene->settings, preset, error);
}

bool percale_scene_set(PercaleScene *scene, const char *key, const char *value, PercaleSceneError *error)
{
    const uint32_t index = percale_settings_find(&scene->settings, key, error);
    return index < scene->settings.count &&
           percale_settings_assign_text(&scene->settings, index, value, error);
}

const PercaleSetting *percale_scene_settings(const PercaleScene *scene, uint32_t *count)
{
    *count = scene->settings.count;
    return scene->settings.items;
}

const char *percale_scene_log(const PercaleScene *scene)
{
    return scene->solver_log;
}

const char *percale_scene_preset(const PercaleScene *scene)
{
    return scene->settings.preset;
}

uint32_t percale_scene_default_frames(const PercaleScene *scene)
{
    return scene->default_frames;
}

double percale_scene_frame_rate(const PercaleScene *scene)
{
    return percale_settings_number(&scene->settings, PERCALE_SET_FRAME_RATE);
}

void percale_scene_origin(const PercaleScene *scene, double origin[3])
{
    memcpy(origin, scene->settings.items[PERCALE_SET_ORIGIN].value, 3 * sizeof *origin);
}

// ---- read-out ----

uint32_t percale_scene_cloth_count(const PercaleScene *scene)
{
    return scene->cloth_count;
}

uint32_t percale_scene_obstacle_count(const PercaleScene *scene)
{
    const bool there = percale_settings_switch(&scene->settings, PERCALE_SET_OBSTACLE);
    return there ? scene->obstacle_count : 0;
}

static PercaleSceneObject describe(const PercaleSceneItem *item)
{
    return (PercaleSceneObject){.name = item->mesh.name,
                                .positions = item->mesh.positions,
                                .vertex_count = item->mesh.vertex_count,
                                .triangles = item->mesh.triangles,
                                .triangle_count = item->mesh.triangle_count,
                                .rest_lengths = item->rest_lengths,
                                .weld = item->weld,
                                .thickness = item->thickness,
                                .mask = item->mask,
                                .cloth = item->cloth,
                                .obstacle = item->obstacle};
}

PercaleSceneObject percale_scene_cloth(const PercaleScene *scene, uint32_t index)
{
    return describe(&scene->cloths[index]);
}

PercaleSceneObject percale_scene_obstacle(const PercaleScene *scene, uint32_t index)
{
    return describe(&scene->obstacles[index]);
}
