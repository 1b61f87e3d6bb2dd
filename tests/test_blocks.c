// Laws of blocks of points: what they say that points have moved against each other since a moment is never
// less than the truth, and nothing where all move alike.

#include "detect/blocks.h"
#include "testing.h"

#include <string.h>

enum { BLOCKS = 12, CLOTH_BLOCKS = 9, BLOCK_POINTS = 10, POINTS = BLOCKS * BLOCK_POINTS, STEPS = 300 };
static const float REACH = 0.05f; // m
static const float FAR = 0.2f;    // m

/// Blocks of points that move at random, and where the points were when each block's moment began.
typedef struct Swarm {
    PercaleMemory memory;
    PercaleAllocator allocator;
    PercaleBlocks blocks;
    f32x4 from[POINTS], to[POINTS];
    f32x4 then[BLOCKS][POINTS];
    bool remember, again;
    uint64_t seed;
    bool found_here[BLOCKS]; // their moment is one of these ways
} Swarm;

static float around_zero(Swarm *swarm)
{
    return (float)(2.0 * percale_test_random(&swarm->seed) - 1.0);
}

/// Blocks along a row, each with two points of the next one.
static void open_swarm(Swarm *swarm)
{
    *swarm = (Swarm){.allocator = percale_allocator_default(), .seed = 5};
    swarm->memory = (PercaleMemory){&swarm->allocator, 0};
    for (uint32_t i = 0; i < POINTS; i++) {
        uint32_t block = i / BLOCK_POINTS;
        float along = 0.1f * (float)block;
        swarm->to[i] = (f32x4){along + 0.1f * around_zero(swarm), 0.1f * around_zero(swarm), 0.0f, 0.0f};
        swarm->from[i] = swarm->to[i];
    }
    PercaleBlockLister lister = {.last = percale_memory_new(&swarm->memory, POINTS, sizeof(uint32_t))};
    for (uint32_t b = 0; b < BLOCKS; b++) {
        ck_assert(percale_blocks_open(&lister, &swarm->memory));
        for (uint32_t i = 0; i < BLOCK_POINTS + 2; i++) {
            uint32_t point = (b * BLOCK_POINTS + i) % POINTS;
            ck_assert(percale_blocks_add(&lister, point, &swarm->memory));
            ck_assert(percale_blocks_add(&lister, point, &swarm->memory)); // it has that
        }
    }
    ck_assert_uint_eq(lister.point_count, BLOCKS * (BLOCK_POINTS + 2));
    ck_assert(percale_blocks_create(&swarm->blocks, &lister, CLOTH_BLOCKS, swarm->to, &swarm->memory));
    percale_memory_free(&swarm->memory, lister.last);
}

static void close_swarm(Swarm *swarm)
{
    percale_blocks_free(&swarm->blocks, &swarm->memory);
    ck_assert_uint_eq(swarm->memory.bytes, 0);
}

/// The listed blocks begin the newest moment.
static void begin(Swarm *swarm, uint32_t *listed, uint32_t count, float most)
{
    PercaleBlockList list = {listed, count};
    percale_blocks_begin(&swarm->blocks, &list, swarm->from, swarm->to, most, (PercaleBlockReach){REACH, FAR},
                         percale_team_alone());
    for (uint32_t i = 0; i < count; i++) {
        memcpy(swarm->then[listed[i]], swarm->to, sizeof(swarm->to));
        swarm->found_here[listed[i]] = true;
    }
}

static void look(Swarm *swarm)
{
    PercaleBlockWays ways = {swarm->from, swarm->to, swarm->again};
    for (uint32_t b = 0; b < BLOCKS && !swarm->again; b++) {
        swarm->found_here[b] = false;
    }
    percale_blocks_measure(&swarm->blocks, &ways, swarm->remember, percale_team_alone());
    percale_blocks_compare(&swarm->blocks, 0, BLOCKS, (PercaleBlockReach){REACH, FAR}, percale_team_alone());
}

/// How far points of two blocks have moved against each other since the first one's moment; where that is one
/// of these ways, at their ends only.
static float moved_against(const Swarm *swarm, uint32_t a, uint32_t b)
{
    const PercaleBlocks *blocks = &swarm->blocks;
    float most = 0.0f;
    for (uint32_t i = blocks->first[a]; i < blocks->first[a + 1]; i++) {
        for (uint32_t k = blocks->first[b]; k < blocks->first[b + 1]; k++) {
            uint32_t p = blocks->points[i];
            uint32_t q = blocks->points[k];
            f32x4 apart = swarm->then[a][p] - swarm->then[a][q];
            bool both = !swarm->remember || !swarm->found_here[a];
            most = both ? fmaxf(most, length3(swarm->from[p] - swarm->from[q] - apart)) : most;
            most = fmaxf(most, length3(swarm->to[p] - swarm->to[q] - apart));
        }
    }
    return most;
}

static bool are_near(const Swarm *swarm, uint32_t a, uint32_t b, float reach)
{
    const PercaleBlock *blocks = swarm->blocks.items;
    f32x4 apart = max4(blocks[a].low - blocks[b].high, blocks[b].low - blocks[a].high);
    return fmaxf(apart[0], fmaxf(apart[1], apart[2])) <= reach;
}

/// Each block has a motion of its own, turns to and fro, and trembles.
static void move(Swarm *swarm, int step)
{
    memcpy(swarm->from, swarm->to, sizeof(swarm->to));
    for (uint32_t i = 0; i < POINTS; i++) {
        uint32_t b = i / BLOCK_POINTS;
        float turn = (step / 10 % 2 == 0 ? 0.02f : -0.02f) * (float)(b % 3);
        f32x4 x = swarm->from[i];
        float sway = (step / 20 + (int)b) % 2 == 0 ? 0.001f : -0.001f;
        swarm->to[i] += (f32x4){sway - turn * x[1], turn * (x[0] - 0.1f * (float)b) - 0.05f,
                                0.0005f * around_zero(swarm), 0.0f};
    }
}

/// Moments begin at random, and for all whose moment is forgotten; anchors are seldom or often new.
START_TEST(what_blocks_have_moved_is_never_more_than_they_say)
{
    Swarm swarm;
    open_swarm(&swarm);
    uint32_t all[BLOCKS];
    for (uint32_t b = 0; b < BLOCKS; b++) {
        all[b] = b;
    }
    look(&swarm);
    begin(&swarm, all, BLOCKS, 0.0f);
    uint32_t near_count = 0;
    double share = 0.0;
    double moved[2] = {0.0, 0.0}; // of those that begin a moment, before and after
    for (int step = 0; step < STEPS; step++) {
        move(&swarm, step);
        look(&swarm);
        uint32_t listed[BLOCKS];
        uint32_t count = 0;
        for (uint32_t a = 0; a < BLOCKS; a++) {
            float truth = 0.0f;
            for (uint32_t b = 0; b < CLOTH_BLOCKS; b++) {
                truth = are_near(&swarm, a, b, REACH) ? fmaxf(truth, moved_against(&swarm, a, b)) : truth;
                near_count += are_near(&swarm, a, b, REACH);
            }
            float said = swarm.blocks.items[a].moved;
            ck_assert_msg(said >= truth, "step %d, block %u: %g of %g m", step, a, (double)said,
                          (double)truth);
            share += (double)(truth / fmaxf(said, 1e-9f)) / (BLOCKS * STEPS);
            if (swarm.blocks.items[a].moment == percale_blocks_oldest(&swarm.blocks) ||
                percale_test_random(&swarm.seed) < 0.03) {
                listed[count++] = a;
                moved[0] += (double)said;
            }
        }
        begin(&swarm, listed, count, step % 100 < 50 ? 0.002f : 1.0f);
        for (uint32_t i = 0; i < count; i++) { // what they have moved is found anew: on this way
            float truth = 0.0f;
            for (uint32_t b = 0; b < CLOTH_BLOCKS; b++) {
                uint32_t a = listed[i];
                truth = are_near(&swarm, a, b, REACH) ? fmaxf(truth, moved_against(&swarm, a, b)) : truth;
            }
            ck_assert(swarm.blocks.items[listed[i]].moved >= truth);
            moved[1] += (double)swarm.blocks.items[listed[i]].moved;
        }
    }
    ck_assert_uint_gt(near_count, 2 * BLOCKS * STEPS);
    ck_assert_msg(share > 0.2, "%g", share); // nor is it much less
    ck_assert(moved[1] < 0.7 * moved[0]);
    close_swarm(&swarm);
}
END_TEST

/// How far points of two blocks have moved against each other from one place to another.
static float between_places(const Swarm *swarm, uint32_t a, uint32_t b, const f32x4 *before, const f32x4 *now)
{
    const PercaleBlocks *blocks = &swarm->blocks;
    float most = 0.0f;
    for (uint32_t i = blocks->first[a]; i < blocks->first[a + 1]; i++) {
        for (uint32_t k = blocks->first[b]; k < blocks->first[b + 1]; k++) {
            uint32_t p = blocks->points[i];
            uint32_t q = blocks->points[k];
            most = fmaxf(most, length3(now[p] - now[q] - (before[p] - before[q])));
        }
    }
    return most;
}

/// What a block says is no less than what is true. Adds to the shares that the truth has of it.
static void expect_turned(const Swarm *swarm, uint32_t a, const f32x4 *last, double shares[2])
{
    const PercaleBlock *block = &swarm->blocks.items[a];
    float turned = 0.0f;
    float drifted = 0.0f;
    for (uint32_t b = 0; b < CLOTH_BLOCKS; b++) {
        if (are_near(swarm, a, b, FAR)) {
            turned = fmaxf(turned, between_places(swarm, a, b, swarm->from, swarm->to));
            drifted = fmaxf(drifted, between_places(swarm, a, b, last, swarm->to));
        }
    }
    ck_assert(block->turned >= turned);
    ck_assert(block->drifted >= drifted);
    shares[0] += (double)(turned / fmaxf(block->turned, 1e-9f)) / (BLOCKS * STEPS);
    shares[1] += (double)(drifted / fmaxf(block->drifted, 1e-9f)) / (BLOCKS * STEPS);
}

/// Remembered at random, as between passes with looks ahead.
START_TEST(what_has_turned_and_drifted_is_never_more_than_they_say)
{
    Swarm swarm;
    open_swarm(&swarm);
    f32x4 last[POINTS];
    swarm.remember = true;
    double shares[2] = {0.0, 0.0};
    for (int step = 0; step < STEPS; step++) {
        look(&swarm);
        for (uint32_t a = 0; step > 0 && a < BLOCKS; a++) {
            expect_turned(&swarm, a, last, shares);
        }
        if (swarm.remember) {
            memcpy(last, swarm.to, sizeof(last));
        }
        swarm.remember = percale_test_random(&swarm.seed) < 0.5;
        move(&swarm, step);
    }
    ck_assert_msg(shares[0] > 0.5 && shares[1] > 0.5, "%g %g", shares[0], shares[1]); // nor is it much less
    close_swarm(&swarm);
}
END_TEST

/// Some points of a few blocks end elsewhere; blocks say what they would if all were measured.
static void shove(Swarm *swarm)
{
    uint32_t first = (uint32_t)(percale_test_random(&swarm->seed) * BLOCKS);
    for (uint32_t i = 0; i < POINTS; i++) {
        if (i / BLOCK_POINTS == first && percale_test_random(&swarm->seed) < 0.3) {
            swarm->to[i] += (f32x4){0.02f * around_zero(swarm), 0.0f, 0.02f * around_zero(swarm), 0.0f};
        }
    }
}

static bool same_bits(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

/// Returns how many blocks stood and say the same.
static uint32_t expect_same(const Swarm *swarm, const Swarm *twin)
{
    uint32_t stood = 0;
    for (uint32_t b = 0; b < BLOCKS; b++) {
        const PercaleBlock *said = &swarm->blocks.items[b];
        const PercaleBlock *whole = &twin->blocks.items[b];
        ck_assert(same_bits(said->centre, whole->centre, sizeof(said->centre)));
        ck_assert(same_bits(said->deviation, whole->deviation, sizeof(said->deviation)));
        ck_assert(said->turned >= whole->turned);
        for (uint32_t other = 0; other < CLOTH_BLOCKS; other++) {
            ck_assert(!are_near(swarm, b, other, REACH) || said->moved >= moved_against(swarm, b, other));
        }
        ck_assert(said->drifted == whole->drifted);
        stood += !said->changed && said->turned == whole->turned;
    }
    return stood;
}

static uint32_t count_changed(const Swarm *swarm)
{
    uint32_t changed = 0;
    for (uint32_t b = 0; b < BLOCKS; b++) {
        changed += swarm->blocks.items[b].changed;
    }
    return changed;
}

/// Some get anchors of their own, in both.
static void begin_some(Swarm *swarm, Swarm *twin)
{
    uint32_t listed[BLOCKS] = {(uint32_t)(percale_test_random(&swarm->seed) * BLOCKS)};
    uint32_t count = 1;
    for (uint32_t b = 0; b < BLOCKS; b++) {
        if (b != listed[0] && swarm->blocks.items[b].moment == percale_blocks_oldest(&swarm->blocks)) {
            listed[count++] = b;
        }
    }
    begin(swarm, listed, count, 1.0f);
    begin(twin, listed, count, 1.0f);
}

static void open_twins(Swarm *swarm, Swarm *twin)
{
    uint32_t all[BLOCKS];
    for (uint32_t b = 0; b < BLOCKS; b++) {
        all[b] = b;
    }
    Swarm *both[2] = {swarm, twin};
    for (int i = 0; i < 2; i++) {
        open_swarm(both[i]);
        both[i]->remember = true;
        look(both[i]);
        begin(both[i], all, BLOCKS, 0.0f);
    }
}

START_TEST(what_is_measured_again_says_the_same)
{
    Swarm swarm;
    Swarm twin; // is measured as a whole
    open_twins(&swarm, &twin);
    uint32_t stood = 0;
    uint32_t changed = 0;
    for (int step = 0; step < STEPS; step++) {
        swarm.again = step % 6 != 0;
        if (swarm.again) {
            shove(&swarm);
        } else {
            move(&swarm, step);
        }
        memcpy(twin.from, swarm.from, sizeof(twin.from));
        memcpy(twin.to, swarm.to, sizeof(twin.to));
        look(&swarm);
        look(&twin);
        stood += expect_same(&swarm, &twin);
        changed += count_changed(&swarm);
        if (percale_test_random(&swarm.seed) < 0.3) {
            begin_some(&swarm, &twin);
        }
    }
    ck_assert_uint_gt(stood, BLOCKS * STEPS / 2);
    ck_assert_uint_gt(changed, BLOCKS * STEPS / 6);
    close_swarm(&swarm);
    close_swarm(&twin);
}
END_TEST

START_TEST(what_moves_alike_has_not_moved)
{
    Swarm swarm;
    open_swarm(&swarm);
    uint32_t all[BLOCKS];
    for (uint32_t b = 0; b < BLOCKS; b++) {
        all[b] = b;
    }
    look(&swarm);
    begin(&swarm, all, BLOCKS, 0.0f);
    swarm.remember = true;
    for (int step = 0; step < 10; step++) {
        memcpy(swarm.from, swarm.to, sizeof(swarm.to));
        for (uint32_t i = 0; i < POINTS; i++) {
            swarm.to[i] += (f32x4){1.0f, -0.5f, 0.25f, 0.0f};
        }
        look(&swarm);
        for (uint32_t b = 0; b < BLOCKS; b++) {
            const PercaleBlock *block = &swarm.blocks.items[b];
            ck_assert(block->moved < 1e-3f); // a ten-thousandth of the way, for rounding
            ck_assert(block->turned < 1e-3f);
            ck_assert(step == 0 || block->drifted < 1e-3f);
        }
    }
    close_swarm(&swarm);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("blocks");
    TCase *blocks = tcase_create("blocks");
    tcase_add_test(blocks, what_blocks_have_moved_is_never_more_than_they_say);
    tcase_add_test(blocks, what_has_turned_and_drifted_is_never_more_than_they_say);
    tcase_add_test(blocks, what_is_measured_again_says_the_same);
    tcase_add_test(blocks, what_moves_alike_has_not_moved);
    suite_add_tcase(suite, blocks);
    return percale_test_run(suite);
}
