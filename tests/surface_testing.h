// surface_testing.h: obstacles of all kinds with their trees, and points to ask about.

#ifndef PERCALE_SURFACE_TESTING_H
#define PERCALE_SURFACE_TESTING_H

#include "testing.h"

#include "detect/surface.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- an obstacle with its tree ----

enum { BYSTANDERS = 5 }; // points of another obstacle that stand before the one under test

typedef struct Scene {
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleMessage message;
    PercaleObstacleObject objects[2]; // a bystander, so that points don't begin at 0, and the mesh
    PercaleObjects all;
    PercaleModel model;
    PercaleTree tree;
    f32x4 *points;
    PercaleMesh mesh;
    PercaleSurface surface;
} Scene;

static inline void place_points(Scene *scene)
{
    f32x4 *points = scene->points + scene->model.obstacles[1].first_point;
    for (uint32_t i = 0; i < scene->mesh.vertex_count; i++) {
        const float *x = scene->mesh.positions + 3 * (size_t)i;
        points[i] = (f32x4){x[0], x[1], x[2], 0.0f};
    }
}

/// Takes the mesh's positions over into points and boxes.
static inline void refit_with(PercaleTeam *team, void *context)
{
    Scene *scene = context;
    percale_tree_refit(&scene->tree, scene->surface.mesh->triangles, scene->points, team);
}

static inline void refit(Scene *scene, int thread_count)
{
    PercaleCrowding crowding = {0, 0};
    place_points(scene);
    percale_team_open(thread_count, &crowding, refit_with, scene);
}

/// Takes the mesh over. The scene must not move.
static inline void open_scene(Scene *scene, PercaleMesh mesh)
{
    static uint32_t bystander[3] = {0, 2, 4};
    static float nowhere[3 * BYSTANDERS];
    memset(scene, 0, sizeof(*scene));
    scene->allocator = percale_allocator_default();
    scene->memory.allocator = &scene->allocator;
    scene->mesh = mesh;
    scene->objects[0] = (PercaleObstacleObject){.vertex_count = BYSTANDERS,
                                                .triangle_count = 1,
                                                .base = nowhere,
                                                .triangles = bystander,
                                                .thickness = 0.002f};
    scene->objects[1] = (PercaleObstacleObject){.vertex_count = mesh.vertex_count,
                                                .triangle_count = mesh.triangle_count,
                                                .base = mesh.positions,
                                                .triangles = mesh.triangles,
                                                .thickness = 0.002f};
    scene->all.obstacles = scene->objects;
    scene->all.obstacle_count = 2;
    PERCALE_TEST_OK(NULL,
                    percale_model_assemble(&scene->model, &scene->all, (PercaleParts){true, true, false, 0},
                                           &scene->memory, &scene->message));
    scene->points = percale_memory_new(&scene->memory, scene->model.point_count, sizeof(f32x4));
    if (scene->points == NULL) {
        ck_abort_msg("no memory for the points");
    }
    place_points(scene);
    const PercaleModelSurface *obstacle = &scene->model.obstacles[1];
    ck_assert(percale_tree_build(&scene->tree, obstacle->triangles, 3, obstacle->triangle_count,
                                 scene->points, &scene->memory));
    scene->surface = (PercaleSurface){obstacle, &scene->tree, scene->points, NULL};
    refit(scene, 1);
}

static inline void close_scene(Scene *scene)
{
    percale_memory_free(&scene->memory, scene->points);
    percale_tree_free(&scene->tree, &scene->memory);
    percale_model_free(&scene->model, &scene->memory);
    ck_assert_uint_eq(scene->memory.bytes, 0);
    percale_mesh_free(&scene->mesh);
}

// ---- meshes ----

/// Uniform between -half and half, rounded to float32.
static inline float random_float(uint64_t *seed, double half)
{
    return (float)(half * (2.0 * percale_test_random(seed) - 1.0));
}

/// Triangles that share nothing, of all sizes; every third has no area: two corners coincide, all three do,
/// or they lie on a line.
static inline PercaleMesh make_soup(uint32_t triangle_count, bool degenerate, uint64_t seed)
{
    PercaleMesh mesh = {.vertex_count = 3 * triangle_count, .triangle_count = triangle_count};
    mesh.positions = calloc(9 * (size_t)triangle_count, sizeof(float));
    mesh.triangles = calloc(3 * (size_t)triangle_count, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    for (uint32_t t = 0; t < triangle_count; t++) {
        float *x = mesh.positions + 9 * (size_t)t;
        double size = pow(10.0, -3.0 * percale_test_random(&seed));
        for (uint32_t axis = 0; axis < 3; axis++) {
            float middle = random_float(&seed, 1.0);
            for (uint32_t k = 0; k < 3; k++) {
                x[3 * k + axis] = middle + random_float(&seed, size);
                mesh.triangles[3 * (size_t)t + k] = 3 * t + k;
            }
            if (degenerate && t % 3 == 0) {
                bool on_a_line = t % 9 == 6;
                x[6 + axis] = on_a_line ? 0.5f * (x[axis] + x[3 + axis]) : x[axis];
                x[3 + axis] = t % 9 == 0 ? x[axis] : x[3 + axis];
            }
        }
    }
    return mesh;
}

/// Sheet of unit cells, whose points are exact: many queries have several nearest triangles.
static inline PercaleMesh make_grid(void)
{
    return percale_test_sheet(17, 16.0f);
}

/// A closed mesh with dents and spikes; every ray from the origin meets it once.
static inline PercaleMesh make_bumpy_sphere(uint64_t seed)
{
    PercaleMesh mesh = percale_test_sphere(2, 1.0f);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        float factor = 0.6f + 0.8f * (float)percale_test_random(&seed);
        for (uint32_t axis = 0; axis < 3; axis++) {
            mesh.positions[3 * (size_t)i + axis] *= factor;
        }
    }
    return mesh;
}

/// A box whose first edge has a vertex in the middle that only one of its two faces knows: a triangle without
/// area closes the gap.
static inline PercaleMesh make_box_with_sliver(void)
{
    PercaleMesh box = percale_test_box(2.0f, 2.0f, 2.0f);
    PercaleMesh mesh = {.vertex_count = 9, .triangle_count = 14};
    mesh.positions = calloc(27, sizeof(float));
    mesh.triangles = calloc(42, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    memcpy(mesh.positions, box.positions, 24 * sizeof(float));
    memcpy(mesh.triangles, box.triangles, 36 * sizeof(uint32_t));
    uint32_t a = box.triangles[0];
    uint32_t b = box.triangles[1];
    uint32_t c = box.triangles[2];
    for (uint32_t axis = 0; axis < 3; axis++) {
        mesh.positions[24 + axis] = 0.5f * (box.positions[3 * a + axis] + box.positions[3 * b + axis]);
    }
    const uint32_t split[3][3] = {{a, 8, c}, {8, b, c}, {8, a, b}};
    memcpy(mesh.triangles, split[0], sizeof(split[0]));
    memcpy(mesh.triangles + 36, split[1], 2 * sizeof(split[1]));
    percale_mesh_free(&box);
    return mesh;
}

/// A sharp pyramid on a triangle. One of its sides is a fan of many slices, which at the apex outnumber the
/// other two sides, but not outweigh them: their angles are small.
static inline PercaleMesh make_fan(void)
{
    enum { SLICES = 24, APEX = SLICES + 1, CORNER }; // vertices 0 .. SLICES run along the base of the fan
    PercaleMesh mesh = {.vertex_count = SLICES + 3, .triangle_count = 2 * SLICES + 2};
    mesh.positions = calloc(3 * (size_t)mesh.vertex_count, sizeof(float));
    mesh.triangles = calloc(3 * (size_t)mesh.triangle_count, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    for (uint32_t i = 0; i <= SLICES; i++) {
        const float base[3] = {(float)i / SLICES - 0.5f, -0.5f, 0.3f};
        memcpy(mesh.positions + 3 * (size_t)i, base, sizeof(base));
    }
    const float rest[2][3] = {{0.0f, 1.0f, 0.0f}, {0.0f, -0.5f, -0.6f}};
    memcpy(mesh.positions + 3 * (size_t)APEX, rest, sizeof(rest));
    for (uint32_t i = 0; i < SLICES; i++) {
        const uint32_t slice[6] = {APEX, i, i + 1, CORNER, i + 1, i};
        memcpy(mesh.triangles + 6 * (size_t)i, slice, sizeof(slice));
    }
    const uint32_t sides[6] = {APEX, CORNER, 0, APEX, SLICES, CORNER};
    memcpy(mesh.triangles + 6 * (size_t)SLICES, sides, sizeof(sides));
    return mesh;
}

enum { MESH_COUNT = 8, CLOSED_COUNT = 5 };

/// The first CLOSED_COUNT meshes are closed, and every ray from the origin meets them once.
static inline PercaleMesh make_mesh(int which)
{
    switch (which) {
    case 0:
        return percale_test_sphere(2, 1.0f);
    case 1:
        return percale_test_box(2.0f, 2.0f, 2.0f);
    case 2:
        return make_bumpy_sphere(11);
    case 3:
        return make_box_with_sliver();
    case 4:
        return make_fan();
    case 5:
        return make_grid();
    case 6:
        return make_soup(400, false, 3);
    default:
        return make_soup(333, true, 5);
    }
}

static inline Vec3 vertex_of(const PercaleMesh *mesh, uint32_t vertex)
{
    const float *x = mesh->positions + 3 * (size_t)vertex;
    return vec3((double)x[0], (double)x[1], (double)x[2]);
}

static inline void corners_of(const PercaleMesh *mesh, uint32_t triangle, Vec3 corners[3])
{
    for (uint32_t k = 0; k < 3; k++) {
        corners[k] = vertex_of(mesh, mesh->triangles[3 * (size_t)triangle + k]);
    }
}

/// A point that the tree may be asked about: anywhere near, on a vertex, or on or just off an edge.
static inline Vec3 make_query(const PercaleMesh *mesh, int i, uint64_t *seed)
{
    Vec3 corners[3];
    corners_of(mesh, (uint32_t)(percale_test_random(seed) * mesh->triangle_count), corners);
    float reach = mesh->triangle_count == 512 ? 9.0f : 2.0f;
    f32x4 anywhere = {random_float(seed, (double)reach), random_float(seed, (double)reach),
                      random_float(seed, (double)reach), 0.0f};
    f32x4 near_edge = f32x4_of(vscale(0.5, vadd(corners[0], corners[1])), 0.0f);
    near_edge[1] += i % 8 < 4 ? 0.0f : 0.25f;
    return i % 4 == 0 ? corners[0] : i % 4 == 1 ? vec3_of(near_edge) : vec3_of(anywhere);
}

#endif
