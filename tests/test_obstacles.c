// Cloth vertices and obstacles that pass each other within one step: what is in front stays in front, what
// comes from behind an open surface isn't touched.
//
// Vertices without cloth: triangles that share nothing and hardly resist being stretched.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float LOOSE = 1e9f;       // m/N; such an edge doesn't pull
static const double STEP = 1.0 / 64.0; // s
enum { PARTICLES = 300 };              // a multiple of 3

/// Free vertices, and the scene around them.
typedef struct Scene {
    PercaleSolver *solver;
    PercaleCloth cloth;
    PercaleObstacle obstacle;
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES]; // m/s
    float end[3 * PARTICLES];
} Scene;

static PercaleSolverDef weightless(int substeps)
{
    PercaleSolverDef def = percale_solver_def_default();
    memset(def.gravity, 0, sizeof(def.gravity));
    def.damping = 0.0f;
    def.speed_max = 1000.0f;
    def.substeps = substeps;
    def.thread_count = 2;
    return def;
}

/// Adds the vertices of scene->start with their velocities.
static void add_particles(Scene *scene)
{
    uint32_t triangles[PARTICLES];
    for (uint32_t i = 0; i < PARTICLES; i++) {
        triangles[i] = i;
    }
    PercaleClothDef def = percale_cloth_def_default();
    def.positions = scene->start;
    def.velocities = scene->velocity;
    def.vertex_count = PARTICLES;
    def.triangles = triangles;
    def.triangle_count = PARTICLES / 3;
    def.material.stretch_compliance = LOOSE;
    def.material.thickness = 0.002f;
    PERCALE_TEST_OK(scene->solver, percale_cloth_add(scene->solver, &def, &scene->cloth));
}

static Scene create(PercaleSolverDef def, const PercaleMesh *obstacle, const float *start,
                    const float *velocity)
{
    Scene scene = {.solver = percale_test_solver(def)};
    memcpy(scene.start, start, sizeof(scene.start));
    memcpy(scene.velocity, velocity, sizeof(scene.velocity));
    add_particles(&scene);
    if (obstacle != NULL) {
        scene.obstacle = percale_test_add_obstacle(scene.solver, obstacle);
    }
    return scene;
}

static void step(Scene *scene)
{
    PERCALE_TEST_OK(scene->solver, percale_solver_step(scene->solver, STEP));
    PERCALE_TEST_OK(scene->solver, percale_cloth_get_positions(scene->solver, scene->cloth, scene->end, 0));
}

static float between(uint64_t *seed, double low, double high)
{
    return (float)(low + (high - low) * percale_test_random(seed));
}

/// Random points in a box; velocity so that each goes by `path` m per step.
static void scatter(const double low[3], const double high[3], const double path[3], float *start,
                    float *velocity)
{
    uint64_t seed = 5;
    for (size_t i = 0; i < PARTICLES; i++) {
        for (size_t axis = 0; axis < 3; axis++) {
            start[3 * i + axis] = between(&seed, low[axis], high[axis]);
            velocity[3 * i + axis] = (float)(path[axis] / STEP);
        }
    }
}

/// What becomes of the same vertices with no obstacle at all.
static uint64_t free_hash(PercaleSolverDef def, const float *start, const float *velocity)
{
    Scene scene = create(def, NULL, start, velocity);
    step(&scene);
    uint64_t hash = percale_solver_hash(scene.solver);
    percale_solver_destroy(scene.solver);
    return hash;
}

// ---- a fast vertex, an open surface at rest ----

static const uint32_t SIDES[] = {2, 41}; // of the open sheet: two triangles, and 3,200

START_TEST(ten_metres_in_a_step_end_in_front_of_an_open_surface)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-1.0, 0.0005, -1.0};
    const double high[3] = {1.0, 2.0, 1.0};
    const double path[3] = {0.7, -10.0, 0.3};
    scatter(low, high, path, start, velocity);
    PercaleMesh sheet = percale_test_sheet(SIDES[_i], 8.0f);
    Scene scene = create(weightless(1), &sheet, start, velocity);
    step(&scene);
    for (size_t i = 0; i < PARTICLES; i++) {
        ck_assert(scene.end[3 * i + 1] > 0.0f);
        ck_assert(scene.end[3 * i + 1] < 0.01f);
    }
    for (int k = 0; k < 30; k++) { // and there they stay
        step(&scene);
        for (size_t i = 0; i < PARTICLES; i++) {
            ck_assert(scene.end[3 * i + 1] > 0.0f || fabsf(scene.end[3 * i]) > 4.0f ||
                      fabsf(scene.end[3 * i + 2]) > 4.0f);
        }
    }
    ck_assert_uint_eq(percale_solver_counters(scene.solver).left_inside, 0);
    percale_solver_destroy(scene.solver);
    percale_mesh_free(&sheet);
}
END_TEST

START_TEST(from_behind_an_open_surface_is_not_there)
{
    const double path[3][3] = {
        {0.7, 10.0, 0.3}, {0.0, 0.004, 0.0}, {0.5, 0.0, 0.0}}; // m: through, just so, along
    for (int k = 0; k < 3; k++) {
        float start[3 * PARTICLES];
        float velocity[3 * PARTICLES];
        const double low[3] = {-1.0, k == 0 ? -2.0 : -0.004, -1.0};
        const double high[3] = {1.0, -0.0001, 1.0};
        scatter(low, high, path[k], start, velocity);
        PercaleMesh sheet = percale_test_sheet(SIDES[_i], 8.0f);
        Scene scene = create(weightless(1), &sheet, start, velocity);
        step(&scene);
        ck_assert_uint_eq(percale_solver_hash(scene.solver), free_hash(weightless(1), start, velocity));
        percale_solver_destroy(scene.solver);
        percale_mesh_free(&sheet);
    }
}
END_TEST

// The way leads past the rim, and ends below the middle of the sheet.
START_TEST(around_the_rim_is_a_free_way)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {1.5, 0.2, -0.5};
    const double high[3] = {1.6, 0.3, 0.5};
    const double path[3] = {-1.5, -0.9, 0.0}; // passes y = 0 at x >= 1.5 - 0.5
    scatter(low, high, path, start, velocity);
    PercaleMesh sheet = percale_test_sheet(SIDES[_i], 1.8f);
    Scene scene = create(weightless(1), &sheet, start, velocity);
    step(&scene);
    ck_assert_uint_eq(percale_solver_hash(scene.solver), free_hash(weightless(1), start, velocity));
    percale_solver_destroy(scene.solver);
    percale_mesh_free(&sheet);
}
END_TEST

// Slowly out through the surface: free until it is through, then no faster than contact may push.
START_TEST(what_came_through_from_behind_is_not_pulled_back)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-1.0, -0.003, -1.0};
    const double high[3] = {1.0, -0.0001, 1.0};
    const double path[3] = {0.0, 0.002, 0.0};
    scatter(low, high, path, start, velocity);
    PercaleMesh sheet = percale_test_sheet(SIDES[_i], 4.0f);
    Scene scene = create(weightless(5), &sheet, start, velocity);
    float before[3 * PARTICLES];
    memcpy(before, start, sizeof(before));
    for (int k = 0; k < 10; k++) {
        step(&scene);
        for (size_t i = 0; i < PARTICLES; i++) {
            float risen = scene.end[3 * i + 1] - before[3 * i + 1];
            ck_assert(risen > 0.002f - 1e-5f);
            ck_assert(risen < 0.6f * (float)STEP);
        }
        memcpy(before, scene.end, sizeof(before));
    }
    for (size_t i = 0; i < PARTICLES; i++) {
        ck_assert(scene.end[3 * i + 1] > 0.002f);
    }
    percale_solver_destroy(scene.solver);
    percale_mesh_free(&sheet);
}
END_TEST

// ---- a whole cloth, with its edges ----

/// A roof turned against the obstacle, its ridge at a height, with a speed upwards; hash after some steps.
static uint64_t fly(const PercaleMesh *obstacle, float height, float speed, int steps, float range[2])
{
    enum { SIDE = 9 };
    PercaleSolverDef def = weightless(4);
    def.edge_edge = def.self_collision = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh sheet = percale_test_sheet(SIDE, 0.4f);
    float velocities[3 * SIDE * SIDE] = {0};
    for (size_t i = 0; i < sheet.vertex_count; i++) {
        float *x = sheet.positions + 3 * i;
        float turned[2] = {0.96f * x[0] - 0.28f * x[2], 0.28f * x[0] + 0.96f * x[2]};
        x[1] = height + 0.1f * turned[0] - 0.3f * fabsf(x[0]); // and tilted
        x[0] = turned[0];
        x[2] = turned[1];
        velocities[3 * i + 1] = speed;
    }
    PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
    cloth_def.velocities = velocities;
    cloth_def.material.thickness = 0.002f;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    if (obstacle != NULL) {
        (void)percale_test_add_obstacle(solver, obstacle);
    }
    for (int k = 0; k < steps; k++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, STEP));
    }
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, sheet.positions, 0));
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (size_t i = 0; i < sheet.vertex_count; i++) {
        range[0] = fminf(range[0], sheet.positions[3 * i + 1]);
        range[1] = fmaxf(range[1], sheet.positions[3 * i + 1]);
    }
    uint64_t hash = percale_solver_hash(solver);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    return hash;
}

// Faster than contact pushes, its vertices, edges and faces go through as if nothing were there, and on from
// the other side; from the front it stops.
START_TEST(a_cloth_with_edges_passes_an_open_surface_from_behind)
{
    PercaleMesh sheet = percale_test_sheet(SIDES[_i], 1.0f);
    float range[2];
    uint64_t hash = fly(&sheet, -0.05f, 1.0f, 14, range);
    ck_assert_uint_eq(hash, fly(NULL, -0.05f, 1.0f, 14, range));
    ck_assert(range[0] > 0.05f);
    hash = fly(&sheet, -0.0083f, 0.02f, 8, range); // it comes within the reach of contact, still behind
    ck_assert_uint_eq(hash, fly(NULL, -0.0083f, 0.02f, 8, range));
    ck_assert(range[1] < 0.0f && range[1] > -0.001f);
    (void)fly(&sheet, 0.1f, -1.0f, 10, range);
    ck_assert(range[0] > 0.0f);
    percale_mesh_free(&sheet);
}
END_TEST

// ---- an open surface that sweeps over resting vertices ----

/// Moves the obstacle in one step by `shift` along y after a turn about z.
static void sweep(Scene *scene, const PercaleMesh *mesh, double shift, double degrees, bool rigidly)
{
    double half = 0.5 * degrees * 3.14159265358979323846 / 180.0;
    if (rigidly) {
        const double rotation[4] = {0.0, 0.0, sin(half), cos(half)};
        const double translation[3] = {0.0, shift, 0.0};
        PERCALE_TEST_OK(scene->solver, percale_obstacle_set_transform(scene->solver, scene->obstacle,
                                                                      rotation, translation));
        return;
    }
    float *to = malloc(3 * sizeof(float) * mesh->vertex_count);
    ck_assert_ptr_nonnull(to);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double x = (double)mesh->positions[3 * i];
        double y = (double)mesh->positions[3 * i + 1];
        to[3 * i] = (float)(x * cos(2.0 * half) - y * sin(2.0 * half));
        to[3 * i + 1] = (float)(x * sin(2.0 * half) + y * cos(2.0 * half) + shift);
        to[3 * i + 2] = mesh->positions[3 * i + 2];
    }
    PERCALE_TEST_OK(scene->solver, percale_obstacle_move(scene->solver, scene->obstacle, to, 0, NULL, 0));
    free(to);
}

static const int SUBSTEPS[] = {1, 4};

START_TEST(a_sweep_of_ten_metres_takes_along_what_is_in_front)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-1.0, -4.9, -1.0};
    const double high[3] = {1.0, 4.9, 1.0};
    const double path[3] = {0.0, 0.0, 0.0};
    scatter(low, high, path, start, velocity);
    for (int k = 0; k < 4; k++) {
        PercaleMesh sheet = percale_test_sheet(SIDES[_i], 4.0f);
        percale_test_translate(&sheet, 0.0f, -5.0f, 0.0f);
        Scene scene = create(weightless(SUBSTEPS[k / 2]), &sheet, start, velocity);
        sweep(&scene, &sheet, 10.0, 0.0, k % 2 == 1);
        step(&scene);
        for (size_t i = 0; i < PARTICLES; i++) {
            ck_assert(scene.end[3 * i + 1] > 5.0f);
        }
        ck_assert_uint_eq(percale_solver_counters(scene.solver).left_inside, 0);
        percale_solver_destroy(scene.solver);
        percale_mesh_free(&sheet);
    }
}
END_TEST

// The only collision pass is before the first of many substeps, when a vertex that starts to fall is still
// far away. Its path tells in time: there is nothing to put back.
START_TEST(between_two_passes_nothing_gets_through_either)
{
    static const PercaleCcd CCD[] = {PERCALE_CCD_RAY, PERCALE_CCD_OFF, PERCALE_CCD_EXACT};
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-1.0, 0.01, -1.0};
    const double high[3] = {1.0, 4.9, 1.0};
    const double none[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        scatter(low, high, none, start, velocity);
        PercaleSolverDef def = weightless(20);
        def.gravity[1] = -8000.0f; // 1 m in the first step, 3 in the second
        def.passes = 1;
        def.ccd = CCD[k];
        PercaleMesh sheet = percale_test_sheet(_i == 0 ? 2 : 9, 8.0f); // a reach of metres has much to sort
        Scene scene = create(def, &sheet, start, velocity);
        for (int j = 0; j < 3; j++) {
            step(&scene);
            for (size_t i = 0; i < PARTICLES; i++) {
                ck_assert(scene.end[3 * i + 1] > 0.0f);
            }
        }
        PercaleCounters counters = percale_solver_counters(scene.solver);
        ck_assert_uint_eq(counters.left_inside, 0);
        ck_assert(CCD[k] == PERCALE_CCD_OFF || counters.truncated == 0);
        percale_solver_destroy(scene.solver);
        percale_mesh_free(&sheet);
    }
}
END_TEST

START_TEST(a_sweep_from_behind_touches_nothing)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-1.0, -4.9, -1.0};
    const double high[3] = {1.0, 4.9, 1.0};
    const double path[3] = {0.0, 0.0, 0.0};
    scatter(low, high, path, start, velocity);
    for (int rigidly = 0; rigidly < 2; rigidly++) {
        PercaleMesh sheet = percale_test_sheet(SIDES[_i], 4.0f);
        percale_test_translate(&sheet, 0.0f, 5.0f, 0.0f);
        Scene scene = create(weightless(1), &sheet, start, velocity);
        sweep(&scene, &sheet, -10.0, 0.0, rigidly == 1);
        step(&scene);
        ck_assert_uint_eq(percale_solver_hash(scene.solver), free_hash(weightless(1), start, velocity));
        percale_solver_destroy(scene.solver);
        percale_mesh_free(&sheet);
    }
}
END_TEST

// The sheet turns by 50 degrees about its middle line: one half comes up at what lies above it, the other
// goes down, away from that. Below it nothing is touched.
START_TEST(a_turn_takes_along_what_is_in_front)
{
    const double DEGREES = 50.0;
    double angle = DEGREES * 3.14159265358979323846 / 180.0;
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-1.0, 0.001, -1.0};
    const double high[3] = {1.0, 1.0, 1.0};
    const double path[3] = {0.0, 0.0, 0.0};
    scatter(low, high, path, start, velocity);
    for (int k = 0; k < 4; k++) {
        PercaleMesh sheet = percale_test_sheet(SIDES[_i], 8.0f);
        Scene scene = create(weightless(SUBSTEPS[k / 2]), &sheet, start, velocity);
        sweep(&scene, &sheet, 0.0, DEGREES, k % 2 == 1);
        step(&scene);
        for (size_t i = 0; i < PARTICLES; i++) {
            double above = -sin(angle) * (double)scene.end[3 * i] + cos(angle) * (double)scene.end[3 * i + 1];
            ck_assert_double_gt(above, 0.0);
        }
        percale_solver_destroy(scene.solver);
        for (size_t i = 0; i < PARTICLES; i++) {
            start[3 * i + 1] = -start[3 * i + 1];
        }
        scene = create(weightless(1), &sheet, start, velocity);
        sweep(&scene, &sheet, 0.0, DEGREES, k % 2 == 1);
        step(&scene);
        ck_assert_uint_eq(percale_solver_hash(scene.solver), free_hash(weightless(1), start, velocity));
        percale_solver_destroy(scene.solver);
        for (size_t i = 0; i < PARTICLES; i++) {
            start[3 * i + 1] = -start[3 * i + 1];
        }
        percale_mesh_free(&sheet);
    }
}
END_TEST

// ---- closed bodies ----

START_TEST(a_body_that_sweeps_ten_metres_passes_nothing)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-0.3, -4.0, -0.3};
    const double high[3] = {0.3, 4.0, 0.3};
    const double path[3] = {0.0, 0.0, 0.0};
    scatter(low, high, path, start, velocity);
    for (int k = 0; k < 8; k++) {
        PercaleMesh body = k < 4 ? percale_test_sphere(3, 0.5f) : percale_test_box(1.0f, 1.0f, 1.0f);
        percale_test_translate(&body, 0.0f, -5.0f, 0.0f);
        Scene scene = create(weightless(SUBSTEPS[k / 2 % 2]), &body, start, velocity);
        sweep(&scene, &body, 10.0, 0.0, k % 2 == 1);
        step(&scene);
        for (size_t i = 0; i < PARTICLES;
             i++) { // ahead of the centre at y = 5, or aside, but not in its wake
            float aside = hypotf(scene.end[3 * i], scene.end[3 * i + 2]);
            ck_assert(scene.end[3 * i + 1] > 5.2f || aside > 0.5f);
        }
        PercaleQuality quality;
        PERCALE_TEST_OK(scene.solver, percale_solver_quality(scene.solver, &quality));
        ck_assert_double_eq(quality.vertices_inside, 0.0);
        ck_assert_double_eq(quality.penetration_max_mm, 0.0);
        ck_assert_uint_eq(percale_solver_counters(scene.solver).left_inside, 0);
        percale_solver_destroy(scene.solver);
        percale_mesh_free(&body);
    }
}
END_TEST

// Moved once, then at rest: it stops what a static one at that place stops, bit for bit.
START_TEST(a_rigid_body_that_came_to_rest_is_a_static_one)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-0.4, 5.0, -0.4};
    const double high[3] = {0.4, 6.0, 0.4};
    const double path[3] = {0.0, -1.0, 0.0};
    scatter(low, high, path, start, velocity);
    uint64_t hash[2];
    for (int moved = 0; moved < 2; moved++) {
        PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
        percale_test_translate(&box, 0.0f, moved == 1 ? -2.0f : 0.0f, 0.0f);
        Scene scene = create(weightless(1), &box, start, velocity);
        if (moved == 1) {
            sweep(&scene, &box, 2.0, 0.0, true);
        }
        for (int k = 0; k < 8; k++) {
            step(&scene);
        }
        hash[moved] = percale_solver_hash(scene.solver);
        percale_solver_destroy(scene.solver);
        percale_mesh_free(&box);
    }
    ck_assert_uint_eq(hash[0], hash[1]);
}
END_TEST

// A sheet sweeps vertices into a box that was judged before it: the box gets to know, and lets them out
// slowly.
START_TEST(what_is_pushed_into_a_body_is_not_shot_out)
{
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES];
    const double low[3] = {-0.3, -0.5, -0.3};
    const double high[3] = {0.3, 0.3, 0.3};
    const double path[3] = {0.0, 0.0, 0.0};
    scatter(low, high, path, start, velocity);
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    percale_test_translate(&box, 0.0f, 1.0f, 0.0f);
    PercaleMesh sheet = percale_test_sheet(2, 4.0f);
    percale_test_translate(&sheet, 0.0f, -1.0f, 0.0f);
    PercaleSolverDef def = weightless(2);
    def.damping = 2000.0f; // what the sweep has thrown stands still at once
    Scene scene = create(def, &box, start, velocity);
    scene.obstacle = percale_test_add_obstacle(scene.solver, &sheet);
    sweep(&scene, &sheet, 2.3, 0.0, true);
    step(&scene);
    float before[3 * PARTICLES];
    for (int k = 0; k < 60; k++) {
        memcpy(before, scene.end, sizeof(before));
        step(&scene);
        for (size_t i = 0; i < PARTICLES; i++) {
            double way = hypot(hypot((double)scene.end[3 * i] - (double)before[3 * i],
                                     (double)scene.end[3 * i + 1] - (double)before[3 * i + 1]),
                               (double)scene.end[3 * i + 2] - (double)before[3 * i + 2]);
            ck_assert_msg(way < 0.65 * STEP, "step %d: vertex %zu moves %g m", k, i, way);
        }
    }
    PercaleQuality quality;
    PERCALE_TEST_OK(scene.solver, percale_solver_quality(scene.solver, &quality));
    ck_assert_double_eq(quality.vertices_inside, 0.0);
    percale_solver_destroy(scene.solver);
    percale_mesh_free(&box);
    percale_mesh_free(&sheet);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("obstacles");
    TCase *open = tcase_create("open surfaces");
    tcase_set_timeout(open, 60.0);
    tcase_add_loop_test(open, ten_metres_in_a_step_end_in_front_of_an_open_surface, 0, 2);
    tcase_add_loop_test(open, from_behind_an_open_surface_is_not_there, 0, 2);
    tcase_add_loop_test(open, around_the_rim_is_a_free_way, 0, 2);
    tcase_add_loop_test(open, what_came_through_from_behind_is_not_pulled_back, 0, 2);
    tcase_add_loop_test(open, a_cloth_with_edges_passes_an_open_surface_from_behind, 0, 2);
    tcase_add_loop_test(open, a_sweep_of_ten_metres_takes_along_what_is_in_front, 0, 2);
    tcase_add_loop_test(open, between_two_passes_nothing_gets_through_either, 0, 2);
    tcase_add_loop_test(open, a_sweep_from_behind_touches_nothing, 0, 2);
    tcase_add_loop_test(open, a_turn_takes_along_what_is_in_front, 0, 2);
    suite_add_tcase(suite, open);
    TCase *closed = tcase_create("closed bodies");
    tcase_set_timeout(closed, 60.0);
    tcase_add_test(closed, a_body_that_sweeps_ten_metres_passes_nothing);
    tcase_add_test(closed, a_rigid_body_that_came_to_rest_is_a_static_one);
    tcase_add_test(closed, what_is_pushed_into_a_body_is_not_shot_out);
    suite_add_tcase(suite, closed);
    return percale_test_run(suite);
}
