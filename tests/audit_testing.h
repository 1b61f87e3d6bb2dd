// audit_testing.h: what the tests of the audit share: meshes as the audit sees them, and plain vectors for
// the slow twins.

#ifndef PERCALE_AUDIT_TESTING_H
#define PERCALE_AUDIT_TESTING_H

#include "testing.h"

#include <math.h>
#include <stdlib.h>

// ---- meshes ----

static inline PercaleAuditMesh as_audit(const PercaleMesh *mesh)
{
    PercaleAuditMesh seen = {
        .positions = mesh->positions,
        .vertex_count = mesh->vertex_count,
        .triangles = mesh->triangles,
        .triangle_count = mesh->triangle_count,
        .thickness = 2e-3f,
        .mask = 1,
    };
    return seen;
}

static inline PercaleAuditMesh as_points(const float *positions, uint32_t count)
{
    PercaleAuditMesh seen = {.positions = positions, .vertex_count = count, .thickness = 2e-3f, .mask = 1};
    return seen;
}

static inline PercaleAuditMesh as_triangles(const float *positions, uint32_t vertex_count,
                                            const uint32_t *triangles, uint32_t triangle_count)
{
    PercaleAuditMesh seen = as_points(positions, vertex_count);
    seen.triangles = triangles;
    seen.triangle_count = triangle_count;
    return seen;
}

static inline PercaleQuality judge(const PercaleAuditMesh *cloth, const PercaleAuditMesh *obstacle)
{
    PercaleQuality quality;
    PERCALE_TEST_OK(NULL, percale_audit(cloth, cloth ? 1 : 0, obstacle, obstacle ? 1 : 0, &quality));
    return quality;
}

static inline float *rest_lengths_of(const PercaleMesh *mesh)
{
    float *lengths = calloc((size_t)mesh->triangle_count * 3, sizeof *lengths);
    ck_assert_ptr_nonnull(lengths);
    for (size_t side = 0; side < 3 * (size_t)mesh->triangle_count; side++) {
        const float *a = mesh->positions + 3 * (size_t)mesh->triangles[side];
        const float *b = mesh->positions + 3 * (size_t)mesh->triangles[side % 3 == 2 ? side - 2 : side + 1];
        double x = (double)a[0] - (double)b[0];
        double y = (double)a[1] - (double)b[1];
        double z = (double)a[2] - (double)b[2];
        lengths[side] = (float)sqrt(x * x + y * y + z * z);
    }
    return lengths;
}

static inline float random_between(uint64_t *seed, double low, double high)
{
    return (float)(low + (high - low) * percale_test_random(seed));
}

static inline void jitter(PercaleMesh *mesh, double by, uint64_t *seed)
{
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++)
        mesh->positions[i] += random_between(seed, -by, by);
}

// ---- vectors ----

typedef struct Vector {
    double x, y, z;
} Vector;

static inline Vector vector_at(const float *positions, size_t vertex)
{
    const float *point = positions + 3 * vertex;
    return (Vector){(double)point[0], (double)point[1], (double)point[2]};
}

static inline Vector plus(Vector a, double scale, Vector b)
{
    return (Vector){a.x + scale * b.x, a.y + scale * b.y, a.z + scale * b.z};
}

static inline double inner(Vector a, Vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline Vector outer(Vector a, Vector b)
{
    return (Vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline double length_of(Vector a)
{
    return sqrt(inner(a, a));
}

#endif
