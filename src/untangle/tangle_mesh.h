// tangle_mesh.h: everything that can be tangled as one mesh: the cloths' triangles, then the obstacles'.
//
//   in   the model: welded cloth, obstacles
//   out  one list of triangles with its edges, whose triangle is whose, which points are sewn
//
// Points are the model's, so sewn vertices that have closed are one. What doesn't change while cloth moves.

#ifndef PERCALE_TANGLE_MESH_H
#define PERCALE_TANGLE_MESH_H

#include "model/model.h"

/// A cloth or an obstacle.
typedef struct PercaleTangleObject {
    float thickness; // m
    uint32_t mask;
    uint32_t rank;    // of a cloth's layer, from the body outwards
    bool is_obstacle; // then it stands still
    bool is_closed;   // an obstacle with an inside
} PercaleTangleObject;

typedef struct PercaleTangleMesh {
    const PercaleModel *model;
    uint32_t triangle_count;
    uint32_t cloth_triangle_count; // the first ones
    uint32_t *triangles;           // [3 * triangle_count] points
    PercaleEdges edges;            // of all
    uint32_t cloth_edge_count;     // the first ones: cloth points have smaller numbers
    uint32_t *object_of;           // [triangle_count] cloths, then obstacles
    PercaleTangleObject *objects;
    uint32_t *seam_of; // [point_count] the smallest point that it is sewn to, through open seams; or itself
    uint32_t *first_edge;  // [point_count + 1] into point_edges
    uint32_t *point_edges; // edges around a point, ascending
    int8_t *turns;         // [triangle_count] -1: against the others of its piece of cloth it is turned over
} PercaleTangleMesh;

static const uint32_t NO_INDEX = UINT32_MAX;

/// `obstacles`: with their triangles. False without memory; then there is nothing to free.
bool percale_tangle_mesh_build(PercaleTangleMesh *mesh, const PercaleModel *model, bool obstacles,
                               PercaleMemory *memory);
void percale_tangle_mesh_free(PercaleTangleMesh *mesh, PercaleMemory *memory);

static inline const uint32_t *corners_of_triangle(const PercaleTangleMesh *mesh, uint32_t triangle)
{
    return mesh->triangles + 3 * (size_t)triangle;
}

static inline const PercaleTangleObject *object_of_triangle(const PercaleTangleMesh *mesh, uint32_t triangle)
{
    return &mesh->objects[mesh->object_of[triangle]];
}

static inline uint32_t triangles_of_edge(const PercaleTangleMesh *mesh, uint32_t edge)
{
    return mesh->edges.first_side[edge + 1] - mesh->edges.first_side[edge];
}

/// The k-th triangle at an edge.
static inline uint32_t triangle_of_edge(const PercaleTangleMesh *mesh, uint32_t edge, uint32_t k)
{
    return mesh->edges.sides[mesh->edges.first_side[edge] + k] / 3;
}

/// The triangle beyond an edge; NO_INDEX at a boundary and where more than two meet.
static inline uint32_t triangle_beyond(const PercaleTangleMesh *mesh, uint32_t edge, uint32_t triangle)
{
    if (triangles_of_edge(mesh, edge) != 2) {
        return NO_INDEX;
    }
    uint32_t first = triangle_of_edge(mesh, edge, 0);
    return first == triangle ? triangle_of_edge(mesh, edge, 1) : first;
}

/// Whether two points are one, or will be when a seam has closed.
static inline bool are_sewn_together(const PercaleTangleMesh *mesh, uint32_t a, uint32_t b)
{
    return mesh->seam_of[a] == mesh->seam_of[b];
}

/// Whether two triangles share a point.
static inline bool do_triangles_meet(const PercaleTangleMesh *mesh, uint32_t a, uint32_t b)
{
    const uint32_t *corners_a = corners_of_triangle(mesh, a);
    const uint32_t *corners_b = corners_of_triangle(mesh, b);
    bool meet = false;
    for (int k = 0; k < 9; k++) {
        meet = meet || are_sewn_together(mesh, corners_a[k / 3], corners_b[k % 3]);
    }
    return meet;
}

#endif
