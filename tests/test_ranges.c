// Stages that take vertices two at a time: the same bits for any number of them and any team, and the vertex
// at fault named.

#include "kernel_testing.h"

#include "base/parallel.h"
#include "finish/advance.h"
#include "predict/predict.h"

#include <math.h>
#include <stdlib.h>

enum { SLOTS = 2 * GRAIN + 2055, GUARDS = 4, RANGE_COUNTS = 12 };
static const uint32_t RANGE_COUNT[RANGE_COUNTS] = {
    0, 1, 2, 3, 8, 63, GRAIN - 1, GRAIN, GRAIN + 1, 2 * GRAIN, 2 * GRAIN + 1, SLOTS};
static const int TEAMS[] = {1, 2, 3, 7};
enum { TEAM_COUNT = 4 };

/// A cloth of loose triangles; what lies behind its slots is there too, and must stay as it is.
typedef struct Cloth {
    f32x4 position[SLOTS + GUARDS], velocity[SLOTS + GUARDS];
    f32x4 predicted[SLOTS + GUARDS], next_velocity[SLOTS + GUARDS];
    uint32_t triangles[3 * SLOTS], first_triangle[SLOTS + GUARDS + 1], slot_triangles[3 * SLOTS];
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
                                  .cloth = {.triangles = cloth->triangles,
                                            .vertex_first_face = cloth->first_triangle,
                                            .vertex_faces = cloth->slot_triangles}};
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
            cloth->triangles[i] = i;
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
    cloth->model.cloth.vertex_first_face += SHIFT;
    for (uint32_t i = SHIFT; i < SLOTS; i++) {
        cloth->triangles[i] -= SHIFT;
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
    Suite *suite = suite_create("ranges");
    TCase *ranges = tcase_create("ranges");
    tcase_set_timeout(ranges, 60.0);
    tcase_add_loop_test(ranges, prediction_is_the_same_for_any_count_and_any_team, 0, 2);
    tcase_add_test(ranges, new_velocities_are_the_same_for_any_count_and_any_team);
    tcase_add_loop_test(ranges, a_vertex_gets_the_same_bits_from_either_half, 0, 3);
    tcase_add_loop_test(ranges, the_first_vertex_that_is_not_finite_is_named, 0, 3);
    suite_add_tcase(suite, ranges);
    return percale_test_run(suite);
}
