// Eight lanes against one: the shuffles of wide.h against plain loops, and the kernels' blocks against the
// same constraints one by one, bit for bit.

#include "kernel_testing.h"

#include "base/parallel.h"
#include "base/wide.h"
#include "finish/advance.h"
#include "predict/predict.h"
#include "solve/solve_arrays.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { TRIALS = 100 };

static uint32_t random_below(uint64_t *seed, uint32_t limit)
{
    return (uint32_t)(percale_test_random(seed) * limit);
}

/// For what == can't tell: NaNs and the sign of zeros.
static bool same_bits(const void *a, const void *b, size_t size)
{
    return size == 0 || memcmp(a, b, size) == 0;
}

// ---- wide.h ----

/// Any bits: numbers, denormals, NaNs with a payload, infinities, negative zeros.
static float any_float(uint64_t *seed)
{
    static const float SPECIAL[] = {0.0f, -0.0f, HUGE_VALF, -HUGE_VALF, 1e-40f, -FLT_MIN, FLT_MAX, 1.0f};
    if (percale_test_random(seed) < 0.3) {
        return SPECIAL[random_below(seed, 8)];
    }
    uint32_t bits = random_below(seed, UINT32_MAX);
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static f32x4 any_point(uint64_t *seed)
{
    float p[4];
    f32x4 point;
    for (int k = 0; k < 4; k++) {
        p[k] = any_float(seed);
    }
    memcpy(&point, p, sizeof(point));
    return point;
}

static f32x8 any_pair(uint64_t *seed)
{
    f32x4 points[2] = {any_point(seed), any_point(seed)};
    f32x8 pair;
    memcpy(&pair, points, sizeof(pair));
    return pair;
}

static f32x8 random_pair(uint64_t *seed)
{
    f32x8 pair;
    for (int k = 0; k < 8; k++) {
        pair[k] = random_float(seed, -2.0, 2.0);
    }
    return pair;
}

static void lanes_of(f32x8 pair, float lanes[8])
{
    memcpy(lanes, &pair, 8 * sizeof(float));
}

static void expect_lanes(f32x8 pair, const float expected[8])
{
    ck_assert_mem_eq(&pair, expected, 8 * sizeof(float));
}

START_TEST(a_pair_is_its_two_points)
{
    uint64_t seed = 1;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x4 points[2] = {any_point(&seed), any_point(&seed)};
        f32x8 pair = pair_of_points(points[0], points[1]);
        f32x4 back[2] = {low_point(pair), high_point(pair)};
        ck_assert_mem_eq(&pair, points, sizeof(pair));
        ck_assert_mem_eq(back, points, sizeof(back));
    }
}
END_TEST

#define EXPECT_SHUFFLE(i, j, k, l)                                                                          \
    do {                                                                                                    \
        const int from[4] = {i, j, k, l};                                                                   \
        float expected[8];                                                                                  \
        for (int lane = 0; lane < 8; lane++) {                                                              \
            int half = lane / 4 * 4;                                                                        \
            int source = from[lane % 4];                                                                    \
            memcpy(&expected[lane], source < 4 ? &a[half + source] : &b[half + source - 4], sizeof(float)); \
        }                                                                                                   \
        expect_lanes(SHUFFLE_HALVES(wide_a, wide_b, i, j, k, l), expected);                                 \
    } while (0)

START_TEST(shuffles_stay_inside_the_halves)
{
    uint64_t seed = 2;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 wide_a = any_pair(&seed);
        f32x8 wide_b = any_pair(&seed);
        float a[8];
        float b[8];
        lanes_of(wide_a, a);
        lanes_of(wide_b, b);
        EXPECT_SHUFFLE(0, 1, 2, 3);
        EXPECT_SHUFFLE(4, 5, 6, 7);
        EXPECT_SHUFFLE(0, 4, 1, 5);
        EXPECT_SHUFFLE(2, 6, 3, 7);
        EXPECT_SHUFFLE(0, 1, 4, 5);
        EXPECT_SHUFFLE(2, 3, 6, 7);
        EXPECT_SHUFFLE(3, 0, 7, 4);
        EXPECT_SHUFFLE(6, 6, 1, 5);
    }
}
END_TEST

#define EXPECT_SPREAD(k)                                                    \
    do {                                                                    \
        float expected[8];                                                  \
        for (int lane = 0; lane < 8; lane++) {                              \
            memcpy(&expected[lane], &a[lane / 4 * 4 + (k)], sizeof(float)); \
        }                                                                   \
        expect_lanes(SPREAD(pair, k), expected);                            \
    } while (0)

START_TEST(spreading_fills_each_half_with_its_own_component)
{
    uint64_t seed = 3;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 pair = any_pair(&seed);
        float a[8];
        lanes_of(pair, a);
        EXPECT_SPREAD(0);
        EXPECT_SPREAD(1);
        EXPECT_SPREAD(2);
        EXPECT_SPREAD(3);
    }
}
END_TEST

START_TEST(transposing_gives_the_components_of_eight_points_in_order)
{
    uint64_t seed = 4;
    for (int trial = 0; trial < TRIALS; trial++) {
        float points[8][4];
        float expected[4][8];
        f32x8 pairs[4];
        for (int k = 0; k < 4; k++) {
            f32x4 low = any_point(&seed);
            f32x4 high = any_point(&seed);
            memcpy(points[k], &low, sizeof(low));
            memcpy(points[k + 4], &high, sizeof(high));
            pairs[k] = pair_of_points(low, high);
        }
        for (int i = 0; i < 8; i++) {
            for (int axis = 0; axis < 4; axis++) {
                memcpy(&expected[axis][i], &points[i][axis], sizeof(float));
            }
        }
        WidePoints wide = transpose_pairs(pairs);
        expect_lanes(wide.x, expected[0]);
        expect_lanes(wide.y, expected[1]);
        expect_lanes(wide.z, expected[2]);
        expect_lanes(transpose_w(pairs), expected[3]);
    }
}
END_TEST

START_TEST(dot_products_stand_in_all_places_of_their_half)
{
    uint64_t seed = 5;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 a = random_pair(&seed);
        f32x8 b = random_pair(&seed);
        float expected[8];
        for (int lane = 0; lane < 8; lane++) {
            int half = lane / 4 * 4;
            expected[lane] = (a[half] * b[half] + a[half + 1] * b[half + 1]) + a[half + 2] * b[half + 2];
        }
        expect_lanes(dot3_pairs(a, b), expected);
    }
}
END_TEST

START_TEST(square_roots_are_those_of_the_lanes)
{
    uint64_t seed = 6;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 a = random_pair(&seed);
        a = a * a * (trial % 2 == 0 ? 1e-30f : 1e30f);
        a[trial % 8] = trial % 3 == 0 ? -0.0f : HUGE_VALF;
        float expected[8];
        for (int lane = 0; lane < 8; lane++) {
            expected[lane] = sqrtf(a[lane]);
        }
        expect_lanes(sqrt8(a), expected);
    }
}
END_TEST

START_TEST(masks_choose_bits_lane_by_lane)
{
    uint64_t seed = 7;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 wide_a = any_pair(&seed);
        f32x8 wide_b = any_pair(&seed);
        float a[8];
        float b[8];
        float chosen[8];
        float kept[8] = {0.0f};
        float first_three[8] = {0.0f};
        i32x8 mask = {0};
        uint32_t set = random_below(&seed, 256);
        lanes_of(wide_a, a);
        lanes_of(wide_b, b);
        for (int lane = 0; lane < 8; lane++) {
            bool on = (set >> lane & 1) != 0;
            mask[lane] = on ? -1 : 0;
            memcpy(&chosen[lane], on ? &a[lane] : &b[lane], sizeof(float));
            memcpy(&kept[lane], on ? &a[lane] : &kept[lane], sizeof(float));
            memcpy(&first_three[lane], lane % 4 != 3 ? &a[lane] : &first_three[lane], sizeof(float));
        }
        expect_lanes(select8(mask, wide_a, wide_b), chosen);
        expect_lanes(where8(mask, wide_a), kept);
        expect_lanes(without_w(wide_a), first_three);
        ck_assert_uint_eq(lane_bits(mask), set);
    }
}
END_TEST

START_TEST(one_or_two_points_are_loaded_and_stored_and_nothing_beside_them)
{
    uint64_t seed = 8;
    for (uint32_t count = 1; count <= 2; count++) {
        for (int trial = 0; trial < TRIALS; trial++) {
            f32x4 *source = malloc(count * sizeof(f32x4)); // no byte more: the sanitizer sees what is read
            f32x4 place[4];
            f32x4 expected[4];
            ck_assert_ptr_nonnull(source);
            for (uint32_t i = 0; i < 4; i++) {
                place[i] = any_point(&seed);
            }
            memcpy(expected, place, sizeof(place));
            for (uint32_t i = 0; i < count; i++) {
                source[i] = any_point(&seed);
                memcpy(&expected[1 + i], &source[i], sizeof(f32x4));
            }
            f32x8 pair = load_two(source, count);
            ck_assert_mem_eq(&pair, source, count * sizeof(f32x4));
            if (count == 1) {
                f32x4 other = high_point(pair);
                ck_assert_mem_eq(&other, source, sizeof(f32x4));
            }
            store_two(place + 1, pair, count);
            ck_assert_mem_eq(place, expected, sizeof(place));
            free(source);
        }
    }
}
END_TEST

START_TEST(what_is_not_finite_is_seen_in_its_own_lane_alone)
{
    static const float BAD[3] = {NAN, HUGE_VALF, -HUGE_VALF};
    static const float GOOD[8] = {0.0f, -0.0f, FLT_MAX, -FLT_MAX, FLT_MIN, 1e-40f, 1.0f, -3.0f};
    for (int first = 0; first < 8; first++) {
        f32x8 good;
        for (int lane = 0; lane < 8; lane++) {
            good[lane] = GOOD[(first + lane) % 8];
        }
        ck_assert_uint_eq(lane_bits(not_finite8(good)), 0);
        for (int lane = 0; lane < 8; lane++) {
            for (int kind = 0; kind < 3; kind++) {
                f32x8 bad = good;
                bad[lane] = BAD[kind];
                ck_assert_uint_eq(lane_bits(not_finite8(bad)), 1u << lane);
                bad[(lane + 3) % 8] = BAD[(kind + 1) % 3];
                ck_assert_uint_eq(lane_bits(not_finite8(bad)), 1u << lane | 1u << (lane + 3) % 8);
            }
        }
    }
}
END_TEST

// ---- kernels: constraints that share no point ----

enum {
    MOST = 300,             // constraints
    POINT_COUNT = 6 * MOST, // four for each, and every third one belongs to nobody
    SHARED = 3,             // fixed points that contacts share; the last of all
    TOTAL = POINT_COUNT + SHARED,
    CONTACT_KINDS = 5
};

/// All that a kernel writes.
typedef struct State {
    f32x4 x[TOTAL];
    float edge_multipliers[MOST];
    f32x4 hinge_multipliers[MOST];
    PercaleStencil stencils[MOST];
} State;

typedef struct Twins {
    uint32_t count;
    uint32_t places[MOST][4]; // slots of each constraint's points
    uint32_t edges[MOST][2], hinges[MOST][4], order[MOST];
    float lengths[MOST], compliances[MOST], relaxations[MOST];
    f32x4 weights[MOST];
    f32x4 start[TOTAL];
    State before;
    PercaleModel model;
} Twins;

/// Mostly a metre and less, sometimes exactly on an axis, from either side.
static f32x4 place_of(uint64_t *seed)
{
    f32x4 x = {random_float(seed, -1.0, 1.0), random_float(seed, -1.0, 1.0), random_float(seed, -1.0, 1.0),
               random_float(seed, 0.1, 10.0)};
    if (percale_test_random(seed) < 0.3) {
        x[random_below(seed, 3)] = percale_test_random(seed) < 0.7 ? -0.0f : 0.0f;
    }
    if (percale_test_random(seed) < 0.2) {
        x[3] = 0.0f;
    }
    return x;
}

/// Gives every constraint four slots in no order, of which two are never neighbours' alone.
static void deal_places(Twins *twins, uint64_t *seed)
{
    uint32_t slots[POINT_COUNT];
    for (uint32_t i = 0; i < POINT_COUNT; i++) {
        slots[i] = i;
    }
    for (uint32_t i = POINT_COUNT - 1; i > 0; i--) {
        uint32_t j = random_below(seed, i + 1);
        uint32_t slot = slots[i];
        slots[i] = slots[j];
        slots[j] = slot;
    }
    memcpy(twins->places, slots, sizeof(twins->places));
}

static void make_edges_and_hinges(Twins *twins, uint64_t *seed)
{
    for (uint32_t i = 0; i < twins->count; i++) {
        const uint32_t *places = twins->places[i];
        for (uint32_t k = 0; k < 4; k++) {
            twins->hinges[i][k] = places[k] * POINT_BYTES;
            twins->weights[i][(int)k] = random_float(seed, -1.0, 1.0);
            twins->before.hinge_multipliers[i][(int)k] = k < 3 ? random_float(seed, -0.1, 0.1) : 0.0f;
        }
        twins->edges[i][0] = places[0] * POINT_BYTES;
        twins->edges[i][1] = places[1] * POINT_BYTES;
        twins->lengths[i] = random_float(seed, 0.1, 2.0);
        twins->compliances[i] = i % 3 == 0 ? 0.0f : random_float(seed, 0.1, 3.0);
        twins->relaxations[i] = random_float(seed, 0.1, 1.0);
        twins->before.edge_multipliers[i] = i % 4 == 0 ? 0.0f : random_float(seed, -0.1, 0.1);
        if (i % 7 == 3) { // no direction
            memcpy(&twins->before.x[places[1]], &twins->before.x[places[0]], 3 * sizeof(float));
        }
        if (i % 11 == 5) { // nothing to move
            twins->before.x[places[0]][3] = twins->before.x[places[1]][3] = 0.0f;
        }
    }
}

/// Contacts that press, that hold from before, that let go, that are far, and that nobody can yield to.
static void make_contacts(Twins *twins, uint64_t *seed)
{
    for (uint32_t i = 0; i < twins->count; i++) {
        PercaleStencil *stencil = &twins->before.stencils[i];
        int kind = (int)random_below(seed, CONTACT_KINDS);
        double u = percale_test_random(seed);
        double v = (1.0 - u) * percale_test_random(seed);
        const double weights[3] = {u, v, 1.0 - u - v};
        float rounded[3];
        quantize_weights(weights, rounded);
        bool fixed = percale_test_random(seed) < 0.5;
        *stencil = (PercaleStencil){.weights = {1.0f, -rounded[0], -rounded[1], -rounded[2]},
                                    .friction = i % 5 == 0 ? 0.0f : random_float(seed, 0.0, 1.0)};
        for (uint32_t k = 0; k < 4; k++) {
            stencil->points[k] = fixed && k > 0 ? POINT_COUNT + k - 1 : twins->places[i][k];
        }
        f32x4 normal = {random_float(seed, -1.0, 1.0), random_float(seed, -1.0, 1.0), 1.0f, 0.0f};
        stencil->normal = with_w(normal / length3(normal), kind == 0 || kind == 4 ? 3.0f : -3.0f);
        if (kind == 1 || kind == 2) {
            f32x4 before = {random_float(seed, -0.1, 0.1), random_float(seed, -0.1, 0.1), 0.0f, 0.0f};
            stencil->multiplier = with_w(before, kind == 1 ? 50.0f : 1e-3f);
        }
        for (uint32_t k = 0; kind == 4 && k < 4; k++) {
            twins->before.x[stencil->points[k]][3] = 0.0f;
        }
    }
}

static Twins *new_twins(uint32_t count, uint64_t seed)
{
    Twins *twins = aligned_alloc(64, (sizeof(Twins) + 63) / 64 * 64);
    ck_assert_ptr_nonnull(twins);
    memset(twins, 0, sizeof(*twins));
    twins->count = count;
    for (uint32_t i = 0; i < TOTAL; i++) {
        twins->before.x[i] = place_of(&seed);
        twins->start[i] = twins->before.x[i] + (f32x4){random_float(&seed, -0.1, 0.1), 0.05f, -0.0f, 0.0f};
        if (i >= POINT_COUNT) {
            twins->before.x[i][3] = 0.0f;
        }
    }
    deal_places(twins, &seed);
    make_edges_and_hinges(twins, &seed);
    make_contacts(twins, &seed);
    for (uint32_t i = 0; i < count; i++) { // in no order
        uint32_t j = random_below(&seed, i + 1);
        twins->order[i] = twins->order[j];
        twins->order[j] = i;
    }
    twins->model = (PercaleModel){.point_count = TOTAL,
                                  .edge_count = count,
                                  .edges = twins->edges,
                                  .edge_lengths = twins->lengths,
                                  .edge_compliances = twins->compliances,
                                  .hinge_count = count,
                                  .hinges = twins->hinges};
    return twins;
}

/// `again`: with the multipliers of compliant edges and of bending in several sweeps.
static PercaleSolveArrays arrays_of(Twins *twins, State *state, bool again)
{
    return (PercaleSolveArrays){.model = &twins->model,
                                .x = state->x,
                                .start = twins->start,
                                .dt = 0.5f,
                                .edge_multipliers = again ? state->edge_multipliers : NULL,
                                .bend_weights = twins->weights,
                                .bend_relaxations = twins->relaxations,
                                .hinge_multipliers = again ? state->hinge_multipliers : NULL,
                                .stencils = state->stencils,
                                .stencil_order = twins->order};
}

static State *new_state(const Twins *twins)
{
    State *state = aligned_alloc(64, (sizeof(State) + 63) / 64 * 64);
    ck_assert_ptr_nonnull(state);
    memcpy(state, &twins->before, sizeof(*state));
    return state;
}

typedef enum Split { WHOLE, SINGLES, PIECES } Split;

/// Two sweeps over all constraints, in calls as `split` says.
static State *solved(Twins *twins, PercaleKernel *kernel, bool again, Split split)
{
    State *state = new_state(twins);
    PercaleSolveArrays arrays = arrays_of(twins, state, again);
    uint64_t seed = 77 + twins->count;
    for (int sweep = 0; sweep < 2; sweep++) {
        uint32_t begin = 0;
        while (begin < twins->count) {
            uint32_t length = split == WHOLE ? twins->count : 1;
            length = split == PIECES ? random_below(&seed, 20) : length; // also none
            uint32_t end = begin + length < twins->count ? begin + length : twins->count;
            kernel(&arrays, begin, end);
            begin = end;
        }
    }
    return state;
}

/// Points that no constraint has keep their bits, those that can't move their place.
static void expect_neighbours_untouched(const Twins *twins, const State *state, uint32_t arity)
{
    bool *owned = calloc(TOTAL, sizeof(bool));
    ck_assert_ptr_nonnull(owned);
    for (uint32_t i = 0; i < twins->count; i++) {
        for (uint32_t k = 0; k < arity; k++) {
            owned[twins->places[i][k]] = true;
        }
    }
    for (uint32_t i = 0; i < TOTAL; i++) {
        f32x4 before = twins->before.x[i];
        f32x4 after = state->x[i];
        bool moved = before[0] != after[0] || before[1] != after[1] || before[2] != after[2];
        if (before[3] != after[3] || !is_finite3(after)) {
            ck_abort_msg("point %u is no longer what it was", i);
        }
        if (moved && before[3] <= 0.0f) {
            ck_abort_msg("point %u can't move, but did", i);
        }
        if (!owned[i] && !same_bits(&before, &after, sizeof(before))) {
            ck_abort_msg("point %u is in no constraint, but was written", i);
        }
    }
    size_t rest = MOST - twins->count;
    ck_assert(same_bits(state->edge_multipliers + twins->count, twins->before.edge_multipliers + twins->count,
                        rest * sizeof(float)));
    ck_assert(same_bits(state->hinge_multipliers + twins->count,
                        twins->before.hinge_multipliers + twins->count, rest * sizeof(f32x4)));
    free(owned);
}

static const uint32_t LARGE[] = {127, 128, 299, MOST};
enum { SMALL = 40, COUNTS = SMALL + 4 };

static void expect_twins(PercaleKernel *kernel, bool again, uint32_t arity)
{
    for (uint32_t i = 0; i < COUNTS; i++) {
        uint32_t count = i < SMALL ? i + 1 : LARGE[i - SMALL];
        Twins *twins = new_twins(count, 100 + i);
        State *whole = solved(twins, kernel, again, WHOLE);
        State *singles = solved(twins, kernel, again, SINGLES);
        State *pieces = solved(twins, kernel, again, PIECES);
        ck_assert_msg(same_bits(whole, singles, sizeof(*whole)), "%u at once differ from one by one", count);
        ck_assert_msg(same_bits(whole, pieces, sizeof(*whole)), "%u at once differ from pieces", count);
        ck_assert(count < 3 || !same_bits(whole, &twins->before, sizeof(*whole)));
        expect_neighbours_untouched(twins, whole, arity);
        free(whole);
        free(singles);
        free(pieces);
        free(twins);
    }
}

START_TEST(edges_at_once_are_edges_one_by_one)
{
    expect_twins(percale_solve_stretch, _i == 1, 2); // 1: with compliance
}
END_TEST

START_TEST(hinges_at_once_are_hinges_one_by_one)
{
    expect_twins(percale_solve_bend, _i == 1, 4); // 1: with multipliers
}
END_TEST

START_TEST(contacts_at_once_are_contacts_one_by_one)
{
    expect_twins(percale_solve_contact, false, 4);
}
END_TEST

/// Whether a contact acted; one that did not must have left its points alone.
static bool acts(const Twins *twins, const State *after, uint32_t place)
{
    const PercaleStencil *before = &twins->before.stencils[twins->order[place]];
    if (!same_bits(before, &after->stencils[twins->order[place]], sizeof(*before))) {
        return true;
    }
    for (uint32_t k = 0; k < 4; k++) {
        uint32_t point = before->points[k];
        if (!same_bits(&after->x[point], &twins->before.x[point], sizeof(f32x4))) {
            ck_abort_msg("contact %u does not act, but moves point %u", place, point);
        }
    }
    return false;
}

// A contact beside one that doesn't act, in the same block, on either side of it.
START_TEST(a_contact_that_does_not_act_is_not_touched_by_its_neighbour)
{
    uint32_t mixed[2] = {0, 0};
    for (uint64_t seed = 1; seed <= 10; seed++) {
        Twins *twins = new_twins(MOST, seed);
        State *after = new_state(twins);
        PercaleSolveArrays arrays = arrays_of(twins, after, false);
        percale_solve_contact(&arrays, 0, MOST);
        for (uint32_t i = 0; i < MOST; i += 2) {
            bool low = acts(twins, after, i);
            bool high = acts(twins, after, i + 1);
            mixed[0] += low && !high;
            mixed[1] += high && !low;
        }
        free(after);
        free(twins);
    }
    ck_assert_uint_gt(mixed[0], 100);
    ck_assert_uint_gt(mixed[1], 100);
}
END_TEST

enum { TETHERED = 301, LAYERS = 3 };

/// Slots tethered to pins among them, some not at all, some long enough.
typedef struct Tethered {
    uint32_t anchors[LAYERS * TETHERED];
    float lengths[LAYERS * TETHERED];
    f32x4 x[TETHERED + 1]; // and a guard
    PercaleModel model;
} Tethered;

static void make_tethers(Tethered *tethered, uint64_t *seed)
{
    *tethered = (Tethered){.model = {.slot_count = TETHERED,
                                     .tether_layers = LAYERS,
                                     .tether_anchors = tethered->anchors,
                                     .tether_lengths = tethered->lengths}};
    for (uint32_t i = 0; i <= TETHERED; i++) {
        tethered->x[i] = place_of(seed);
        tethered->x[i][3] = i % 10 == 0 ? 0.0f : tethered->x[i][3];
    }
    for (uint32_t i = 0; i < LAYERS * TETHERED; i++) {
        bool none = percale_test_random(seed) < 0.3;
        tethered->anchors[i] = (none ? i % TETHERED : 10 * random_below(seed, TETHERED / 10)) * POINT_BYTES;
        tethered->lengths[i] = none ? INFINITY : random_float(seed, 0.0, 2.0);
    }
}

START_TEST(tethers_at_once_are_tethers_one_by_one)
{
    uint64_t seed = 13;
    for (int trial = 0; trial < 20; trial++) {
        Tethered tethered;
        f32x4 before[TETHERED + 1];
        f32x4 whole[TETHERED + 1];
        make_tethers(&tethered, &seed);
        PercaleSolveArrays arrays = {.model = &tethered.model, .x = tethered.x};
        memcpy(before, tethered.x, sizeof(before));
        percale_solve_tether(&arrays, 0, TETHERED);
        memcpy(whole, tethered.x, sizeof(whole));
        ck_assert(same_bits(&whole[TETHERED], &before[TETHERED], sizeof(f32x4)));
        ck_assert(!same_bits(whole, before, sizeof(whole)));
        memcpy(tethered.x, before, sizeof(before));
        for (uint32_t slot = 0; slot < TETHERED; slot++) {
            percale_solve_tether(&arrays, slot, slot + 1);
        }
        for (uint32_t slot = 0; slot < TETHERED; slot++) {
            if (!same_bits(&whole[slot], &tethered.x[slot], sizeof(f32x4))) {
                ck_abort_msg("slot %u: (%g %g %g) in a pair, (%g %g %g) alone", slot, (double)whole[slot][0],
                             (double)whole[slot][1], (double)whole[slot][2], (double)tethered.x[slot][0],
                             (double)tethered.x[slot][1], (double)tethered.x[slot][2]);
            }
        }
    }
}
END_TEST

// ---- ranges ----

enum { SLOTS = 2 * GRAIN + 2055, GUARDS = 4, RANGE_COUNTS = 12 };
static const uint32_t RANGE_COUNT[RANGE_COUNTS] = {
    0, 1, 2, 3, 8, 63, GRAIN - 1, GRAIN, GRAIN + 1, 2 * GRAIN, 2 * GRAIN + 1, SLOTS};
static const int TEAMS[] = {1, 2, 3, 7};
enum { TEAM_COUNT = 4 };

/// A cloth of loose triangles; what lies behind its slots is there too, and must stay as it is.
typedef struct Cloth {
    f32x4 position[SLOTS + GUARDS], velocity[SLOTS + GUARDS];
    f32x4 predicted[SLOTS + GUARDS], next_velocity[SLOTS + GUARDS];
    uint32_t triangles[SLOTS][3], first_triangle[SLOTS + GUARDS + 1], slot_triangles[3 * SLOTS];
    PercaleModel model;
    bool windy;
    uint32_t bad; // what the stage has returned
} Cloth;

static Cloth *allocate_cloth(void)
{
    Cloth *cloth = aligned_alloc(64, (sizeof(Cloth) + 63) / 64 * 64);
    ck_assert_ptr_nonnull(cloth);
    return cloth;
}

/// The first `count` vertices of a cloth's copy.
static Cloth *copy_cloth(const Cloth *original, uint32_t count)
{
    Cloth *cloth = allocate_cloth();
    memcpy(cloth, original, sizeof(*cloth));
    cloth->model = (PercaleModel){.slot_count = count,
                                  .point_count = count,
                                  .position = cloth->position,
                                  .velocity = cloth->velocity,
                                  .predicted = cloth->predicted,
                                  .next_velocity = cloth->next_velocity,
                                  .triangles = cloth->triangles,
                                  .slot_first_triangle = cloth->first_triangle,
                                  .slot_triangles = cloth->slot_triangles};
    return cloth;
}

/// Triangle t joins slots 3t, 3t + 1 and 3t + 2.
static Cloth *new_cloth(uint64_t seed)
{
    Cloth *cloth = allocate_cloth();
    memset(cloth, 0, sizeof(*cloth));
    for (uint32_t i = 0; i < SLOTS + GUARDS; i++) {
        cloth->position[i] = place_of(&seed);
        cloth->velocity[i] = with_w(place_of(&seed) * (i % 5 == 0 ? 20.0f : 1.0f), 0.0f); // a fifth too fast
        cloth->next_velocity[i] = with_w(place_of(&seed), 0.0f);
        f32x4 push = with_w(place_of(&seed) * 1e-3f, 0.0f); // by constraints
        cloth->predicted[i] = cloth->position[i] + cloth->next_velocity[i] * 1e-3f + push;
        cloth->first_triangle[i] = i < SLOTS ? i : SLOTS;
        if (i < SLOTS) {
            cloth->slot_triangles[i] = i / 3;
            cloth->triangles[i / 3][i % 3] = i;
        }
    }
    cloth->first_triangle[SLOTS + GUARDS] = SLOTS;
    return cloth;
}

static void lead_predict(PercaleTeam *team, void *context)
{
    Cloth *cloth = context;
    PercalePredictStage stage = {.model = &cloth->model,
                                 .gravity = {0.0f, -9.81f, 0.0f, 0.0f},
                                 .wind = {cloth->windy ? 3.0f : 0.0f, 0.0f, 0.0f, 0.0f},
                                 .damping = 0.99f,
                                 .speed_max = 5.0f,
                                 .dt = 1e-3f};
    cloth->bad = percale_predict_cloth(&stage, team);
}

static void lead_advance(PercaleTeam *team, void *context)
{
    Cloth *cloth = context;
    cloth->bad = percale_advance_velocities(&cloth->model, 1e-3f, team);
}

static void lead_find_bad(PercaleTeam *team, void *context)
{
    Cloth *cloth = context;
    cloth->bad = percale_advance_find_bad(&cloth->model, team);
}

static void run_stage(PercaleLead *lead, int thread_count, Cloth *cloth)
{
    PercaleCrowding crowding = {0};
    percale_team_open(thread_count, &crowding, lead, cloth);
}

/// The first `count` vertices as in `all`, what is behind them as in `untouched`.
static void expect_range(const Cloth *cloth, const Cloth *all, const Cloth *untouched, uint32_t count)
{
    const size_t size = count * sizeof(f32x4);
    const size_t rest = (SLOTS + GUARDS - count) * sizeof(f32x4);
    ck_assert_uint_eq(cloth->bad, UINT32_MAX);
    ck_assert(same_bits(cloth->predicted, all->predicted, size));
    ck_assert(same_bits(cloth->next_velocity, all->next_velocity, size));
    ck_assert(same_bits(cloth->predicted + count, untouched->predicted + count, rest));
    ck_assert(same_bits(cloth->next_velocity + count, untouched->next_velocity + count, rest));
    ck_assert(same_bits(cloth->position, untouched->position, sizeof(cloth->position)));
    ck_assert(same_bits(cloth->velocity, untouched->velocity, sizeof(cloth->velocity)));
}

static void expect_ranges(PercaleLead *lead, bool windy)
{
    Cloth *untouched = new_cloth(9);
    Cloth *all = copy_cloth(untouched, SLOTS);
    all->windy = windy;
    run_stage(lead, 1, all);
    for (uint32_t i = 0; i < RANGE_COUNTS; i++) {
        for (uint32_t t = 0; t < TEAM_COUNT; t++) {
            Cloth *cloth = copy_cloth(untouched, RANGE_COUNT[i]);
            cloth->windy = windy;
            run_stage(lead, TEAMS[t], cloth);
            expect_range(cloth, all, untouched, RANGE_COUNT[i]);
            free(cloth);
        }
    }
    free(all);
    free(untouched);
}

START_TEST(prediction_is_the_same_for_any_count_and_any_team)
{
    expect_ranges(lead_predict, _i == 1); // 1: with wind
}
END_TEST

START_TEST(new_velocities_are_the_same_for_any_count_and_any_team)
{
    expect_ranges(lead_advance, false);
}
END_TEST

enum { SHIFT = 3 }; // odd, and whole triangles

/// The same cloth without its first vertices: each vertex comes into the other half of its block.
static Cloth *shift_cloth(const Cloth *original)
{
    Cloth *cloth = copy_cloth(original, SLOTS - SHIFT);
    cloth->model.position += SHIFT;
    cloth->model.velocity += SHIFT;
    cloth->model.predicted += SHIFT;
    cloth->model.next_velocity += SHIFT;
    cloth->model.slot_first_triangle += SHIFT;
    for (uint32_t i = SHIFT; i < SLOTS; i++) {
        cloth->triangles[i / 3][i % 3] -= SHIFT;
    }
    return cloth;
}

START_TEST(a_vertex_gets_the_same_bits_from_either_half)
{
    const size_t size = (SLOTS - SHIFT) * sizeof(f32x4);
    PercaleLead *lead = _i < 2 ? lead_predict : lead_advance;
    Cloth *original = new_cloth(10);
    Cloth *cloth = copy_cloth(original, SLOTS);
    Cloth *shifted = shift_cloth(original);
    cloth->windy = shifted->windy = _i == 1;
    run_stage(lead, 1, cloth);
    run_stage(lead, 1, shifted);
    ck_assert(same_bits(cloth->predicted + SHIFT, shifted->predicted + SHIFT, size));
    ck_assert(same_bits(cloth->next_velocity + SHIFT, shifted->next_velocity + SHIFT, size));
    free(original);
    free(cloth);
    free(shifted);
}
END_TEST

/// Spoils a coordinate of what the stage reads.
static void spoil(Cloth *cloth, PercaleLead *lead, uint32_t slot, uint64_t *seed)
{
    static const float BAD[3] = {NAN, HUGE_VALF, -HUGE_VALF};
    float bad = BAD[random_below(seed, 3)];
    int axis = (int)random_below(seed, 3);
    cloth->position[slot][3] = 1.0f; // a fixed vertex does not care about its velocity
    if (lead == lead_predict) {
        (random_below(seed, 2) == 0 ? cloth->position : cloth->velocity)[slot][axis] = bad;
    } else {
        (random_below(seed, 2) == 0 ? cloth->predicted : cloth->next_velocity)[slot][axis] = bad;
    }
}

START_TEST(the_first_vertex_that_is_not_finite_is_named)
{
    PercaleLead *leads[3] = {lead_predict, lead_advance, lead_find_bad};
    Cloth *original = new_cloth(12);
    uint64_t seed = 11;
    for (int trial = 0; trial < 60; trial++) {
        uint32_t count = trial % 2 == 0 ? SLOTS : SLOTS - 1;
        Cloth *spoilt = copy_cloth(original, count);
        uint32_t first = UINT32_MAX;
        for (int i = 0; i < 1 + trial % 4; i++) {
            uint32_t slot = trial == 0 ? count - 1 : random_below(&seed, count);
            spoil(spoilt, leads[_i], slot, &seed);
            first = slot < first ? slot : first;
        }
        spoil(spoilt, leads[_i], count, &seed); // beyond the last: nobody's business
        run_stage(leads[_i], TEAMS[trial % TEAM_COUNT], spoilt);
        ck_assert_uint_eq(spoilt->bad, first);
        free(spoilt);
    }
    free(original);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("wide");
    TCase *lanes = tcase_create("lanes");
    tcase_add_test(lanes, a_pair_is_its_two_points);
    tcase_add_test(lanes, shuffles_stay_inside_the_halves);
    tcase_add_test(lanes, spreading_fills_each_half_with_its_own_component);
    tcase_add_test(lanes, transposing_gives_the_components_of_eight_points_in_order);
    tcase_add_test(lanes, dot_products_stand_in_all_places_of_their_half);
    tcase_add_test(lanes, square_roots_are_those_of_the_lanes);
    tcase_add_test(lanes, masks_choose_bits_lane_by_lane);
    tcase_add_test(lanes, one_or_two_points_are_loaded_and_stored_and_nothing_beside_them);
    tcase_add_test(lanes, what_is_not_finite_is_seen_in_its_own_lane_alone);
    suite_add_tcase(suite, lanes);
    TCase *twins = tcase_create("twins");
    tcase_set_timeout(twins, 60.0);
    tcase_add_loop_test(twins, edges_at_once_are_edges_one_by_one, 0, 2);
    tcase_add_loop_test(twins, hinges_at_once_are_hinges_one_by_one, 0, 2);
    tcase_add_test(twins, contacts_at_once_are_contacts_one_by_one);
    tcase_add_test(twins, tethers_at_once_are_tethers_one_by_one);
    tcase_add_test(twins, a_contact_that_does_not_act_is_not_touched_by_its_neighbour);
    suite_add_tcase(suite, twins);
    TCase *ranges = tcase_create("ranges");
    tcase_set_timeout(ranges, 60.0);
    tcase_add_loop_test(ranges, prediction_is_the_same_for_any_count_and_any_team, 0, 2);
    tcase_add_test(ranges, new_velocities_are_the_same_for_any_count_and_any_team);
    tcase_add_loop_test(ranges, a_vertex_gets_the_same_bits_from_either_half, 0, 3);
    tcase_add_loop_test(ranges, the_first_vertex_that_is_not_finite_is_named, 0, 3);
    suite_add_tcase(suite, ranges);
    return percale_test_run(suite);
}
