// collect.h: stencils found by many threads, in an order that does not depend on them.
//
//   in   a number of items, a function that finds the stencils of a range of them
//   out  the stencils, ordered by item
//
// The items are cut into shares, each with lists of its own, which are appended in order.

#ifndef PERCALE_COLLECT_H
#define PERCALE_COLLECT_H

#include "base/parallel.h"
#include "detect/neighbors.h"
#include "detect/stencil.h"
#include "detect/surface.h"

typedef struct PercaleStencilList {
    PercaleStencil *items;
    size_t count, capacity;
} PercaleStencilList;

/// What is kept of a pair from one pass to the next: its side.
typedef struct PercalePairNote {
    uint64_t key;    // kind and the two features
    uint64_t source; // of its stencil
    f32x4 normal;    // of an edge pair; of a vertex and a face [3] is the side, +1 or -1; zero: it was born
                     // crossed and belongs nowhere
} PercalePairNote;

typedef struct PercaleNoteList {
    PercalePairNote *items;
    size_t count, capacity;
} PercaleNoteList;

/// One share's lists, kept between calls; on cache lines of their own, for the counts change with every item.
typedef struct PercaleCollector {
    _Alignas(64) PercaleFeatureList features; // scratch of one item
    PercaleNodeList nodes;                    // too
    PercaleItemPairList touched;              // of some items
    PercaleNodeList numbers;                  // theirs, among the pairs of their block
    PercaleNeighborList found;                // of some items
    PercaleNeighborList neighbors;            // of one item: a part of those found
    PercaleStencilList stencils;
    PercaleNoteList notes;
    PercaleItemPairList pairs;
    PercaleMemory memory;
    uint64_t source;       // of the stencils that are found now
    uint64_t candidates;   // pairs looked at
    uint64_t born_crossed; // edges and faces
    bool complete;         // there was memory
} PercaleCollector;

typedef struct PercaleCollectors {
    PercaleCollector shares[PERCALE_MAX_THREADS];
    uint64_t candidates;   // pairs that the last call has looked at
    uint64_t born_crossed; // of it, too
} PercaleCollectors;

/// Finds the stencils of the items [first, end).
typedef void PercaleFind(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end);

/// Where it goes; NULL: nothing of the kind is found.
typedef struct PercaleCollected {
    PercaleStencilList *stencils;
    PercaleNoteList *notes;
    PercaleItemPairList *pairs;
} PercaleCollected;

/// Appends to the lists. False without memory.
bool percale_collect(PercaleTeam *team, uint64_t item_count, PercaleFind *find, const void *context,
                     PercaleCollectors *collectors, PercaleMemory *memory, const PercaleCollected *to);
void percale_collectors_free(PercaleCollectors *collectors, PercaleMemory *memory);

/// Adds one to the share's stencils; without memory the share is no longer complete.
void percale_collect_stencil(PercaleCollector *collector, const PercaleStencil *stencil);
void percale_collect_note(PercaleCollector *collector, PercalePairNote note);
void percale_collect_pair(PercaleCollector *collector, PercaleItemPair pair);

#endif
