// pairs.h: stencils between features of the cloth, and of the cloth and the obstacles' vertices and edges.
//
//   in   start and predicted positions, trees over the cloth's triangles and edges, what was known at the
//   last
//        pass
//   out  stencils, ordered by vertex and by edge; notes of the sides for the next pass
//
// A vertex and a face, an edge or a vertex; two edges only where both closest points are inside them, so that
// every pair of features has one stencil (MATH.md, section 7). Two features that share a vertex are no pair;
// others keep their thickness, or half of the way between them on the rest shape where that is less.
//
// Sides. Of a vertex and a face: one bit, that of the start, unless the path goes around the face; a pair
// that had a stencil at the last pass is known by its note. Of two edges: the normal is carried on from the
// note, or from where they were. A rim has no memory. Against an obstacle its oriented surface decides.

#ifndef PERCALE_PAIRS_H
#define PERCALE_PAIRS_H

#include "detect/candidates.h"

typedef struct PercalePairStage {
    const PercaleModel *model;
    const PercaleCandidates *candidates;
    const PercaleNoteList *known; // ascending by key
    float later_substeps;         // until the next pass
    float dt;                     // s, of a substep
    PercaleTeam *team;
} PercalePairStage;

typedef struct PercalePairCounts {
    uint64_t candidates;             // pairs looked at
    uint64_t vertex_face, edge_edge; // stencils
} PercalePairCounts;

/// Appends to `stencils` and to the emptied `notes`, which it sorts by key. False without memory.
bool percale_pairs_find(const PercalePairStage *stage, PercaleCollectors *collectors, PercaleMemory *memory,
                        PercaleStencilList *stencils, PercaleNoteList *notes, PercalePairCounts *counts);

#endif
