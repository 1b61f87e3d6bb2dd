// mesh.h: connectivity of a triangle mesh.
//
//   in   triangles
//   out  unique edges with the triangle sides that they come from

#ifndef PERCALE_MESH_H
#define PERCALE_MESH_H

#include "base/memory.h"

/// A side of a triangle: 3 * triangle + corner, from that corner to the next.
typedef struct PercaleEdges {
    uint32_t edge_count;
    uint32_t (*vertices)[2]; // [edge_count] smaller index first, edges in ascending order
    uint32_t *first_side;    // [edge_count + 1] into sides
    uint32_t *sides;         // [3 * triangle_count] grouped by edge, ascending inside a group
    uint32_t *edge_of_side;  // [3 * triangle_count]
} PercaleEdges;

/// Vertex indices only need to be numbers; a side whose two ends are the same vertex belongs to no edge
/// (edge_of_side is UINT32_MAX). False without memory.
bool percale_edges_build(const uint32_t *triangles, uint32_t triangle_count, PercaleMemory *memory,
                         PercaleEdges *edges);
void percale_edges_free(PercaleEdges *edges, PercaleMemory *memory);

/// Next corner of a triangle.
static inline uint32_t next_corner(uint32_t corner)
{
    return corner == 2 ? 0 : corner + 1;
}

#endif
