// flag: an upright sheet, held along one edge, in the wind. No collisions.

#include "scene/scene_model.h"
#include "scene/shapes.h"

static const double width = 1.5;  // m
static const double height = 1.0; // m
static const double foot = 1.0;   // m; height of the lower edge

// The wind blows a little across, else a plane flag would stay plane.
static const char *const defaults[] = {"wind", "6,0,1.5", NULL};

static bool pin_mast(PercaleSceneItem *cloth, uint32_t columns, uint32_t rows, PercaleSceneError *error)
{
    PercalePinGroup *group = percale_scene_add_pins(cloth, rows, error);
    for (uint32_t row = 0; row < rows && group != NULL; ++row) {
        group->vertices[row] = row * columns;
    }
    return group != NULL;
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    uint32_t columns;
    uint32_t rows;
    percale_sheet_divide(scene->size, width, height, &columns, &rows);
    const double corner[3] = {0.0, foot, 0.0};
    const double along[3] = {width, 0.0, 0.0};
    const double across[3] = {0.0, height, 0.0};
    PercaleSceneItem *cloth = percale_scene_add_cloth(scene, error);
    return cloth != NULL &&
           percale_sheet_make("flag", columns, rows, corner, along, across, &cloth->mesh, error) &&
           pin_mast(cloth, columns, rows, error);
}

const PercaleSceneKind percale_scene_flag = {.name = "flag",
                                             .summary = "a flag in the wind, without collisions",
                                             .default_size = 9600,
                                             .default_frames = 240,
                                             .defaults = defaults,
                                             .make = make};
