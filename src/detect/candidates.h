// candidates.h: pairs of features that may come within reach, kept as long as nothing else can.
//
//   in   trees over the cloth's triangles and edges, positions
//   out  for each item (a vertex or an edge) the primitives of the cloth that it may come to touch
//
// They are found where all points were at one moment, with a margin beyond the reach. Two points that were
// farther apart than that can't touch as long as the difference of what they have moved is smaller. Slots are
// cut into blocks: a block's motion is its mean and the greatest deviation from it, so what all fall together
// costs nothing. Blocks are compared where they are near each other now, whether they were then or not.
// The same bounds, block by block, tell which pairs of a list can't be near at the moment.

#ifndef PERCALE_CANDIDATES_H
#define PERCALE_CANDIDATES_H

#include "detect/collect.h"
#include "model/model.h"

// Thicknesses within which two features get a stencil: half of one is for what the solver moves them in a
// substep.
static const float CONTACT_REACH = 1.5f;

/// The pairs of one kind of item, by item.
typedef struct PercaleCandidateList {
    const PercaleModelSurface *mesh; // whose vertices or edges the items are
    uint32_t *order;                 // [items] along a curve; NULL: as they are
    PercaleItemPairList pairs;
} PercaleCandidateList;

typedef struct PercaleCandidates {
    const PercaleModel *model;
    PercaleTree faces, edges;    // of the cloth; edges only where they collide
    bool cloth, obstacles;       // what collides with the cloth
    PercaleCandidateList *lists; // [list_count] faces and edges by turns: cloth's items, then each obstacle's
    uint32_t list_count;
    float margin;                // m, beyond the reach
    float thickest;              // cloth, m
    f32x4 *reference;            // [point_count] where all points were
    bool known;                  // the lists hold pairs of `reference`
    uint32_t block_size;         // slots
    struct PercaleBlock *blocks; // [cloth_blocks, then one for each obstacle]
    uint32_t cloth_blocks;
    uint32_t *halo_first; // [cloth_blocks + 1] into halo
    uint32_t *halo;       // slots of other blocks that have an edge with one of the block
    float *moved;         // [(1 + obstacle_count) * cloth_blocks] how far what is near the block, cloth or an
                          // obstacle, has moved against it since the reference, at most, m
} PercaleCandidates;

/// False without memory.
bool percale_candidates_create(PercaleCandidates *candidates, const PercaleModel *model, bool cloth,
                               bool edges, bool obstacles, PercaleMemory *memory);
void percale_candidates_free(PercaleCandidates *candidates, PercaleMemory *memory);

/// Whether no two points near each other on these ways have moved against each other by more than `slack`, m,
/// since the lists were made: then those that are in no list are farther apart than margin + reach - slack.
bool percale_candidates_hold(PercaleCandidates *candidates, const f32x4 *from, const f32x4 *to, float slack,
                             PercaleTeam *team);

/// Finds them anew. `places`: positions on whose ways nothing may be missed; the last is the reference.
bool percale_candidates_find(PercaleCandidates *candidates, const f32x4 *const *places, int place_count,
                             PercaleCollectors *collectors, PercaleMemory *memory, PercaleTeam *team,
                             uint64_t *tested);

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

/// The pairs [first, end) of one item.
typedef struct PercaleCandidateRun {
    size_t first, end;
    uint32_t place; // in the list's order, ascending from run to run
    uint32_t item;
} PercaleCandidateRun;

/// The run that begins at `first` or next after it; first is the list's count when there is none.
PercaleCandidateRun percale_candidates_run(const PercaleCandidateList *list, size_t first);

/// That of the item at this place; empty when there is none.
PercaleCandidateRun percale_candidates_run_at(const PercaleCandidateList *list, uint32_t place);

/// Those pairs of a run that can be within `reach` of each other now, as the collector's `touched`. False
/// without memory.
bool percale_candidates_select(const PercaleCandidates *candidates, uint32_t list, PercaleCandidateRun run,
                               float reach, PercaleCollector *collector);

/// The neighbours of a run's item, which is the query, as the collector's; it is no longer complete without
/// memory.
void percale_candidates_ask(const PercaleCandidates *candidates, uint32_t list, PercaleCandidateRun run,
                            const PercaleNeighborhood *hood, const PercaleQuery *query,
                            PercaleCollector *collector);

/// An item of a list, as a query; `edge`: else a vertex.
PercaleQuery percale_candidate_query(const PercaleCandidates *candidates, const PercaleModelSurface *mesh,
                                     bool edge, uint32_t item);

#endif
