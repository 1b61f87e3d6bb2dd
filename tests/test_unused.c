// Pay only for what the scene has: what is switched off or absent costs no work and no memory, and what was
// taken away again has left no trace.

#include "testing.h"

#include <stdlib.h>

static const double FRAME = 1.0 / 60.0; // s

// ---- absent ----

enum { BARE_COUNT = 3 };

/// A sheet alone without bending, and without tethers: they are switched off, or there are no pins.
static PercaleSolver *new_bare_solver(int index)
{
    const uint32_t side = 50;
    PercaleSolverDef def = percale_solver_def_default();
    def.bending = 0;
    def.tethers = index == 2;
    def.thread_count = 1 + index;
    def.iterations = 1 + index;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh sheet = percale_test_sheet(side, 1.0f);
    (void)percale_test_add_cloth(solver, &sheet);
    percale_mesh_free(&sheet);
    return solver;
}

static void step(PercaleSolver *solver, int count)
{
    for (int i = 0; i < count; i++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
}

START_TEST(what_the_scene_lacks_is_never_projected)
{
    PercaleSolver *solver = new_bare_solver(_i);
    step(solver, 4);
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_gt(counters.projections_stretch, 0);
    ck_assert_uint_eq(counters.projections_seam, 0);
    ck_assert_uint_eq(counters.projections_bend, 0);
    ck_assert_uint_eq(counters.projections_tether, 0);
    ck_assert_uint_eq(counters.projections_contact, 0);
    ck_assert_uint_eq(counters.projections, counters.projections_stretch);
    percale_solver_destroy(solver);
}
END_TEST

START_TEST(what_the_scene_lacks_is_never_detected)
{
    PercaleSolver *solver = new_bare_solver(_i);
    step(solver, 4);
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_eq(counters.candidates, 0);
    ck_assert_uint_eq(counters.stencils_vf, 0);
    ck_assert_uint_eq(counters.stencils_ee, 0);
    ck_assert_uint_eq(counters.rays, 0);
    ck_assert_uint_eq(counters.detections, 0);
    ck_assert_uint_eq(counters.detections_skipped, 0);
    percale_solver_destroy(solver);
}
END_TEST

START_TEST(inextensible_cloth_alone_needs_no_memory_to_be_solved)
{
    PercaleSolver *solver = new_bare_solver(_i);
    step(solver, 4);
    PercaleBytes bytes = percale_solver_bytes(solver);
    percale_solver_destroy(solver);
    ck_assert_uint_gt(bytes.model, 0);
    ck_assert_uint_eq(bytes.solve, 0);
}
END_TEST

START_TEST(without_obstacles_detection_needs_no_memory)
{
    PercaleSolver *solver = new_bare_solver(_i);
    step(solver, 4);
    PercaleBytes bytes = percale_solver_bytes(solver);
    percale_solver_destroy(solver);
    ck_assert_uint_eq(bytes.detect, 0);
}
END_TEST

// ---- taken away again ----

enum {
    SIDE = PERCALE_SANITIZED ? 24 : 60, // vertices along the sheet
    PATCH_SIDE = 8,
    STEPS = 10
};

/// A sheet over a ball that stays, a patch beside it, and perhaps what was there for a moment.
typedef struct Scene {
    PercaleSolver *solver;
    PercaleCloth sheet, patch;
    PercaleMesh sheet_mesh;
} Scene;

static void open_scene(Scene *scene)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.thread_count = 2;
    def.substeps = 8;
    def.passes = 4;
    def.wind[0] = 1.0f;
    *scene = (Scene){.solver = percale_test_solver(def), .sheet_mesh = percale_test_sheet(SIDE, 1.0f)};
    percale_test_translate(&scene->sheet_mesh, 0.01f, 0.31f, 0.003f);
    scene->sheet = percale_test_add_cloth(scene->solver, &scene->sheet_mesh);
    PercaleMesh patch = percale_test_sheet(PATCH_SIDE, 0.2f);
    percale_test_translate(&patch, 0.0f, 0.4f, -0.7f);
    scene->patch = percale_test_add_cloth(scene->solver, &patch);
    PercaleMesh ball = percale_test_sphere(PERCALE_SANITIZED ? 2 : 3, 0.3f);
    (void)percale_test_add_obstacle(scene->solver, &ball);
    percale_mesh_free(&patch);
    percale_mesh_free(&ball);
}

/// The state after some steps; it has to have touched the ball.
static uint64_t finish(Scene *scene)
{
    step(scene->solver, STEPS);
    PERCALE_TEST_OK(scene->solver, percale_solver_validate(scene->solver));
    ck_assert_uint_gt(percale_solver_counters(scene->solver).projections_contact, 0);
    ck_assert_uint_eq(percale_solver_counters(scene->solver).projections_seam, 0);
    uint64_t hash = percale_solver_hash(scene->solver);
    percale_solver_destroy(scene->solver);
    percale_mesh_free(&scene->sheet_mesh);
    return hash;
}

static uint64_t plain_hash(void)
{
    Scene scene;
    open_scene(&scene);
    return finish(&scene);
}

/// Whether somebody asks for the state while the part is there, which assembles the model with it.
static void perhaps_look(Scene *scene, bool looks)
{
    if (looks) {
        ck_assert_uint_ne(percale_solver_hash(scene->solver), 0);
    }
}

static PercalePin add_pin(Scene *scene)
{
    const uint32_t corners[3] = {0, SIDE - 1, SIDE * SIDE / 2};
    PercalePinDef def = percale_pin_def_default();
    PercalePin pin = {0};
    def.cloth = scene->sheet;
    def.vertices = corners;
    def.vertex_count = 3;
    PERCALE_TEST_OK(scene->solver, percale_pin_add(scene->solver, &def, &pin));
    return pin;
}

static PercaleSeam add_open_seam(Scene *scene)
{
    uint32_t in_patch[PATCH_SIDE];
    uint32_t in_sheet[PATCH_SIDE];
    PercaleSeamDef def = percale_seam_def_default();
    PercaleSeam seam = {0};
    for (uint32_t i = 0; i < PATCH_SIDE; i++) {
        in_patch[i] = PATCH_SIDE * (PATCH_SIDE - 1) + i;
        in_sheet[i] = 3 + i;
    }
    def.cloth_a = scene->patch;
    def.cloth_b = scene->sheet;
    def.vertices_a = in_patch;
    def.vertices_b = in_sheet;
    def.pair_count = PATCH_SIDE;
    PERCALE_TEST_OK(scene->solver, percale_seam_add(scene->solver, &def, &seam));
    return seam;
}

START_TEST(an_obstacle_that_was_removed_leaves_no_trace)
{
    Scene scene;
    open_scene(&scene);
    PercaleMesh box = percale_test_box(0.5f, 0.5f, 0.5f); // in the way, if it were still there
    percale_test_translate(&box, 0.3f, 0.2f, 0.0f);
    PercaleObstacle obstacle = percale_test_add_obstacle(scene.solver, &box);
    perhaps_look(&scene, _i == 1);
    PERCALE_TEST_OK(scene.solver, percale_obstacle_remove(scene.solver, obstacle));
    percale_mesh_free(&box);
    ck_assert_uint_eq(finish(&scene), plain_hash());
}
END_TEST

START_TEST(a_pin_that_was_removed_leaves_no_trace)
{
    Scene scene;
    open_scene(&scene);
    PercalePin pin = add_pin(&scene);
    perhaps_look(&scene, _i == 1);
    PERCALE_TEST_OK(scene.solver, percale_pin_remove(scene.solver, pin));
    ck_assert_uint_eq(finish(&scene), plain_hash());
}
END_TEST

START_TEST(a_pin_that_was_moved_and_removed_leaves_no_trace)
{
    const float targets[9] = {0.1f, 0.9f, 0.2f, -0.3f, 0.8f, 0.0f, 0.0f, 0.7f, 0.4f};
    Scene scene;
    open_scene(&scene);
    PercalePin pin = add_pin(&scene);
    PERCALE_TEST_OK(scene.solver, percale_pin_move(scene.solver, pin, targets, 0));
    perhaps_look(&scene, _i == 1);
    PERCALE_TEST_OK(scene.solver, percale_pin_remove(scene.solver, pin));
    ck_assert_uint_eq(finish(&scene), plain_hash());
}
END_TEST

START_TEST(a_seam_that_was_removed_leaves_no_trace)
{
    Scene scene;
    open_scene(&scene);
    PercaleSeam seam = add_open_seam(&scene);
    perhaps_look(&scene, _i == 1);
    PERCALE_TEST_OK(scene.solver, percale_seam_remove(scene.solver, seam));
    ck_assert_uint_eq(finish(&scene), plain_hash());
}
END_TEST

// What they would have done, so that their absence means something.
START_TEST(each_of_them_would_have_changed_the_state)
{
    uint64_t plain = plain_hash();
    Scene scene;
    open_scene(&scene);
    (void)add_pin(&scene);
    ck_assert_uint_ne(finish(&scene), plain);
    open_scene(&scene);
    PercaleMesh box = percale_test_box(0.5f, 0.5f, 0.5f);
    percale_test_translate(&box, 0.3f, 0.2f, 0.0f);
    (void)percale_test_add_obstacle(scene.solver, &box);
    percale_mesh_free(&box);
    ck_assert_uint_ne(finish(&scene), plain);
}
END_TEST

/// Bytes of a scene in which a seam and a pin have come and gone so many times.
static PercaleBytes bytes_after(int round_count, bool looks)
{
    Scene scene;
    open_scene(&scene);
    for (int round = 0; round < round_count; round++) {
        PercaleSeam seam = add_open_seam(&scene);
        PercalePin pin = add_pin(&scene);
        perhaps_look(&scene, looks);
        PERCALE_TEST_OK(scene.solver, percale_pin_remove(scene.solver, pin));
        PERCALE_TEST_OK(scene.solver, percale_seam_remove(scene.solver, seam));
    }
    perhaps_look(&scene, true);
    PercaleBytes bytes = percale_solver_bytes(scene.solver);
    percale_solver_destroy(scene.solver);
    percale_mesh_free(&scene.sheet_mesh);
    return bytes;
}

START_TEST(what_was_removed_gives_its_memory_back)
{
    PercaleBytes never = bytes_after(0, _i == 1);
    PercaleBytes once = bytes_after(1, _i == 1);
    PercaleBytes often = bytes_after(5, _i == 1);
    ck_assert_uint_eq(once.solve, never.solve);
    ck_assert_uint_eq(once.detect, never.detect);
    ck_assert_uint_eq(often.solve, never.solve);
    ck_assert_uint_eq(often.detect, never.detect);
    ck_assert_uint_eq(often.model, once.model); // the lists of pins and seams keep their room
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("unused");
    TCase *absent = tcase_create("absent");
    tcase_set_timeout(absent, 60.0);
    tcase_add_loop_test(absent, what_the_scene_lacks_is_never_projected, 0, BARE_COUNT);
    tcase_add_loop_test(absent, what_the_scene_lacks_is_never_detected, 0, BARE_COUNT);
    tcase_add_loop_test(absent, inextensible_cloth_alone_needs_no_memory_to_be_solved, 0, BARE_COUNT);
    tcase_add_loop_test(absent, without_obstacles_detection_needs_no_memory, 0, BARE_COUNT);
    suite_add_tcase(suite, absent);
    TCase *removed = tcase_create("removed");
    tcase_set_timeout(removed, 100.0);
    tcase_add_loop_test(removed, an_obstacle_that_was_removed_leaves_no_trace, 0, 2);
    tcase_add_loop_test(removed, a_pin_that_was_removed_leaves_no_trace, 0, 2);
    tcase_add_loop_test(removed, a_pin_that_was_moved_and_removed_leaves_no_trace, 0, 2);
    tcase_add_loop_test(removed, a_seam_that_was_removed_leaves_no_trace, 0, 2);
    tcase_add_test(removed, each_of_them_would_have_changed_the_state);
    tcase_add_loop_test(removed, what_was_removed_gives_its_memory_back, 0, 2);
    suite_add_tcase(suite, removed);
    return percale_test_run(suite);
}
