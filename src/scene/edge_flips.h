// edge_flips.h: evens out how many triangles meet in a vertex.
//
//   in   a closed, orientable triangle mesh
//   out  the same vertices and the same surface, other diagonals
//
// An edge is flipped where that brings the four vertices around it closer to the six neighbours of a regular
// mesh (Botsch and Kobbelt 2004), unless the surface would fold or an edge would stand there twice.

#ifndef PERCALE_EDGE_FLIPS_H
#define PERCALE_EDGE_FLIPS_H

#include <stdbool.h>
#include <stdint.h>

/// positions: [3 * vertex_count]; triangles: [3 * triangle_count], changed in place. False without memory, or
/// if some edge does not lie between exactly two triangles.
bool percale_flip_edges(const double *positions, uint32_t vertex_count, uint32_t *triangles,
                        uint32_t triangle_count);

#endif
