// The impact times of straight motions against an exact oracle, on queries that are hard on purpose.
//
// `test_impact --full` asks 10^6 queries of each of the first two laws instead of some 20,000 and 5,000,
// which takes some minutes, and tells what each family came to.

#include "impact_oracle.h"
#include "impact_queries.h"
#include "testing.h"

#include "detect/impact_time.h"
#include "percale/geometry.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static const double APART = 1e-9; // of the differences of coordinates: beyond it a hit is a false one
static const double FALSE_HITS_MOST = 1e-3; // of the queries that stay so far apart
static const double TIME_EARLY = 1e-6;      // at most, where the features close in
// A distance of these shares of the differences of coordinates and of the motion is a touch up to rounding.
// Features may all but touch long before they do.
static const double ROUNDING = 4e-15;
static const double ROUNDING_OF_WAY = 1e-11;
static const double CLOSING = 1e-3; // of the motion, per unit of time: that is closing in

static bool full;

/// ck_assert_msg writes to a file whether it holds or not: too slow for millions.
#define EXPECT(CONDITION, ...) ((CONDITION) ? (void)0 : ck_abort_msg(__VA_ARGS__))

static bool ask(const ImpactQuery *query, double separation, double *time)
{
    *time = -1.0;
    bool answer = query->edges ? percale_edge_edge_approach(query->start, query->end, separation, time)
                               : percale_vertex_face_approach(query->start, query->end, separation, time);
    EXPECT(answer ? *time >= 0.0 && *time <= 1.0 : *time == -1.0, "time %g", *time);
    return answer;
}

static const char *text_of(const ImpactQuery *query)
{
    static char text[2000];
    size_t used = 0;
    for (int i = 0; i < 8; i++) {
        const double *x = i < 4 ? query->start[i] : query->end[i - 4];
        used += (size_t)snprintf(text + used, sizeof(text) - used, "{%a, %a, %a}, ", x[0], x[1], x[2]);
    }
    return text;
}

/// What a family's queries came to.
typedef struct Tally {
    int hits;
    int apart;       // that stay apart by more than rounding
    int false_hits;  // of these
    int closing;     // hits with closing speed
    int almost;      // of these, that all but touch before: left out
    int undecided;   // the oracle can't tell: left out
    double earliest; // of their times, before the true one
} Tally;

static void add_tally(Tally *sum, const Tally *tally)
{
    sum->hits += tally->hits;
    sum->apart += tally->apart;
    sum->false_hits += tally->false_hits;
    sum->closing += tally->closing;
    sum->almost += tally->almost;
    sum->undecided += tally->undecided;
    sum->earliest = fmax(sum->earliest, tally->earliest);
}

static void tell(const char *name, const Tally *tally)
{
    if (full) {
        printf("%-32s %8d hits %8d apart %6d false %8d closing, %d almost before, %d undecided, at most %.2g "
               "early\n",
               name, tally->hits, tally->apart, tally->false_hits, tally->closing, tally->almost,
               tally->undecided, tally->earliest);
        (void)fflush(stdout);
    }
}

/// Judges a time where the distance falls fast enough just before the first touch.
static void judge_time(const char *name, const ImpactQuery *query, double separation, double first,
                       double time, Tally *tally)
{
    double before = first - TIME_EARLY;
    double way = impact_way(query);
    if (before <= 0.0 || (double)impact_distance(query, before) - separation <= CLOSING * way * TIME_EARLY) {
        return;
    }
    double touch = ROUNDING * (impact_size(query) + separation) + ROUNDING_OF_WAY * way;
    if (time < before && (double)impact_distance(query, time) - separation <= touch) {
        tally->almost++;
        return;
    }
    tally->closing++;
    tally->earliest = fmax(tally->earliest, first - time);
    EXPECT(time >= before, "%s: %.17g is %g before %.17g, separation %a: %s", name, time, first - time, first,
           separation, text_of(query));
}

/// At the time of an answer: samples may miss that it is small there.
static double distance_then(const ImpactQuery *query, bool answer, double time)
{
    return answer ? (double)impact_distance(query, time) : HUGE_VAL;
}

// ---- touching ----

static void judge_touch(ImpactFamily family, const ImpactQuery *query, Tally *tally)
{
    static ImpactTruth truth;
    double time;
    double when;
    exact_forget();
    impact_truth(query, &truth);
    bool answer = ask(query, 0.0, &time);
    const char *name = impact_family_name(family);
    if (truth.undecided) {
        tally->undecided++;
        return;
    }
    if (truth.count == 0) {
        double least = fmin(impact_least_distance(query, &when), distance_then(query, answer, time));
        bool apart = least > APART * impact_size(query);
        tally->apart += apart;
        tally->false_hits += apart && answer;
        return;
    }
    tally->hits++;
    EXPECT(answer, "%s: missed at %.17g: %s", name, impact_truth_time(&truth), text_of(query));
    EXPECT(impact_truth_order(&truth, time) >= 0, "%s: %.17g is later than %.17g: %s", name, time,
           impact_truth_time(&truth), text_of(query));
    judge_time(name, query, 0.0, impact_truth_time(&truth), time, tally);
}

typedef void Judge(ImpactFamily family, const ImpactQuery *query, Tally *tally);

/// Asks `count` queries of every family and kind; a family needs hits and misses for its count to tell.
static void judge_families(Judge *judge, int count, uint64_t seed)
{
    Tally whole = {0};
    for (int kind = 0; kind < 2 * FAMILY_COUNT; kind++) {
        ImpactFamily family = (ImpactFamily)(kind / 2);
        bool edges = kind % 2 == 1;
        Tally tally = {0};
        for (int i = 0; i < count; i++) {
            ImpactQuery query = impact_query(family, edges, &seed);
            judge(family, &query, &tally);
        }
        char name[100];
        (void)snprintf(name, sizeof(name), "%s, %s", impact_family_name(family), edges ? "edges" : "face");
        tell(name, &tally);
        add_tally(&whole, &tally);
    }
    tell("all", &whole);
    ck_assert_int_gt(whole.hits, FAMILY_COUNT * count / 4);
    ck_assert_int_gt(whole.apart, FAMILY_COUNT * count / 4);
    ck_assert_int_gt(whole.closing, FAMILY_COUNT * count / 10);
    ck_assert_int_lt(whole.undecided, FAMILY_COUNT * count / 100);
    ck_assert_msg((double)whole.false_hits <= FALSE_HITS_MOST * (double)whole.apart,
                  "%d of %d that stay apart are hits", whole.false_hits, whole.apart);
}

static int queries_of_each_kind(int most)
{
    return full ? 1000000 / (2 * FAMILY_COUNT) + 1 : PERCALE_SANITIZED ? most / 10 : most;
}

START_TEST(no_touch_is_missed_and_no_time_is_late)
{
    judge_families(judge_touch, queries_of_each_kind(800), 1);
}
END_TEST

// ---- coming within a separation ----

/// The first time at which the distance is within the separation, as far as samples find it; else 2.
static double first_within(const ImpactQuery *query, double separation)
{
    enum { SAMPLES = 64 };
    double least_at;
    double least = impact_least_distance(query, &least_at);
    double high = least <= separation ? least_at : 2.0;
    for (int i = 0; i <= SAMPLES && (double)i / SAMPLES < high; i++) {
        if ((double)impact_distance(query, (double)i / SAMPLES) <= separation) {
            high = (double)i / SAMPLES;
        }
    }
    if (high > 1.0) {
        return high;
    }
    double low = fmax(0.0, high - 1.0 / SAMPLES);
    for (int round = 0; round < DBL_MANT_DIG; round++) {
        double middle = 0.5 * (low + high);
        if ((double)impact_distance(query, middle) <= separation) {
            high = middle;
        } else {
            low = middle;
        }
    }
    return high;
}

/// Below the least distance, what the distance is at the start or the end, or any.
static double separation_for(const ImpactQuery *query, double least)
{
    uint64_t seed = 1 + (uint64_t)(1e6 * fabs(query->start[0][0] - query->end[1][1]));
    double kind = percale_test_random(&seed);
    double share = percale_test_random(&seed);
    if (kind < 0.5) {
        return least * (kind < 0.3 ? share : 1.0 - pow(10.0, -9.0 * share));
    }
    if (kind < 0.7) {
        return (double)impact_distance(query, share < 0.5 ? 0.0 : 1.0);
    }
    return kind < 0.8 ? 1.0 : impact_size(query) * pow(10.0, -6.0 * share);
}

static void judge_approach(ImpactFamily family, const ImpactQuery *query, Tally *tally)
{
    double time;
    double when;
    double least = impact_least_distance(query, &when);
    double separation = separation_for(query, least);
    double first = first_within(query, separation);
    bool answer = ask(query, separation, &time);
    const char *name = impact_family_name(family);
    exact_forget();
    if (first <= 1.0 && (!answer || first < time) && impact_within(query, separation, first)) {
        ck_abort_msg("%s: within %a at %.17g, answer %d %.17g: %s", name, separation, first, (int)answer,
                     time, text_of(query));
    }
    if (first <= 1.0 && !answer) { // within it only by the samples' rounding
        tally->undecided++;
        return;
    }
    if (first > 1.0) {
        least = fmin(least, distance_then(query, answer, time));
        bool apart = least > separation + APART * (impact_size(query) + separation);
        tally->apart += apart;
        tally->false_hits += apart && answer;
        return;
    }
    tally->hits++;
    judge_time(name, query, separation, first, time, tally);
}

START_TEST(no_approach_is_missed_and_no_time_is_late)
{
    judge_families(judge_approach, queries_of_each_kind(200), 2);
}
END_TEST

// ---- what else is promised ----

static void to_vectors(const ImpactQuery *query, Vec3 from[4], Vec3 to[4])
{
    for (int k = 0; k < 4; k++) {
        from[k] = vec3(query->start[k][0], query->start[k][1], query->start[k][2]);
        to[k] = vec3(query->end[k][0], query->end[k][1], query->end[k][2]);
    }
}

static bool ask_inside(const ImpactQuery *query, double separation, PercaleImpact *impact)
{
    Vec3 from[4];
    Vec3 to[4];
    to_vectors(query, from, to);
    return query->edges ? percale_edge_edge_impact_time(from, to, separation, impact)
                        : percale_vertex_face_impact_time(from, to, separation, impact);
}

/// How far the first feature is beyond the second along the normal, and the closest points' distance.
static double room_along(const ImpactQuery *query, const PercaleImpact *impact, double *distance)
{
    Vec3 from[4];
    Vec3 to[4];
    Vec3 apart = vec3(0.0, 0.0, 0.0);
    double low = HUGE_VAL;
    double high = -HUGE_VAL;
    to_vectors(query, from, to);
    for (int k = 0; k < 4; k++) {
        from[k] = vsub(from[k], vec3(query->start[0][0], query->start[0][1], query->start[0][2]));
        to[k] = vsub(to[k], vec3(query->end[0][0], query->end[0][1], query->end[0][2]));
        Vec3 x = vadd(vscale(1.0 - impact->time, from[k]), vscale(impact->time, to[k]));
        double along = vdot(x, impact->normal);
        if (k < (query->edges ? 2 : 1)) {
            low = fmin(low, along);
        } else {
            high = fmax(high, along);
        }
        apart = vadd(apart, vscale(impact->weights[k], x));
    }
    *distance = vlength(apart);
    return low - high;
}

/// Returns whether there is a plane.
static bool judge_plane(const ImpactQuery *query, double separation, const PercaleImpact *impact)
{
    const double TOLERANCE = 1e-13; // of the differences of coordinates
    const double CLOSEST = 1e-7;    // the same for the closest points of what is nearly a line
    double size = impact_size(query);
    double distance;
    double room = room_along(query, impact, &distance);
    double sum = (impact->weights[0] + impact->weights[1]) + (impact->weights[2] + impact->weights[3]);
    EXPECT(fabs(sum) <= 1e-15, "the weights sum to %g", sum);
    EXPECT(fabs(distance - (double)impact_distance(query, impact->time)) <= CLOSEST * size,
           "the closest points are %g apart, not %Lg", distance, impact_distance(query, impact->time));
    double length = vlength(impact->normal);
    if (length == 0.0) {
        EXPECT(impact->time == 0.0, "no plane at %g", impact->time);
        return false;
    }
    EXPECT(fabs(length - 1.0) <= 1e-15, "a normal as long as %g", length);
    EXPECT(room >= separation - TOLERANCE * size, "%g between the features, separation %g", room, separation);
    return true;
}

START_TEST(the_plane_of_an_impact_is_between_the_features)
{
    enum { QUERIES = PERCALE_SANITIZED ? 50 : 500 };
    uint64_t seed = 3;
    int planes = 0;
    for (int i = 0; i < 2 * FAMILY_COUNT * QUERIES; i++) {
        ImpactQuery query = impact_query((ImpactFamily)(i / 2 % FAMILY_COUNT), i % 2 == 1, &seed);
        double separation = i % 4 < 2 ? 0.0 : impact_size(&query) * percale_test_random(&seed);
        PercaleImpact impact;
        if (ask_inside(&query, separation, &impact)) {
            planes += judge_plane(&query, separation, &impact);
        }
    }
    ck_assert_int_gt(planes, FAMILY_COUNT * QUERIES / 4);
}
END_TEST

/// A vertex far above a face, and an edge above an edge: at rest.
static const ImpactQuery FAR_APART[] = {
    {false,
     {{0.2, 0.3, 1.0}, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}},
     {{0.2, 0.3, 1.0}, {0.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}},
    {true,
     {{0.0, 0.0, 1.0}, {1.0, 1.0, 1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}},
     {{0.0, 0.0, 1.0}, {1.0, 1.0, 1.0}, {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}},
};

static void expect_nothing_proved(const ImpactQuery *query, double separation, const char *what)
{
    double time;
    bool answer = ask(query, separation, &time);
    ck_assert_msg(answer && time == 0.0, "%s: answer %d, time %g", what, (int)answer, time);
}

START_TEST(what_is_no_number_is_a_touch_at_once)
{
    static const double VALUES[] = {(double)NAN, (double)INFINITY, -(double)INFINITY, 1e300, -DBL_MAX};
    for (size_t kind = 0; kind < 2; kind++) {
        const ImpactQuery *whole = &FAR_APART[kind];
        double time;
        ck_assert(!ask(whole, 0.0, &time));
        for (size_t value = 0; value < sizeof(VALUES) / sizeof(VALUES[0]); value++) {
            for (int place = 0; place < 12; place++) {
                ImpactQuery broken = *whole;
                broken.start[place / 3][place % 3] = VALUES[value];
                expect_nothing_proved(&broken, 0.0, "start");
                broken.end[place / 3][place % 3] = VALUES[value];
                expect_nothing_proved(&broken, 0.0, "start and end");
                broken = *whole;
                broken.end[place / 3][place % 3] = VALUES[value];
                expect_nothing_proved(&broken, 0.0, "end");
            }
            expect_nothing_proved(whole, VALUES[value], "separation");
        }
        expect_nothing_proved(whole, -1e-9, "separation below 0");
    }
}
END_TEST

/// The features shrunk, and half a unit apart.
static ImpactQuery speck_of(const ImpactQuery *query, double size)
{
    ImpactQuery speck = *query;
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            bool above = k < (speck.edges ? 2 : 1) && c == 2;
            speck.start[k][c] = size * query->start[k][c] + (above ? 0.5 : 0.0);
            speck.end[k][c] = size * query->end[k][c] + (above ? 0.625 : 0.0);
        }
    }
    return speck;
}

/// Also where the squares of their areas underflow.
START_TEST(specks_meet_like_points)
{
    static const double SIZES[] = {1e-30, 1e-50, 1e-70, 1e-80, 1e-90, 1e-120, 1e-150, 1e-200, 1e-300, 0.0};
    for (size_t i = 0; i < 2 * sizeof(SIZES) / sizeof(SIZES[0]); i++) {
        double size = SIZES[i / 2];
        double time;
        ImpactQuery speck = speck_of(&FAR_APART[i % 2], size);
        EXPECT(ask(&speck, 1.0, &time) && time == 0.0, "missed at %g", size);
        EXPECT(ask(&speck, 0.5, &time) && time == 0.0, "missed at %g, at the separation", size);
        EXPECT(!ask(&speck, 0.25, &time), "a false hit at %g", size);
    }
}
END_TEST

/// The names without a separation are those with 0.
START_TEST(an_impact_is_an_approach_to_nothing)
{
    enum { QUERIES = 100 };
    uint64_t seed = 5;
    for (int i = 0; i < 2 * QUERIES; i++) {
        ImpactQuery made = impact_query(i < QUERIES ? GRID : GRAZING, i % 2 == 1, &seed);
        const ImpactQuery *query = &made;
        double time = -1.0;
        double expected;
        bool answer = query->edges ? percale_edge_edge_impact(query->start, query->end, &time)
                                   : percale_vertex_face_impact(query->start, query->end, &time);
        ck_assert(answer == ask(query, 0.0, &expected));
        ck_assert_double_eq(time, expected);
    }
}
END_TEST

static ImpactQuery in_unit(const ImpactQuery *query, double unit)
{
    ImpactQuery scaled = *query;
    for (int k = 0; k < 4; k++) {
        for (int c = 0; c < 3; c++) {
            scaled.start[k][c] *= unit;
            scaled.end[k][c] *= unit;
        }
    }
    return scaled;
}

/// Answers and times don't depend on the unit, from 1e-30 to 1e48 of it: powers of two, so the same bits.
START_TEST(the_unit_of_length_does_not_matter)
{
    enum { QUERIES = PERCALE_SANITIZED ? 20 : 200 };
    static const double UNITS[] = {0x1p-100, 0x1p-60, 0x1p60, 0x1p160};
    uint64_t seed = 4;
    for (int i = 0; i < 2 * FAMILY_COUNT * QUERIES; i++) {
        ImpactQuery query = impact_query((ImpactFamily)(i / 2 % FAMILY_COUNT), i % 2 == 1, &seed);
        double separation = i % 4 < 2 ? 0.0 : impact_size(&query) * percale_test_random(&seed);
        double time;
        bool answer = ask(&query, separation, &time);
        for (size_t unit = 0; unit < sizeof(UNITS) / sizeof(UNITS[0]); unit++) {
            ImpactQuery scaled = in_unit(&query, UNITS[unit]);
            double scaled_time;
            bool scaled_answer = ask(&scaled, UNITS[unit] * separation, &scaled_time);
            EXPECT(scaled_answer == answer && scaled_time == time, "unit %g: %d %.17g, not %d %.17g: %s",
                   UNITS[unit], (int)scaled_answer, scaled_time, (int)answer, time, text_of(&query));
        }
    }
}
END_TEST

int main(int argc, char **argv)
{
    full = argc > 1 && strcmp(argv[1], "--full") == 0;
    Suite *suite = suite_create("impact");
    TCase *impact = tcase_create("impact");
    tcase_set_tags(impact, PERCALE_ONE_THREAD);
    tcase_set_timeout(impact, 0);
    tcase_add_test(impact, no_touch_is_missed_and_no_time_is_late);
    tcase_add_test(impact, no_approach_is_missed_and_no_time_is_late);
    tcase_add_test(impact, the_plane_of_an_impact_is_between_the_features);
    tcase_add_test(impact, what_is_no_number_is_a_touch_at_once);
    tcase_add_test(impact, specks_meet_like_points);
    tcase_add_test(impact, an_impact_is_an_approach_to_nothing);
    tcase_add_test(impact, the_unit_of_length_does_not_matter);
    suite_add_tcase(suite, impact);
    return percale_test_run(suite);
}
