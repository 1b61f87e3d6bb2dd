// solver_cloths.c: adding, reading, changing and removing cloths.

#include "solver_reading.h"

#include "model/order.h"

#include <stdlib.h>
#include <string.h>

static const float DEFAULT_THICKNESS = 0.2f; // of the median rest edge, when 0 is given

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
        return percale_measure_sides(solver, cloth->name, def->rest_uvs, 2, cloth->triangles,
                                     cloth->triangle_count, cloth->rest_lengths, cloth->rest_areas);
    }
    if (def->rest_positions == NULL) {
        return percale_measure_sides(solver, cloth->name, cloth->positions, 3, cloth->triangles,
                                     cloth->triangle_count, cloth->rest_lengths, cloth->rest_areas);
    }
    float *rest = percale_memory_new(&solver->object_memory, 3 * (size_t)cloth->vertex_count, sizeof(float));
    if (rest == NULL) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result = percale_read_points(solver, cloth->name, def->rest_positions, def->rest_stride,
                                               cloth->vertex_count, rest);
    if (result == PERCALE_OK) {
        result = percale_measure_sides(solver, cloth->name, rest, 3, cloth->triangles, cloth->triangle_count,
                                       cloth->rest_lengths, cloth->rest_areas);
    }
    percale_memory_free(&solver->object_memory, rest);
    return result;
}

static PercaleResult fill_cloth(PercaleSolver *solver, const PercaleClothDef *def, PercaleClothObject *cloth)
{
    PercaleMemory *memory = &solver->object_memory;
    memcpy(cloth->triangles, def->triangles, 3 * (size_t)def->triangle_count * sizeof(uint32_t));
    PercaleResult result = percale_read_points(solver, cloth->name, def->positions, def->position_stride,
                                               def->vertex_count, cloth->positions);
    if (result == PERCALE_OK && def->velocities != NULL) {
        result = percale_read_points(solver, cloth->name, def->velocities, def->velocity_stride,
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
        percale_check_triangles(solver, name, def->triangles, def->triangle_count, def->vertex_count);
    return result == PERCALE_OK ? percale_check_material(solver, name, &def->material) : result;
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
    percale_copy_name(object.name, def->name, "cloth", object.id);
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
    if (percale_check_array(solver, object->name, target, stride) != PERCALE_OK) {
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
        percale_read_points(solver, object->name, source, stride, object->vertex_count, points);
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
    PercaleResult result = percale_check_material(solver, object->name, &material);
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
