// drape: a square sheet falls onto a sphere, or hangs from its corners. The scene that other programs are
// compared on.

#include "scene/scene_error.h"
#include "scene/scene_model.h"
#include "scene/shapes.h"

#include <math.h>

static const double side = 2.0;         // m
static const double sheet_height = 1.2; // m
static const double radius = 0.5;       // m; of the sphere, which stands on y = 0
enum { SUBDIVISIONS = 5 };              // 20480 triangles

static const char *const defaults[] = {"self", "on", "ee", "on", NULL};

static const PercaleSettingRow extra[] = {
    {{"hang", PERCALE_SETTING_CHOICE, {0}, 0, 2, "", "0|2|4", "corners that hold the sheet"}, NULL, 0}};

// N for which N x N is nearest to the size.
static uint32_t nearest_side(uint64_t size)
{
    const uint64_t below = (uint64_t)sqrt((double)size);
    const uint64_t above = below + 1;
    const bool nearer_above = above * above - size < size - below * below;
    const uint64_t count = nearer_above ? above : below;
    return count < 2 ? 2 : (uint32_t)count;
}

static bool pin_corners(PercaleSceneItem *cloth, uint32_t count, uint32_t per_side, PercaleSceneError *error)
{
    const uint32_t last = per_side * per_side - 1;
    const uint32_t corners[4] = {0, per_side - 1, last - (per_side - 1), last};
    if (count == 0) {
        return true;
    }
    PercalePinGroup *group = percale_scene_add_pins(cloth, count, error);
    for (uint32_t k = 0; k < count && group != NULL; ++k) {
        group->vertices[k] = corners[k];
    }
    return group != NULL;
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    const uint32_t per_side = nearest_side(scene->size);
    const uint32_t held = 2 * (uint32_t)percale_settings_extra(&scene->settings, "hang");
    const double corner[3] = {-side / 2.0, sheet_height, side / 2.0};
    const double along[3] = {side, 0.0, 0.0};
    const double across[3] = {0.0, 0.0, -side}; // so that the sheet faces upwards
    const double centre[3] = {0.0, radius, 0.0};
    PercaleSceneItem *cloth = percale_scene_add_cloth(scene, error);
    PercaleSceneItem *sphere = percale_scene_add_obstacle(scene, error);
    return cloth != NULL && sphere != NULL &&
           percale_sheet_make("sheet", per_side, per_side, corner, along, across, &cloth->mesh, error) &&
           pin_corners(cloth, held, per_side, error) &&
           percale_icosphere_make("sphere", SUBDIVISIONS, radius, centre, &sphere->mesh, error);
}

const PercaleSceneKind percale_scene_drape = {.name = "drape",
                                              .summary = "a square sheet falls onto a sphere",
                                              .default_size = 128 * 128,
                                              .default_frames = 120,
                                              .extra_count = sizeof extra / sizeof extra[0],
                                              .extra = extra,
                                              .defaults = defaults,
                                              .make = make};
