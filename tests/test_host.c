// A good guest: the host's memory, its failures, its floating-point mode, its threads; and numbers that
// overflow.

#include "testing.h"

#include <fenv.h>
#include <locale.h>
#include <math.h>
#include <omp.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s

// ---- an allocator that counts and fails ----

typedef struct Heap {
    size_t live_count, call_count;
    size_t fail_at; // the call, counted from 0, that gets nothing; SIZE_MAX: none
    bool has_failed;
} Heap;

static void *allocate(void *user, size_t size, size_t alignment)
{
    Heap *heap = user;
    if (heap->call_count++ == heap->fail_at) {
        heap->has_failed = true;
        return NULL;
    }
    void *block = aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    ck_assert_ptr_nonnull(block);
    memset(block, 0x5a, size); // nothing may rely on zeros
    heap->live_count++;
    return block;
}

static void release(void *user, void *memory)
{
    Heap *heap = user;
    ck_assert_ptr_nonnull(memory);
    heap->live_count--;
    free(memory);
}

// ---- the scene, call after call ----

typedef struct Scene {
    Heap heap;
    PercaleSolver *solver;
    PercaleMesh sheet, patch, box, ball;
    PercaleCloth cloth, patch_cloth;
    PercaleObstacle box_obstacle, ball_obstacle;
    PercalePin pin;
    PercaleSeam seam;
    float numbers[3 * 200];
} Scene;

static PercaleResult make_solver(Scene *scene)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = 1; // else a step that fails has done some of its substeps
    def.iterations = 3;
    def.thread_count = 2;
    def.allocate = allocate;
    def.release = release;
    def.allocator_user = &scene->heap;
    return percale_solver_create(def, &scene->solver);
}

static PercaleResult add_sheet(Scene *scene)
{
    PercaleClothDef def = percale_test_cloth_def(&scene->sheet);
    def.rest_positions = scene->sheet.positions;
    def.velocities = scene->numbers;
    return percale_cloth_add(scene->solver, &def, &scene->cloth);
}

static PercaleResult add_patch(Scene *scene)
{
    PercaleClothDef def = percale_test_cloth_def(&scene->patch);
    def.material.stretch_compliance = 1e-4f;
    return percale_cloth_add(scene->solver, &def, &scene->patch_cloth);
}

static PercaleResult add_box(Scene *scene)
{
    PercaleObstacleDef def = percale_test_obstacle_def(&scene->box);
    return percale_obstacle_add(scene->solver, &def, &scene->box_obstacle);
}

static PercaleResult add_ball(Scene *scene)
{
    PercaleObstacleDef def = percale_test_obstacle_def(&scene->ball);
    return percale_obstacle_add(scene->solver, &def, &scene->ball_obstacle);
}

static PercaleResult add_pin(Scene *scene)
{
    const uint32_t vertices[2] = {0, 5};
    PercalePinDef def = percale_pin_def_default();
    def.cloth = scene->cloth;
    def.vertices = vertices;
    def.vertex_count = 2;
    return percale_pin_add(scene->solver, &def, &scene->pin);
}

static PercaleResult add_seam(Scene *scene)
{
    const uint32_t in_sheet[2] = {63, 55};
    const uint32_t in_patch[2] = {12, 0};
    PercaleSeamDef def = percale_seam_def_default();
    def.cloth_a = scene->cloth;
    def.cloth_b = scene->patch_cloth;
    def.vertices_a = in_sheet;
    def.vertices_b = in_patch;
    def.pair_count = 2;
    return percale_seam_add(scene->solver, &def, &scene->seam);
}

static PercaleResult step(Scene *scene)
{
    return percale_solver_step(scene->solver, FRAME);
}

static PercaleResult judge(Scene *scene)
{
    PercaleQuality quality;
    return percale_solver_quality(scene->solver, &quality);
}

static PercaleResult validate(Scene *scene)
{
    return percale_solver_validate(scene->solver);
}

static PercaleResult view(Scene *scene)
{
    PercaleClothView seen;
    return percale_cloth_view(scene->solver, scene->cloth, &seen);
}

static PercaleResult move_pin(Scene *scene)
{
    const float targets[6] = {-0.15f, 0.05f, -0.15f, 0.05f, 0.04f, -0.15f};
    return percale_pin_move(scene->solver, scene->pin, targets, 0);
}

static PercaleResult move_ball(Scene *scene)
{
    return percale_obstacle_move(scene->solver, scene->ball_obstacle, scene->ball.positions, 0, NULL, 0);
}

static PercaleResult turn_box(Scene *scene)
{
    const double turn[4] = {0.0, 0.02, 0.0, 1.0};
    const double shift[3] = {0.0, 0.01, 0.0};
    return percale_obstacle_set_transform(scene->solver, scene->box_obstacle, turn, shift);
}

static PercaleResult set_positions(Scene *scene)
{
    return percale_cloth_set_positions(scene->solver, scene->cloth, scene->sheet.positions, 0);
}

static PercaleResult set_velocities(Scene *scene)
{
    return percale_cloth_set_velocities(scene->solver, scene->patch_cloth, scene->numbers, 0);
}

static PercaleResult change_material(Scene *scene)
{
    PercaleMaterial material = percale_material_default();
    material.density = 0.3f;
    return percale_cloth_set_material(scene->solver, scene->cloth, material);
}

static PercaleResult remove_seam(Scene *scene)
{
    return percale_seam_remove(scene->solver, scene->seam);
}

static PercaleResult remove_box(Scene *scene)
{
    return percale_obstacle_remove(scene->solver, scene->box_obstacle);
}

typedef PercaleResult Call(Scene *scene);

static Call *const CALLS[] = {
    make_solver, add_sheet, add_patch,  add_box, add_ball,      add_pin,        add_seam,        validate,
    move_ball,   turn_box,  step,       step,    move_pin,      move_ball,      turn_box,        step,
    view,        judge,     step,       step,    set_positions, set_velocities, change_material, step,
    remove_seam, step,      remove_box, step,
};
enum { CALL_COUNT = sizeof(CALLS) / sizeof(CALLS[0]) };

static Scene *create(void)
{
    Scene *scene = calloc(1, sizeof(*scene));
    ck_assert_ptr_nonnull(scene);
    scene->heap.fail_at = SIZE_MAX;
    scene->sheet = percale_test_sheet(8, 0.3f);
    percale_test_translate(&scene->sheet, 0.001f, 0.004f, 0.002f);
    scene->patch = percale_test_sheet(4, 0.1f);
    percale_test_translate(&scene->patch, 0.21f, 0.004f, 0.1f);
    scene->box = percale_test_box(1.0f, 1.0f, 1.0f);
    percale_test_translate(&scene->box, 0.0f, -0.5f, 0.0f);
    scene->ball = percale_test_sphere(2, 0.1f);
    percale_test_translate(&scene->ball, 0.0f, -0.08f, 0.0f);
    uint64_t seed = 9;
    for (size_t i = 0; i < sizeof(scene->numbers) / sizeof(scene->numbers[0]); i++) {
        scene->numbers[i] = (float)percale_test_random(&seed) - 0.5f;
    }
    return scene;
}

/// Ends the scene; true when every byte has come back.
static bool destroy(Scene *scene)
{
    percale_solver_destroy(scene->solver);
    bool clean = scene->heap.live_count == 0;
    percale_mesh_free(&scene->sheet);
    percale_mesh_free(&scene->patch);
    percale_mesh_free(&scene->box);
    percale_mesh_free(&scene->ball);
    free(scene);
    return clean;
}

static void make_calls(Scene *scene, size_t first, size_t end)
{
    for (size_t c = first; c < end; c++) {
        PERCALE_TEST_OK(scene->solver, CALLS[c](scene));
    }
}

static uint64_t reference_hash(void)
{
    Scene *scene = create();
    make_calls(scene, 0, CALL_COUNT);
    uint64_t hash = percale_solver_hash(scene->solver);
    ck_assert_uint_gt(percale_solver_counters(scene->solver).projections_contact, 0);
    ck_assert(destroy(scene));
    return hash;
}

// ---- memory ----

START_TEST(every_byte_comes_back)
{
    for (size_t end = 1; end <= CALL_COUNT; end++) {
        Scene *scene = create();
        make_calls(scene, 0, end);
        ck_assert_uint_gt(scene->heap.live_count, 0);
        ck_assert(destroy(scene));
    }
}
END_TEST

START_TEST(every_allocation_may_fail)
{
    uint64_t expected = reference_hash();
    size_t failures = 0;
    for (size_t c = 0; c < CALL_COUNT; c++) {
        bool has_failed = true;
        for (size_t n = 0; has_failed; n++) {
            Scene *scene = create();
            make_calls(scene, 0, c);
            scene->heap.fail_at = scene->heap.call_count + n;
            PercaleResult result = CALLS[c](scene);
            scene->heap.fail_at = SIZE_MAX;
            has_failed = scene->heap.has_failed;
            ck_assert_msg(result == (has_failed ? PERCALE_OUT_OF_MEMORY : PERCALE_OK),
                          "call %zu, allocation %zu: %s", c, n, percale_result_string(result));
            if (has_failed) {
                failures++;
                ck_assert(c > 0 || scene->solver == NULL);
                make_calls(scene, c, c + 1);
            }
            make_calls(scene, c + 1, CALL_COUNT);
            uint64_t hash = percale_solver_hash(scene->solver);
            ck_assert_msg(hash == expected, "call %zu, allocation %zu: another state", c, n);
            ck_assert_msg(destroy(scene), "call %zu, allocation %zu: not all came back", c, n);
        }
    }
    ck_assert_uint_gt(failures, 200);
}
END_TEST

START_TEST(a_step_in_the_long_run_asks_for_nothing)
{
    Scene *scene = create();
    make_calls(scene, 0, 8);
    size_t calls = 0;
    for (int frame = 0; frame < 90; frame++) {
        for (size_t i = 1; i < 3 * (size_t)scene->ball.vertex_count; i += 3) { // up and down
            scene->ball.positions[i] += (float)frame < 45.0f ? 5e-4f : -5e-4f;
        }
        PERCALE_TEST_OK(scene->solver, move_ball(scene));
        PERCALE_TEST_OK(scene->solver, turn_box(scene));
        size_t before = scene->heap.call_count;
        PERCALE_TEST_OK(scene->solver, step(scene));
        calls += frame >= 60 ? scene->heap.call_count - before : 0;
    }
    ck_assert_uint_gt(percale_solver_counters(scene->solver).stencils_vf, 0);
    ck_assert_uint_eq(calls, 0);
    ck_assert(destroy(scene));
}
END_TEST

/// Two sheets that lie on a ball in folds, with everything that contact has.
static PercaleSolver *make_pile(Heap *heap, const PercaleMesh *ball, PercaleObstacle *obstacle)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.thread_count = 1; // whose scratch grows is the same in each run
    def.self_collision = def.edge_edge = 1;
    def.damping = 5.0f; // 1/s; it comes to rest soon
    def.allocate = allocate;
    def.release = release;
    def.allocator_user = heap;
    PercaleSolver *solver = percale_test_solver(def);
    for (int i = 0; i < 2; i++) {
        PercaleMesh sheet = percale_test_sheet(15, 0.5f);
        percale_test_translate(&sheet, 0.03f * (float)i, 0.21f + 0.01f * (float)i, 0.0f);
        PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
        cloth_def.material.friction = 1.0f;
        PercaleCloth cloth;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
        percale_mesh_free(&sheet);
    }
    *obstacle = percale_test_add_obstacle(solver, ball);
    return solver;
}

START_TEST(a_pile_in_the_long_run_asks_for_nothing)
{
    enum { MOVING = 40, FRAMES = 120, COUNTED = 30 };
    Heap heap = {.fail_at = SIZE_MAX};
    PercaleMesh ball = percale_test_sphere(3, 0.2f);
    PercaleObstacle obstacle;
    PercaleSolver *solver = make_pile(&heap, &ball, &obstacle);
    size_t calls = 0;
    for (int frame = 0; frame < FRAMES; frame++) {
        if (frame < MOVING) { // up and down, so that more comes near than at rest
            percale_test_translate(&ball, 0.0f, frame % 10 < 5 ? 3e-3f : -3e-3f, 0.0f);
            PERCALE_TEST_OK(solver, percale_obstacle_move(solver, obstacle, ball.positions, 0, NULL, 0));
        }
        size_t before = heap.call_count;
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        calls += frame >= FRAMES - COUNTED ? heap.call_count - before : 0;
    }
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_gt(counters.stencils_ee, 0);
    ck_assert_uint_gt(counters.stencils_vf, 0);
    ck_assert_uint_eq(calls, 0);
    percale_solver_destroy(solver);
    ck_assert_uint_eq(heap.live_count, 0);
    percale_mesh_free(&ball);
}
END_TEST

// ---- the host's modes ----

START_TEST(however_the_host_rounds_the_bits_are_the_same)
{
    uint64_t expected = reference_hash();
    const int DIRECTIONS[] = {FE_UPWARD, FE_TOWARDZERO};
    for (int i = 0; i < 2; i++) {
        Scene *scene = create();
        PercaleResult results[CALL_COUNT];
        ck_assert_int_eq(fesetround(DIRECTIONS[i]), 0);
        int directions[CALL_COUNT];
        for (size_t c = 0; c < CALL_COUNT; c++) {
            results[c] = CALLS[c](scene);
            directions[c] = fegetround();
        }
        ck_assert_int_eq(fesetround(FE_TONEAREST), 0);
        for (size_t c = 0; c < CALL_COUNT; c++) {
            ck_assert_int_eq(results[c], PERCALE_OK);
            ck_assert_int_eq(directions[c], DIRECTIONS[i]);
        }
        ck_assert_uint_eq(percale_solver_hash(scene->solver), expected);
        ck_assert(destroy(scene));
    }
}
END_TEST

/// A number below the smallest normal one: 0 when such numbers are flushed.
static float denormal_half(void)
{
    volatile float tiny = 1.17549435e-38f;
    return tiny * 0.5f;
}

START_TEST(the_host_keeps_its_modes)
{
    omp_set_num_threads(3);
    omp_set_dynamic(1);
    omp_set_max_active_levels(2);
    struct sigaction before[3];
    struct sigaction after[3];
    const int SIGNALS[3] = {SIGFPE, SIGSEGV, SIGINT};
    locale_t locale = uselocale((locale_t)0);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(sigaction(SIGNALS[i], NULL, &before[i]), 0);
    }
    Scene *scene = create();
    make_calls(scene, 0, CALL_COUNT);
    ck_assert(denormal_half() > 0.0f);
    ck_assert_int_eq(fegetround(), FE_TONEAREST);
    ck_assert_int_eq(omp_get_max_threads(), 3);
    ck_assert_int_ne(omp_get_dynamic(), 0);
    ck_assert_int_eq(omp_get_max_active_levels(), 2);
    ck_assert(uselocale((locale_t)0) == locale);
    for (int i = 0; i < 3; i++) {
        ck_assert_int_eq(sigaction(SIGNALS[i], NULL, &after[i]), 0);
        ck_assert(before[i].sa_handler == after[i].sa_handler);
    }
    uint64_t hash = percale_solver_hash(scene->solver);
    ck_assert(destroy(scene));
    omp_set_dynamic(0);
    ck_assert_uint_eq(hash, reference_hash());
}
END_TEST

/// What a host thread is to find, and how often it did not.
typedef struct Life {
    uint64_t expected;
    int mismatch_count;
} Life;

static void *live(void *user)
{
    Life *life = user;
    for (int again = 0; again < 12; again++) {
        life->mismatch_count += reference_hash() != life->expected;
    }
    return NULL;
}

START_TEST(solvers_of_several_host_threads_do_not_meet)
{
    enum { THREADS = 4 };
    pthread_t threads[THREADS];
    Life lives[THREADS];
    for (int i = 0; i < THREADS; i++) {
        lives[i] = (Life){.expected = reference_hash()};
    }
    for (int i = 0; i < THREADS; i++) {
        ck_assert_int_eq(pthread_create(&threads[i], NULL, live, &lives[i]), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        ck_assert_int_eq(pthread_join(threads[i], NULL), 0);
    }
    for (int i = 0; i < THREADS; i++) {
        ck_assert_int_eq(lives[i].mismatch_count, 0);
    }
}
END_TEST

// ---- numbers that overflow ----

START_TEST(what_would_not_be_finite_is_named_and_undone)
{
    PercaleMesh sheet = percale_test_sheet(8, 0.3f);
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    percale_test_translate(&box, 0.0f, -0.503f, 0.0f);
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    PercaleClothDef def = percale_test_cloth_def(&sheet);
    def.name = "veil";
    def.material.friction = 0.3f;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    (void)percale_test_add_obstacle(solver, &box);
    for (int frame = 0; frame < 3; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    uint64_t good = percale_solver_hash(solver);
    PercaleMaterial material = def.material;
    material.stretch_compliance = 3e38f; // times 1 / dt^2 it is infinite
    PERCALE_TEST_OK(solver, percale_cloth_set_material(solver, cloth, material));
    ck_assert_uint_eq(percale_solver_hash(solver), good);
    for (int again = 0; again < 2; again++) {
        ck_assert_int_eq(percale_solver_step(solver, FRAME), PERCALE_NOT_FINITE);
        const char *text = percale_solver_last_error(solver);
        ck_assert_msg(strstr(text, "veil") != NULL && strstr(text, "vertex") != NULL, "'%s'", text);
        ck_assert_uint_eq(percale_solver_hash(solver), good);
        PERCALE_TEST_OK(solver, percale_solver_validate(solver));
    }
    PERCALE_TEST_OK(solver, percale_cloth_set_material(solver, cloth, def.material));
    PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    ck_assert_uint_ne(percale_solver_hash(solver), good);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    percale_mesh_free(&box);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("host");
    TCase *memory = tcase_create("memory");
    tcase_set_tags(memory, PERCALE_ANY_ENGINE);
    tcase_set_timeout(memory, 100.0);
    tcase_add_test(memory, every_byte_comes_back);
    tcase_add_test(memory, every_allocation_may_fail);
    tcase_add_test(memory, a_step_in_the_long_run_asks_for_nothing);
    tcase_add_test(memory, a_pile_in_the_long_run_asks_for_nothing);
    suite_add_tcase(suite, memory);
    TCase *modes = tcase_create("modes");
    tcase_set_timeout(modes, 60.0);
    tcase_add_test(modes, however_the_host_rounds_the_bits_are_the_same);
    tcase_add_test(modes, the_host_keeps_its_modes);
    tcase_add_test(modes, solvers_of_several_host_threads_do_not_meet);
    tcase_add_test(modes, what_would_not_be_finite_is_named_and_undone);
    suite_add_tcase(suite, modes);
    return percale_test_run(suite);
}
