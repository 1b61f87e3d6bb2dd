// garment_testing.h: what the tests of the mannequin and of the dress measure.

#ifndef PERCALE_GARMENT_TESTING_H
#define PERCALE_GARMENT_TESTING_H

#include "mesh_topology.h"
#include "percale/geometry.h"
#include "percale/scene.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float THICKNESS = 0.002F; // m

static inline void corner(const float *positions, uint32_t vertex, double point[3])
{
    for (size_t k = 0; k < 3; k++) {
        point[k] = (double)positions[3 * (size_t)vertex + k];
    }
}

static inline double distance_between(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

typedef struct Shape {
    double aspect;   ///< longest edge by smallest height
    double area;     ///< m^2
    double smallest; ///< cosine of the smallest angle
} Shape;

static inline Shape shape_of(const PercaleMesh *mesh, uint32_t triangle)
{
    double p[3][3];
    for (uint32_t k = 0; k < 3; k++) {
        corner(mesh->positions, mesh->triangles[3 * triangle + k], p[k]);
    }
    const double a = distance_between(p[0], p[1]);
    const double b = distance_between(p[1], p[2]);
    const double c = distance_between(p[2], p[0]);
    const double s = 0.5 * (a + b + c);
    const double area = sqrt(fmax(s * (s - a) * (s - b) * (s - c), 0.0));
    const double longest = fmax(a, fmax(b, c));
    const double shortest = fmin(a, fmin(b, c));
    const double middle = a + b + c - longest - shortest;
    return (Shape){.aspect = longest * longest / (2.0 * area),
                   .area = area,
                   .smallest = (longest * longest + middle * middle - shortest * shortest) /
                               (2.0 * longest * middle)};
}

static inline uint64_t digest(const PercaleMesh *mesh)
{
    uint64_t hash = 1469598103934665603ULL; // FNV-1a
    const unsigned char *bytes = (const unsigned char *)mesh->positions;
    for (size_t i = 0; i < 3 * sizeof(float) * mesh->vertex_count; i++) {
        hash = (hash ^ bytes[i]) * 1099511628211ULL;
    }
    return hash;
}

/// A part of the body, by where its vertices are in the rest pose.
typedef bool Part(double x, double y);

static inline bool is_part(const PercaleMesh *mesh, Part *part, uint32_t vertex)
{
    return part((double)mesh->positions[3 * vertex], (double)mesh->positions[3 * vertex + 1]);
}

/// The triangles of a part in a pose, each with a ball around it, which spares most of the work.
typedef struct Ball {
    double corners[3][3]; // m
    double reach;         // m, around the first corner
} Ball;

typedef struct Balls {
    Ball *list;
    uint32_t count;
} Balls;

/// Of the mesh at other positions: of the triangles whose first corner belongs to the part; NULL: all.
static inline Balls balls_of(const PercaleMesh *mesh, const float *positions, Part *part)
{
    Balls balls = {.list = calloc(mesh->triangle_count, sizeof(Ball))};
    ck_assert_ptr_nonnull(balls.list);
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *v = mesh->triangles + 3 * (size_t)t;
        if (part && !is_part(mesh, part, v[0])) {
            continue;
        }
        Ball *ball = &balls.list[balls.count++];
        for (int k = 0; k < 3; k++) {
            corner(positions, v[k], ball->corners[k]);
        }
        ball->reach = fmax(distance_between(ball->corners[0], ball->corners[1]),
                           distance_between(ball->corners[0], ball->corners[2]));
    }
    return balls;
}

/// Smallest distance of a point to the triangles, if it is less than `limit`.
static inline double distance_to_balls(const Balls *balls, const double point[3], double limit)
{
    double best = limit;
    for (uint32_t i = 0; i < balls->count; i++) {
        const Ball *ball = &balls->list[i];
        const double far = best + ball->reach;
        const double dx = point[0] - ball->corners[0][0];
        const double dy = point[1] - ball->corners[0][1];
        const double dz = point[2] - ball->corners[0][2];
        if (dx * dx + dy * dy + dz * dz < far * far) {
            double x[4][3];
            double weight[4];
            memcpy(x[0], point, sizeof x[0]);
            memcpy(x[1], ball->corners, sizeof ball->corners);
            best = fmin(best, percale_vertex_face_closest((const double(*)[3])x, weight));
        }
    }
    return best;
}

#endif
