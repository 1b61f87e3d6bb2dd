// The same bits: for any number of threads, for every run, and whatever was added and taken away again
// before.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
enum {
    SIDE =
        PERCALE_SANITIZED ? 24 : 76, // vertices along the sheet: 5,776, so that loops do get several threads
    PATCH_SIDE = 9,
    FRAMES = PERCALE_SANITIZED ? 3 : 4
};

/// What the scene below is made of; parts that a test adds for a moment are called `extra`.
typedef struct Scene {
    PercaleSolver *solver;
    PercaleMesh sheet, patch, ball, paddle, blob;
    PercaleCloth cloth, patch_cloth;
    PercaleObstacle rigid, deforming;
    PercalePin pin;
} Scene;

static PercaleSolverDef usual_def(int thread_count)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.thread_count = thread_count;
    def.substeps = 6;
    def.iterations = 3;
    def.passes = 4;
    def.wind[0] = 1.5f;
    def.wind[1] = 0.3f;
    return def;
}

static void make_meshes(Scene *scene)
{
    scene->sheet = percale_test_sheet(SIDE, 1.0f);
    percale_test_translate(&scene->sheet, 0.003f, 0.302f, 0.001f);
    scene->patch = percale_test_sheet(PATCH_SIDE, 0.2f); // sewn to the sheet's first corner, a little apart
    percale_test_translate(&scene->patch, -0.5f, 0.31f, -0.6f);
    scene->ball = percale_test_sphere(PERCALE_SANITIZED ? 2 : 4, 0.3f);
    scene->paddle = percale_test_box(0.1f, 0.5f, 0.5f);
    percale_test_translate(&scene->paddle, -0.45f, 0.3f, 0.0f);
    scene->blob = percale_test_sphere(3, 0.1f);
    percale_test_translate(&scene->blob, 0.35f, 0.15f, 0.3f);
}

static void add_seam(Scene *scene, PercaleSeam *seam)
{
    uint32_t in_patch[PATCH_SIDE];
    uint32_t in_sheet[PATCH_SIDE];
    for (uint32_t i = 0; i < PATCH_SIDE; i++) {
        in_patch[i] = PATCH_SIDE * (PATCH_SIDE - 1) + i;
        in_sheet[i] = 2 * i;
    }
    PercaleSeamDef def = percale_seam_def_default();
    def.cloth_a = scene->patch_cloth;
    def.cloth_b = scene->cloth;
    def.vertices_a = in_patch;
    def.vertices_b = in_sheet;
    def.pair_count = PATCH_SIDE;
    PERCALE_TEST_OK(scene->solver, percale_seam_add(scene->solver, &def, seam));
}

static void add_pin(Scene *scene, uint32_t vertex, PercalePin *pin)
{
    PercalePinDef def = percale_pin_def_default();
    def.cloth = scene->cloth;
    def.vertices = &vertex;
    def.vertex_count = 1;
    PERCALE_TEST_OK(scene->solver, percale_pin_add(scene->solver, &def, pin));
}

static Scene create(PercaleSolverDef def)
{
    Scene scene = {.solver = percale_test_solver(def)};
    make_meshes(&scene);
    scene.cloth = percale_test_add_cloth(scene.solver, &scene.sheet);
    PercaleClothDef patch = percale_test_cloth_def(&scene.patch);
    patch.material.stretch_compliance = 1e-5f;
    patch.material.friction = 0.6f;
    PERCALE_TEST_OK(scene.solver, percale_cloth_add(scene.solver, &patch, &scene.patch_cloth));
    (void)percale_test_add_obstacle(scene.solver, &scene.ball);
    scene.rigid = percale_test_add_obstacle(scene.solver, &scene.paddle);
    scene.deforming = percale_test_add_obstacle(scene.solver, &scene.blob);
    PercaleSeam seam;
    add_seam(&scene, &seam);
    add_pin(&scene, SIDE * SIDE - 1, &scene.pin);
    return scene;
}

static void destroy(Scene *scene)
{
    percale_solver_destroy(scene->solver);
    percale_mesh_free(&scene->sheet);
    percale_mesh_free(&scene->patch);
    percale_mesh_free(&scene->ball);
    percale_mesh_free(&scene->paddle);
    percale_mesh_free(&scene->blob);
}

/// The paddle turns and comes nearer, the blob swells, the pin rises.
static void move(Scene *scene, int frame)
{
    double angle = 0.05 * frame;
    const double rotation[4] = {0.0, sin(0.5 * angle), 0.0, cos(0.5 * angle)};
    const double translation[3] = {0.01 * frame, 0.002 * frame, 0.0};
    PERCALE_TEST_OK(scene->solver,
                    percale_obstacle_set_transform(scene->solver, scene->rigid, rotation, translation));
    size_t count = 3 * (size_t)scene->blob.vertex_count;
    float *swollen = malloc(count * sizeof(float));
    ck_assert_ptr_nonnull(swollen);
    for (size_t i = 0; i < count; i++) {
        const float centre[3] = {0.35f, 0.15f, 0.3f};
        float c = centre[i % 3];
        swollen[i] = c + (scene->blob.positions[i] - c) * (1.0f + 0.05f * (float)frame);
    }
    PERCALE_TEST_OK(scene->solver,
                    percale_obstacle_move(scene->solver, scene->deforming, swollen, 0, NULL, 0));
    free(swollen);
    const float *corner = scene->sheet.positions + 3 * (size_t)(SIDE * SIDE - 1);
    const float target[3] = {corner[0], corner[1] + 0.01f * (float)frame, corner[2]};
    PERCALE_TEST_OK(scene->solver, percale_pin_move(scene->solver, scene->pin, target, 0));
}

static uint64_t run(Scene *scene)
{
    for (int frame = 1; frame <= FRAMES; frame++) {
        move(scene, frame);
        PERCALE_TEST_OK(scene->solver, percale_solver_step(scene->solver, FRAME));
    }
    PERCALE_TEST_OK(scene->solver, percale_solver_validate(scene->solver));
    return percale_solver_hash(scene->solver);
}

static uint64_t hash_with(int thread_count)
{
    Scene scene = create(usual_def(thread_count));
    uint64_t hash = run(&scene);
    PercaleCounters counters = percale_solver_counters(scene.solver);
    ck_assert_uint_gt(counters.projections_contact, 0); // all of it took part
    ck_assert_uint_gt(counters.projections_seam, 0);
    ck_assert_uint_gt(counters.projections_bend, 0);
    ck_assert_uint_gt(counters.rays, 0);
    destroy(&scene);
    return hash;
}

START_TEST(one_thread_equals_seven)
{
    uint64_t one = hash_with(1);
    const int OTHERS[] = {1, 2, 3, 7};
    for (size_t i = 0; i < sizeof(OTHERS) / sizeof(OTHERS[0]); i++) {
        ck_assert_uint_eq(hash_with(OTHERS[i]), one);
    }
}
END_TEST

START_TEST(the_thread_count_may_change_between_steps)
{
    Scene scene = create(usual_def(1));
    for (int frame = 1; frame <= FRAMES; frame++) {
        PERCALE_TEST_OK(scene.solver, percale_solver_set_thread_count(scene.solver, 1 + frame % 4));
        move(&scene, frame);
        PERCALE_TEST_OK(scene.solver, percale_solver_step(scene.solver, FRAME));
    }
    ck_assert_uint_eq(percale_solver_hash(scene.solver), hash_with(2));
    destroy(&scene);
}
END_TEST

START_TEST(the_counters_do_not_depend_on_the_threads)
{
    PercaleCounters counters[2];
    for (int i = 0; i < 2; i++) {
        Scene scene = create(usual_def(1 + 2 * i));
        (void)run(&scene);
        counters[i] = percale_solver_counters(scene.solver);
        destroy(&scene);
    }
#define PERCALE_EQUAL_COUNTER(name) ck_assert_uint_eq(counters[0].name, counters[1].name);
    PERCALE_COUNTERS(PERCALE_EQUAL_COUNTER)
#undef PERCALE_EQUAL_COUNTER
}
END_TEST

START_TEST(asking_changes_nothing)
{
    Scene scene = create(usual_def(2));
    for (int frame = 1; frame <= FRAMES; frame++) {
        move(&scene, frame);
        PERCALE_TEST_OK(scene.solver, percale_solver_step(scene.solver, FRAME));
        PercaleQuality quality;
        PercaleClothView view;
        (void)percale_solver_hash(scene.solver);
        PERCALE_TEST_OK(scene.solver, percale_solver_validate(scene.solver));
        PERCALE_TEST_OK(scene.solver, percale_cloth_view(scene.solver, scene.cloth, &view));
        if (frame % 4 == 1) {
            PERCALE_TEST_OK(scene.solver, percale_solver_quality(scene.solver, &quality));
        }
    }
    ck_assert_uint_eq(percale_solver_hash(scene.solver), hash_with(2));
    destroy(&scene);
}
END_TEST

START_TEST(what_was_taken_away_before_the_first_step_was_never_there)
{
    Scene scene = create(usual_def(2));
    PercaleMesh extra_mesh = percale_test_box(1.0f, 1.0f, 1.0f);
    PercaleObstacle extra = percale_test_add_obstacle(scene.solver, &extra_mesh);
    (void)percale_solver_hash(scene.solver); // assembles the model with it
    PERCALE_TEST_OK(scene.solver, percale_obstacle_remove(scene.solver, extra));
    PercalePin pin;
    add_pin(&scene, 5, &pin);
    (void)percale_solver_hash(scene.solver);
    PERCALE_TEST_OK(scene.solver, percale_pin_remove(scene.solver, pin));
    PercaleSeam seam;
    add_seam(&scene, &seam);
    (void)percale_solver_hash(scene.solver);
    PERCALE_TEST_OK(scene.solver, percale_seam_remove(scene.solver, seam));
    PercaleCloth cloth = percale_test_add_cloth(scene.solver, &extra_mesh);
    (void)percale_solver_hash(scene.solver);
    PERCALE_TEST_OK(scene.solver, percale_cloth_remove(scene.solver, cloth));
    ck_assert_uint_eq(run(&scene), hash_with(2));
    percale_mesh_free(&extra_mesh);
    destroy(&scene);
}
END_TEST

/// A sheet alone, with bending and one of the parts that can be absent.
static PercaleCounters plain_counters(int bending, uint64_t *hash)
{
    PercaleMesh sheet = percale_test_sheet(12, 0.5f);
    PercaleSolverDef def = percale_solver_def_default();
    def.bending = bending;
    PercaleSolver *solver = percale_test_solver(def);
    (void)percale_test_add_cloth(solver, &sheet);
    for (int frame = 0; frame < 3; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    PercaleCounters counters = percale_solver_counters(solver);
    *hash = percale_solver_hash(solver);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    return counters;
}

START_TEST(what_the_scene_lacks_costs_nothing)
{
    uint64_t hash;
    PercaleCounters with = plain_counters(1, &hash);
    PercaleCounters without = plain_counters(0, &hash);
    ck_assert_uint_gt(with.projections_bend, 0);
    ck_assert_uint_eq(without.projections_bend, 0);
    ck_assert_uint_eq(without.projections, without.projections_stretch);
    ck_assert_uint_eq(with.projections_stretch, without.projections_stretch);
    ck_assert_uint_eq(with.projections_seam, 0);
    ck_assert_uint_eq(with.projections_contact, 0);
    ck_assert_uint_eq(with.projections_tether, 0);
    ck_assert_uint_eq(with.candidates, 0);
    ck_assert_uint_eq(with.stencils_vf, 0);
    ck_assert_uint_eq(with.stencils_ee, 0);
    ck_assert_uint_eq(with.rays, 0);
    ck_assert_uint_eq(with.detections, 0);
}
END_TEST

// An obstacle that is never near changes no bit.
START_TEST(a_far_obstacle_changes_nothing)
{
    uint64_t hash[2];
    for (int far = 0; far < 2; far++) {
        PercaleMesh sheet = percale_test_sheet(20, 0.5f);
        PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
        percale_test_translate(&box, 50.0f, 0.0f, 0.0f);
        PercaleSolver *solver = percale_test_solver(usual_def(2));
        (void)percale_test_add_cloth(solver, &sheet);
        if (far == 1) {
            (void)percale_test_add_obstacle(solver, &box);
        }
        for (int frame = 0; frame < 5; frame++) {
            PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        }
        hash[far] = percale_solver_hash(solver);
        percale_solver_destroy(solver);
        percale_mesh_free(&sheet);
        percale_mesh_free(&box);
    }
    ck_assert_uint_eq(hash[0], hash[1]);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("determinism");
    TCase *bits = tcase_create("bits");
    tcase_set_timeout(bits, 100.0);
    tcase_add_test(bits, one_thread_equals_seven);
    tcase_add_test(bits, the_thread_count_may_change_between_steps);
    tcase_add_test(bits, the_counters_do_not_depend_on_the_threads);
    tcase_add_test(bits, asking_changes_nothing);
    tcase_add_test(bits, what_was_taken_away_before_the_first_step_was_never_there);
    suite_add_tcase(suite, bits);
    TCase *absent = tcase_create("absent");
    tcase_set_timeout(absent, 60.0);
    tcase_add_test(absent, what_the_scene_lacks_costs_nothing);
    tcase_add_test(absent, a_far_obstacle_changes_nothing);
    suite_add_tcase(suite, absent);
    return percale_test_run(suite);
}
