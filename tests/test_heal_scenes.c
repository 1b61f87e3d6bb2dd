// Scenes in which cloth starts tangled, and scenes in which it doesn't, with untangling on.

#include "scene_play.h"

/// A jacket that starts tucked into the dress comes out and stays out; whoever runs it, in the same way.
START_TEST(a_tucked_in_jacket_comes_out)
{
    const uint32_t FRAMES = PERCALE_SANITIZED ? 4 : 6;
    const int THREADS[] = {1, 7};
    uint64_t hash[2] = {0, 0};
    for (int k = 0; k < 2; k++) {
        Play play = open_play("layers", 3000);
        set(&play, "push", "0.03");
        build(&play, THREADS[k]);
        ck_assert(k > 0 || judge(&play).ef_cloth_cloth > 0.0);
        for (uint32_t frame = 1; frame <= FRAMES; frame++) {
            run_frame(&play);
            ck_assert(k > 0 || frame < 4 || judge(&play).ef_cloth_cloth == 0.0);
        }
        ck_assert_uint_le(percale_solver_counters(play.solver).last_crossed_frame, 3);
        hash[k] = percale_solver_hash(play.solver);
        close_play(&play);
    }
    ck_assert_uint_eq(hash[1], hash[0]);
}
END_TEST

/// Where nothing crosses there is nothing of it.
START_TEST(what_is_not_tangled_never_notices)
{
    const char *const SCENES[] = {"drape", "cards"};
    uint64_t hash[2];
    uint64_t bytes[2];
    for (int on = 0; on < 2; on++) {
        Play play = open_play(SCENES[_i], 1000);
        set(&play, "self", "on");
        set(&play, "untangle", on ? "on" : "off");
        build(&play, 1);
        run_frames(&play, PERCALE_SANITIZED ? 12 : 40);
        PercaleCounters counters = percale_solver_counters(play.solver);
        ck_assert_uint_eq(counters.last_crossed_frame + counters.born_crossed, 0);
        hash[on] = percale_solver_hash(play.solver);
        bytes[on] = percale_solver_bytes(play.solver).detect;
        close_play(&play);
    }
    ck_assert_uint_eq(hash[1], hash[0]);
    ck_assert_uint_le(bytes[1], bytes[0] + 4096); // lists of nodes may have grown
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("heal_scenes");
    TCase *scenes = tcase_create("scenes");
    tcase_add_test(scenes, a_tucked_in_jacket_comes_out);
    suite_add_tcase(suite, scenes);
    tcase_set_tags(scenes, PERCALE_ANY_ENGINE);
    TCase *clean = tcase_create("clean");
    tcase_add_loop_test(clean, what_is_not_tangled_never_notices, 0, 2);
    tcase_set_tags(clean, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    suite_add_tcase(suite, clean);
    return percale_test_run(suite);
}
