// solver_obstacles.c: adding, moving and removing obstacles.

#include "solver_reading.h"

#include <string.h>

PercaleObstacleDef percale_obstacle_def_default(void)
{
    return (PercaleObstacleDef){
        .size = sizeof(PercaleObstacleDef), .friction = 0.3f, .thickness = 0.002f, .mask = UINT32_MAX};
}

static const PercalePose AT_HOME = {{0.0, 0.0, 0.0, 1.0}, {0.0, 0.0, 0.0}};

static PercaleResult check_obstacle_def(PercaleSolver *solver, const PercaleObstacleDef *def)
{
    const char *name = def->name != NULL ? def->name : "obstacle";
    if (def->positions == NULL || def->triangles == NULL) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s has no positions or no triangles",
                            name);
    }
    PercaleMaterial surface = percale_material_default();
    surface.friction = def->friction;
    surface.thickness = def->thickness;
    PercaleResult result =
        percale_check_triangles(solver, name, def->triangles, def->triangle_count, def->vertex_count);
    return result == PERCALE_OK ? percale_check_material(solver, name, &surface) : result;
}

static bool allocate_obstacle(PercaleObstacleObject *obstacle, PercaleMemory *memory)
{
    obstacle->base = percale_memory_new(memory, 3 * (size_t)obstacle->vertex_count, sizeof(float));
    obstacle->from = percale_memory_new(memory, 3 * (size_t)obstacle->vertex_count, sizeof(float));
    obstacle->to = percale_memory_new(memory, 3 * (size_t)obstacle->vertex_count, sizeof(float));
    obstacle->triangles = percale_memory_new(memory, 3 * (size_t)obstacle->triangle_count, sizeof(uint32_t));
    return obstacle->base != NULL && obstacle->from != NULL && obstacle->to != NULL &&
           obstacle->triangles != NULL;
}

static PercaleResult fill_obstacle(PercaleSolver *solver, const PercaleObstacleDef *def,
                                   PercaleObstacleObject *obstacle)
{
    PercaleMemory *memory = &solver->object_memory;
    PercaleResult result = percale_read_points(solver, obstacle->name, def->positions, def->position_stride,
                                               def->vertex_count, obstacle->base);
    if (result != PERCALE_OK) {
        return result;
    }
    memcpy(obstacle->triangles, def->triangles, 3 * (size_t)def->triangle_count * sizeof(uint32_t));
    memcpy(obstacle->from, obstacle->base, 3 * (size_t)def->vertex_count * sizeof(float));
    memcpy(obstacle->to, obstacle->base, 3 * (size_t)def->vertex_count * sizeof(float));
    float *lengths = percale_memory_new(memory, 3 * (size_t)def->triangle_count, sizeof(float));
    result = lengths == NULL
                 ? percale_fail_memory(&solver->error)
                 : percale_measure_sides(solver, obstacle->name, obstacle->base, 3, obstacle->triangles,
                                         obstacle->triangle_count, lengths, NULL);
    percale_memory_free(memory, lengths);
    return result;
}

static PercaleResult add_obstacle(PercaleSolver *solver, const PercaleObstacleDef *def,
                                  PercaleObstacle *obstacle)
{
    *obstacle = (PercaleObstacle){0};
    if (def == NULL || def->size != sizeof(*def)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "the obstacle Def did not come from percale_obstacle_def_default");
    }
    PercaleResult result = check_obstacle_def(solver, def);
    if (result != PERCALE_OK) {
        return result;
    }
    PercaleObjects *objects = &solver->objects;
    PercaleMemory *memory = &solver->object_memory;
    PercaleObstacleObject object = {.id = solver->last_id + 1,
                                    .vertex_count = def->vertex_count,
                                    .triangle_count = def->triangle_count,
                                    .pose_from = AT_HOME,
                                    .pose_to = AT_HOME,
                                    .friction = def->friction,
                                    .thickness = def->thickness,
                                    .mask = def->mask};
    percale_copy_name(object.name, def->name, "obstacle", object.id);
    bool complete = percale_memory_reserve(memory, &objects->obstacles, &objects->obstacle_capacity,
                                           objects->obstacle_count + 1, sizeof(object)) &&
                    allocate_obstacle(&object, memory);
    result = complete ? fill_obstacle(solver, def, &object) : percale_fail_memory(&solver->error);
    if (result != PERCALE_OK) {
        percale_obstacle_object_free(&object, memory);
        return result;
    }
    percale_solver_release_model(solver);
    objects->obstacles[objects->obstacle_count++] = object;
    *obstacle = (PercaleObstacle){++solver->last_id};
    return PERCALE_OK;
}

PercaleResult percale_obstacle_add(PercaleSolver *solver, const PercaleObstacleDef *def,
                                   PercaleObstacle *obstacle)
{
    uint32_t mode = float_mode_enter();
    PercaleResult result = add_obstacle(solver, def, obstacle);
    float_mode_leave(mode);
    return percale_solver_logged(solver, result);
}

static size_t require_obstacle(PercaleSolver *solver, PercaleObstacle obstacle)
{
    size_t index = percale_find_obstacle(&solver->objects, obstacle);
    if (index == SIZE_MAX) {
        (void)percale_fail(&solver->error, PERCALE_INVALID_HANDLE, "there is no obstacle with handle %u",
                           obstacle.id);
    }
    return index;
}

PercaleResult percale_obstacle_remove(PercaleSolver *solver, PercaleObstacle obstacle)
{
    PercaleObjects *objects = &solver->objects;
    size_t index = require_obstacle(solver, obstacle);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    percale_solver_release_model(solver);
    percale_obstacle_object_free(&objects->obstacles[index], &solver->object_memory);
    memmove(&objects->obstacles[index], &objects->obstacles[index + 1],
            (--objects->obstacle_count - index) * sizeof(objects->obstacles[0]));
    return PERCALE_OK;
}

/// How an obstacle moves is part of how its rays are cast: a change assembles the model anew.
static void set_motion(PercaleSolver *solver, PercaleObstacleObject *object, PercaleMotion motion)
{
    if (object->motion != motion) {
        percale_solver_release_model(solver);
        object->motion = motion;
    }
    object->moving = true;
}

/// A copy of the caller's points, or NULL with the error set.
static PercaleResult copy_points(PercaleSolver *solver, const PercaleObstacleObject *object,
                                 const float *points, size_t stride, float **copy)
{
    *copy = percale_memory_new(&solver->object_memory, 3 * (size_t)object->vertex_count, sizeof(float));
    if (*copy == NULL) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result =
        percale_read_points(solver, object->name, points, stride, object->vertex_count, *copy);
    if (result != PERCALE_OK) {
        percale_memory_free(&solver->object_memory, *copy);
        *copy = NULL;
    }
    return result;
}

static PercaleResult move_obstacle(PercaleSolver *solver, size_t index, const float *positions, size_t stride,
                                   const float *velocities, size_t velocity_stride)
{
    PercaleObstacleObject *object = &solver->objects.obstacles[index];
    if (object->motion == MOTION_RIGID) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "%s was moved by percale_obstacle_set_transform: it can't be deformed",
                            object->name);
    }
    float *target;
    float *velocity = NULL;
    PercaleResult result = copy_points(solver, object, positions, stride, &target);
    if (result == PERCALE_OK && velocities != NULL) {
        result = copy_points(solver, object, velocities, velocity_stride, &velocity);
    }
    if (result != PERCALE_OK) {
        percale_memory_free(&solver->object_memory, target);
        return result;
    }
    set_motion(solver, object, MOTION_DEFORMING);
    percale_memory_free(&solver->object_memory, object->to);
    percale_memory_free(&solver->object_memory, object->velocity_to);
    object->to = target;
    object->velocity_to = velocity;
    return PERCALE_OK;
}

PercaleResult percale_obstacle_move(PercaleSolver *solver, PercaleObstacle obstacle, const float *positions,
                                    size_t stride, const float *velocities, size_t velocity_stride)
{
    size_t index = require_obstacle(solver, obstacle);
    return percale_solver_logged(solver, index == SIZE_MAX ? PERCALE_INVALID_HANDLE
                                                           : move_obstacle(solver, index, positions, stride,
                                                                           velocities, velocity_stride));
}

static PercaleResult turn_obstacle(PercaleSolver *solver, size_t index, const double rotation[4],
                                   const double translation[3])
{
    PercaleObstacleObject *object = &solver->objects.obstacles[index];
    if (object->motion == MOTION_DEFORMING) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "%s was moved by percale_obstacle_move: it can't be moved rigidly", object->name);
    }
    double norm2 = 0.0;
    bool near = rotation != NULL && translation != NULL;
    for (int k = 0; near && k < 4; k++) {
        norm2 += rotation[k] * rotation[k];
    }
    for (int axis = 0; axis < 3; axis++) {
        near = near && fabs(translation[axis]) <= (double)FARTHEST; // no for NaN
    }
    if (!near || !(norm2 > 1e-12) || !(norm2 < 1e12)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s: the transform is not usable",
                            object->name);
    }
    set_motion(solver, object, MOTION_RIGID);
    for (int k = 0; k < 4; k++) {
        object->pose_to.rotation[k] = rotation[k] / sqrt(norm2);
    }
    memcpy(object->pose_to.translation, translation, sizeof(object->pose_to.translation));
    return PERCALE_OK;
}

PercaleResult percale_obstacle_set_transform(PercaleSolver *solver, PercaleObstacle obstacle,
                                             const double rotation[4], const double translation[3])
{
    size_t index = require_obstacle(solver, obstacle);
    uint32_t mode = float_mode_enter();
    PercaleResult result =
        index == SIZE_MAX ? PERCALE_INVALID_HANDLE : turn_obstacle(solver, index, rotation, translation);
    float_mode_leave(mode);
    return percale_solver_logged(solver, result);
}
