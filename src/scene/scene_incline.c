// incline: a stiff sheet at rest on an inclined plane, to see friction by: below the angle whose tangent is
// the friction coefficient it stays, above it slides with g (sin - mu cos).
//
// Nothing but gravity and the plane acts (no damping), and the sheet starts in contact, at its thickness over
// the plane. With several layers each lies on the one below.

#include "scene/scene_error.h"
#include "scene/scene_model.h"
#include "scene/shapes.h"

#include <stdio.h>

enum { NAME_BYTES = 24 };

static const double side = 0.2;                      // m, of the sheet
static const double plane_size[3] = {4.0, 0.1, 1.0}; // m; its upper side is the plane
static const double uphill = 1.5; // m, from the middle of the plane to the sheet: room to slide

static const PercaleSettingRow extra[] = {
    {{"angle", PERCALE_SETTING_NUMBER, {15}, 0, 60, "degrees", NULL, "slope of the plane; it falls along x"},
     NULL,
     0},
    {{"layers", PERCALE_SETTING_INTEGER, {1}, 1, 3, "", NULL, "sheets, one on the other"}, NULL, 0}};

static const char *const defaults[] = {"self", "on",      "ee", "on", "bending_stiffness",
                                       "0.01", "damping", "0",  NULL};

static bool make_layer(PercaleScene *scene, int layer, const PercaleTransform *sloped,
                       PercaleSceneError *error)
{
    char name[NAME_BYTES];
    const uint64_t layers = (uint64_t)percale_settings_extra(&scene->settings, "layers");
    uint32_t columns;
    uint32_t rows;
    percale_sheet_divide((scene->size + layers / 2) / layers, side, side, &columns, &rows);
    const double height = (layer + 1) * percale_scene_thickness(scene, side / (columns - 1));
    double corner[3];
    double along[3];
    double across[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double *to = sloped->matrix[axis];
        along[axis] = side * to[0];
        across[axis] = -side * to[2]; // so that the sheet faces upwards
        corner[axis] = height * to[1] - uphill * to[0] - 0.5 * (along[axis] + across[axis]);
    }
    (void)snprintf(name, sizeof name, "sheet_%d", layer);
    PercaleSceneItem *sheet = percale_scene_add_cloth(scene, error);
    return sheet != NULL &&
           percale_sheet_make(name, columns, rows, corner, along, across, &sheet->mesh, error);
}

// Its upper side goes through the origin.
static bool make_plane(PercaleScene *scene, const PercaleTransform *sloped, PercaleSceneError *error)
{
    double along[3];
    double up[3];
    double across[3];
    double corner[3];
    for (int axis = 0; axis < 3; ++axis) {
        const double *to = sloped->matrix[axis];
        along[axis] = plane_size[0] * to[0];
        up[axis] = plane_size[1] * to[1];
        across[axis] = plane_size[2] * to[2];
        corner[axis] = -0.5 * along[axis] - up[axis] - 0.5 * across[axis];
    }
    PercaleSceneItem *plane = percale_scene_add_obstacle(scene, error);
    return plane != NULL && percale_box_make("plane", corner, along, up, across, &plane->mesh, error);
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    const double angle = percale_settings_extra(&scene->settings, "angle");
    const int layers = (int)percale_settings_extra(&scene->settings, "layers");
    const PercaleTransform sloped =
        percale_transform_make(1.0, (const double[3]){0.0, 0.0, -angle}, (const double[3]){0.0});
    for (int layer = 0; layer < layers; ++layer) {
        if (!make_layer(scene, layer, &sloped, error)) {
            return false;
        }
    }
    return make_plane(scene, &sloped, error);
}

const PercaleSceneKind percale_scene_incline = {.name = "incline",
                                                .summary =
                                                    "a stiff sheet on an inclined plane, held by friction",
                                                .default_size = 441,
                                                .default_frames = 120,
                                                .extra_count = sizeof extra / sizeof extra[0],
                                                .extra = extra,
                                                .defaults = defaults,
                                                .make = make};
