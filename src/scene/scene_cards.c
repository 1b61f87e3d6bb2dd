// cards: 30 sheets, each turned a little against the one below, fall on the ground one upon the other and lie
// there in a pile. Thirty cloths, card_00 (the lowest) to card_29.

#include "scene/scene_error.h"
#include "scene/scene_model.h"
#include "scene/shapes.h"

#include <math.h>
#include <stdio.h>

enum { CARD_COUNT = 30, NAME_BYTES = 16 };

static const double length = 0.30; // m, of a card
static const double width = 0.20;  // m
static const double turn = 2.0;    // degrees, from one card to the next
static const double gap = 1.5;     // thicknesses from one to the next: more than they keep, but no crash
static const double ground_size[3] = {0.6, 0.1, 0.6}; // m; its top is y = 0

// Cardboard, not cloth: the corners that stand out over the pile stay nearly level.
static const char *const defaults[] = {"self", "on", "ee", "on", "bending_stiffness", "1e-3", NULL};

static bool make_card(PercaleScene *scene, int index, uint32_t columns, uint32_t rows,
                      PercaleSceneError *error)
{
    char name[NAME_BYTES];
    const PercaleTransform turned =
        percale_transform_make(1.0, (const double[3]){0.0, index * turn, 0.0}, (const double[3]){0.0});
    double corner[3];
    double along[3];
    double across[3];
    for (int axis = 0; axis < 3; ++axis) {
        along[axis] = length * turned.matrix[axis][0];
        across[axis] = -width * turned.matrix[axis][2]; // so that the card faces upwards
        corner[axis] = -0.5 * (along[axis] + across[axis]);
    }
    const double longest_cell =
        fmax(length / (columns - 1), width / (rows - 1)); // the median edge, or longer
    corner[1] = (index + 1) * gap * percale_scene_thickness(scene, longest_cell);
    (void)snprintf(name, sizeof name, "card_%02d", index);
    PercaleSceneItem *card = percale_scene_add_cloth(scene, error);
    return card != NULL && percale_sheet_make(name, columns, rows, corner, along, across, &card->mesh, error);
}

static bool make_ground(PercaleScene *scene, PercaleSceneError *error)
{
    const double corner[3] = {-0.5 * ground_size[0], -ground_size[1], -0.5 * ground_size[2]};
    const double along[3] = {ground_size[0], 0.0, 0.0};
    const double up[3] = {0.0, ground_size[1], 0.0};
    const double across[3] = {0.0, 0.0, ground_size[2]};
    PercaleSceneItem *ground = percale_scene_add_obstacle(scene, error);
    return ground != NULL && percale_box_make("ground", corner, along, up, across, &ground->mesh, error);
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    uint32_t columns;
    uint32_t rows;
    percale_sheet_divide((scene->size + CARD_COUNT / 2) / CARD_COUNT, length, width, &columns, &rows);
    for (int index = 0; index < CARD_COUNT; ++index) {
        if (!make_card(scene, index, columns, rows, error)) {
            return false;
        }
    }
    return make_ground(scene, error);
}

const PercaleSceneKind percale_scene_cards = {.name = "cards",
                                              .summary = "thirty sheets fall into a pile",
                                              .default_size = 10000,
                                              .default_frames = 120,
                                              .defaults = defaults,
                                              .make = make};
