// geodesic.h: distances along the cloth's rest shape from a set of vertices.
//
//   in   triangles with the rest lengths of their sides, source vertices
//   out  for each vertex the distance to the nearest source, and which source that is
//
// Dijkstra's order, with Kimmel and Sethian's update (1998) in the exact form for one source (Novotni and
// Klein 2002): two corners of a triangle and their distances give the source's place in its plane, and so the
// distance of the third. Exact on a flat convex piece; across a cut or a bulge it is the length of a path, up
// to some per mille.

#ifndef PERCALE_GEODESIC_H
#define PERCALE_GEODESIC_H

#include "base/memory.h"

typedef struct PercaleGeodesicMesh {
    uint32_t vertex_count, triangle_count;
    const uint32_t *triangles;             // [3 * triangle_count]
    const float (*lengths)[3];             // [triangle_count] m at rest; side k from corner k to the next
    const uint32_t *vertex_first_triangle; // [vertex_count + 1] into vertex_triangles
    const uint32_t *vertex_triangles;
} PercaleGeodesicMesh;

/// distances: [vertex_count] m, INFINITY where no source is reached; nearest: [vertex_count] index into
/// sources. False without memory.
bool percale_geodesic_run(const PercaleGeodesicMesh *mesh, const uint32_t *sources, uint32_t source_count,
                          PercaleMemory *memory, float *distances, uint32_t *nearest);

/// Room for many searches around single vertices.
typedef struct PercaleGeodesicFront {
    const PercaleGeodesicMesh *mesh;
    float radius;
    float *distances;  // [vertex_count] m, of what is reached
    uint32_t *nearest; // [vertex_count] its source
    uint32_t *heap;
    uint32_t *place;   // [vertex_count] in the heap, or that it is not yet, or no longer there
    uint32_t *reached; // [vertex_count] vertices of the last search, by distance
    uint32_t count, reached_count;
} PercaleGeodesicFront;

/// False without memory; then and at the end it is closed.
bool percale_geodesic_open(PercaleGeodesicFront *front, const PercaleGeodesicMesh *mesh,
                           PercaleMemory *memory);
void percale_geodesic_close(PercaleGeodesicFront *front, PercaleMemory *memory);

/// The vertices not farther than `radius` from a source: the first `reached_count` of `reached`, the source
/// itself first, and their `distances`, until the next search.
void percale_geodesic_near(PercaleGeodesicFront *front, uint32_t source, float radius);

#endif
