// What is kept of earlier detections changes nothing but the time: with reuse=always, which keeps nothing,
// the state is the same bit for bit, and a bound that were wrong would be seen.

#include "percale/scene.h"
#include "solver.h"
#include "testing.h"

enum { SIZE = PERCALE_SANITIZED ? 400 : 900, FRAMES = PERCALE_SANITIZED ? 2 : 5, LAYERED_SIZE = 3000 };

typedef struct Case {
    const char *scene;
    const char *substeps, *iterations, *passes;
    uint64_t size;
    const char *guard_passes;
} Case;

static const Case CASES[] = {
    {"drape", "20", "1", "0", SIZE, "off"},         {"drape", "2", "5", "0", SIZE, "off"},
    {"funnel", "20", "1", "0", SIZE, "off"},        {"cards", "20", "1", "0", SIZE, "off"},
    {"dress", "20", "1", "0", 1000, "off"},         {"dress", "5", "4", "20", 1000, "off"},
    {"layers", "5", "4", "0", LAYERED_SIZE, "off"}, {"funnel", "20", "1", "4", SIZE, "on"},
    {"cards", "20", "1", "2", SIZE, "on"},          {"dress", "20", "1", "4", 1000, "on"},
};
enum { CASE_COUNT = sizeof CASES / sizeof CASES[0] };

/// The state after some frames.
static uint64_t run(const Case *entry, const char *reuse, int threads, PercaleCounters *counters)
{
    PercaleSceneError error = {""};
    PercaleScene *scene = percale_scene_open(entry->scene, entry->size, &error);
    ck_assert_msg(scene != NULL, "%s", error.text);
    const char *const settings[][2] = {{"substeps", entry->substeps},
                                       {"iterations", entry->iterations},
                                       {"passes", entry->passes},
                                       {"guard_passes", entry->guard_passes},
                                       {"self", "on"},
                                       {"ee", "on"},
                                       {"reuse", reuse}};
    for (size_t i = 0; i < sizeof(settings) / sizeof(settings[0]); i++) {
        ck_assert_msg(percale_scene_set(scene, settings[i][0], settings[i][1], &error), "%s", error.text);
    }
    PercaleSolver *solver = percale_scene_build(scene, threads, &error);
    ck_assert_msg(solver != NULL, "%s", error.text);
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        ck_assert_msg(percale_scene_move(scene, solver, frame, &error), "%s", error.text);
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / percale_scene_frame_rate(scene)));
    }
    uint64_t hash = percale_solver_hash(solver);
    *counters = percale_solver_counters(solver);
    percale_solver_destroy(solver);
    percale_scene_close(scene);
    return hash;
}

START_TEST(the_state_is_that_of_detecting_anew_at_every_pass)
{
    PercaleCounters kept;
    PercaleCounters anew;
    uint64_t expected = run(&CASES[_i], "auto", 1, &kept);
    uint64_t hash = run(&CASES[_i], "always", 3, &anew);
    ck_assert_msg(hash == expected, "%s, always: %016lx instead of %016lx", CASES[_i].scene,
                  (unsigned long)hash, (unsigned long)expected);
    ck_assert_uint_eq(anew.missed, 0);
    ck_assert_uint_ge(anew.detections, 2 * kept.detections);
    ck_assert_uint_gt(anew.candidates, kept.candidates);
    PercaleCounters audited; // the work is that of auto, and misses nothing
    hash = run(&CASES[_i], "audit", 1, &audited);
    ck_assert_msg(hash == expected, "%s, audit: %016lx instead of %016lx", CASES[_i].scene,
                  (unsigned long)hash, (unsigned long)expected);
    ck_assert_uint_eq(audited.missed, 0);
    ck_assert_uint_eq(audited.candidates, kept.candidates);
    ck_assert_uint_eq(audited.stencils_vf, kept.stencils_vf);
    ck_assert_uint_eq(audited.stencils_ee, kept.stencils_ee);
}
END_TEST

/// Two sheets that fall together, within reach of each other; then the solver is told of all pairs of
/// vertices and faces that they are a metre apart.
static PercaleCounters fall(PercaleReuse reuse, bool is_told_wrong, uint64_t *hash)
{
    static const int FALL = 4; // frames
    PercaleSolverDef def = percale_solver_def_default();
    def.reuse = reuse;
    def.self_collision = def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    for (int k = 0; k < 2; k++) {
        PercaleMesh sheet = percale_test_sheet(9, 0.1f);
        percale_test_translate(&sheet, 1e-3f * (float)k, 3e-3f * (float)k, 0.0f);
        (void)percale_test_add_cloth(solver, &sheet);
        percale_mesh_free(&sheet);
    }
    for (int frame = 0; frame <= FALL; frame++) {
        for (uint32_t b = 0; frame == FALL && is_told_wrong && b < solver->candidates.lists[0].block_count;
             b++) {
            PercaleBlockPairs *pairs = &solver->candidates.lists[0].pairs[b];
            for (uint32_t i = 0; i < pairs->count; i++) {
                page_of_pair(pairs, i)->bounds[i % PAGE_PAIRS] = 1.0f;
            }
        }
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / 60.0));
    }
    *hash = percale_solver_hash(solver);
    PercaleCounters counters = percale_solver_counters(solver);
    percale_solver_destroy(solver);
    return counters;
}

START_TEST(an_audit_counts_the_pairs_that_a_wrong_bound_hides)
{
    uint64_t right_hash;
    uint64_t wrong_hash;
    uint64_t unseen_hash;
    PercaleCounters right = fall(PERCALE_REUSE_AUDIT, false, &right_hash);
    PercaleCounters wrong = fall(PERCALE_REUSE_AUDIT, true, &wrong_hash);
    PercaleCounters unseen = fall(PERCALE_REUSE_AUTO, true, &unseen_hash);
    ck_assert_uint_eq(right.missed, 0);
    ck_assert_uint_gt(wrong.missed, 0);
    ck_assert_uint_eq(unseen.missed, 0);
    ck_assert_uint_eq(wrong_hash, unseen_hash);
    ck_assert_uint_gt(right.stencils_vf, wrong.stencils_vf);
}
END_TEST

/// A sheet that has come to lie on a box; then the solver is told that a vertex is a metre away.
static PercaleSolver *lie(PercaleReuse reuse, bool is_told_wrong)
{
    static const int FALL = 12; // frames
    PercaleSolverDef def = percale_solver_def_default();
    def.reuse = reuse;
    def.ccd = PERCALE_CCD_OFF;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh sheet = percale_test_sheet(9, 0.1f);
    PercaleMesh box = percale_test_box(0.3f, 0.1f, 0.3f);
    percale_test_translate(&box, 0.0f, -0.06f, 0.0f);
    (void)percale_test_add_cloth(solver, &sheet);
    (void)percale_test_add_obstacle(solver, &box);
    for (int frame = 0; frame <= FALL; frame++) {
        if (frame == FALL && is_told_wrong) {
            solver->proximities[0].clearance[0] = 1.0f;
            solver->proximities[0].side[0] = 1;
        }
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / 60.0));
    }
    percale_mesh_free(&sheet);
    percale_mesh_free(&box);
    return solver;
}

START_TEST(a_bound_that_is_wrong_is_counted_where_all_is_found_anew)
{
    PercaleSolver *right = lie(PERCALE_REUSE_ALWAYS, false);
    PercaleSolver *wrong = lie(PERCALE_REUSE_ALWAYS, true);
    PercaleSolver *unseen = lie(PERCALE_REUSE_AUTO, true);
    ck_assert_uint_eq(percale_solver_counters(right).missed, 0);
    ck_assert_uint_eq(percale_solver_counters(wrong).missed, 1);
    ck_assert_uint_eq(percale_solver_counters(unseen).missed, 0);
    percale_solver_destroy(right);
    percale_solver_destroy(wrong);
    percale_solver_destroy(unseen);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("reuse");
    TCase *reuse = tcase_create("reuse");
    tcase_set_tags(reuse, PERCALE_ANY_ENGINE);
    tcase_set_timeout(reuse, 0);
    tcase_add_loop_test(reuse, the_state_is_that_of_detecting_anew_at_every_pass, 0, CASE_COUNT);
    tcase_add_test(reuse, a_bound_that_is_wrong_is_counted_where_all_is_found_anew);
    tcase_add_test(reuse, an_audit_counts_the_pairs_that_a_wrong_bound_hides);
    suite_add_tcase(suite, reuse);
    return percale_test_run(suite);
}
