// solver_reading.c: what the caller gives, checked and copied.

#include "solver_reading.h"

#include <stdio.h>
#include <string.h>

static const double FLATTEST = 1e-12; // (2 area / longest side^2)^2 of a triangle below which it has no area

static void read_point(const void *source, size_t stride, size_t index, float point[3])
{
    memcpy(point, (const char *)source + index * (stride == 0 ? 3 * sizeof(float) : stride),
           3 * sizeof(float));
}

PercaleResult percale_check_array(PercaleSolver *solver, const char *what, const float *array, size_t stride)
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

PercaleResult percale_read_points(PercaleSolver *solver, const char *what, const float *source, size_t stride,
                                  uint32_t count, float *points)
{
    if (percale_check_array(solver, what, source, stride) != PERCALE_OK) {
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

PercaleResult percale_check_triangles(PercaleSolver *solver, const char *what, const uint32_t *triangles,
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

PercaleResult percale_measure_sides(PercaleSolver *solver, const char *what, const float *shape,
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

PercaleResult percale_check_material(PercaleSolver *solver, const char *what, const PercaleMaterial *material)
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

void percale_copy_name(char target[NAME_SIZE], const char *name, const char *kind, uint32_t id)
{
    if (name != NULL && name[0] != '\0') {
        (void)snprintf(target, NAME_SIZE, "%s", name);
    } else {
        (void)snprintf(target, NAME_SIZE, "%s %u", kind, id);
    }
}
