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
// note, or from where they were. A rim has no memory. Against an obstacle its oriented surface decides. What
// crosses and has always done so, as far as one knows, has no side and gets no stencil.

#ifndef PERCALE_PAIRS_H
#define PERCALE_PAIRS_H

#include "base/arena.h"
#include "detect/candidates.h"
#include "detect/pinch.h"
#include "detect/release.h"
#include "detect/renew.h"

typedef struct PercalePairStage {
    const PercaleModel *model;
    const f32x4 *end;                // where the points are looked at
    PercaleCandidates *candidates;   // their tree of faces is refitted where something may be crossed
    const PercaleNoteList *known;    // ascending by key
    float later_substeps;            // until the next pass
    float dt;                        // s, of a substep
    bool may_be_crossed;             // nobody knows yet, or the guard has left something, or something was
    const PercaleSources *only;      // NULL: all items
    const PercalePinches *pinches;   // NULL: nothing is pinched
    const PercaleReleases *releases; // NULL: none
    bool edges_wait; // those of the cloth and an obstacle's, as long as vertices and faces keep them apart
    PercaleArena *arena;
    PercaleTeam *team;
    PercaleNoteList born; // pairs that were born crossed; percale_pairs_find fills it in
} PercalePairStage;

typedef struct PercalePairCounts {
    uint64_t candidates;             // pairs looked at
    uint64_t vertex_face, edge_edge; // stencils
    uint64_t born_crossed;           // edges and faces that cross, and nothing tells how that came
    uint64_t free_pairs;             // of their features
} PercalePairCounts;

/// Appends to `stencils` and to the emptied `notes`, which it sorts by key. False without memory.
bool percale_pairs_find(const PercalePairStage *stage, PercaleCollectors *collectors, PercaleMemory *memory,
                        PercaleStencilList *stencils, PercaleNoteList *notes, PercalePairCounts *counts);

/// How many stencils of pairs stand in the second list and not in the first. Both ascend by source; what has
/// an earlier source than the second list's first is not compared.
uint64_t percale_pairs_count_missing(const PercaleStencilList *kept, const PercaleStencilList *anew);

/// Whether a vertex and a face of the cloth, or two edges, are noted as born crossed: they may pass.
bool percale_pairs_are_free(const PercaleNoteList *notes, bool edges, uint32_t item, uint32_t primitive);

#endif
