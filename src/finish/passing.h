// passing.h: which features of the cloth have gone through features of it, or of an obstacle, between the
// start of the substep and where the points are now.
//
//   in   start and predicted positions, candidates
//   out  of each passage the stencil that pushes it back

#ifndef PERCALE_PASSING_H
#define PERCALE_PASSING_H

#include "finish/pair_guard.h"

/// What is asked: a mesh's vertices and the cloth's faces, or edges of both.
typedef struct PercalePassing {
    const PercalePairGuardStage *stage;
    const PercaleModelSurface *mesh;
    bool of_edges;
    double reach; // m; of contact
} PercalePassing;

/// A vertex or an edge of the mesh, and a face or an edge of the cloth.
typedef struct PercaleFeaturePair {
    uint32_t item, primitive;
    const uint32_t *points, *corners; // theirs; of a vertex [0]
} PercaleFeaturePair;

/// Adds to the collector's stencils, if they have passed each other.
void percale_passing_ask(const PercalePassing *passing, PercaleCollector *collector,
                         const PercaleFeaturePair *pair);

/// All passages, as the stage's `passing`. `touched`: they have been found already; these points have moved
/// since, or passed. False without memory.
bool percale_passages_find(const PercalePairGuardStage *stage, const uint8_t *touched,
                           PercalePairGuardCounts *counts);

#endif
