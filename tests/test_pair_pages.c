// Pages of pairs go from block to block: each belongs to one, and none is made while some are left.

#include "testing.h"

#include "base/team.h"
#include "detect/pair_pages.h"

#include <stdlib.h>

enum { BLOCKS = 500, TURNS = 6, MOST = 300 };

/// An allocator that can be told to have nothing more.
static void *take(void *user, size_t size, size_t alignment)
{
    const bool *empty = user;
    return *empty ? NULL : aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void give(void *user, void *memory)
{
    (void)user;
    free(memory);
}

/// Blocks that take pages in parallel. Counts what is wrong instead of failing: Check's assertions belong to
/// the thread that runs the test.
typedef struct Blocks {
    PercalePairPool pool;
    PercaleBlockPairs pairs[BLOCKS];
    uint32_t counts[BLOCKS];
    PercaleAllocator allocator;
    PercaleMemory memory, memories[BLOCKS];
    bool empty;
} Blocks;

static void take_range(void *context, uint32_t first, uint32_t end)
{
    Blocks *blocks = context;
    for (uint32_t b = first; b < end; b++) {
        PercaleBlockPairs *pairs = &blocks->pairs[b];
        if (percale_pair_pages_take(&blocks->pool, pairs, blocks->counts[b], &blocks->memories[b],
                                    &blocks->memory)) {
            for (; pairs->count < blocks->counts[b]; pairs->count++) {
                page_of_pair(pairs, pairs->count)->primitives[pairs->count % PAGE_PAIRS] = b;
            }
        }
    }
}

static void take_all(PercaleTeam *team, void *context)
{
    percale_team_for(team, BLOCKS, 1, take_range, context);
}

static Blocks *open_blocks(void)
{
    Blocks *blocks = calloc(1, sizeof(*blocks));
    ck_assert_ptr_nonnull(blocks);
    blocks->allocator = (PercaleAllocator){take, give, &blocks->empty};
    blocks->memory.allocator = &blocks->allocator;
    for (uint32_t b = 0; b < BLOCKS; b++) {
        blocks->memories[b].allocator = &blocks->allocator;
    }
    return blocks;
}

static void close_blocks(Blocks *blocks)
{
    for (uint32_t b = 0; b < BLOCKS; b++) {
        percale_memory_free(&blocks->memories[b], blocks->pairs[b].pages);
        ck_assert_uint_eq(blocks->memories[b].bytes, 0);
    }
    percale_pair_pool_free(&blocks->pool, &blocks->memory);
    ck_assert_uint_eq(blocks->memory.bytes, 0);
    free(blocks);
}

static void give_all(Blocks *blocks)
{
    for (uint32_t b = 0; b < BLOCKS; b++) {
        percale_pair_pages_give(&blocks->pool, &blocks->pairs[b]);
        ck_assert_uint_eq(blocks->pairs[b].page_count, 0);
        ck_assert_uint_eq(blocks->pairs[b].count, 0);
    }
}

/// Each turn the blocks want the same numbers in another order: whatever the team, the pool never grows.
START_TEST(pages_go_round)
{
    const int threads[] = {1, 2, 7};
    Blocks *blocks = open_blocks();
    PercaleCrowding crowding = {0, 0};
    uint64_t held = 0;
    for (uint32_t turn = 0; turn < TURNS; turn++) {
        for (uint32_t b = 0; b < BLOCKS; b++) {
            blocks->counts[b] = (b + 17 * turn) % BLOCKS % MOST;
        }
        percale_team_open(threads[turn % 3], &crowding, take_all, blocks);
        for (uint32_t b = 0; b < BLOCKS; b++) {
            PercaleBlockPairs *pairs = &blocks->pairs[b];
            ck_assert_uint_eq(pairs->count, blocks->counts[b]);
            for (uint32_t i = 0; i < pairs->count; i++) {
                ck_assert_uint_eq(page_of_pair(pairs, i)->primitives[i % PAGE_PAIRS], b);
            }
        }
        held = turn == 0 ? blocks->memory.bytes : held;
        ck_assert_uint_eq(blocks->memory.bytes, held);
        give_all(blocks);
    }
    close_blocks(blocks);
}
END_TEST

/// Without memory a block has none that it could lose, and what there is goes on.
START_TEST(without_memory_nothing_is_lost)
{
    Blocks *blocks = open_blocks();
    PercaleBlockPairs *pairs = blocks->pairs;
    uint64_t held = 0;
    for (int turn = 0; turn < 3; turn++) {
        blocks->empty = turn == 1;
        for (int b = 0; b < 2; b++) {
            bool expected = turn == 0 ? true : b == 0 || turn == 2;
            size_t count = turn == 0 ? PAGE_PAIRS : b == 0 ? PAGE_PAIRS / 2 : 100 * PAGE_PAIRS;
            ck_assert(percale_pair_pages_take(&blocks->pool, &pairs[b], count, &blocks->memories[b],
                                              &blocks->memory) == expected);
        }
        held = turn == 0 ? blocks->memory.bytes : held;
        ck_assert(turn == 2 ? blocks->memory.bytes > held : blocks->memory.bytes == held);
        give_all(blocks);
    }
    close_blocks(blocks);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("pair_pages");
    TCase *pages = tcase_create("pages");
    tcase_add_test(pages, pages_go_round);
    tcase_add_test(pages, without_memory_nothing_is_lost);
    suite_add_tcase(suite, pages);
    return percale_test_run(suite);
}
