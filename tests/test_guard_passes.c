// The guard of pairs between passes (guard_passes): nothing of it where there is nothing between them, and
// else the same cloth without a crossing for less work.

#include "scene_play.h"

/// Runs some frames; the quality of the worst of them.
static PercaleQuality run_guarded(const char *scene, const char *passes, const char *guard_passes,
                                  int threads, uint32_t frames, PercaleCounters *counters, uint64_t *hash)
{
    Play play = open_play(scene, 1000);
    set(&play, "self", "on");
    set(&play, "ee", "on");
    set(&play, "passes", passes);
    set(&play, "guard_passes", guard_passes);
    build(&play, threads);
    PercaleQuality worst = {0};
    for (uint32_t frame = 0; frame < frames; frame++) {
        run_frame(&play);
        PercaleQuality quality = judge(&play);
        worst.ef_cloth_cloth = fmax(worst.ef_cloth_cloth, quality.ef_cloth_cloth);
        worst.ef_cloth_obstacle = fmax(worst.ef_cloth_obstacle, quality.ef_cloth_obstacle);
        worst.penetration_max_mm = fmax(worst.penetration_max_mm, quality.penetration_max_mm);
    }
    *counters = percale_solver_counters(play.solver);
    *hash = percale_solver_hash(play.solver);
    close_play(&play);
    return worst;
}

static const char *const SCENES[] = {"drape", "cards", "dress"};

START_TEST(with_a_pass_in_each_substep_nothing_changes)
{
    PercaleCounters counters[2];
    uint64_t hash[2];
    const uint32_t frames = PERCALE_SANITIZED ? 2 : 5;
    (void)run_guarded(SCENES[_i], "0", "off", 1, frames, &counters[0], &hash[0]);
    (void)run_guarded(SCENES[_i], "0", "on", 1, frames, &counters[1], &hash[1]);
    ck_assert_uint_eq(hash[1], hash[0]);
    ck_assert_uint_eq(counters[1].candidates, counters[0].candidates);
}
END_TEST

/// Cards that fall on each other, and a sheet on a ball: nothing crosses, for a fraction of the candidates,
/// and whoever runs it.
START_TEST(guarded_before_passes_nothing_crosses_for_less)
{
    PercaleCounters counters[3];
    uint64_t hash[3];
    const uint32_t frames = PERCALE_SANITIZED ? 8 : 30;
    (void)run_guarded(SCENES[_i], "4", "off", 1, frames, &counters[0], &hash[0]);
    for (int k = 1; k < 3; k++) {
        PercaleQuality worst = run_guarded(SCENES[_i], "4", "on", k, frames, &counters[k], &hash[k]);
        ck_assert_double_eq(worst.ef_cloth_cloth, 0.0);
        ck_assert_double_eq(worst.ef_cloth_obstacle, 0.0);
        ck_assert_double_eq(worst.penetration_max_mm, 0.0);
        ck_assert_uint_eq(counters[k].left_crossed, 0);
    }
    ck_assert_uint_eq(hash[2], hash[1]);
    ck_assert_msg(PERCALE_SANITIZED || 2 * counters[1].candidates <= counters[0].candidates, "%lu of %lu",
                  (unsigned long)counters[1].candidates, (unsigned long)counters[0].candidates);
}
END_TEST

/// A sheet that lands hard: what is pushed out of itself isn't left in the ball.
START_TEST(what_pairs_push_into_a_body_is_lifted_out)
{
    Play play = open_play("drape", 2500);
    set(&play, "seed", "2");
    set(&play, "passes", "2");
    set(&play, "guard_passes", "on");
    build(&play, 1);
    for (uint32_t frame = 0; frame < 40; frame++) {
        run_frame(&play);
        PercaleQuality quality = judge(&play);
        ck_assert_double_eq(quality.ef_cloth_obstacle, 0.0);
        ck_assert_double_eq(quality.penetration_max_mm, 0.0);
        ck_assert_double_eq(quality.ef_cloth_cloth, 0.0);
    }
    PercaleCounters counters = percale_solver_counters(play.solver);
    ck_assert_uint_gt(counters.truncated, 100);
    ck_assert_uint_eq(counters.left_inside, 0);
    close_play(&play);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("guard passes");
    TCase *cases = tcase_create("guard passes");
    tcase_set_tags(cases, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(cases, 0);
    tcase_add_loop_test(cases, with_a_pass_in_each_substep_nothing_changes, 0, 3);
    tcase_add_test(cases, what_pairs_push_into_a_body_is_lifted_out);
    suite_add_tcase(suite, cases);
    TCase *threads = tcase_create("threads");
    tcase_set_tags(threads, PERCALE_ANY_ENGINE);
    tcase_set_timeout(threads, 0);
    tcase_add_loop_test(threads, guarded_before_passes_nothing_crosses_for_less, 0, 2);
    suite_add_tcase(suite, threads);
    return percale_test_run(suite);
}
