// Cloth on obstacles that are flat to it: nothing comes through, and what is flat costs nothing.

#include "scene_play.h"

/// What a sheet is pressed with.
typedef struct Press {
    const char *seed, *stretch_compliance;
    int frames;
} Press;

static const Press PRESSES[] = {{"0", "0", 16}, {"3", "0", 16}, {"0", "1", 15}};

/// A thick sheet is pressed so hard onto a ball that is flat to it, in so few substeps, that its vertices
/// come near the ball, or is drawn out until its edges are four times as long as at rest: what lies between
/// its vertices doesn't go through.
START_TEST(what_is_low_or_long_does_not_go_through)
{
    Play play = open_play("drape", 2500);
    set(&play, "thickness", "0.01");
    set(&play, "gravity", "0,-80,0");
    set(&play, "iterations_per_frame", "10");
    set(&play, "seed", PRESSES[_i].seed);
    set(&play, "stretch_compliance", PRESSES[_i].stretch_compliance);
    build(&play, 1);
    for (int frame = 0; frame < PRESSES[_i].frames; frame++) {
        run_frame(&play);
        PercaleQuality quality = judge(&play);
        ck_assert_double_eq(quality.ef_cloth_obstacle, 0.0);
        ck_assert_double_eq(quality.penetration_obstacle_mm, 0.0);
        ck_assert_double_eq(quality.penetration_max_mm, 0.0);
    }
    ck_assert_uint_eq(percale_solver_counters(play.solver).left_inside, 0);
    close_play(&play);
}
END_TEST

/// To a fine cloth the ball is flat and its edges and vertices are asked for nothing: the sheet goes the same
/// way with them and without.
START_TEST(what_is_flat_costs_nothing)
{
    PercaleCounters counters[2];
    float *positions[2];
    uint32_t count = 0;
    for (int edges = 0; edges < 2; edges++) {
        Play play = open_play("drape", 2500);
        set(&play, "thickness", "0.01");
        set(&play, "self", "off");
        set(&play, "ee", edges ? "on" : "off");
        build(&play, 1);
        run_frames(&play, 30);
        counters[edges] = percale_solver_counters(play.solver);
        positions[edges] = positions_of(&play, 0);
        count = count_vertices(&play);
        close_play(&play);
    }
    ck_assert_uint_gt(counters[0].stencils_vf, 1000);
    ck_assert_uint_eq(counters[1].stencils_vf, counters[0].stencils_vf);
    ck_assert_uint_eq(counters[1].stencils_ee, 0);
    ck_assert_mem_eq(positions[0], positions[1], 3 * sizeof(float) * count);
    free(positions[0]);
    free(positions[1]);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("flat scenes");
    TCase *cases = tcase_create("flat scenes");
    tcase_set_tags(cases, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_add_loop_test(cases, what_is_low_or_long_does_not_go_through, 0, 3);
    tcase_add_test(cases, what_is_flat_costs_nothing);
    suite_add_tcase(suite, cases);
    return percale_test_run(suite);
}
