// Laws of the guard of pairs: nothing goes through, and what it can't help it counts.

#include "finish/pair_guard.h"
#include "sheets_testing.h"

#include <string.h>

enum { PILE = 8 };

static PercalePairGuardStage pair_guard_of(Sheets *sheets, float dt)
{
    PercaleSolver *solver = sheets->solver;
    return (PercalePairGuardStage){.model = sheets->model,
                                   .candidates = sheets->candidates,
                                   .dt = dt,
                                   .collectors = &solver->collectors,
                                   .passing = &solver->passing,
                                   .memory = &solver->detect_memory,
                                   .arena = &solver->arena,
                                   .team = percale_team_alone()};
}

/// Of the new velocities, kg m/s.
static void sum_momentum(const PercaleModel *model, double sum[3])
{
    memset(sum, 0, 3 * sizeof(double));
    for (uint32_t i = 0; i < model->slot_count; i++) {
        for (int axis = 0; axis < 3; axis++) {
            sum[axis] += (double)model->next_velocity[i][axis] / (double)model->predicted[i][3];
        }
    }
}

/// Two sheets are thrown through each other, each vertex its own way: none of it happens, no momentum is made
/// while pushing is enough, and the velocities are those of the ways.
START_TEST(nothing_goes_through_however_it_is_thrown)
{
    static const float THROWS[][2] = {{0.004f, 0.001f}, {0.02f, 0.003f}, {0.05f, 0.02f}}; // m: common, each
    const float dt = 1e-3f;
    for (size_t t = 0; t < sizeof(THROWS) / sizeof(THROWS[0]); t++) {
        Sheets sheets;
        open_sheets(&sheets, SIDE);
        PercaleModel *model = sheets.model;
        move(&sheets, (f32x4){0}, THROWS[t][1]);
        for (uint32_t i = 0; i < model->slot_count; i++) {
            model->predicted[i][1] += model->cloth_of[i] == 0 ? 0.012f + THROWS[t][0] : 0.0f;
            model->next_velocity[i] = with_w((model->predicted[i] - model->position[i]) / dt, 0.0f);
        }
        ck_assert_uint_gt(count_passages(model), 20);
        PercalePairGuardStage stage = pair_guard_of(&sheets, dt);
        PercalePairGuardCounts counts;
        double before[3];
        double after[3];
        sum_momentum(model, before);
        ck_assert(percale_pair_guard_run(&stage, &counts));
        sum_momentum(model, after);
        for (int axis = 0; t == 0 && axis < 3; axis++) {
            ck_assert(fabs(after[axis] - before[axis]) <= 1e-5 * fabs(before[1]));
        }
        ck_assert_uint_gt(counts.pushed, 20);
        ck_assert_uint_eq(counts.left, 0);
        ck_assert_uint_eq(count_passages(model), 0);
        for (uint32_t i = 0; i < model->slot_count; i++) {
            f32x4 way = model->predicted[i] - model->position[i];
            ck_assert(length3(with_w(way / dt - model->next_velocity[i], 0.0f)) < 1e-2f);
        }
        close_sheets(&sheets);
    }
}
END_TEST

/// Pins lead the lowest of a pile of sheets, 12 mm apart, through five of them toward the highest, which
/// others hold: what is between them finds its place.
START_TEST(what_pins_press_together_finds_its_place)
{
    const float dt = 1e-3f;
    Sheets sheets;
    open_pile(&sheets, SIDE / 2, PILE);
    PercaleModel *model = sheets.model;
    for (uint32_t i = 0; i < model->slot_count; i++) {
        uint32_t cloth = model->cloth_of[i];
        model->predicted[i][1] += cloth == 0 ? 0.06f : 0.0f;
        model->predicted[i][3] *= cloth == 0 || cloth == PILE - 1 ? 0.0f : 1.0f;
    }
    ck_assert_uint_gt(count_passages(model), 20);
    PercalePairGuardStage stage = pair_guard_of(&sheets, dt);
    PercalePairGuardCounts counts;
    ck_assert(percale_pair_guard_run(&stage, &counts));
    ck_assert_uint_eq(counts.left, 0);
    ck_assert_uint_eq(count_passages(model), 0);
    close_sheets(&sheets);
}
END_TEST

/// Pins lead one sheet through another that pins hold: nobody can help it, and it is said.
START_TEST(what_only_pins_lead_through_each_other_is_counted)
{
    Sheets sheets;
    open_sheets(&sheets, SIDE);
    PercaleModel *model = sheets.model;
    for (uint32_t i = 0; i < model->slot_count; i++) {
        model->predicted[i][1] += model->cloth_of[i] == 0 ? 0.016f : 0.0f;
        model->predicted[i][3] = 0.0f;
    }
    uint32_t passages = count_passages(model);
    ck_assert_uint_gt(passages, 20);
    PercalePairGuardStage stage = pair_guard_of(&sheets, 1e-3f);
    PercalePairGuardCounts counts;
    ck_assert(percale_pair_guard_run(&stage, &counts));
    ck_assert_uint_eq(counts.left, passages);
    close_sheets(&sheets);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("pair guard");
    TCase *guard = tcase_create("pair guard");
    tcase_set_timeout(guard, 60.0);
    tcase_add_test(guard, nothing_goes_through_however_it_is_thrown);
    tcase_add_test(guard, what_only_pins_lead_through_each_other_is_counted);
    tcase_add_test(guard, what_pins_press_together_finds_its_place);
    suite_add_tcase(suite, guard);
    return percale_test_run(suite);
}
