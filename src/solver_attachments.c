// solver_attachments.c: pins and seams, and the quality of the present state.

#include "solver_reading.h"

#include "audit/audit.h"

#include <stdio.h>

#include <string.h>

/// Copies vertex indices that must exist in the cloth.
static PercaleResult read_vertices(PercaleSolver *solver, const char *kind, const PercaleClothObject *cloth,
                                   const uint32_t *source, uint32_t count, uint32_t *vertices)
{
    for (uint32_t i = 0; i < count; i++) {
        if (source[i] >= cloth->vertex_count) {
            return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                "%s: vertex %u is out of range, cloth '%s' has %u", kind, source[i],
                                cloth->name, cloth->vertex_count);
        }
        vertices[i] = source[i];
    }
    return PERCALE_OK;
}

// ---- pins ----

PercalePinDef percale_pin_def_default(void)
{
    return (PercalePinDef){.size = sizeof(PercalePinDef)};
}

/// Where the pinned vertices are now.
static PercaleResult read_present_targets(PercaleSolver *solver, const PercaleClothObject *cloth,
                                          PercalePinObject *pin)
{
    float *positions =
        percale_memory_new(&solver->object_memory, 3 * (size_t)cloth->vertex_count, sizeof(float));
    if (positions == NULL) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result = percale_cloth_get_positions(solver, pin->cloth, positions, 0);
    for (size_t i = 0; i < pin->vertex_count; i++) {
        memcpy(pin->to + 3 * i, positions + 3 * (size_t)pin->vertices[i], 3 * sizeof(float));
    }
    percale_memory_free(&solver->object_memory, positions);
    return result;
}

static PercaleResult fill_pin(PercaleSolver *solver, const PercalePinDef *def,
                              const PercaleClothObject *cloth, PercalePinObject *pin)
{
    PercaleMemory *memory = &solver->object_memory;
    pin->vertices = percale_memory_new(memory, def->vertex_count, sizeof(uint32_t));
    pin->to = percale_memory_new(memory, 3 * (size_t)def->vertex_count, sizeof(float));
    if (pin->vertices == NULL || pin->to == NULL ||
        !percale_memory_reserve(memory, &solver->objects.pins, &solver->objects.pin_capacity,
                                solver->objects.pin_count + 1, sizeof(*pin))) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result =
        read_vertices(solver, "pin", cloth, def->vertices, def->vertex_count, pin->vertices);
    if (result != PERCALE_OK) {
        return result;
    }
    return def->targets == NULL ? read_present_targets(solver, cloth, pin)
                                : percale_read_points(solver, "pin targets", def->targets, def->target_stride,
                                                      def->vertex_count, pin->to);
}

static PercaleResult add_pin(PercaleSolver *solver, const PercalePinDef *def, PercalePin *pin)
{
    *pin = (PercalePin){0};
    if (def == NULL || def->size != sizeof(*def) || def->vertices == NULL || def->vertex_count == 0) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "the pin Def has no vertices or did not come from percale_pin_def_default");
    }
    size_t cloth = percale_solver_require_cloth(solver, def->cloth);
    if (cloth == SIZE_MAX) {
        return PERCALE_INVALID_HANDLE;
    }
    PercalePinObject object = {
        .id = solver->last_id + 1, .cloth = def->cloth, .vertex_count = def->vertex_count};
    PercaleResult result = fill_pin(solver, def, &solver->objects.cloths[cloth], &object);
    if (result != PERCALE_OK) {
        percale_pin_object_free(&object, &solver->object_memory);
        return result;
    }
    percale_solver_release_model(solver);
    solver->objects.pins[solver->objects.pin_count++] = object;
    *pin = (PercalePin){++solver->last_id};
    return PERCALE_OK;
}

PercaleResult percale_pin_add(PercaleSolver *solver, const PercalePinDef *def, PercalePin *pin)
{
    return percale_solver_logged(solver, add_pin(solver, def, pin));
}

static size_t require_pin(PercaleSolver *solver, PercalePin pin)
{
    for (size_t i = 0; i < solver->objects.pin_count; i++) {
        if (solver->objects.pins[i].id == pin.id) {
            return i;
        }
    }
    (void)percale_fail(&solver->error, PERCALE_INVALID_HANDLE, "there is no pin with handle %u", pin.id);
    return SIZE_MAX;
}

PercaleResult percale_pin_remove(PercaleSolver *solver, PercalePin pin)
{
    PercaleObjects *objects = &solver->objects;
    size_t index = require_pin(solver, pin);
    if (index == SIZE_MAX) {
        return percale_solver_logged(solver, PERCALE_INVALID_HANDLE);
    }
    percale_solver_release_model(solver);
    percale_pin_object_free(&objects->pins[index], &solver->object_memory);
    memmove(&objects->pins[index], &objects->pins[index + 1],
            (--objects->pin_count - index) * sizeof(objects->pins[0]));
    return PERCALE_OK;
}

static PercaleResult move_pin(PercaleSolver *solver, size_t index, const float *targets, size_t stride)
{
    PercalePinObject *pin = &solver->objects.pins[index];
    float *to = percale_memory_new(&solver->object_memory, 3 * (size_t)pin->vertex_count, sizeof(float));
    if (to == NULL) {
        return percale_fail_memory(&solver->error);
    }
    PercaleResult result = percale_read_points(solver, "pin targets", targets, stride, pin->vertex_count, to);
    percale_memory_free(&solver->object_memory, result == PERCALE_OK ? pin->to : to);
    pin->to = result == PERCALE_OK ? to : pin->to;
    return result;
}

PercaleResult percale_pin_move(PercaleSolver *solver, PercalePin pin, const float *targets, size_t stride)
{
    size_t index = require_pin(solver, pin);
    return percale_solver_logged(solver, index == SIZE_MAX ? PERCALE_INVALID_HANDLE
                                                           : move_pin(solver, index, targets, stride));
}

// ---- seams ----

PercaleSeamDef percale_seam_def_default(void)
{
    return (PercaleSeamDef){.size = sizeof(PercaleSeamDef)};
}

static PercaleResult fill_seam(PercaleSolver *solver, const PercaleSeamDef *def, PercaleSeamObject *seam)
{
    PercaleMemory *memory = &solver->object_memory;
    seam->vertices_a = percale_memory_new(memory, def->pair_count, sizeof(uint32_t));
    seam->vertices_b = percale_memory_new(memory, def->pair_count, sizeof(uint32_t));
    seam->welded = percale_memory_new(memory, def->pair_count, sizeof(bool));
    if (seam->vertices_a == NULL || seam->vertices_b == NULL || seam->welded == NULL ||
        !percale_memory_reserve(memory, &solver->objects.seams, &solver->objects.seam_capacity,
                                solver->objects.seam_count + 1, sizeof(*seam))) {
        return percale_fail_memory(&solver->error);
    }
    size_t index_a = percale_solver_require_cloth(solver, def->cloth_a);
    size_t index_b = percale_solver_require_cloth(solver, def->cloth_b);
    if (index_a == SIZE_MAX || index_b == SIZE_MAX) {
        return PERCALE_INVALID_HANDLE;
    }
    const PercaleClothObject *a = &solver->objects.cloths[index_a];
    const PercaleClothObject *b = &solver->objects.cloths[index_b];
    PercaleResult result =
        read_vertices(solver, "seam", a, def->vertices_a, def->pair_count, seam->vertices_a);
    if (result == PERCALE_OK) {
        result = read_vertices(solver, "seam", b, def->vertices_b, def->pair_count, seam->vertices_b);
    }
    for (uint32_t i = 0; result == PERCALE_OK && i < def->pair_count; i++) {
        if (a == b && seam->vertices_a[i] == seam->vertices_b[i]) {
            result = percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                  "seam: pair %u sews vertex %u to itself", i, seam->vertices_a[i]);
        }
    }
    return result;
}

static PercaleResult add_seam(PercaleSolver *solver, const PercaleSeamDef *def, PercaleSeam *seam)
{
    *seam = (PercaleSeam){0};
    if (def == NULL || def->size != sizeof(*def) || def->vertices_a == NULL || def->vertices_b == NULL ||
        def->pair_count == 0) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                            "the seam Def has no pairs or did not come from percale_seam_def_default");
    }
    PercaleSeamObject object = {.id = solver->last_id + 1,
                                .cloth_a = def->cloth_a,
                                .cloth_b = def->cloth_b,
                                .pair_count = def->pair_count};
    PercaleResult result = fill_seam(solver, def, &object);
    if (result != PERCALE_OK) {
        percale_seam_object_free(&object, &solver->object_memory);
        return result;
    }
    percale_solver_release_model(solver);
    solver->objects.seams[solver->objects.seam_count++] = object;
    *seam = (PercaleSeam){++solver->last_id};
    return PERCALE_OK;
}

PercaleResult percale_seam_add(PercaleSolver *solver, const PercaleSeamDef *def, PercaleSeam *seam)
{
    return percale_solver_logged(solver, add_seam(solver, def, seam));
}

PercaleResult percale_seam_remove(PercaleSolver *solver, PercaleSeam seam)
{
    PercaleObjects *objects = &solver->objects;
    for (size_t i = 0; i < objects->seam_count; i++) {
        if (objects->seams[i].id == seam.id) {
            percale_solver_release_model(solver);
            percale_seam_object_free(&objects->seams[i], &solver->object_memory);
            memmove(&objects->seams[i], &objects->seams[i + 1],
                    (--objects->seam_count - i) * sizeof(objects->seams[0]));
            return PERCALE_OK;
        }
    }
    return percale_solver_logged(solver, percale_fail(&solver->error, PERCALE_INVALID_HANDLE,
                                                      "there is no seam with handle %u", seam.id));
}

// ---- quality ----

/// A cloth's positions as packed floats in the arena; its weld numbers are the model's slots.
static PercaleResult audit_cloth(PercaleSolver *solver, uint32_t index, PercaleAuditMesh *mesh)
{
    const PercaleClothObject *cloth = &solver->objects.cloths[index];
    float *positions = percale_arena_new(&solver->arena, 3 * (size_t)cloth->vertex_count, sizeof(float));
    if (positions == NULL) {
        return percale_fail_memory(&solver->error);
    }
    *mesh = (PercaleAuditMesh){positions,
                               cloth->vertex_count,
                               cloth->triangles,
                               cloth->triangle_count,
                               cloth->rest_lengths,
                               solver->model.cloths[index].slots,
                               cloth->material.thickness,
                               cloth->mask};
    return percale_cloth_get_positions(solver, (PercaleCloth){cloth->id}, positions, 0);
}

static PercaleResult audit_obstacle(PercaleSolver *solver, uint32_t index, PercaleAuditMesh *mesh)
{
    const PercaleObstacleObject *obstacle = &solver->objects.obstacles[index];
    float *positions = percale_arena_new(&solver->arena, 3 * (size_t)obstacle->vertex_count, sizeof(float));
    if (positions == NULL) {
        return percale_fail_memory(&solver->error);
    }
    const f32x4 *points = solver->model.position + solver->model.obstacles[index].first_point;
    for (size_t i = 0; i < obstacle->vertex_count; i++) {
        memcpy(positions + 3 * i, &points[i], 3 * sizeof(float));
    }
    *mesh = (PercaleAuditMesh){.positions = positions,
                               .vertex_count = obstacle->vertex_count,
                               .triangles = obstacle->triangles,
                               .triangle_count = obstacle->triangle_count,
                               .thickness = obstacle->thickness,
                               .mask = obstacle->mask};
    return PERCALE_OK;
}

/// Tells the log which triangles cross deepest.
static void log_crossing(PercaleSolver *solver, const PercaleQuality *quality,
                         const PercaleAuditCrossing *deepest)
{
    if (!(deepest->depth > 0.0) || solver->def.log == NULL) {
        return;
    }
    const PercaleObjects *objects = &solver->objects;
    const char *other =
        deepest->is_obstacle ? objects->obstacles[deepest->other].name : objects->cloths[deepest->other].name;
    char line[512];
    (void)snprintf(line, sizeof(line),
                   "%.0f pairs of triangles cross; deepest, by %.3g mm: %u of %s and %u of %s",
                   quality->ef_cloth_cloth + quality->ef_cloth_obstacle, 1e3 * deepest->depth,
                   deepest->triangle, objects->cloths[deepest->cloth].name, deepest->other_triangle, other);
    solver->def.log(solver->def.log_user, line);
}

PercaleResult percale_solver_quality(PercaleSolver *solver, PercaleQuality *quality)
{
    PercaleResult result = percale_solver_prepare(solver);
    if (result != PERCALE_OK) {
        return percale_solver_logged(solver, result);
    }
    uint32_t cloth_count = solver->model.cloth_count;
    uint32_t obstacle_count = solver->model.obstacle_count;
    percale_arena_reset(&solver->arena);
    PercaleAuditMesh *meshes =
        percale_arena_new(&solver->arena, cloth_count + obstacle_count, sizeof(meshes[0]));
    if (meshes == NULL) {
        return percale_solver_logged(solver, percale_fail_memory(&solver->error));
    }
    for (uint32_t i = 0; result == PERCALE_OK && i < cloth_count + obstacle_count; i++) {
        result = i < cloth_count ? audit_cloth(solver, i, &meshes[i])
                                 : audit_obstacle(solver, i - cloth_count, &meshes[i]);
    }
    if (result == PERCALE_OK) {
        PercaleAuditMemory memory = {solver->allocator.allocate, solver->allocator.release,
                                     solver->allocator.user};
        PercaleAuditCrossing deepest = {.depth = 0.0};
        result = percale_audit_with(memory, meshes, cloth_count, meshes + cloth_count, obstacle_count,
                                    quality, &deepest);
        log_crossing(solver, quality, &deepest);
        result = result == PERCALE_OUT_OF_MEMORY ? percale_fail_memory(&solver->error) : result;
    }
    return percale_solver_logged(solver, result);
}
