// solver_objects.c: adding, changing and removing cloths and obstacles, with every check on the caller's
// data.

#include "solver.h"

#include "base/parallel.h"
#include "model/order.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float FARTHEST =
    1e6f; // m from the origin; beyond it float32 has no millimetres left: use `origin`
static const double FLATTEST = 1e-12; // (2 area / longest side^2)^2 of a triangle below which it has no area
static const float DEFAULT_THICKNESS = 0.2f; // of the median rest edge, when 0 is given

// ---- reading the caller's arrays ----

static void read_point(const void *source, size_t stride, size_t index, float point[3])
{
    memcpy(point, (const char *)source + index * (stride == 0 ? 3 * sizeof(float) : stride),
           3 * sizeof(float));
}

static PercaleResult check_array(PercaleSolver *solver, const char *what, const float *array, size_t stride)
{
    if (array == NULL) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s: there is no array", what);
    }
    if (stride != 0 && stride < 3 * sizeof(float)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "%s: a stride of %zu bytes is less than a point's 12", what, stride);
    }
    return PERCALE_OK;
}

PercaleResult percale_solver_read_points(PercaleSolver *solver, const char *what, const float *source,
                                         size_t stride, uint32_t count, float *points)
{
    if (check_array(solver, what, source, stride) != PERCALE_OK) {
        return PERCALE_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < count; i++) {
        float *point = points + 3 * (size_t)i;
        read_point(source, stride, i, point);
        for (int axis = 0; axis < 3; axis++) {
            if (!isfinite(point[axis])) {
                return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s: vertex %u is not finite",
                                    what, i);
            }
            if (fabsf(point[axis]) > FARTHEST) {
                return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                    "%s: vertex %u is more than 1e6 from the origin", what, i);
            }
        }
    }
    return PERCALE_OK;
}

static PercaleResult check_triangles(PercaleSolver *solver, const char *what, const uint32_t *triangles,
                                     uint32_t triangle_count, uint32_t vertex_count)
{
    if (vertex_count == 0 || triangle_count == 0) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "%s is empty: %u vertices, %u triangles", what, vertex_count, triangle_count);
    }
    uint64_t vertex_total = vertex_count;
    uint64_t triangle_total = triangle_count;
    for (size_t i = 0; i < solver->objects.cloth_count; i++) {
        vertex_total += solver->objects.cloths[i].vertex_count;
        triangle_total += solver->objects.cloths[i].triangle_count;
    }
    for (size_t i = 0; i < solver->objects.obstacle_count; i++) {
        vertex_total += solver->objects.obstacles[i].vertex_count;
    }
    if (vertex_total > POINTS_MAX || triangle_total > UINT32_MAX / 8) { // all indices are 32-bit
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s is too large", what);
    }
    for (uint32_t t = 0; t < triangle_count; t++) {
        const uint32_t *v = triangles + 3 * (size_t)t;
        for (int k = 0; k < 3; k++) {
            if (v[k] >= vertex_count) {
                return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                    "%s: triangle %u names vertex %u, but there are %u", what, t, v[k],
                                    vertex_count);
            }
        }
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
            return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                "%s: triangle %u names a vertex twice", what, t);
        }
    }
    return PERCALE_OK;
}

/// Lengths of all triangle sides in a shape of 2 or 3 floats a vertex, and areas where asked for; refuses
/// triangles without area.
static PercaleResult measure_sides(PercaleSolver *solver, const char *what, const float *shape,
                                   uint32_t dimensions, const uint32_t *triangles, uint32_t triangle_count,
                                   float *lengths, double *areas)
{
    for (uint32_t t = 0; t < triangle_count; t++) {
        Vec3 corner[3];
        double longest2 = 0.0;
        for (int k = 0; k < 3; k++) {
            const float *p = shape + (size_t)dimensions * triangles[3 * (size_t)t + (size_t)k];
            corner[k] = vec3((double)p[0], (double)p[1], dimensions == 3 ? (double)p[2] : 0.0);
        }
        for (int k = 0; k < 3; k++) {
            Vec3 side = vsub(corner[(k + 1) % 3], corner[k]);
            longest2 = vdot(side, side) > longest2 ? vdot(side, side) : longest2;
            lengths[3 * (size_t)t + (size_t)k] = (float)vlength(side);
        }
        Vec3 normal = vcross(vsub(corner[1], corner[0]), vsub(corner[2], corner[0]));
        if (areas != NULL) {
            areas[t] = 0.5 * vlength(normal);
        }
        if (!(vdot(normal, normal) > FLATTEST * longest2 * longest2)) {
            return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s: triangle %u has no area", what,
                                t);
        }
    }
    return PERCALE_OK;
}

static PercaleResult check_material(PercaleSolver *solver, const char *what, const PercaleMaterial *material)
{
    const struct {
        const char *name;
        float value;
        bool positive;
    } NUMBERS[] = {
        {"density", material->density, true},
        {"stretch compliance", material->stretch_compliance, false},
        {"bending stiffness", material->bending_stiffness, false},
        {"thickness", material->thickness, false},
        {"friction", material->friction, false},
    };
    for (size_t i = 0; i < sizeof(NUMBERS) / sizeof(NUMBERS[0]); i++) {
        float value = NUMBERS[i].value;
        if (!isfinite(value) || value < 0.0f || (NUMBERS[i].positive && value <= 0.0f)) {
            return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s: %s %g is not %s 0", what,
                                NUMBERS[i].name, (double)value, NUMBERS[i].positive ? ">" : ">=");
        }
    }
    if (material->density < 1e-6f || material->density > 1e6f) { // else inverse masses leave float32's range
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s: density %g is not in 1e-6 .. 1e6",
                            what, (double)material->density);
    }
    return PERCALE_OK;
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a;
    float y = *(const float *)b;
    return (x > y) - (x < y);
}

static float median_of(const float *values, size_t count, PercaleMemory *memory)
{
    float *sorted = percale_memory_new(memory, count, sizeof(float));
    if (sorted == NULL) {
        return -1.0f;
    }
    memcpy(sorted, values, count * sizeof(float));
    qsort(sorted, count, sizeof(float), compare_floats);
    float median = sorted[count / 2];
    percale_memory_free(memory, sorted);
    return median;
}

static void copy_name(char target[NAME_SIZE], const char *name, const char *kind, uint32_t id)
{
    if (name != NULL && name[0] != '\0') {
        (void)snprintf(target, NAME_SIZE, "%s", name);
    } else {
        (void)snprintf(target, NAME_SIZE, "%s %u", kind, id);
    }
}

// ---- cloth ----

PercaleMaterial percale_material_default(void)
{
    return (PercaleMaterial){.density = 0.2f,
                             .stretch_compliance = 0.0f,
                             .bending_stiffness = 1e-6f,
                             .thickness = 0.0f,
                             .friction = 0.3f};
}

PercaleClothDef percale_cloth_def_default(void)
{
    return (PercaleClothDef){
        .size = sizeof(PercaleClothDef), .material = percale_material_default(), .mask = UINT32_MAX};
}

static bool allocate_cloth(PercaleClothObject *cloth, PercaleMemory *memory)
{
    cloth->positions = percale_memory_new(memory, 3 * (size_t)cloth->vertex_count, sizeof(float));
    cloth->velocities = percale_memory_new(memory, 3 * (size_t)cloth->vertex_count, sizeof(float));
    cloth->triangles = percale_memory_new(memory, 3 * (size_t)cloth->triangle_count, sizeof(uint32_t));
    cloth->rest_areas = percale_memory_new(memory, cloth->triangle_count, sizeof(double));
    cloth->rest_lengths = percale_memory_new(memory, 3 * (size_t)cloth->triangle_count, sizeof(float));
    cloth->curve = percale_memory_new(memory, cloth->vertex_count, sizeof(uint32_t));
    return cloth->positions != NULL && cloth->velocities != NULL && cloth->triangles != NULL &&
           cloth->rest_lengths != NULL && cloth->rest_areas != NULL && cloth->curve != NULL;
}

/// Rest side lengths from the pattern, the rest positions or the start, whichever is given.
static PercaleResult read_rest_shape(PercaleSolver *solver, const PercaleClothDef *def,
                                     PercaleClothObject *cloth)
{
    if (def->rest_uvs != NULL) {
        for (size_t i = 0; i < 2 * (size_t)def->vertex_count; i++) {
            if (!(fabsf(def->rest_uvs[i]) <= FARTHEST)) {
                return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                    "%s: the rest UV of vertex %zu is not finite or too large", cloth->name,
                                    i / 2);
            }
        }
        return measure_sides(solver, cloth->name, def->rest_uvs, 2, cloth->triangles, cloth->triangle_count,
                             cloth->rest_lengths, cloth->rest_areas);
    }
    if (def->rest_positions == NULL) {
        return measure_sides(solver, cloth->name, cloth->positions, 3, cloth->triangles,
                             cloth->triangle_count, cloth->rest_lengths, cloth->rest_areas);
    }
    float *rest = percale_memory_new(&solver->object_memory, 3 * (size_t)cloth->vertex_count, sizeof(float));
    if (rest == NULL) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result = percale_solver_read_points(solver, cloth->name, def->rest_positions,
                                                      def->rest_stride, cloth->vertex_count, rest);
    if (result == PERCALE_OK) {
        result = measure_sides(solver, cloth->name, rest, 3, cloth->triangles, cloth->triangle_count,
                               cloth->rest_lengths, cloth->rest_areas);
    }
    percale_memory_free(&solver->object_memory, rest);
    return result;
}

static PercaleResult fill_cloth(PercaleSolver *solver, const PercaleClothDef *def, PercaleClothObject *cloth)
{
    PercaleMemory *memory = &solver->object_memory;
    memcpy(cloth->triangles, def->triangles, 3 * (size_t)def->triangle_count * sizeof(uint32_t));
    PercaleResult result = percale_solver_read_points(
        solver, cloth->name, def->positions, def->position_stride, def->vertex_count, cloth->positions);
    if (result == PERCALE_OK && def->velocities != NULL) {
        result = percale_solver_read_points(solver, cloth->name, def->velocities, def->velocity_stride,
                                            def->vertex_count, cloth->velocities);
    }
    if (result == PERCALE_OK) {
        result = read_rest_shape(solver, def, cloth);
    }
    if (result != PERCALE_OK) {
        return result;
    }
    if (cloth->material.thickness <= 0.0f) {
        cloth->material.thickness =
            DEFAULT_THICKNESS * median_of(cloth->rest_lengths, 3 * (size_t)cloth->triangle_count, memory);
    }
    bool complete = cloth->material.thickness >= 0.0f &&
                    percale_order_along_curve(cloth->positions, cloth->vertex_count, memory, cloth->curve);
    return complete ? PERCALE_OK : percale_fail_memory(&solver->error);
}

static PercaleResult check_cloth_def(PercaleSolver *solver, const PercaleClothDef *def)
{
    const char *name = def->name != NULL ? def->name : "cloth";
    if (def->positions == NULL || def->triangles == NULL) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "%s has no positions or no triangles",
                            name);
    }
    PercaleResult result =
        check_triangles(solver, name, def->triangles, def->triangle_count, def->vertex_count);
    return result == PERCALE_OK ? check_material(solver, name, &def->material) : result;
}

static PercaleResult add_cloth(PercaleSolver *solver, const PercaleClothDef *def, PercaleCloth *cloth)
{
    *cloth = (PercaleCloth){0};
    if (def == NULL || def->size != sizeof(*def)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "the cloth Def did not come from percale_cloth_def_default");
    }
    PercaleResult result = check_cloth_def(solver, def);
    if (result != PERCALE_OK) {
        return result;
    }
    PercaleObjects *objects = &solver->objects;
    PercaleMemory *memory = &solver->object_memory;
    PercaleClothObject object = {.id = solver->last_id + 1,
                                 .vertex_count = def->vertex_count,
                                 .triangle_count = def->triangle_count,
                                 .material = def->material,
                                 .layer = def->layer,
                                 .mask = def->mask};
    copy_name(object.name, def->name, "cloth", object.id);
    bool complete = percale_memory_reserve(memory, &objects->cloths, &objects->cloth_capacity,
                                           objects->cloth_count + 1, sizeof(object)) &&
                    allocate_cloth(&object, memory);
    result = complete ? fill_cloth(solver, def, &object) : percale_fail_memory(&solver->error);
    if (result != PERCALE_OK) {
        percale_cloth_object_free(&object, memory);
        return result;
    }
    percale_solver_release_model(solver);
    objects->cloths[objects->cloth_count++] = object;
    *cloth = (PercaleCloth){++solver->last_id};
    return PERCALE_OK;
}

PercaleResult percale_cloth_add(PercaleSolver *solver, const PercaleClothDef *def, PercaleCloth *cloth)
{
    uint32_t mode = float_mode_enter(); // the same rest shape, however the host rounds
    PercaleResult result = add_cloth(solver, def, cloth);
    float_mode_leave(mode);
    return percale_solver_logged(solver, result);
}

PercaleResult percale_cloth_remove(PercaleSolver *solver, PercaleCloth cloth)
{
    PercaleObjects *objects = &solver->objects;
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    percale_solver_release_model(solver);
    for (size_t i = objects->pin_count; i-- > 0;) {
        if (objects->pins[i].cloth.id == cloth.id) {
            (void)percale_pin_remove(solver, (PercalePin){objects->pins[i].id});
        }
    }
    for (size_t i = objects->seam_count; i-- > 0;) {
        if (objects->seams[i].cloth_a.id == cloth.id || objects->seams[i].cloth_b.id == cloth.id) {
            (void)percale_seam_remove(solver, (PercaleSeam){objects->seams[i].id});
        }
    }
    percale_cloth_object_free(&objects->cloths[index], &solver->object_memory);
    memmove(&objects->cloths[index], &objects->cloths[index + 1],
            (--objects->cloth_count - index) * sizeof(objects->cloths[0]));
    return PERCALE_OK;
}

/// Copies one vector per vertex of the assembled model, in which sewn vertices agree.
static PercaleResult copy_out(PercaleSolver *solver, PercaleCloth cloth, bool velocities, float *target,
                              size_t stride)
{
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    const PercaleClothObject *object = &solver->objects.cloths[index];
    if (check_array(solver, object->name, target, stride) != PERCALE_OK) {
        return percale_solver_logged(solver, PERCALE_INVALID_ARGUMENT);
    }
    PercaleResult result = percale_solver_prepare(solver);
    if (result != PERCALE_OK) {
        return percale_solver_logged(solver, result);
    }
    const f32x4 *state = velocities ? solver->model.velocity : solver->model.position;
    for (size_t i = 0; i < object->vertex_count; i++) {
        char *to = (char *)target + i * (stride == 0 ? 3 * sizeof(float) : stride);
        memcpy(to, &state[solver->model.cloths[index].slots[i]], 3 * sizeof(float));
    }
    return PERCALE_OK;
}

PercaleResult percale_cloth_get_positions(PercaleSolver *solver, PercaleCloth cloth, float *positions,
                                          size_t stride)
{
    return copy_out(solver, cloth, false, positions, stride);
}

PercaleResult percale_cloth_get_velocities(PercaleSolver *solver, PercaleCloth cloth, float *velocities,
                                           size_t stride)
{
    return copy_out(solver, cloth, true, velocities, stride);
}

/// Replaces positions or velocities; all of them or, on a bad one, none.
static PercaleResult copy_in(PercaleSolver *solver, PercaleCloth cloth, bool velocities, const float *source,
                             size_t stride)
{
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return PERCALE_INVALID_HANDLE;
    }
    PercaleClothObject *object = &solver->objects.cloths[index];
    float *points =
        percale_memory_new(&solver->object_memory, 3 * (size_t)object->vertex_count, sizeof(float));
    if (points == NULL) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result =
        percale_solver_read_points(solver, object->name, source, stride, object->vertex_count, points);
    if (result != PERCALE_OK) {
        percale_memory_free(&solver->object_memory, points);
        return result;
    }
    percale_solver_release_model(solver);
    percale_memory_free(&solver->object_memory, velocities ? object->velocities : object->positions);
    *(velocities ? &object->velocities : &object->positions) = points;
    return PERCALE_OK;
}

PercaleResult percale_cloth_set_positions(PercaleSolver *solver, PercaleCloth cloth, const float *positions,
                                          size_t stride)
{
    return percale_solver_logged(solver, copy_in(solver, cloth, false, positions, stride));
}

PercaleResult percale_cloth_set_velocities(PercaleSolver *solver, PercaleCloth cloth, const float *velocities,
                                           size_t stride)
{
    return percale_solver_logged(solver, copy_in(solver, cloth, true, velocities, stride));
}

PercaleResult percale_cloth_view(PercaleSolver *solver, PercaleCloth cloth, PercaleClothView *view)
{
    *view = (PercaleClothView){0};
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    PercaleResult result = percale_solver_prepare(solver);
    if (result == PERCALE_OK) {
        *view =
            (PercaleClothView){(const float *)solver->model.position, (const float *)solver->model.velocity,
                               solver->model.cloths[index].slots, solver->model.cloths[index].vertex_count};
    }
    return percale_solver_logged(solver, result);
}

PercaleResult percale_cloth_set_material(PercaleSolver *solver, PercaleCloth cloth, PercaleMaterial material)
{
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    PercaleClothObject *object = &solver->objects.cloths[index];
    PercaleResult result = check_material(solver, object->name, &material);
    if (result == PERCALE_OK) {
        percale_solver_release_model(solver);
        float before = object->material.thickness;
        object->material = material;
        object->material.thickness = material.thickness > 0.0f ? material.thickness : before;
    }
    return percale_solver_logged(solver, result);
}

PercaleResult percale_cloth_set_layer(PercaleSolver *solver, PercaleCloth cloth, int32_t layer)
{
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    percale_solver_release_model(solver);
    solver->objects.cloths[index].layer = layer;
    return PERCALE_OK;
}

PercaleResult percale_cloth_set_mask(PercaleSolver *solver, PercaleCloth cloth, uint32_t mask)
{
    size_t index = percale_solver_require_cloth(solver, cloth);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    percale_solver_release_model(solver);
    solver->objects.cloths[index].mask = mask;
    return PERCALE_OK;
}

// ---- obstacle ----

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
        check_triangles(solver, name, def->triangles, def->triangle_count, def->vertex_count);
    return result == PERCALE_OK ? check_material(solver, name, &surface) : result;
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
    PercaleResult result = percale_solver_read_points(
        solver, obstacle->name, def->positions, def->position_stride, def->vertex_count, obstacle->base);
    if (result != PERCALE_OK) {
        return result;
    }
    memcpy(obstacle->triangles, def->triangles, 3 * (size_t)def->triangle_count * sizeof(uint32_t));
    memcpy(obstacle->from, obstacle->base, 3 * (size_t)def->vertex_count * sizeof(float));
    memcpy(obstacle->to, obstacle->base, 3 * (size_t)def->vertex_count * sizeof(float));
    float *lengths = percale_memory_new(memory, 3 * (size_t)def->triangle_count, sizeof(float));
    result = lengths == NULL ? percale_fail_memory(&solver->error)
                             : measure_sides(solver, obstacle->name, obstacle->base, 3, obstacle->triangles,
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
    copy_name(object.name, def->name, "obstacle", object.id);
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
        percale_solver_read_points(solver, object->name, points, stride, object->vertex_count, *copy);
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
