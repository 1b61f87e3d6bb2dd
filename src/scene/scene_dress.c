// dress: a dress sewn from panels on a walking mannequin; nothing is pinned.

#include "scene/scene_walk.h"

static const PercaleSettingRow extra[] = {
    {{"jump", PERCALE_SETTING_NUMBER, {0}, 0, 2, "m", NULL, "the body leaps sideways by so much, once"},
     NULL,
     0},
    PERCALE_WALK_SPEED_ROW};

// Cotton on skin; with less the dress would hang on its shoulders alone.
static const char *const defaults[] = {"friction", "0.6", NULL};

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    return percale_scene_add_garment(scene, &percale_dress_cut, scene->size, 0.0, error) != NULL &&
           percale_scene_add_walker(scene, percale_settings_extra(&scene->settings, "jump"), error);
}

const PercaleSceneKind percale_scene_dress = {.name = "dress",
                                              .summary = "a sewn dress on a walking mannequin",
                                              .default_size = 20000,
                                              .default_frames = 120,
                                              .extra_count = sizeof extra / sizeof extra[0],
                                              .extra = extra,
                                              .defaults = defaults,
                                              .make = make};
