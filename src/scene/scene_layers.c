// layers: a dress under a jacket under a coat on the walking mannequin. Nothing is pinned, each garment hangs
// on the one beneath; their layers are 0, 1, 2.
//
// They are levels of one field, so each starts outside the one beneath. With `push` the jacket starts tucked
// into the dress from the hips down, crossing it all round: work for untangling. Its rest shape stays.

#include "scene/body_field.h"
#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/scene_walk.h"

#include <math.h>

enum { JACKET = 1, GARMENT_COUNT = 3 };

static const PercaleGarmentCut *const cuts[GARMENT_COUNT] = {&percale_dress_cut, &percale_jacket_cut,
                                                             &percale_coat_cut}; // from the skin outwards

static const uint64_t smallest = 3000; // vertices of all three
static const double apart =
    1.6; // thicknesses from one to the next: more than they keep, with room for corners
static const double sag_share = 0.6; // the garment beneath cuts nearly the same corners

// m farther out than that: in the hollows behind the arms a garment's cells bridge what the next one follows.
static const double ease[GARMENT_COUNT] = {0.0, 0.0025, 0.004};

// m: the jacket is tucked in fully below, not at all above. Where the skirt leaves the body there is room.
static const double tuck_full = 0.88;
static const double tuck_top = 0.94;

static const PercaleSettingRow extra[] = {
    {{"push",
      PERCALE_SETTING_NUMBER,
      {0},
      0,
      0.1,
      "m",
      NULL,
      "so far inwards the jacket's lower half starts, tucked into the dress, up to the skin"},
     NULL,
     0},
    PERCALE_WALK_SPEED_ROW};

static const char *const defaults[] = {"self", "on", "ee", "on", "friction", "0.6", NULL};

// The rest shape is the one that was made, in world coordinates.
static bool keep_rest(const PercaleScene *scene, PercaleSceneItem *cloth, PercaleSceneError *error)
{
    double origin[3];
    percale_scene_origin(scene, origin);
    const size_t size = 3 * (size_t)cloth->mesh.vertex_count;
    cloth->rest_file = percale_array_new(size, sizeof *cloth->rest_file);
    if (cloth->rest_file == NULL) {
        return percale_scene_out_of_memory(error);
    }
    for (size_t k = 0; k < size; ++k) {
        cloth->rest_file[k] = (double)cloth->mesh.positions[k] + origin[k % 3];
    }
    cloth->rest = PERCALE_REST_POINTS;
    return true;
}

// Towards the skin, but no nearer to it than `clearance`.
static void push_inwards(double distance, double clearance, float position[3])
{
    const double point[3] = {(double)position[0], (double)position[1], (double)position[2]};
    double gradient[3];
    const double room = percale_body_field(point, gradient) - clearance;
    const double length =
        sqrt(gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2]);
    const double way = fmin(distance, fmax(room, 0.0));
    for (int axis = 0; axis < 3; ++axis) {
        position[axis] = (float)(point[axis] - way * gradient[axis] / length);
    }
}

static bool tuck_in(const PercaleScene *scene, double push, double clearance, PercaleSceneItem *jacket,
                    PercaleSceneError *error)
{
    if (!keep_rest(scene, jacket, error)) {
        return false;
    }
    for (size_t vertex = 0; vertex < jacket->mesh.vertex_count; ++vertex) {
        float *position = &jacket->mesh.positions[3 * vertex];
        const double down = (tuck_top - (double)position[1]) / (tuck_top - tuck_full);
        push_inwards(push * fmin(fmax(down, 0.0), 1.0), clearance, position);
    }
    return true;
}

static uint64_t whole(void)
{
    uint64_t vertices = 0;
    for (int layer = 0; layer < GARMENT_COUNT; ++layer) {
        vertices += percale_garment_vertices(cuts[layer]);
    }
    return vertices;
}

// All equally fine, and a step from each to the next, as from the skin to the first.
static bool make_garment(PercaleScene *scene, int layer, PercaleSceneError *error)
{
    const PercaleGarmentCut *cut = cuts[layer];
    const double thickness = percale_settings_number(&scene->settings, PERCALE_SET_THICKNESS);
    const double push = percale_settings_extra(&scene->settings, "push");
    const uint64_t size = (scene->size * percale_garment_vertices(cut) + whole() / 2) / whole();
    const double step = apart * thickness + sag_share * percale_garment_sag(cut, size);
    double outwards = 0.0;
    for (int beneath = 0; beneath <= layer; ++beneath) {
        outwards += step + ease[beneath];
    }
    PercaleSceneItem *garment = percale_scene_add_garment(scene, cut, size, outwards, error);
    if (garment == NULL) {
        return false;
    }
    garment->layer = layer;
    return layer != JACKET || push == 0.0 || tuck_in(scene, push, step, garment, error);
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    if (scene->size < smallest) {
        return percale_scene_fail(error, "layers: size %llu is too small: at least %llu vertices",
                                  (unsigned long long)scene->size, (unsigned long long)smallest);
    }
    for (int layer = 0; layer < GARMENT_COUNT; ++layer) {
        if (!make_garment(scene, layer, error)) {
            return false;
        }
    }
    return percale_scene_add_walker(scene, 0.0, error);
}

const PercaleSceneKind percale_scene_layers = {.name = "layers",
                                               .summary = "a dress under a jacket under a coat, walking",
                                               .default_size = 10000,
                                               .default_frames = 240,
                                               .extra_count = sizeof extra / sizeof extra[0],
                                               .extra = extra,
                                               .defaults = defaults,
                                               .make = make};
