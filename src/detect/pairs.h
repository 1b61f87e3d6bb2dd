// pairs.h: stencils between features of the cloth, and of the cloth and the obstacles' vertices and edges.
//
//   in   start and predicted positions, the tree over the cloth's triangles, what was known at the last pass
//   out  stencils, ordered by vertex and by edge; notes of the sides for the next pass
//
// A vertex and a face, an edge or a vertex; two edges only where both closest points are inside them, so that
// every pair of features has one stencil (MATH.md, section 7). Two features that share a vertex are no pair;
// others keep their thickness, or half of the way between them on the rest shape where that is less.
//
// Sides. Of a vertex and a face: one bit, that of the last pass, unless the path since went around the face;
// a pair that had a stencil then is known by its note. Of two edges: the normal is carried on from the note,
// or from where they were. A rim has no memory. Against an obstacle its oriented surface decides.

#ifndef PERCALE_PAIRS_H
#define PERCALE_PAIRS_H

#include "detect/collect.h"

typedef struct PercalePairStage {
    const PercaleModel *model;
    const PercaleTree *tree;      // of the cloth's triangles, over `earlier`, `position` and `ahead`
    const f32x4 *earlier;         // [point_count] where the points were when `known` was written
    const f32x4 *ahead;           // [point_count] where they would be at the next pass
    const PercaleNoteList *known; // ascending by key
    float later_substeps;         // until the next pass
    float dt;                     // s, of a substep
    bool cloth;                   // cloth against cloth
    bool edges;                   // of the cloth against each other
    bool obstacles;               // their vertices against the cloth's faces, their edges against its edges
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
