// From a scene to a solver, and its motion from frame to frame.

#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double jitter = 1e-4;         // m; how far a vertex may start off with a seed
static const float thickness_share = 0.2F; // of the median rest edge, where a thickness of 0 is given

typedef struct Build {
    PercaleScene *scene;
    PercaleSolver *solver;
    PercaleSceneError *error;
    double origin[3];
    uint32_t vertex_count; // cloth vertices so far
} Build;

static bool fail_object(const Build *build, const char *kind, const char *name)
{
    return percale_scene_fail(build->error, "%s \"%s\": %s", kind, name,
                              percale_solver_last_error(build->solver));
}

static void keep_log_line(void *user, const char *text)
{
    PercaleScene *scene = user;
    (void)snprintf(scene->solver_log, sizeof scene->solver_log, "%s", text);
}

// ---- meshes ----

static bool place_points(const Build *build, const PercaleSceneItem *item, const double *file,
                         float *positions)
{
    const PercaleTransform placed = percale_transform_from_file(&item->transform, build->origin, false);
    for (size_t k = 0; k < 3 * (size_t)item->mesh.vertex_count; k += 3) {
        percale_transform_point(&placed, &file[k], &positions[k]);
        if (!(isfinite(positions[k]) && isfinite(positions[k + 1]) && isfinite(positions[k + 2]))) {
            return percale_scene_fail(build->error, "\"%s\": vertex %zu is too far away", item->mesh.name,
                                      k / 3);
        }
    }
    return true;
}

// The rest shape before the seed moves anything.
static bool make_rest(const Build *build, PercaleSceneItem *cloth)
{
    const size_t size = 3 * (size_t)cloth->mesh.vertex_count;
    free(cloth->rest_positions);
    cloth->rest_positions = NULL;
    if (cloth->rest == PERCALE_REST_UV) {
        return true;
    }
    cloth->rest_positions = percale_array_new(size, sizeof *cloth->rest_positions);
    if (cloth->rest_positions == NULL) {
        return percale_scene_out_of_memory(build->error);
    }
    if (cloth->rest == PERCALE_REST_POINTS) {
        return place_points(build, cloth, cloth->rest_file, cloth->rest_positions);
    }
    memcpy(cloth->rest_positions, cloth->mesh.positions, size * sizeof *cloth->rest_positions);
    return true;
}

// SplitMix64 (Steele, Lea, Flood 2014).
static uint64_t next_random(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15U;
    uint64_t bits = *state;
    bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9U;
    bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebU;
    return bits ^ (bits >> 31);
}

static void jitter_positions(const Build *build, PercaleSceneItem *cloth)
{
    uint64_t state = (uint64_t)percale_settings_number(&build->scene->settings, PERCALE_SET_SEED);
    if (state == 0) {
        return;
    }
    for (size_t k = 0; k < 3 * (size_t)cloth->mesh.vertex_count; ++k) {
        const double unit = (double)(next_random(&state) >> 11) * 0x1p-53; // [0, 1)
        cloth->mesh.positions[k] += (float)(jitter * (2.0 * unit - 1.0));
    }
    for (uint32_t group = 0; group < cloth->pin_count; ++group) {
        for (uint32_t k = 0; k < cloth->pins[group].count && cloth->rest == PERCALE_REST_MESH; ++k) {
            const size_t vertex = 3 * (size_t)cloth->pins[group].vertices[k];
            memcpy(&cloth->mesh.positions[vertex], &cloth->rest_positions[vertex],
                   3 * sizeof *cloth->rest_positions);
        }
    }
}

static float own_or(const PercaleSceneItem *item, PercaleOwnValue own, float common)
{
    return item->has_own[own] ? item->own[own] : common;
}

// ---- cloths ----

double percale_scene_thickness(const PercaleScene *scene, double median_edge)
{
    const double given = percale_settings_number(&scene->settings, PERCALE_SET_THICKNESS);
    return given > 0.0 ? given : (double)thickness_share * median_edge;
}

static bool choose_material(const Build *build, PercaleSceneItem *cloth, PercaleMaterial *material)
{
    const PercaleMaterial common = percale_settings_material(&build->scene->settings);
    *material = (PercaleMaterial){
        .density = own_or(cloth, PERCALE_OWN_DENSITY, common.density),
        .stretch_compliance = own_or(cloth, PERCALE_OWN_STRETCH_COMPLIANCE, common.stretch_compliance),
        .bending_stiffness = own_or(cloth, PERCALE_OWN_BENDING_STIFFNESS, common.bending_stiffness),
        .thickness = own_or(cloth, PERCALE_OWN_THICKNESS, common.thickness),
        .friction = own_or(cloth, PERCALE_OWN_FRICTION, common.friction)};
    if (material->thickness == 0.0F) {
        const double median = percale_scene_median_edge(cloth);
        if (median < 0.0) {
            return percale_scene_out_of_memory(build->error);
        }
        material->thickness = thickness_share * (float)median;
    }
    cloth->thickness = material->thickness;
    return true;
}

static bool add_pin_group(const Build *build, const PercaleSceneItem *cloth, PercalePinGroup *group)
{
    PercalePinDef def = percale_pin_def_default();
    def.cloth = cloth->cloth;
    def.vertices = group->vertices;
    def.vertex_count = group->count;
    if (percale_motion_given(&group->motion)) {
        free(group->targets);
        group->targets = percale_array_new(3 * (uint64_t)group->count, sizeof *group->targets);
        if (group->targets == NULL) {
            return percale_scene_out_of_memory(build->error);
        }
        percale_motion_pose(&group->motion, 0, percale_scene_frame_rate(build->scene), &cloth->transform,
                            build->origin, group->targets);
        def.targets = group->targets;
    }
    return percale_pin_add(build->solver, &def, &group->pin) == PERCALE_OK ||
           fail_object(build, "pins of cloth", cloth->mesh.name);
}

static bool add_seams(const Build *build, const PercaleSceneItem *cloth)
{
    if (cloth->seam_count == 0) {
        return true;
    }
    uint32_t *ends = percale_array_new(2 * (uint64_t)cloth->seam_count, sizeof *ends);
    if (ends == NULL) {
        return percale_scene_out_of_memory(build->error);
    }
    for (size_t pair = 0; pair < cloth->seam_count; ++pair) {
        ends[pair] = cloth->seams[pair][0];
        ends[cloth->seam_count + pair] = cloth->seams[pair][1];
    }
    PercaleSeamDef def = percale_seam_def_default();
    PercaleSeam seam;
    def.cloth_a = cloth->cloth;
    def.cloth_b = cloth->cloth;
    def.vertices_a = ends;
    def.vertices_b = ends + cloth->seam_count;
    def.pair_count = cloth->seam_count;
    const bool done = percale_seam_add(build->solver, &def, &seam) == PERCALE_OK ||
                      fail_object(build, "seams of cloth", cloth->mesh.name);
    free(ends);
    return done;
}

static bool prepare_cloth(const Build *build, PercaleSceneItem *cloth)
{
    if (cloth->file != NULL && !place_points(build, cloth, cloth->file, cloth->mesh.positions)) {
        return false;
    }
    if (!make_rest(build, cloth)) {
        return false;
    }
    jitter_positions(build, cloth);
    return percale_scene_measure(cloth, build->vertex_count, build->error);
}

static bool add_cloth(Build *build, PercaleSceneItem *cloth)
{
    PercaleClothDef def = percale_cloth_def_default();
    if (!prepare_cloth(build, cloth) || !choose_material(build, cloth, &def.material)) {
        return false;
    }
    def.name = cloth->mesh.name;
    def.positions = cloth->mesh.positions;
    def.vertex_count = cloth->mesh.vertex_count;
    def.triangles = cloth->mesh.triangles;
    def.triangle_count = cloth->mesh.triangle_count;
    def.rest_positions = cloth->rest_positions;
    def.rest_uvs = cloth->rest == PERCALE_REST_UV ? cloth->mesh.uvs : NULL;
    def.layer = cloth->layer;
    def.mask = cloth->mask;
    if (percale_cloth_add(build->solver, &def, &cloth->cloth) != PERCALE_OK) {
        return fail_object(build, "cloth", cloth->mesh.name);
    }
    build->vertex_count += cloth->mesh.vertex_count;
    // Seams first: a sewn vertex that is pinned is then already one point with its partner.
    bool done = add_seams(build, cloth);
    for (uint32_t group = 0; group < cloth->pin_count && done; ++group) {
        done = add_pin_group(build, cloth, &cloth->pins[group]);
    }
    return done;
}

// ---- obstacles ----

static bool start_obstacle(const Build *build, PercaleSceneItem *obstacle)
{
    PercaleMotion *motion = &obstacle->motion;
    if (percale_motion_given(motion)) {
        percale_motion_pose(motion, 0, percale_scene_frame_rate(build->scene), &obstacle->transform,
                            build->origin, obstacle->mesh.positions);
        return true;
    }
    return obstacle->file == NULL || place_points(build, obstacle, obstacle->file, obstacle->mesh.positions);
}

// A pair keeps the mean of two thicknesses: an obstacle without one takes after the cloths.
static float common_obstacle_thickness(const PercaleScene *scene)
{
    float thickness = (float)percale_settings_number(&scene->settings, PERCALE_SET_THICKNESS);
    for (uint32_t index = 0; index < scene->cloth_count && thickness == 0.0F; ++index) {
        thickness = scene->cloths[index].thickness;
    }
    return thickness;
}

static bool add_obstacle(const Build *build, PercaleSceneItem *obstacle)
{
    const PercaleMaterial common = percale_settings_material(&build->scene->settings);
    PercaleObstacleDef def = percale_obstacle_def_default();
    if (!start_obstacle(build, obstacle)) {
        return false;
    }
    obstacle->thickness = own_or(obstacle, PERCALE_OWN_THICKNESS, common_obstacle_thickness(build->scene));
    def.name = obstacle->mesh.name;
    def.positions = obstacle->mesh.positions;
    def.vertex_count = obstacle->mesh.vertex_count;
    def.triangles = obstacle->mesh.triangles;
    def.triangle_count = obstacle->mesh.triangle_count;
    def.friction = own_or(obstacle, PERCALE_OWN_FRICTION, common.friction);
    def.thickness = obstacle->thickness;
    def.mask = obstacle->mask;
    return percale_obstacle_add(build->solver, &def, &obstacle->obstacle) == PERCALE_OK ||
           fail_object(build, "obstacle", obstacle->mesh.name);
}

// ---- the whole ----

static bool make_meshes(PercaleScene *scene, PercaleSceneError *error)
{
    if (scene->kind == NULL) {
        return true;
    }
    percale_scene_clear(scene);
    return scene->kind->make(scene, error);
}

static bool add_objects(Build *build)
{
    PercaleScene *scene = build->scene;
    for (uint32_t index = 0; index < scene->cloth_count; ++index) {
        if (!add_cloth(build, &scene->cloths[index])) {
            return false;
        }
    }
    for (uint32_t index = 0; index < percale_scene_obstacle_count(scene); ++index) {
        if (!add_obstacle(build, &scene->obstacles[index])) {
            return false;
        }
    }
    return true;
}

PercaleSolver *percale_scene_build(PercaleScene *scene, int thread_count, PercaleSceneError *error)
{
    Build build = {.scene = scene, .error = error};
    if (!percale_settings_check(&scene->settings, error) || !make_meshes(scene, error)) {
        return NULL;
    }
    percale_scene_origin(scene, build.origin);
    PercaleSolverDef def = percale_settings_solver_def(&scene->settings, thread_count);
    def.log = keep_log_line;
    def.log_user = scene;
    scene->solver_log[0] = '\0';
    const PercaleResult result = percale_solver_create(def, &build.solver);
    if (result != PERCALE_OK) {
        percale_scene_fail(error, "%s",
                           scene->solver_log[0] != '\0' ? scene->solver_log : percale_result_string(result));
        return NULL;
    }
    if (!add_objects(&build)) {
        percale_solver_destroy(build.solver);
        return NULL;
    }
    return build.solver;
}

// ---- motion ----

static bool move_pins(PercaleScene *scene, PercaleSceneItem *cloth, PercaleSolver *solver, uint32_t frame,
                      PercaleSceneError *error)
{
    double origin[3];
    percale_scene_origin(scene, origin);
    for (uint32_t index = 0; index < cloth->pin_count; ++index) {
        PercalePinGroup *group = &cloth->pins[index];
        if (!percale_motion_changes(&group->motion, frame)) {
            continue;
        }
        percale_motion_pose(&group->motion, frame, percale_scene_frame_rate(scene), &cloth->transform, origin,
                            group->targets);
        if (percale_pin_move(solver, group->pin, group->targets, 0) != PERCALE_OK) {
            return percale_scene_fail(error, "pins of cloth \"%s\": %s", cloth->mesh.name,
                                      percale_solver_last_error(solver));
        }
    }
    return true;
}

/// Velocities at a frame from those before and after it: NULL without memory.
static float *frame_velocities(PercaleScene *scene, PercaleSceneItem *obstacle, const double origin[3],
                               uint32_t frame)
{
    const double rate = percale_scene_frame_rate(scene);
    const size_t count = 3 * (size_t)obstacle->mesh.vertex_count;
    float *velocities = malloc(2 * count * sizeof *velocities);
    if (velocities == NULL) {
        return NULL;
    }
    float *before = velocities + count;
    percale_motion_pose(&obstacle->motion, frame - 1, rate, &obstacle->transform, origin, before);
    percale_motion_pose(&obstacle->motion, frame + 1, rate, &obstacle->transform, origin, velocities);
    for (size_t k = 0; k < count; ++k) {
        velocities[k] = (velocities[k] - before[k]) * (float)(0.5 * rate);
    }
    return velocities;
}

static bool move_obstacle(PercaleScene *scene, PercaleSceneItem *obstacle, PercaleSolver *solver,
                          uint32_t frame, PercaleSceneError *error)
{
    double origin[3];
    if (!percale_motion_changes(&obstacle->motion, frame)) {
        return true;
    }
    percale_scene_origin(scene, origin);
    float *velocities = NULL;
    if (percale_settings_switch(&scene->settings, PERCALE_SET_HERMITE)) {
        velocities = frame_velocities(scene, obstacle, origin, frame);
        if (velocities == NULL) {
            return percale_scene_fail(error, "obstacle \"%s\": out of memory", obstacle->mesh.name);
        }
    }
    percale_motion_pose(&obstacle->motion, frame, percale_scene_frame_rate(scene), &obstacle->transform,
                        origin, obstacle->mesh.positions);
    const PercaleResult result =
        percale_obstacle_move(solver, obstacle->obstacle, obstacle->mesh.positions, 0, velocities, 0);
    free(velocities);
    return result == PERCALE_OK || percale_scene_fail(error, "obstacle \"%s\": %s", obstacle->mesh.name,
                                                      percale_solver_last_error(solver));
}

bool percale_scene_move(PercaleScene *scene, PercaleSolver *solver, uint32_t frame, PercaleSceneError *error)
{
    if (scene->kind != NULL && scene->kind->follow != NULL && !scene->kind->follow(scene, solver, error)) {
        return false;
    }
    for (uint32_t index = 0; index < scene->cloth_count; ++index) {
        if (!move_pins(scene, &scene->cloths[index], solver, frame, error)) {
            return false;
        }
    }
    for (uint32_t index = 0; index < percale_scene_obstacle_count(scene); ++index) {
        if (!move_obstacle(scene, &scene->obstacles[index], solver, frame, error)) {
            return false;
        }
    }
    return true;
}
