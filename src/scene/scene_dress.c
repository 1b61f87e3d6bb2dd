// dress: a dress sewn from panels on a walking mannequin; nothing is pinned.

#include "scene/dress.h"
#include "scene/mannequin.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"

#include <stdlib.h>
#include <string.h>

static const PercaleSettingRow extra[] = {
    {{"jump", PERCALE_SETTING_NUMBER, {0}, 0, 2, "m", NULL, "the body leaps sideways by so much, once"},
     NULL,
     0}};

// Cotton on skin; with less the dress would hang on its shoulders alone.
static const char *const defaults[] = {"friction", "0.6", NULL};

static void pose(const void *figure, double seconds, float *positions)
{
    percale_mannequin_pose(figure, seconds, positions);
}

static void release(void *figure)
{
    percale_mannequin_free(figure);
}

static bool make_body(PercaleScene *scene, PercaleSceneError *error)
{
    PercaleSceneItem *body = percale_scene_add_obstacle(scene, error);
    if (body == NULL) {
        return false;
    }
    PercaleMotion *motion = &body->motion;
    motion->figure =
        percale_mannequin_make(percale_settings_extra(&scene->settings, "jump"), &body->mesh, error);
    if (motion->figure == NULL) {
        return false;
    }
    motion->release = release;
    motion->pose = pose;
    free(body->mesh.name);
    body->mesh.name = strdup("body");
    return body->mesh.name != NULL || percale_scene_out_of_memory(error);
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    const double thickness = percale_settings_number(&scene->settings, PERCALE_SET_THICKNESS);
    PercaleSceneItem *dress = percale_scene_add_cloth(scene, error);
    if (dress == NULL || !percale_dress_make(scene->size, (float)thickness, &dress->mesh, &dress->seams,
                                             &dress->seam_count, error)) {
        return false;
    }
    dress->rest = dress->mesh.uvs != NULL ? PERCALE_REST_UV : PERCALE_REST_MESH;
    return make_body(scene, error);
}

const PercaleSceneKind percale_scene_dress = {.name = "dress",
                                              .summary = "a sewn dress on a walking mannequin",
                                              .default_size = 20000,
                                              .default_frames = 120,
                                              .extra_count = sizeof extra / sizeof extra[0],
                                              .extra = extra,
                                              .defaults = defaults,
                                              .make = make};
