// coarse.h: coarse levels of the cloth, through which a pull reaches far in one sweep.
//
//   in   triangles and their rest lengths, inverse masses of the slots
//   out  for each level its nodes, the links between them, and what the level below takes of their moves
//
// Hierarchical position based dynamics (Mueller 2008), over geodesics. The nodes of a level are some of those
// of the level below, the first level's some of the slots: each is COARSE_SPACING times as far from the next
// as there. A link tells how far along the cloth it is from a node to another, which they can't be farther
// apart. A node's mass is what the points that follow it weigh, each as far as it follows: so what conserves
// momentum at the nodes conserves the cloth's. A cloth that may stretch has no levels.

#ifndef PERCALE_COARSE_H
#define PERCALE_COARSE_H

#include "base/memory.h"
#include "base/simd.h"

enum {
    COARSE_LEVELS_MAX = PERCALE_MAX_LEVELS,
    COARSE_SPACING = 4, // of a level's nodes, in those of the level below; of the first's in mean edges
    COARSE_LEADERS = 4  // nodes that a point follows, at most
};

typedef struct PercaleCoarseLevel {
    uint32_t node_count;
    uint32_t *slots;                     // [node_count] pinned ones first, then ascending
    float *inverse_masses;               // [node_count] 1/kg, 0 for a pin
    uint32_t follower_count;             // points of the level below: its nodes, or the slots
    uint32_t (*leaders)[COARSE_LEADERS]; // [follower_count] nodes
    f32x4 *shares;                       // [follower_count] of the leaders' moves; their sum is 1, or 0
    uint32_t link_count;
    uint32_t (*links)[2]; // [link_count] nodes
    float *link_lengths;  // [link_count] m
} PercaleCoarseLevel;

typedef struct PercaleCoarse {
    uint32_t level_count;
    PercaleCoarseLevel levels[COARSE_LEVELS_MAX]; // the finest first
} PercaleCoarse;

struct PercaleGeodesicMesh;

/// points: [mesh's vertices], with inverse masses; spacing: the mean edge, m; level_count: at most so many,
/// fewer where a level would have a single node. False without memory; then, too, it has to be freed.
bool percale_coarse_build(PercaleCoarse *coarse, const struct PercaleGeodesicMesh *mesh, const f32x4 *points,
                          float spacing, uint32_t level_count, PercaleMemory *memory);
void percale_coarse_free(PercaleCoarse *coarse, PercaleMemory *memory);

#endif
