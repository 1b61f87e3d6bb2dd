// crossings.h: which edges go through which faces.
//
//   in   the mesh of everything, positions
//   out  crossings, ordered by edge and face
//
// Cloth with itself and with other cloth, edges of cloth with faces of obstacles and the other way round;
// obstacles among themselves are nobody's business. An edge and a face that share a point, or that an open
// seam joins, are no pair. Decided by exact signs that are never 0 (exact_sign.h): two triangles that share
// no point have no crossing or two, those that share one point none or one. That is what lets them be
// chained.

#ifndef PERCALE_CROSSINGS_H
#define PERCALE_CROSSINGS_H

#include "base/team.h"
#include "detect/tree.h"
#include "untangle/tangle_mesh.h"

typedef struct PercaleTangleCrossing {
    uint32_t edge, face;
    double along;      // place on the edge: 0 at its first point, 1 at its second
    double weights[3]; // place on the face: barycentric coordinates
} PercaleTangleCrossing;

typedef struct PercaleTangleCrossings {
    PercaleTangleCrossing *items;
    size_t count, capacity;
} PercaleTangleCrossings;

enum { TANGLE_SHARES = 64 }; // of the edges, each with a list of its own

/// What one share of the edges has found; kept between searches.
typedef struct PercaleCrossingShare {
    _Alignas(64) PercaleTangleCrossings found;
    PercaleNodeList nodes;
    PercaleMemory memory;
    bool complete;
} PercaleCrossingShare;

typedef struct PercaleCrossingSearch {
    const PercaleTangleMesh *mesh;
    PercaleTree cloth, obstacles; // over their triangles; the latter's boxes don't change
    PercaleCrossingShare shares[TANGLE_SHARES];
} PercaleCrossingSearch;

/// Builds the trees. False without memory; then there is nothing to free.
bool percale_crossing_search_open(PercaleCrossingSearch *search, const PercaleTangleMesh *mesh,
                                  const f32x4 *x, PercaleTeam *team, PercaleMemory *memory);
void percale_crossing_search_close(PercaleCrossingSearch *search, PercaleMemory *memory);

/// Replaces the list; the cloth tree's boxes are then those of x. False without memory.
bool percale_crossing_search_run(PercaleCrossingSearch *search, const f32x4 *x, PercaleTeam *team,
                                 PercaleMemory *memory, PercaleTangleCrossings *crossings);

/// Whether the edge goes through the face; they share no point.
bool percale_does_edge_cross(const f32x4 *x, const uint32_t edge[2], const uint32_t face[3]);

/// Where the two meet, m.
Vec3 percale_crossing_point(const PercaleTangleMesh *mesh, const PercaleTangleCrossing *crossing,
                            const f32x4 *x);

#endif
