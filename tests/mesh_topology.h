// mesh_topology.h: counts a mesh's edges, borders, loops and pieces, for the tests.
//
//   in   triangles, and which vertices are one point (sewn)
//   out  a Topology

#ifndef PERCALE_MESH_TOPOLOGY_H
#define PERCALE_MESH_TOPOLOGY_H

#include "percale/scene.h"

#include <check.h>
#include <stdlib.h>

typedef struct Side {
    uint32_t low, high;
    int direction; ///< +1 from low to high, -1 back
} Side;

typedef struct Topology {
    uint32_t vertices, edges, triangles; ///< vertices: those that a triangle uses
    uint32_t borders;                    ///< edges with one triangle
    uint32_t tangled;                    ///< edges with more than two, or two that run the same way
    uint32_t loops;                      ///< closed curves of border edges
    uint32_t pieces;                     ///< connected components
} Topology;

static inline int compare_sides(const void *left, const void *right)
{
    const Side *a = left;
    const Side *b = right;
    if (a->low != b->low) {
        return a->low < b->low ? -1 : 1;
    }
    if (a->high != b->high) {
        return a->high < b->high ? -1 : 1;
    }
    return a->direction - b->direction;
}

static inline uint32_t root_of(uint32_t *parents, uint32_t i)
{
    while (parents[i] != i) {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    return i;
}

static inline void join(uint32_t *parents, uint32_t a, uint32_t b)
{
    const uint32_t root_a = root_of(parents, a);
    const uint32_t root_b = root_of(parents, b);
    parents[root_a > root_b ? root_a : root_b] = root_a > root_b ? root_b : root_a;
}

static inline uint32_t *identity(uint32_t count)
{
    uint32_t *numbers = malloc(count * sizeof *numbers);
    ck_assert_ptr_nonnull(numbers);
    for (uint32_t i = 0; i < count; i++) {
        numbers[i] = i;
    }
    return numbers;
}

// One number per welded point.
static inline uint32_t *weld(uint32_t count, uint32_t (*pairs)[2], uint32_t pair_count)
{
    uint32_t *points = identity(count);
    for (uint32_t i = 0; i < pair_count; i++) {
        join(points, pairs[i][0], pairs[i][1]);
    }
    for (uint32_t i = 0; i < count; i++) {
        points[i] = root_of(points, i);
    }
    return points;
}

// Counts roots among the marked numbers.
static inline uint32_t count_roots(uint32_t *parents, const uint8_t *marked, uint32_t count)
{
    uint32_t roots = 0;
    for (uint32_t i = 0; i < count; i++) {
        roots += marked[i] && root_of(parents, i) == i;
    }
    return roots;
}

static inline Topology topology_of(const PercaleMesh *mesh, const uint32_t *points)
{
    const uint32_t count = 3 * mesh->triangle_count;
    Side *sides = malloc(count * sizeof *sides);
    uint32_t *pieces = identity(mesh->vertex_count);
    uint32_t *loops = identity(mesh->vertex_count);
    uint8_t *used = calloc(mesh->vertex_count, 1);
    uint8_t *border = calloc(mesh->vertex_count, 1);
    ck_assert(sides && used && border);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t a = points[mesh->triangles[i]];
        const uint32_t b = points[mesh->triangles[i % 3 == 2 ? i - 2 : i + 1]];
        ck_assert_uint_ne(a, b);
        sides[i] = a < b ? (Side){a, b, 1} : (Side){b, a, -1};
        used[a] = 1;
        join(pieces, a, b);
    }
    qsort(sides, count, sizeof *sides, compare_sides);
    Topology t = {.triangles = mesh->triangle_count};
    for (uint32_t i = 0; i < count; t.edges++) {
        uint32_t end = i + 1;
        while (end < count && sides[end].low == sides[i].low && sides[end].high == sides[i].high) {
            end++;
        }
        if (end - i == 1) {
            t.borders++;
            border[sides[i].low] = border[sides[i].high] = 1;
            join(loops, sides[i].low, sides[i].high);
        } else if (end - i > 2 || sides[i].direction == sides[i + 1].direction) {
            t.tangled++;
        }
        i = end;
    }
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        t.vertices += used[i];
    }
    t.pieces = count_roots(pieces, used, mesh->vertex_count);
    t.loops = count_roots(loops, border, mesh->vertex_count);
    free(sides);
    free(pieces);
    free(loops);
    free(used);
    free(border);
    return t;
}

static inline int euler(Topology t)
{
    return (int)t.vertices - (int)t.edges + (int)t.triangles;
}

#endif
