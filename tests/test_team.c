// The team: every chunk of every phase once, phases one after the other, and nobody waits for who isn't
// running.

#include "testing.h"

#include "base/parallel.h"
#include "base/reduce.h"
#include "base/team.h"
#include "base/timer.h"

#include <fenv.h>
#include <omp.h>
#include <pthread.h>
#include <sched.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum {
    ITEMS = 4000,                          // the longest phase
    JOBS = PERCALE_SANITIZED ? 300 : 3000, // in a row
    TEAM_COUNT = 4,                        // thread counts below
    TEAM_MOST = 7                          // the largest of them
};
static const int TEAMS[TEAM_COUNT] = {1, 2, 3, TEAM_MOST};
static const double LONGEST_WAIT = 30.0; // s; beyond it a test gives up on a thread that never comes

static void open_team(int thread_count, PercaleLead *lead, void *context)
{
    PercaleCrowding crowding = {0};
    omp_set_dynamic(0);
    percale_team_open(thread_count, &crowding, lead, context);
}

// ---- every item once ----

/// How often each item has been run, and whether its phase may run yet. Counts what is wrong instead of
/// failing: Check's assertions belong to the thread that runs the test.
typedef struct Tally {
    atomic_uint runs[ITEMS];
    uint32_t first, end, grain;
    uint32_t longest; // items that a chunk may have
    atomic_uint misplaced;
} Tally;

static void tally_range(void *context, uint32_t first, uint32_t end)
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

static void lead_shapes(PercaleTeam *team, void *context)
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

static void expect_each_once(Tally *tally)
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

static Tally *new_tallies(void)
{
    Tally *tallies = calloc(SHAPES, sizeof(Tally));
    ck_assert_ptr_nonnull(tallies);
    return tallies;
}

static void expect_shapes(Shapes *shapes)
{
    for (uint32_t i = 0; i < SHAPES; i++) {
        expect_each_once(&shapes->tallies[i]);
    }
    free(shapes->tallies);
}

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

static uint32_t random_below(uint64_t *seed, uint32_t limit)
{
    return (uint32_t)(percale_test_random(seed) * limit);
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

/// Comes back when `size` callers are there.
static void meet(atomic_uint *present, uint32_t size)
{
    atomic_fetch_add(present, 1);
    double since = percale_seconds();
    while (atomic_load(present) < size && percale_seconds() - since < LONGEST_WAIT) {
        (void)sched_yield();
    }
}

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

static void nap(long milliseconds)
{
    struct timespec time = {0, milliseconds * 1000000};
    (void)nanosleep(&time, NULL);
}

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

// ---- smaller teams than asked for ----

START_TEST(openmp_may_grant_fewer_threads)
{
    int levels = omp_get_max_active_levels();
    for (int i = 0; i < 3; i++) {
        Shapes shapes = {new_tallies(), 0};
        PercaleCrowding crowding = {0};
        omp_set_num_threads(i == 0 ? 1 : TEAM_MOST);
        omp_set_dynamic(i == 1);
        omp_set_max_active_levels(i == 2 ? 0 : levels);
        percale_team_open(TEAM_MOST, &crowding, lead_shapes, &shapes);
        ck_assert_int_ge(shapes.size, 1);
        ck_assert_int_le(shapes.size, TEAM_MOST);
        if (i == 2) {
            ck_assert_int_eq(shapes.size, 1);
        }
        expect_shapes(&shapes);
    }
    omp_set_max_active_levels(levels);
    omp_set_dynamic(0);
}
END_TEST

enum { HOSTS = 3 };

START_TEST(a_team_inside_a_parallel_region_does_everything)
{
    int levels = omp_get_max_active_levels();
    for (int active = 1; active <= 2; active++) { // 1: inner teams have one thread, 2: as many as asked for
        Shapes shapes[HOSTS];
        for (int h = 0; h < HOSTS; h++) {
            shapes[h] = (Shapes){new_tallies(), 0};
        }
        omp_set_max_active_levels(active);
        omp_set_dynamic(0);
#pragma omp parallel default(none) shared(shapes) num_threads(HOSTS)
        {
            PercaleCrowding crowding = {0};
#pragma omp for
            for (int h = 0; h < HOSTS; h++) {
                percale_team_open(2, &crowding, lead_shapes, &shapes[h]);
            }
        }
        for (int h = 0; h < HOSTS; h++) {
            ck_assert_int_eq(shapes[h].size, active);
            expect_shapes(&shapes[h]);
        }
    }
    omp_set_max_active_levels(levels);
}
END_TEST

// ---- floating point ----

/// What a thread's arithmetic makes of two sums that depend on the mode.
typedef struct Arithmetic {
    float tiny; // a denormal times 1
    float sum;  // 1 plus a trifle, rounded
} Arithmetic;

static Arithmetic calculate(void)
{
    volatile float denormal = 1e-40f;
    volatile float one = 1.0f;
    volatile float trifle = 1e-10f;
    volatile float tiny = denormal * one; // stored here: compilers move sums across changes of the mode
    volatile float sum = one + trifle;
    return (Arithmetic){tiny, sum};
}

/// A chunk for each thread: none returns before all are there, so each thread has one.
typedef struct Meeting {
    atomic_uint present;
    uint32_t size;
    Arithmetic found[TEAM_MOST], leader;
    int thread[TEAM_MOST];
} Meeting;

static void meet_range(void *context, uint32_t first, uint32_t end)
{
    Meeting *meeting = context;
    for (uint32_t i = first; i < end; i++) {
        meeting->found[i] = calculate();
        meeting->thread[i] = omp_get_thread_num();
        if (meeting->size > 1) {
            meet(&meeting->present, meeting->size);
        }
    }
}

static void lead_meeting(PercaleTeam *team, void *context)
{
    Meeting *meeting = context;
    meeting->leader = calculate();
    meeting->size = (uint32_t)percale_team_size(team);
    percale_team_for(team, meeting->size, 1, meet_range, meeting);
}

static void expect_same_arithmetic(Arithmetic a, Arithmetic b)
{
    ck_assert_mem_eq(&a, &b, sizeof(a));
}

START_TEST(every_thread_calculates_alike_inside_and_as_before_outside)
{
    Meeting meeting = {.size = 0};
    uint32_t mode = float_mode_enter();
    Arithmetic inside = calculate();
    float_mode_leave(mode);
    ck_assert_int_eq(fesetround(FE_UPWARD), 0);
    Arithmetic outside = calculate();
    ck_assert(outside.tiny > 0.0f && outside.sum > 1.0f);
    open_team(TEAMS[_i], lead_meeting, &meeting);
    Arithmetic after = calculate();
    ck_assert_int_eq(fesetround(FE_TONEAREST), 0);
    expect_same_arithmetic(after, outside);
    expect_same_arithmetic(meeting.leader, inside);
    ck_assert_uint_eq(meeting.size, (uint32_t)TEAMS[_i]);
    uint32_t threads = 0;
    for (uint32_t i = 0; i < meeting.size; i++) {
        expect_same_arithmetic(meeting.found[i], inside);
        threads |= 1u << meeting.thread[i];
    }
    ck_assert_uint_eq(threads, (1u << meeting.size) - 1);
}
END_TEST

// The host's own regions get the same threads again.
START_TEST(the_hosts_threads_calculate_as_before)
{
    Arithmetic before[TEAM_MOST] = {{0}};
    Arithmetic after[TEAM_MOST] = {{0}};
    Meeting meeting = {.size = 0};
    omp_set_dynamic(0);
    for (int round = 0; round < 2; round++) {
        Arithmetic *found = round == 0 ? before : after;
#pragma omp parallel default(none) shared(found) num_threads(TEAM_MOST)
        found[omp_get_thread_num()] = calculate();
        if (round == 0) {
            open_team(TEAM_MOST, lead_meeting, &meeting);
        }
    }
    for (int t = 0; t < TEAM_MOST; t++) {
        ck_assert(before[t].tiny > 0.0f);
        expect_same_arithmetic(before[t], after[t]);
    }
}
END_TEST

// ---- crowding ----

START_TEST(a_crowded_leader_works_alone_for_as_many_openings_as_it_says)
{
    PercaleCrowding crowding = {.alone = 3, .pause = 7};
    for (uint32_t opening = 0; opening < 3; opening++) {
        Shapes shapes = {new_tallies(), 0};
        percale_team_open(TEAM_MOST, &crowding, lead_shapes, &shapes);
        ck_assert_int_eq(shapes.size, 1);
        ck_assert_uint_eq(crowding.alone, 2 - opening);
        ck_assert_uint_eq(crowding.pause, 7);
        expect_shapes(&shapes);
    }
    Shapes shapes = {new_tallies(), 0};
    omp_set_dynamic(0);
    percale_team_open(TEAM_MOST, &crowding, lead_shapes, &shapes);
    ck_assert_int_eq(shapes.size, TEAM_MOST);
    expect_shapes(&shapes);
}
END_TEST

/// Two chunks for two threads: the leader's is done at once, the other's takes its time.
static void wait_range(void *context, uint32_t first, uint32_t end)
{
    atomic_uint *present = context;
    (void)first;
    (void)end;
    meet(present, 2);
    if (omp_get_thread_num() != 0) {
        nap(50);
    }
}

static void lead_waiting(PercaleTeam *team, void *context)
{
    percale_team_for(team, 2, 1, wait_range, context);
}

START_TEST(a_leader_that_waits_for_others_works_alone_twice_as_long_each_time)
{
    static const uint32_t PAUSES[] = {1, 3, 7, 15, 15};
    PercaleCrowding crowding = {0};
    omp_set_dynamic(0);
    for (size_t i = 0; i < sizeof(PAUSES) / sizeof(PAUSES[0]); i++) {
        atomic_uint present = 0;
        percale_team_open(2, &crowding, lead_waiting, &present);
        ck_assert_uint_eq(crowding.pause, PAUSES[i]);
        ck_assert_uint_eq(crowding.alone, PAUSES[i]);
        crowding.alone = 0;
    }
}
END_TEST

static void lead_busy(PercaleTeam *team, void *context)
{
    (void)team;
    (void)context;
    nap(300); // the others come and wait meanwhile
}

START_TEST(a_leader_that_waits_for_nobody_forgets_its_pause)
{
    PercaleCrowding crowding = {.pause = 7};
    omp_set_dynamic(0);
    for (int attempt = 0; attempt < 5 && crowding.pause != 0; attempt++) { // in case the machine is crowded
        crowding = (PercaleCrowding){.pause = 7};
        percale_team_open(2, &crowding, lead_busy, NULL);
    }
    ck_assert_uint_eq(crowding.pause, 0);
    ck_assert_uint_eq(crowding.alone, 0);
}
END_TEST

// ---- reductions ----

enum { VALUES = 3000 };

typedef struct Reduction {
    uint32_t whole[VALUES];
    float real[VALUES];
    ReducedUint least, greatest;
} Reduction;

static void reduce_range(void *context, uint32_t first, uint32_t end)
{
    Reduction *reduction = context;
    for (uint32_t i = first; i < end; i++) {
        reduce_min(&reduction->least, reduction->whole[i]);
        reduce_max_float(&reduction->greatest, reduction->real[i]);
    }
}

static void lead_reduction(PercaleTeam *team, void *context)
{
    percale_team_for(team, VALUES, 16, reduce_range, context);
}

static void shuffle(Reduction *reduction, uint64_t *seed)
{
    for (uint32_t i = VALUES - 1; i > 0; i--) {
        uint32_t j = random_below(seed, i + 1);
        uint32_t whole = reduction->whole[i];
        float real = reduction->real[i];
        reduction->whole[i] = reduction->whole[j];
        reduction->real[i] = reduction->real[j];
        reduction->whole[j] = whole;
        reduction->real[j] = real;
    }
}

START_TEST(least_and_greatest_do_not_depend_on_the_order)
{
    Reduction reduction;
    uint64_t seed = 3;
    for (int trial = 0; trial < 20; trial++) {
        uint32_t least = UINT32_MAX;
        float greatest = 0.0f;
        double scale = trial % 2 == 0 ? 1e-6 : 1e30;
        for (uint32_t i = 0; i < VALUES; i++) {
            reduction.whole[i] = 1000 + random_below(&seed, UINT32_MAX - 1000);
            reduction.real[i] = (float)(scale * percale_test_random(&seed));
            least = reduction.whole[i] < least ? reduction.whole[i] : least;
            greatest = reduction.real[i] > greatest ? reduction.real[i] : greatest;
        }
        for (int order = 0; order < 3; order++) {
            atomic_init(&reduction.least, UINT32_MAX);
            atomic_init(&reduction.greatest, 0);
            open_team(TEAMS[_i], lead_reduction, &reduction);
            ck_assert_uint_eq(reduction.least, least);
            ck_assert(reduced_float(&reduction.greatest) == greatest);
            shuffle(&reduction, &seed);
        }
    }
}
END_TEST

START_TEST(of_nothing_the_greatest_is_zero)
{
    ReducedUint greatest = 0;
    ck_assert(reduced_float(&greatest) == 0.0f);
    reduce_max_float(&greatest, 0.0f);
    ck_assert(reduced_float(&greatest) == 0.0f);
    reduce_max_float(&greatest, HUGE_VALF);
    reduce_max_float(&greatest, 1.0f);
    ck_assert(reduced_float(&greatest) == HUGE_VALF);
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
    TCase *host = tcase_create("host");
    tcase_set_timeout(host, 100.0);
    tcase_add_loop_test(host, the_others_take_every_chunk_while_one_sleeps, 1, TEAM_COUNT);
    tcase_add_test(host, openmp_may_grant_fewer_threads);
    tcase_add_test(host, a_team_inside_a_parallel_region_does_everything);
    tcase_add_loop_test(host, every_thread_calculates_alike_inside_and_as_before_outside, 0, TEAM_COUNT);
    tcase_add_test(host, the_hosts_threads_calculate_as_before);
    suite_add_tcase(suite, host);
    TCase *crowding = tcase_create("crowding");
    tcase_set_timeout(crowding, 60.0);
    tcase_add_test(crowding, a_crowded_leader_works_alone_for_as_many_openings_as_it_says);
    tcase_add_test(crowding, a_leader_that_waits_for_others_works_alone_twice_as_long_each_time);
    tcase_add_test(crowding, a_leader_that_waits_for_nobody_forgets_its_pause);
    suite_add_tcase(suite, crowding);
    TCase *reductions = tcase_create("reductions");
    tcase_set_timeout(reductions, 60.0);
    tcase_add_loop_test(reductions, least_and_greatest_do_not_depend_on_the_order, 0, TEAM_COUNT);
    tcase_add_test(reductions, of_nothing_the_greatest_is_zero);
    suite_add_tcase(suite, reductions);
    return percale_test_run(suite);
}
