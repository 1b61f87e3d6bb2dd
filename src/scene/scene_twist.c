// twist: a strip, four times as long as wide, is wrung: its two ends turn against each other, and the lower
// one is free to travel along the axis. There is no gravity, so that nothing but the wringing acts.
//
// Pins are moved, not pulled, so the lower end is held by a carriage that follows the cloth like a hand that
// pulls lightly: in each frame it makes up for the difference between the strip's lengthwise edges, on the
// mean over all of them, and edges that are stretched by 1 %; never faster than a hand, and never lower than
// it started. It looks at nothing but the positions that the last frame has left, its own included, so the
// same bits come out for any number of threads and from any restart. It does not overshoot: what it moves is
// no more than what the strip is too long or too short by. With 0.2 % the rope goes slack and coils up; a
// carriage that minds only the last tenth of the strip lets the rest be stretched by a quarter.

#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"
#include "scene/shapes.h"

#include <math.h>
#include <string.h>

static const double length = 2.0;         // m, downwards from y = length
static const double width = 0.5;          // m
static const double seconds_all = 4.0;    // 240 frames, in which the ends are turned
static const double carriage_speed = 0.5; // m/s, at most
static const double pull = 0.01;          // mean stretch of the lengthwise edges that the carriage keeps

enum { UPPER = 0, LOWER = 1 }; // ends, and their groups of pins

static const PercaleSettingRow extra[] = {
    {{"turns", PERCALE_SETTING_NUMBER, {4}, 0, 6, "", NULL, "of one end against the other, in 4 s"},
     NULL,
     0}};

static const char *const defaults[] = {"self", "on", "ee", "on", "gravity", "0,0,0", NULL};

/// One end of the strip: its vertices, how it turns, and where it is.
typedef struct Clamp {
    uint32_t columns, rows; // of the strip; an end is a column
    double turns;           // in all; the other end has the opposite
    double travel;          // m, upwards
    float *strip;           // [3 * columns * rows] where the cloth is, m; of the lower clamp only
    float start[];          // [3 * rows] m
} Clamp;

// ---- turning ----

// From rest to rest.
static void pose_clamp(const void *figure, double seconds, float *positions)
{
    const Clamp *clamp = figure;
    const double share = fmin(seconds / seconds_all, 1.0);
    const double degrees = 360.0 * clamp->turns * share * share * (3.0 - 2.0 * share);
    const PercaleTransform placed = percale_transform_make(1.0, (const double[3]){0.0, degrees, 0.0},
                                                           (const double[3]){0.0, clamp->travel, 0.0});
    for (size_t row = 0; row < clamp->rows; ++row) {
        const float *start = &clamp->start[3 * row];
        const double from[3] = {(double)start[0], (double)start[1], (double)start[2]};
        percale_transform_point(&placed, from, &positions[3 * row]);
    }
}

static void release_clamp(void *figure)
{
    Clamp *clamp = figure;
    free(clamp->strip);
    free(clamp);
}

static bool add_clamp(PercaleSceneItem *cloth, uint32_t columns, uint32_t rows, int end, double turns,
                      PercaleSceneError *error)
{
    Clamp *clamp = calloc(1, sizeof *clamp + 3 * (size_t)rows * sizeof clamp->start[0]);
    PercalePinGroup *group = percale_scene_add_pins(cloth, rows, error);
    if (clamp == NULL || group == NULL) {
        free(clamp);
        return percale_scene_out_of_memory(error);
    }
    clamp->columns = columns;
    clamp->rows = rows;
    clamp->turns = end == UPPER ? 0.5 * turns : -0.5 * turns;
    for (uint32_t row = 0; row < rows; ++row) {
        const uint32_t vertex = row * columns + (end == UPPER ? 0 : columns - 1);
        group->vertices[row] = vertex;
        memcpy(&clamp->start[3 * (size_t)row], &cloth->mesh.positions[3 * (size_t)vertex],
               3 * sizeof clamp->start[0]);
    }
    group->motion = (PercaleMotion){.figure = clamp, .pose = pose_clamp, .release = release_clamp};
    if (end == LOWER) {
        clamp->strip = percale_array_new((uint64_t)3 * columns * rows, sizeof *clamp->strip);
    }
    return end == UPPER || clamp->strip != NULL || percale_scene_out_of_memory(error);
}

// ---- travelling ----

static double distance(const float *a, const float *b)
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        const double d = (double)b[axis] - (double)a[axis];
        sum += d * d;
    }
    return sqrt(sum);
}

// Mean length of the rows, m.
static double mean_length(const Clamp *clamp)
{
    double sum = 0.0;
    for (size_t row = 0; row < clamp->rows; ++row) {
        for (size_t column = 1; column < clamp->columns; ++column) {
            const float *point = &clamp->strip[3 * (row * clamp->columns + column)];
            sum += distance(point - 3, point);
        }
    }
    return sum / clamp->rows;
}

static bool follow(PercaleScene *scene, PercaleSolver *solver, PercaleSceneError *error)
{
    const PercaleSceneItem *cloth = &scene->cloths[0];
    Clamp *clamp = cloth->pins[LOWER].motion.figure;
    if (percale_cloth_get_positions(solver, cloth->cloth, clamp->strip, 0) != PERCALE_OK) {
        return percale_scene_fail(error, "cloth \"%s\": %s", cloth->mesh.name,
                                  percale_solver_last_error(solver));
    }
    const double up = mean_length(clamp) - (1.0 + pull) * length;
    const double farthest = carriage_speed / percale_scene_frame_rate(scene);
    const size_t held = 3 * (size_t)(clamp->columns - 1) + 1;
    const double travel = (double)clamp->strip[held] - (double)clamp->start[1];
    clamp->travel = fmax(travel + fmax(-farthest, fmin(up, farthest)), 0.0);
    return true;
}

// ---- the scene ----

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    const double turns = percale_settings_extra(&scene->settings, "turns");
    uint32_t columns;
    uint32_t rows;
    percale_sheet_divide(scene->size, length, width, &columns, &rows);
    const double corner[3] = {-width / 2.0, length, 0.0};
    const double along[3] = {0.0, -length, 0.0};
    const double across[3] = {width, 0.0, 0.0};
    PercaleSceneItem *cloth = percale_scene_add_cloth(scene, error);
    return cloth != NULL &&
           percale_sheet_make("strip", columns, rows, corner, along, across, &cloth->mesh, error) &&
           add_clamp(cloth, columns, rows, UPPER, turns, error) &&
           add_clamp(cloth, columns, rows, LOWER, turns, error);
}

const PercaleSceneKind percale_scene_twist = {.name = "twist",
                                              .summary = "a strip is wrung, one end free to travel",
                                              .default_size = 10000,
                                              .default_frames = 240,
                                              .extra_count = sizeof extra / sizeof extra[0],
                                              .extra = extra,
                                              .defaults = defaults,
                                              .make = make,
                                              .follow = follow};
