// candidates.h: pairs of features that may come within reach, kept as long as nothing else can.
//
//   in   trees over the cloth's triangles and edges, positions
//   out  for each item (a vertex or an edge) the primitives of the cloth that it may come to touch
//
// They are found with a margin beyond the reach of each pair. Two features that were farther apart than that
// can't touch as long as the difference of what their points have moved is smaller. Items that lie together
// are a block (blocks.h), whose pairs were found at one moment; when something near it has moved against it
// by more than the margin since then, its pairs are found anew, and those of no other block.
//
// Who visits the pairs asks only those that can be near now: of each it is known how near it was when it was
// last asked, and of its block how far things there have moved against each other in every substep since.

#ifndef PERCALE_CANDIDATES_H
#define PERCALE_CANDIDATES_H

#include "detect/blocks.h"
#include "detect/collect.h"
#include "detect/flat.h"
#include "detect/pair_pages.h"
#include "model/model.h"

// Thicknesses within which two features get a stencil: half of one is for what the solver moves them in a
// substep.
static const float CONTACT_REACH = 1.5f;
static const float REACH_SLACK = 1.001f; // candidates are looked for that much farther: float32 rounds

// Thicknesses below which an edge of the cloth and an obstacle's get their first: above it vertices and faces
// keep them apart. Once they have one they keep it within reach.
static const float EDGES_WAIT = 0.9f;

/// The pairs of one kind of item: of each block those that were found for its items, by item.
typedef struct PercaleCandidateList {
    const PercaleModelSurface *mesh; // whose vertices or edges the items are
    uint32_t *order;                 // [items] along a curve; NULL: all, as they are
    float *reaches;                  // [items] by place, m; NULL: all have the widest
    PercaleQueries queries;
    float widest;          // m, the queries' largest reach
    float waiting;         // m; pairs that nobody watches are not wanted farther apart
    const uint8_t *smooth; // [items] only pairs of these wait, others are watched always; NULL: none
    uint32_t item_count;
    uint32_t first_block, block_count;
    uint32_t *first_item;     // [block_count + 1] places in the order
    uint32_t *ends;           // [items] by place: of its pairs in those of its block
    PercaleBlockPairs *pairs; // [block_count]
    size_t *first_pair;       // [block_count + 1] in a numbering of all
} PercaleCandidateList;

typedef struct PercaleCandidates {
    const PercaleModel *model;
    PercaleTree faces, edges; // of the cloth; edges only where they collide
    uint32_t *last_edges;     // [lowest nodes of the tree over edges] the greatest edge in each
    bool cloth, obstacles;    // what collides with the cloth
    PercalePairPool pool;
    PercaleCandidateList *lists; // [list_count] faces and edges by turns: cloth's items, then each obstacle's
    uint32_t list_count;
    PercaleFlat *flats;      // [obstacle_count] whose items are in no list
    float longest;           // m; edge of the cloth when the running step began
    float margin;            // m, beyond the reach
    float thickest;          // cloth, m
    PercaleBlockReach reach; // the widest of any pair, and with the margin, which bounds don't exceed
    PercaleBlocks blocks;    // of the cloth's slots, of each obstacle's vertices, of its edges
    bool known;              // pairs have been found
    bool bounded;            // the pairs' bounds hold where they were last kept for
    PercaleBlockList spent;  // those whose pairs were found anew when the candidates were last asked for
} PercaleCandidates;

/// False without memory.
bool percale_candidates_create(PercaleCandidates *candidates, const PercaleModel *model, bool cloth,
                               bool edges, bool obstacles, PercaleMemory *memory);
void percale_candidates_free(PercaleCandidates *candidates, PercaleMemory *memory);

/// At the begin of a step: how long the cloth's edges are, where that is asked for.
void percale_candidates_begin_step(PercaleCandidates *candidates, PercaleTeam *team);

/// What candidates are needed for, and what is needed to find them.
typedef struct PercaleCandidateStage {
    const f32x4 *from, *to; // ways of the points, on which nothing may be missed
    bool again;             // they start where they did when the candidates were last kept
    float spare;            // m; beyond the margin that may be spent: nothing needs to be known within it
    bool all_near;          // pairs whose ways come near each other, even if they don't end so
    PercaleCollectors *collectors;
    PercaleMemory *memory;
    PercaleTeam *team;
} PercaleCandidateStage;

/// Finds those pairs anew that may not be all any longer. False without memory. Those that are in no list are
/// farther apart than their reach less the spare.
bool percale_candidates_keep(PercaleCandidates *candidates, const PercaleCandidateStage *stage,
                             uint64_t *tested);

/// How many pairs a list has.
static inline size_t percale_candidate_count(const PercaleCandidateList *list)
{
    return list->first_pair != NULL ? list->first_pair[list->block_count] : 0;
}

/// What a list's items are asked against, on the way from the model's position to its predicted one.
PercaleNeighborhood percale_candidates_hood(const PercaleCandidates *candidates, uint32_t list);

/// Whether an open seam will make one point of two vertices of two features of the cloth: then they are as
/// good as joined, and would only keep the seam from closing. `points`: a vertex twice or an edge.
bool percale_candidates_are_sewn(const PercaleModel *model, const uint32_t points[2], const uint32_t *corners,
                                 uint32_t corner_count);

/// Whether a point (of the cloth or an obstacle) collides with a vertex of the cloth.
bool percale_candidates_collide(const PercaleCandidates *candidates, uint32_t point, uint32_t slot);

/// The smallest reach of any pair, m.
float percale_candidates_least_reach(const PercaleCandidates *candidates);

/// Moves the collector's neighbours on to those of the next item for which some are found; false: that was
/// the last.
static inline bool percale_candidates_next(PercaleCollector *collector)
{
    PercaleNeighborList *item = &collector->neighbors;
    PercaleNeighbor *end = collector->found.items + collector->found.count;
    item->items += item->count;
    item->count = 0;
    while (item->items + item->count < end && item->items[item->count].place == item->items[0].place) {
        item->count++;
    }
    return item->count > 0;
}

/// An item that something is near, with its neighbours as the collector's.
typedef void PercaleVisit(const void *context, PercaleCollector *collector, const PercaleQuery *query,
                          uint32_t place, uint32_t item);

/// What is asked of a list's pairs.
typedef struct PercaleVisiting {
    const PercaleCandidates *candidates;
    uint32_t list;
    PercaleNeighborhood hood;
    const uint8_t *touched; // [points] only pairs with such a point are asked; NULL: all
    bool none_waits;        // all within reach are wanted
    PercaleVisit *visit;
    const void *context;
} PercaleVisiting;

/// Visits the items whose first pair is in the range, by place in the list's order. The ways are those that
/// the candidates were last kept for, unless all are near; how near a pair is then is written down.
void percale_candidates_visit(const PercaleVisiting *visiting, PercaleCollector *collector, uint64_t first,
                              uint64_t end);

/// Visits the item at this place of the list's order, if it has pairs.
void percale_candidates_visit_place(const PercaleVisiting *visiting, PercaleCollector *collector,
                                    uint32_t place);

#endif
