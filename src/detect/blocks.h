// blocks.h: how far groups of points have moved against each other since each of several moments.
//
//   in   groups of points that lie together, the starts and the ends of their ways
//   out  for each of them how far its points have moved against what is near them now, at most
//
// A block's motion is that of its centre and the greatest deviation from it, so what all fall together costs
// nothing. Each block counts from a moment of its own, when something was found for it. A few moments are
// kept, with all blocks as they were then: since one of them, for points p of block a and q of block b,
//
//     |D_p - D_q| <= |D_centre_a - D_centre_b| + spread_a + spread_b
//
// whether the two were near each other then or not. A block's deviation is measured from places of its own,
// its anchors. Its spread since a moment is how far it had deviated from its anchors then, how far at each
// change of them since, and how far it does now. Where a block's moment is the end of ways that start where
// these do, all of those ways was searched, and only where these end counts.
//
// Besides, all blocks count from the last time that they were remembered: for what is asked in every substep
// and known to move little in one.

#ifndef PERCALE_BLOCKS_H
#define PERCALE_BLOCKS_H

#include "detect/tree.h"

/// Moments that are kept; a block whose own is overwritten has to take a new one.
enum { BLOCK_MOMENTS = 64 };

typedef struct PercaleBlock {
    f32x4 low, high;     // box of its points' ways
    f32x4 centre[2];     // m, at their starts and ends
    f32x4 anchor_centre; // m, of its anchors
    float deviation[2];  // m, of any of its points from its anchor, the centre's motion apart, at most
    uint32_t moment;     // from which it counts
    float moved;         // m, since then, its points against any near them on these ways, at most
    f32x4 last_centre;   // m, when last remembered
    f32x4 way, drift;    // m, of its centre on these ways, and to their ends since last remembered; [3]: more
                         // of any of its points, at most
    float turned;        // m, on these ways, its points against any not far from them, at most
    float drifted;       // m, to their ends since last remembered, the same
    bool changed;        // it is not where it was when last measured
    bool fresh;          // its moment is the end of ways that start where these do
} PercaleBlock;

typedef struct PercaleBlocks {
    uint32_t count, cloth_count; // the first are of the cloth: motion against these is asked for
    PercaleBlock *items;
    uint32_t *first;  // [count + 1] into points and anchors
    uint32_t *points; // of each block
    f32x4 *anchors;   // of each point
    f32x4 *lasts;     // of each point, where it was when last remembered
    f32x4 *moments;   // [BLOCK_MOMENTS * count] by block: its centre, and its spread until now without its
                      // deviation of now in [3]
    uint32_t newest;  // of the moments
    f32x4 *corners;   // [2 * cloth_count] of the boxes
    uint32_t *corner_pairs; // [2 * cloth_count] 0, 1, 2 ...: the tree's primitives
    PercaleTree tree;       // over the boxes of the cloth's blocks
    uint8_t *changed;       // [nodes] of the tree: a bit for each child below which a block has changed
    bool remembered;        // at the last measuring, where all points were
} PercaleBlocks;

/// Points of all blocks one after the other, while they are listed.
typedef struct PercaleBlockLister {
    uint32_t *last; // [point_count] the last block that has the point, and 1
    uint32_t *first, *points;
    size_t first_capacity, point_capacity;
    uint32_t count, point_count;
} PercaleBlockLister;

/// Begins a block. False without memory, as the others.
bool percale_blocks_open(PercaleBlockLister *lister, PercaleMemory *memory);
/// Adds a point to the block that was begun last, unless it has it.
bool percale_blocks_add(PercaleBlockLister *lister, uint32_t point, PercaleMemory *memory);
/// Takes the lister's lists; every block counts from the same moment, `x`. To be freed even when it fails.
bool percale_blocks_create(PercaleBlocks *blocks, PercaleBlockLister *lister, uint32_t cloth_count,
                           const f32x4 *x, PercaleMemory *memory);
void percale_blocks_free(PercaleBlocks *blocks, PercaleMemory *memory);

/// How points have got to where they are measured.
typedef struct PercaleBlockWays {
    const f32x4 *from, *to;
    bool again; // they start where they did when last measured; some may end elsewhere
} PercaleBlockWays;

/// Boxes, centres and deviations on these ways. `remember`: from here on drifts count from their ends.
void percale_blocks_measure(PercaleBlocks *blocks, const PercaleBlockWays *ways, bool remember,
                            PercaleTeam *team);

/// Which boxes are compared.
typedef struct PercaleBlockReach {
    float near; // m; what has moved is asked of boxes that are no farther apart
    float far;  // m, too; of what has turned and drifted
} PercaleBlockReach;

/// Finds out how far the blocks [first, end) have moved. What was found for one is left where nothing near it
/// has changed since.
void percale_blocks_compare(PercaleBlocks *blocks, uint32_t first, uint32_t end, PercaleBlockReach reach,
                            PercaleTeam *team);

/// The moment that will be overwritten next.
static inline uint32_t percale_blocks_oldest(const PercaleBlocks *blocks)
{
    return blocks->newest + 1 < BLOCK_MOMENTS ? blocks->newest + 1 : 0;
}

/// Some of them, ascending.
typedef struct PercaleBlockList {
    uint32_t *blocks;
    uint32_t count;
} PercaleBlockList;

/// The ends of the measured ways become the newest moment, from which the listed blocks count now; what they
/// have moved is found anew. They, and those that deviate by more than `most`, m, get anchors there. All that
/// count from the oldest moment must be listed.
void percale_blocks_begin(PercaleBlocks *blocks, const PercaleBlockList *listed, const f32x4 *from,
                          const f32x4 *to, float most, PercaleBlockReach reach, PercaleTeam *team);

#endif
