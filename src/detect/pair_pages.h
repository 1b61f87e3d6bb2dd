// pair_pages.h: room for the pairs of all blocks, in pages that go from those that need fewer to those that
// need more.
//
// Blocks have many pairs by turns, so lists of their own would stay as long as each has ever been: 68 pairs
// a vertex where 14 are the most at one time (`drape`, 65,536 vertices).

#ifndef PERCALE_PAIR_PAGES_H
#define PERCALE_PAIR_PAGES_H

#include "base/memory.h"

#include <stdatomic.h>
#include <stdint.h>

enum { PAGE_PAIRS = 32 };

static const uint32_t PAIR_WATCHED = 1U << 31; // of a primitive

typedef struct PercalePairPage {
    float bounds[PAGE_PAIRS];        // m; when the blocks were last remembered, a pair was no nearer than
                                     // this less what is lost
    float distances[PAGE_PAIRS];     // m, when they were found
    uint32_t primitives[PAGE_PAIRS]; // with PAIR_WATCHED: who asked last wants to see the pair as long as it
                                     // is within reach; else, where pairs wait, only when it is nearer
} PercalePairPage;

/// The pairs of a block, by item.
typedef struct PercaleBlockPairs {
    PercalePairPage **pages; // [page_count]
    size_t page_capacity;
    uint32_t page_count, count;
    float lost;
} PercaleBlockPairs;

/// Pages that belong to no block, and who owns them all.
typedef struct PercalePairPool {
    struct PercalePairSlab *slabs;
    union PercaleFreePage *free;
    atomic_flag busy; // some thread is taking pages
} PercalePairPool;

static inline PercalePairPage *page_of_pair(const PercaleBlockPairs *pairs, uint32_t pair)
{
    return pairs->pages[pair / PAGE_PAIRS];
}

/// Room for that many pairs of a block that has none; many threads may ask at a time. False without memory.
/// `memory` is the thread's, `pool_memory` that of whoever frees the pool.
bool percale_pair_pages_take(PercalePairPool *pool, PercaleBlockPairs *pairs, size_t count,
                             PercaleMemory *memory, PercaleMemory *pool_memory);

/// Gives a block's pages back; one thread at a time.
void percale_pair_pages_give(PercalePairPool *pool, PercaleBlockPairs *pairs);

void percale_pair_pool_free(PercalePairPool *pool, PercaleMemory *memory);

#endif
