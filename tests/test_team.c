// The team: every chunk of every phase once, phases one after the other, and nobody waits for who sleeps.

#include "team_testing.h"

#include <pthread.h>

enum { JOBS = PERCALE_SANITIZED ? 300 : 3000 }; // in a row

// ---- every item once ----

START_TEST(every_item_of_every_phase_is_run_once_in_chunks_of_the_grain)
{
    Shapes shapes = {new_tallies(), 0};
    open_team(TEAMS[_i], lead_shapes, &shapes);
    ck_assert_int_eq(shapes.size, TEAMS[_i]);
    expect_shapes(&shapes);
}
END_TEST

START_TEST(outside_of_a_region_a_team_of_one_does_everything)
{
    Shapes shapes = {new_tallies(), 0};
    lead_shapes(percale_team_alone(), &shapes);
    ck_assert_int_eq(shapes.size, 1);
    expect_shapes(&shapes);
}
END_TEST

// ---- phase after phase ----

enum { CELLS = 60, ROUNDS = PERCALE_SANITIZED ? 60 : 400 };

/// One phase of a chain: each item reads all items of the phase before.
typedef struct Link {
    const uint32_t *before; // [CELLS]
    uint32_t *after;
} Link;

static void follow_range(void *context, uint32_t first, uint32_t end)
{
    const Link *link = context;
    for (uint32_t i = first; i < end; i++) {
        uint32_t sum = i;
        for (uint32_t k = 0; k < CELLS; k++) {
            sum = sum * 31 + link->before[k];
        }
        link->after[i] = sum;
    }
}

typedef struct Chain {
    uint32_t cells[ROUNDS + 1][CELLS];
    Link links[ROUNDS];
    PercalePhase phases[ROUNDS];
} Chain;

static void lead_chain(PercaleTeam *team, void *context)
{
    Chain *chain = context;
    for (uint32_t r = 0; r < ROUNDS; r++) {
        chain->links[r] = (Link){chain->cells[r], chain->cells[r + 1]};
        // a grain of CELLS and more: one chunk, which the leader or the last to finish runs in place
        chain->phases[r] = (PercalePhase){follow_range, &chain->links[r], 0, CELLS, 1 + r * 7 % (CELLS + 5)};
    }
    percale_team_run(team, chain->phases, ROUNDS);
}

START_TEST(a_phase_begins_when_the_one_before_is_done)
{
    Chain *chain = calloc(2, sizeof(Chain));
    ck_assert_ptr_nonnull(chain);
    for (uint32_t r = 0; r < ROUNDS; r++) {
        Link link = {chain[0].cells[r], chain[0].cells[r + 1]};
        follow_range(&link, 0, CELLS);
    }
    for (int again = 0; again < 5; again++) {
        memset(chain[1].cells, 0, sizeof(chain[1].cells));
        open_team(TEAMS[_i], lead_chain, &chain[1]);
        ck_assert_mem_eq(chain[0].cells, chain[1].cells, sizeof(chain[0].cells));
    }
    free(chain);
}
END_TEST

// ---- job after job ----

enum { JOB_ITEMS = 300, JOB_PHASES = 5 };

/// Jobs one after the other; the leader looks after each whether all of it is there.
typedef struct Jobs {
    uint32_t runs[JOB_PHASES][JOB_ITEMS]; // written by the chunks' threads, read by the leader
    uint32_t job_count;
    uint64_t seed;
    uint32_t wrong;
} Jobs;

static void count_range(void *context, uint32_t first, uint32_t end)
{
    uint32_t *runs = context;
    for (uint32_t i = first; i < end; i++) {
        runs[i]++;
    }
}

static void lead_jobs(PercaleTeam *team, void *context)
{
    Jobs *jobs = context;
    for (uint32_t job = 0; job < jobs->job_count; job++) {
        PercalePhase phases[JOB_PHASES] = {{0}};
        uint32_t phase_count = random_below(&jobs->seed, JOB_PHASES + 1);
        for (uint32_t p = 0; p < phase_count; p++) {
            uint32_t first = random_below(&jobs->seed, JOB_ITEMS);
            uint32_t most = percale_test_random(&jobs->seed) < 0.3 ? 2 : JOB_ITEMS - first + 1;
            uint32_t count = random_below(&jobs->seed, most);
            phases[p] = (PercalePhase){count_range, jobs->runs[p], first, first + count,
                                       1 + random_below(&jobs->seed, 40)};
        }
        memset(jobs->runs, 0, sizeof(jobs->runs));
        percale_team_run(team, phases, phase_count);
        for (uint32_t p = 0; p < JOB_PHASES; p++) {
            for (uint32_t i = 0; i < JOB_ITEMS; i++) {
                jobs->wrong += jobs->runs[p][i] != (i >= phases[p].first && i < phases[p].end);
            }
        }
    }
}

START_TEST(thousands_of_jobs_in_a_row_lose_nothing)
{
    Jobs jobs = {.job_count = JOBS, .seed = 1 + (uint64_t)_i};
    open_team(TEAMS[_i], lead_jobs, &jobs);
    ck_assert_uint_eq(jobs.wrong, 0);
}
END_TEST

static void lead_for(PercaleTeam *team, void *context)
{
    Tally *tally = context;
    tally->end = 1234;
    tally->grain = 10;
    tally->longest = percale_team_size(team) > 1 ? tally->grain : UINT32_MAX;
    percale_team_for(team, 0, tally->grain, tally_range, tally);
    percale_team_for(team, tally->end, tally->grain, tally_range, tally);
}

START_TEST(a_loop_is_one_phase_from_zero)
{
    Tally *tally = calloc(1, sizeof(*tally));
    ck_assert_ptr_nonnull(tally);
    open_team(TEAMS[_i], lead_for, tally);
    expect_each_once(tally);
    free(tally);
}
END_TEST

// ---- two teams ----

enum { REGIONS = 5 }; // of each host thread

/// One of two host threads; in each region they begin together.
typedef struct Host {
    Jobs jobs;
    atomic_uint *present; // [REGIONS]
    int region;
} Host;

static void lead_host(PercaleTeam *team, void *context)
{
    Host *host = context;
    meet(&host->present[host->region], 2);
    lead_jobs(team, &host->jobs);
}

static void *host_thread(void *context)
{
    Host *host = context;
    for (host->region = 0; host->region < REGIONS; host->region++) {
        open_team(3, lead_host, host);
    }
    return NULL;
}

// Regions of two host threads know nothing of each other.
START_TEST(two_teams_at_once_do_not_meet)
{
    atomic_uint present[REGIONS] = {0};
    Host hosts[2] = {{{.job_count = JOBS / 10, .seed = 5}, present, 0},
                     {{.job_count = JOBS / 10, .seed = 6}, present, 0}};
    pthread_t threads[2];
    for (int i = 0; i < 2; i++) {
        ck_assert_int_eq(pthread_create(&threads[i], NULL, host_thread, &hosts[i]), 0);
    }
    for (int i = 0; i < 2; i++) {
        ck_assert_int_eq(pthread_join(threads[i], NULL), 0);
    }
    for (int region = 0; region < REGIONS; region++) {
        ck_assert_uint_eq(present[region], 2);
    }
    ck_assert_uint_eq(hosts[0].jobs.wrong, 0);
    ck_assert_uint_eq(hosts[1].jobs.wrong, 0);
}
END_TEST

// ---- who sleeps ----

enum { NAP_CHUNKS = 40 };

/// The first chunk that is taken sleeps until all others of its phase are done.
typedef struct Nap {
    atomic_uint taken, done;
    atomic_uint done_before;   // of a phase before this one
    uint32_t others_at_waking; // chunks that were done when the sleeper gave up or woke
    uint32_t late;             // chunks of the next phase that began too early
} Nap;

static void nap_range(void *context, uint32_t first, uint32_t end)
{
    Nap *naps = context;
    (void)first;
    (void)end;
    if (atomic_fetch_add(&naps->taken, 1) == 0) {
        double since = percale_seconds();
        while (atomic_load(&naps->done) < NAP_CHUNKS - 1 && percale_seconds() - since < LONGEST_WAIT) {
            nap(1);
        }
        naps->others_at_waking = atomic_load(&naps->done);
    }
    atomic_fetch_add(&naps->done, 1);
}

static void wake_range(void *context, uint32_t first, uint32_t end)
{
    Nap *naps = context;
    if (first == 0) {
        naps->late = atomic_load(&naps->done) != NAP_CHUNKS;
    }
    atomic_fetch_add(&naps->done_before, end - first);
}

static void lead_naps(PercaleTeam *team, void *context)
{
    const PercalePhase phases[2] = {{nap_range, context, 0, NAP_CHUNKS, 1},
                                    {wake_range, context, 0, NAP_CHUNKS, 1}};
    percale_team_run(team, phases, 2);
}

START_TEST(the_others_take_every_chunk_while_one_sleeps)
{
    for (int again = 0; again < 5; again++) {
        Nap naps = {0};
        open_team(TEAMS[_i], lead_naps, &naps);
        ck_assert_uint_eq(naps.others_at_waking, NAP_CHUNKS - 1);
        ck_assert_uint_eq(naps.done, NAP_CHUNKS);
        ck_assert_uint_eq(naps.done_before, NAP_CHUNKS);
        ck_assert_uint_eq(naps.late, 0);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("team");
    TCase *phases = tcase_create("phases");
    tcase_set_timeout(phases, 60.0);
    tcase_add_loop_test(phases, every_item_of_every_phase_is_run_once_in_chunks_of_the_grain, 0, TEAM_COUNT);
    tcase_add_test(phases, outside_of_a_region_a_team_of_one_does_everything);
    tcase_add_loop_test(phases, a_phase_begins_when_the_one_before_is_done, 0, TEAM_COUNT);
    tcase_add_loop_test(phases, thousands_of_jobs_in_a_row_lose_nothing, 0, TEAM_COUNT);
    tcase_add_loop_test(phases, a_loop_is_one_phase_from_zero, 0, TEAM_COUNT);
    tcase_add_test(phases, two_teams_at_once_do_not_meet);
    suite_add_tcase(suite, phases);
    TCase *sleep = tcase_create("who sleeps");
    tcase_set_timeout(sleep, 100.0);
    tcase_add_loop_test(sleep, the_others_take_every_chunk_while_one_sleeps, 1, TEAM_COUNT);
    suite_add_tcase(suite, sleep);
    return percale_test_run(suite);
}
