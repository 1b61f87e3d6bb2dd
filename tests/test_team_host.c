// The team in the hands of its host: OpenMP grants fewer threads or crowds them, floating-point modes differ,
// and the host's own regions find their threads as before.

#include "team_testing.h"

#include "base/parallel.h"

#include <fenv.h>

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

int main(void)
{
    Suite *suite = suite_create("team and host");
    TCase *host = tcase_create("host");
    tcase_set_timeout(host, 100.0);
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
    return percale_test_run(suite);
}
