#include "detect/pair_pages.h"

enum { SLAB_PAGES = 64 };

typedef union PercaleFreePage {
    PercalePairPage page;
    union PercaleFreePage *next;
} PercaleFreePage;

typedef struct PercalePairSlab {
    PercaleFreePage pages[SLAB_PAGES];
    struct PercalePairSlab *next;
} PercalePairSlab;

static bool add_slab(PercalePairPool *pool, PercaleMemory *memory)
{
    PercalePairSlab *slab = percale_memory_new(memory, 1, sizeof(*slab));
    if (slab == NULL) {
        return false;
    }
    slab->next = pool->slabs;
    pool->slabs = slab;
    for (uint32_t i = 0; i < SLAB_PAGES; i++) {
        slab->pages[i].next = pool->free;
        pool->free = &slab->pages[i];
    }
    return true;
}

/// Adds pages to a block's, whose array has room. False without memory.
static bool take_pages(PercalePairPool *pool, PercaleBlockPairs *pairs, uint32_t count, PercaleMemory *memory)
{
    bool complete = true;
    while (atomic_flag_test_and_set_explicit(&pool->busy, memory_order_acquire)) {
    }
    while (complete && pairs->page_count < count) {
        complete = pool->free != NULL || add_slab(pool, memory);
        if (complete) {
            PercaleFreePage *taken = pool->free;
            pool->free = taken->next;
            pairs->pages[pairs->page_count++] = &taken->page;
        }
    }
    atomic_flag_clear_explicit(&pool->busy, memory_order_release);
    return complete;
}

bool percale_pair_pages_take(PercalePairPool *pool, PercaleBlockPairs *pairs, size_t count,
                             PercaleMemory *memory, PercaleMemory *pool_memory)
{
    size_t page_count = (count + PAGE_PAIRS - 1) / PAGE_PAIRS;
    return count <= UINT32_MAX &&
           percale_memory_reserve(memory, &pairs->pages, &pairs->page_capacity, page_count,
                                  sizeof(PercalePairPage *)) &&
           take_pages(pool, pairs, (uint32_t)page_count, pool_memory);
}

void percale_pair_pages_give(PercalePairPool *pool, PercaleBlockPairs *pairs)
{
    for (; pairs->page_count > 0; pairs->page_count--) {
        PercaleFreePage *given = (PercaleFreePage *)(void *)pairs->pages[pairs->page_count - 1];
        given->next = pool->free;
        pool->free = given;
    }
    pairs->count = 0;
}

void percale_pair_pool_free(PercalePairPool *pool, PercaleMemory *memory)
{
    while (pool->slabs != NULL) {
        PercalePairSlab *slab = pool->slabs;
        pool->slabs = slab->next;
        percale_memory_free(memory, slab);
    }
    pool->free = NULL;
}
