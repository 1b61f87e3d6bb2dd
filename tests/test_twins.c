// Kernels that take several constraints at once, against the same constraints one by one, bit for bit.

#include "kernel_testing.h"

#include "solve/solve_arrays.h"

#include <math.h>
#include <stdlib.h>

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

int main(void)
{
    Suite *suite = suite_create("twins");
    TCase *twins = tcase_create("twins");
    tcase_set_timeout(twins, 60.0);
    tcase_add_loop_test(twins, edges_at_once_are_edges_one_by_one, 0, 2);
    tcase_add_loop_test(twins, hinges_at_once_are_hinges_one_by_one, 0, 2);
    tcase_add_test(twins, contacts_at_once_are_contacts_one_by_one);
    tcase_add_test(twins, tethers_at_once_are_tethers_one_by_one);
    tcase_add_test(twins, a_contact_that_does_not_act_is_not_touched_by_its_neighbour);
    suite_add_tcase(suite, twins);
    return percale_test_run(suite);
}
