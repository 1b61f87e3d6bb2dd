// funnel: a square sheet is pulled by its middle through a funnel, and has to gather into the throat.
//
// The throat is as wide as the cloth needs: where the sheet's inscribed circle passes, its cross-section is a
// ring of pi * side * thickness, crumpled into a disc of pi * radius^2. The share of the disc that it fills
// stays the same for every thickness. But a mesh has no folds finer than its edges: a coarse sheet gets a
// wider throat.

#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"
#include "scene/shapes.h"

#include <math.h>
#include <string.h>

static const double side = 1.0;           // m, of the sheet
static const double filling = 0.3;        // of the throat by cloth, at the most
static const double fold_cells = 3.0;     // of the mesh, in the throat's radius at the least
static const double rim_radius = 0.75;    // m; the sheet's corners are 0.71 m from its middle
static const double cone_height = 0.6;    // m, from the throat, which begins at y = 0, to the rim
static const double throat_length = 0.12; // m, downwards from there
static const double wall = 0.05;          // m, across
static const double start_gap = 0.01;     // m, from the rim's plane to the sheet
static const double grip_radius = 0.02;   // m; the vertices so near to the middle are held
static const double bend_share = 0.1;     // of the cone's side; so far up it is rounded towards the throat
static const double pull_seconds = 4.0;   // 240 frames
static const double depth = 1.0; // m, below y = 0, where the pull ends: the sheet is out of the throat

enum { SEGMENTS = 64, CONE_STEPS = 16, BEND_STEPS = 6, THROAT_STEPS = 4 };
enum { INNER_COUNT = CONE_STEPS + BEND_STEPS + THROAT_STEPS, PROFILE_COUNT = 2 * INNER_COUNT };

// A smooth funnel and a smooth cloth: with 0.3 the folds hold fast in the throat, and the pull stretches them
// threefold before they give way.
static const char *const defaults[] = {"self", "on", "ee", "on", "friction", "0.1", NULL};

// ---- the funnel ----

static void between(const double a[2], const double b[2], double share, double point[2])
{
    point[0] = a[0] + share * (b[0] - a[0]);
    point[1] = a[1] + share * (b[1] - a[1]);
}

// Radius and height of the inner side, from the rim (step 0) to the throat's end (step INNER_COUNT - 1). Cone
// and throat are joined by a parabola.
static void inner_point(double radius, int step, double point[2])
{
    const double rim[2] = {rim_radius, cone_height};
    const double corner[2] = {radius, 0.0};
    const double end[2] = {radius, -throat_length};
    double cone_end[2];
    double throat_start[2];
    between(corner, rim, bend_share, cone_end);
    between(corner, end, 0.5, throat_start);
    if (step < CONE_STEPS) {
        between(rim, cone_end, (double)step / CONE_STEPS, point);
    } else if (step < CONE_STEPS + BEND_STEPS) {
        const double share = (double)(step - CONE_STEPS) / BEND_STEPS;
        double in[2];
        double out[2];
        between(cone_end, corner, share, in);
        between(corner, throat_start, share, out);
        between(in, out, share, point);
    } else {
        between(throat_start, end, (double)(step - CONE_STEPS - BEND_STEPS) / (THROAT_STEPS - 1), point);
    }
}

// Down the inner side, then up the outer one.
static void profile_point(double radius, int step, double point[2])
{
    if (step < INNER_COUNT) {
        inner_point(radius, step, point);
    } else {
        inner_point(radius, PROFILE_COUNT - 1 - step, point);
        point[0] += wall;
    }
}

static void fill_funnel(double radius, PercaleMesh *mesh)
{
    float *position = mesh->positions;
    uint32_t *corner = mesh->triangles;
    for (int segment = 0; segment < SEGMENTS; ++segment) {
        const PercaleTransform turned = percale_transform_make(
            1.0, (const double[3]){0.0, 360.0 * segment / SEGMENTS, 0.0}, (const double[3]){0.0});
        const uint32_t here = (uint32_t)segment * PROFILE_COUNT;
        const uint32_t next = (uint32_t)((segment + 1) % SEGMENTS) * PROFILE_COUNT;
        for (int step = 0; step < PROFILE_COUNT; ++step, position += 3, corner += 6) {
            double point[2];
            profile_point(radius, step, point);
            percale_transform_point(&turned, (const double[3]){point[0], point[1], 0.0}, position);
            const uint32_t k = (uint32_t)step;
            const uint32_t below = (k + 1) % PROFILE_COUNT;
            const uint32_t cell[6] = {here + k, next + below, here + below, here + k, next + k, next + below};
            memcpy(corner, cell, sizeof cell);
        }
    }
}

static bool make_funnel(PercaleScene *scene, double radius, PercaleSceneError *error)
{
    const uint32_t count = (uint32_t)SEGMENTS * PROFILE_COUNT;
    PercaleSceneItem *funnel = percale_scene_add_obstacle(scene, error);
    if (funnel == NULL) {
        return false;
    }
    PercaleMesh *mesh = &funnel->mesh;
    *mesh = (PercaleMesh){.name = strdup("funnel"),
                          .positions = percale_array_new((uint64_t)3 * count, sizeof *mesh->positions),
                          .vertex_count = count,
                          .triangles = percale_array_new((uint64_t)6 * count, sizeof *mesh->triangles),
                          .triangle_count = 2 * count};
    if (mesh->name == NULL || mesh->positions == NULL || mesh->triangles == NULL) {
        return percale_scene_out_of_memory(error);
    }
    fill_funnel(radius, mesh);
    return true;
}

// ---- the pull ----

/// The held vertices, and where they start.
typedef struct Grip {
    uint32_t count;
    float start[]; // [3 * count] m
} Grip;

// From rest to rest.
static void pose_grip(const void *figure, double seconds, float *positions)
{
    const Grip *grip = figure;
    const double share = fmin(seconds / pull_seconds, 1.0);
    const double down = (cone_height + start_gap + depth) * share * share * (3.0 - 2.0 * share);
    memcpy(positions, grip->start, 3 * (size_t)grip->count * sizeof *positions);
    for (size_t k = 0; k < grip->count; ++k) {
        positions[3 * k + 1] = (float)((double)grip->start[3 * k + 1] - down);
    }
}

static bool is_held(const float *point, double cell)
{
    // On a coarse sheet the corners of the middle cell, which are 0.71 cells from the middle.
    const double radius = fmax(grip_radius, 0.75 * cell);
    const double x = (double)point[0];
    const double z = (double)point[2];
    return x * x + z * z <= radius * radius;
}

static bool make_grip(PercaleSceneItem *cloth, double cell, PercaleSceneError *error)
{
    const PercaleMesh *mesh = &cloth->mesh;
    uint32_t count = 0;
    for (size_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        count += is_held(&mesh->positions[3 * vertex], cell);
    }
    Grip *grip = calloc(1, sizeof *grip + 3 * (size_t)count * sizeof grip->start[0]);
    PercalePinGroup *group = percale_scene_add_pins(cloth, count, error);
    if (grip == NULL || group == NULL) {
        free(grip);
        return percale_scene_out_of_memory(error);
    }
    for (uint32_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        const float *point = &mesh->positions[3 * (size_t)vertex];
        if (is_held(point, cell)) {
            memcpy(&grip->start[3 * (size_t)grip->count], point, 3 * sizeof *point);
            group->vertices[grip->count++] = vertex;
        }
    }
    group->motion = (PercaleMotion){.figure = grip, .pose = pose_grip, .release = free};
    return true;
}

// ---- the scene ----

static double throat_radius(double thickness, double cell)
{
    return fmax(sqrt(side * thickness / filling), fold_cells * cell);
}

static bool make(PercaleScene *scene, PercaleSceneError *error)
{
    uint32_t columns;
    uint32_t rows;
    percale_sheet_divide(scene->size, side, side, &columns, &rows);
    const double cell = side / (rows - 1);
    const double corner[3] = {-side / 2.0, cone_height + start_gap, side / 2.0};
    const double along[3] = {side, 0.0, 0.0};
    const double across[3] = {0.0, 0.0, -side}; // so that the sheet faces upwards
    PercaleSceneItem *cloth = percale_scene_add_cloth(scene, error);
    return cloth != NULL &&
           percale_sheet_make("sheet", columns, rows, corner, along, across, &cloth->mesh, error) &&
           make_grip(cloth, cell, error) &&
           make_funnel(scene, throat_radius(percale_scene_thickness(scene, cell), cell), error);
}

const PercaleSceneKind percale_scene_funnel = {.name = "funnel",
                                               .summary = "a sheet is pulled through a funnel",
                                               .default_size = 10000,
                                               .default_frames = 240,
                                               .defaults = defaults,
                                               .make = make};
