// team_testing.h: teams of several sizes, and phases of all shapes of which every item has to be run once.

#ifndef PERCALE_TEAM_TESTING_H
#define PERCALE_TEAM_TESTING_H

#include "testing.h"

#include "base/team.h"
#include "base/timer.h"

#include <omp.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    ITEMS = 4000,   // the longest phase
    TEAM_COUNT = 4, // thread counts below
    TEAM_MOST = 7   // the largest of them
};
static const int TEAMS[TEAM_COUNT] = {1, 2, 3, TEAM_MOST};
static const double LONGEST_WAIT = 30.0; // s; beyond it a test gives up on a thread that never comes

static inline void open_team(int thread_count, PercaleLead *lead, void *context)
{
    PercaleCrowding crowding = {0};
    omp_set_dynamic(0);
    percale_team_open(thread_count, &crowding, lead, context);
}

static inline uint32_t random_below(uint64_t *seed, uint32_t limit)
{
    return (uint32_t)(percale_test_random(seed) * limit);
}

/// How often each item has been run, and whether its phase may run yet. Counts what is wrong instead of
/// failing: Check's assertions belong to the thread that runs the test.
typedef struct Tally {
    atomic_uint runs[ITEMS];
    uint32_t first, end, grain;
    uint32_t longest; // items that a chunk may have
    atomic_uint misplaced;
} Tally;

static inline void tally_range(void *context, uint32_t first, uint32_t end)
{
    Tally *tally = context;
    bool begins = first >= tally->first && (first - tally->first) % tally->grain == 0;
    bool ends = end <= tally->end && end > first && end - first <= tally->longest &&
                (end == tally->end || (end - tally->first) % tally->grain == 0);
    if (!begins || !ends) {
        atomic_fetch_add(&tally->misplaced, 1);
    }
    for (uint32_t i = first; i < end && i < ITEMS; i++) {
        atomic_fetch_add(&tally->runs[i], 1);
    }
}

enum { SHAPES = 12 };

/// first, end, grain of a job's phases: empty, of one item, of one chunk, of a short last chunk.
static const uint32_t SHAPE[SHAPES][3] = {
    {0, 0, 1},  {0, 1, 1},   {0, ITEMS, 1}, {5, 6, 128}, {7, 1007, 10},   {900, 900, 3},
    {3, 40, 7}, {0, 64, 64}, {1, 66, 64},   {17, 18, 1}, {0, 3999, 2000}, {11, ITEMS, UINT32_MAX}};

typedef struct Shapes {
    Tally *tallies; // [SHAPES]
    int size;
} Shapes;

static inline void lead_shapes(PercaleTeam *team, void *context)
{
    Shapes *shapes = context;
    PercalePhase phases[SHAPES];
    shapes->size = percale_team_size(team);
    for (uint32_t i = 0; i < SHAPES; i++) {
        Tally *tally = &shapes->tallies[i];
        tally->first = SHAPE[i][0];
        tally->end = SHAPE[i][1];
        tally->grain = SHAPE[i][2];
        tally->longest = shapes->size > 1 ? tally->grain : UINT32_MAX; // alone a phase is one call
        phases[i] = (PercalePhase){tally_range, tally, tally->first, tally->end, tally->grain};
    }
    percale_team_run(team, phases, SHAPES);
}

static inline void expect_each_once(Tally *tally)
{
    ck_assert_uint_eq(tally->misplaced, 0);
    for (uint32_t i = 0; i < ITEMS; i++) {
        uint32_t expected = i >= tally->first && i < tally->end;
        if (tally->runs[i] != expected) {
            ck_abort_msg("item %u of [%u, %u) by %u was run %u times", i, tally->first, tally->end,
                         tally->grain, tally->runs[i]);
        }
    }
}

static inline Tally *new_tallies(void)
{
    Tally *tallies = calloc(SHAPES, sizeof(Tally));
    ck_assert_ptr_nonnull(tallies);
    return tallies;
}

static inline void expect_shapes(Shapes *shapes)
{
    for (uint32_t i = 0; i < SHAPES; i++) {
        expect_each_once(&shapes->tallies[i]);
    }
    free(shapes->tallies);
}

static inline void nap(long milliseconds)
{
    struct timespec time = {0, milliseconds * 1000000};
    (void)nanosleep(&time, NULL);
}

/// Comes back when `size` callers are there.
static inline void meet(atomic_uint *present, uint32_t size)
{
    atomic_fetch_add(present, 1);
    double since = percale_seconds();
    while (atomic_load(present) < size && percale_seconds() - since < LONGEST_WAIT) {
        (void)sched_yield();
    }
}

#endif
