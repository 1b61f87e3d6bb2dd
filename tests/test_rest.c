// Cloth that comes to rest, and cloth that begins too near: nothing pops, nothing creeps, nothing hums.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0;   // s
static const float THICKNESS = 0.002f;    // m, of each pair
static const double EXIT_SPEED_CAP = 0.5; // m/s
static const double HUM = 1e-8;           // J/kg; of a speed of 0.14 mm/s
static const double CREEP = 1e-6;         // m in 30 s

enum { SIDE = 5, VERTICES = SIDE * SIDE };

/// How a step is split.
typedef struct Split {
    int substeps, iterations, passes;
} Split;

static const Split SPLITS[] = {{20, 1, 20}, {20, 1, 5},  {20, 1, 1}, {5, 4, 5},
                               {5, 4, 20},  {1, 20, 20}, {1, 20, 1}};
enum { SPLIT_COUNT = sizeof(SPLITS) / sizeof(SPLITS[0]) };

static PercaleSolver *solver_of(Split split, float gravity)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = split.substeps;
    def.iterations = split.iterations;
    def.passes = split.passes;
    def.gravity[1] = -gravity;
    def.self_collision = 1;
    def.edge_edge = 1;
    return percale_test_solver(def);
}

static void add_obstacle(PercaleSolver *solver, PercaleMesh *mesh)
{
    PercaleObstacleDef def = percale_test_obstacle_def(mesh);
    def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &def, &obstacle));
    percale_mesh_free(mesh);
}

/// A level sheet, turned against the axes.
static PercaleCloth add_sheet(PercaleSolver *solver, float height, double turn, float stiffness)
{
    PercaleMesh mesh = percale_test_sheet(SIDE, 0.1f);
    for (size_t i = 0; i < VERTICES; i++) {
        float *x = mesh.positions + 3 * i;
        double a = (double)x[0];
        double b = (double)x[2];
        x[0] = (float)(cos(turn) * a - sin(turn) * b);
        x[1] = height;
        x[2] = (float)(sin(turn) * a + cos(turn) * b);
    }
    PercaleClothDef def = percale_test_cloth_def(&mesh);
    def.material.thickness = THICKNESS;
    def.material.bending_stiffness = stiffness;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    percale_mesh_free(&mesh);
    return cloth;
}

/// The fastest vertex, m/s, and the mean of v^2 / 2, J/kg.
static void speeds(PercaleSolver *solver, PercaleCloth cloth, double *fastest, double *energy)
{
    float v[3 * VERTICES];
    PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, cloth, v, 0));
    *fastest = 0.0;
    *energy = 0.0;
    for (size_t i = 0; i < 3 * VERTICES; i += 3) {
        double square = (double)v[i] * (double)v[i] + (double)v[i + 1] * (double)v[i + 1] +
                        (double)v[i + 2] * (double)v[i + 2];
        *fastest = fmax(*fastest, sqrt(square));
        *energy += 0.5 * square / VERTICES;
    }
}

static void centre_of(PercaleSolver *solver, PercaleCloth cloth, double centre[3])
{
    float x[3 * VERTICES];
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
    centre[0] = centre[1] = centre[2] = 0.0;
    for (size_t i = 0; i < 3 * VERTICES; i++) {
        centre[i % 3] += (double)x[i] / VERTICES;
    }
}

// ---- pop ----

/// Half a second: no vertex is ever faster than the cap.
static void expect_no_pop(PercaleSolver *solver, const PercaleCloth *cloths, int count)
{
    for (int frame = 0; frame < 30; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        for (int i = 0; i < count; i++) {
            double fastest;
            double energy;
            speeds(solver, cloths[i], &fastest, &energy);
            ck_assert_msg(fastest < EXIT_SPEED_CAP, "frame %d: %g m/s", frame, fastest);
        }
    }
}

/// Without gravity nothing would hold it back: what is left at the end is what the correction has given it.
static void expect_no_motion(PercaleSolver *solver, const PercaleCloth *cloths, int count)
{
    const double DRIFTING = 0.1; // m/s; a jump of 0.5 mm
    for (int i = 0; i < count; i++) {
        double before[3];
        double after[3];
        centre_of(solver, cloths[i], before);
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        centre_of(solver, cloths[i], after);
        ck_assert_double_lt(fabs(after[1] - before[1]) / FRAME, DRIFTING);
    }
    percale_solver_destroy(solver);
}

static PercaleMesh ground_box(void)
{
    PercaleMesh box = percale_test_box(1.0f, 0.2f, 1.0f);
    percale_test_translate(&box, 0.0f, -0.1f, 0.0f);
    return box;
}

START_TEST(half_a_thickness_from_an_obstacle_nothing_pops)
{
    for (int k = 0; k < 2; k++) {
        PercaleSolver *solver = solver_of(SPLITS[_i], k == 0 ? 0.0f : 9.81f);
        PercaleMesh box = ground_box();
        add_obstacle(solver, &box);
        PercaleCloth cloth = add_sheet(solver, 0.5f * THICKNESS, 0.1, 1e-3f);
        expect_no_pop(solver, &cloth, 1);
        expect_no_motion(solver, &cloth, 1);
    }
}
END_TEST

START_TEST(half_a_thickness_from_another_cloth_nothing_pops)
{
    for (int k = 0; k < 2; k++) {
        PercaleSolver *solver = solver_of(SPLITS[_i], k == 0 ? 0.0f : 9.81f);
        PercaleMesh box = ground_box();
        add_obstacle(solver, &box);
        PercaleCloth cloths[2] = {add_sheet(solver, THICKNESS, 0.1, 1e-3f),
                                  add_sheet(solver, 1.5f * THICKNESS, 0.4, 1e-3f)};
        expect_no_pop(solver, cloths, 2);
        percale_solver_destroy(solver);
    }
}
END_TEST

START_TEST(five_millimetres_inside_a_body_nothing_pops)
{
    for (int k = 0; k < 2; k++) {
        PercaleSolver *solver = solver_of(SPLITS[_i], k == 0 ? 0.0f : 9.81f);
        PercaleMesh box = ground_box();
        add_obstacle(solver, &box);
        PercaleCloth cloth = add_sheet(solver, -0.005f, 0.1, 1e-3f);
        expect_no_pop(solver, &cloth, 1);
        double centre[3];
        centre_of(solver, cloth, centre);
        ck_assert_double_gt(centre[1], 0.5 * (double)THICKNESS); // and it did come out
        expect_no_motion(solver, &cloth, 1);
    }
}
END_TEST

/// A correction gives no velocity, so positions have to be asked.
START_TEST(out_of_a_body_cloth_goes_no_faster_than_the_cap)
{
    const double SHORT = 0.25 * FRAME; // s; in a whole frame the 7 mm are soon gone
    const double MOST = 0.6; // m/s: the cap, and a tenth of a metre per second that nobody takes away
    PercaleSolver *solver = solver_of(SPLITS[_i], 0.0f);
    PercaleMesh box = ground_box();
    add_obstacle(solver, &box);
    PercaleCloth cloth = add_sheet(solver, -0.005f, 0.1, 1e-3f);
    for (int step = 0; step < 10; step++) {
        double before[3];
        double after[3];
        centre_of(solver, cloth, before);
        PERCALE_TEST_OK(solver, percale_solver_step(solver, SHORT));
        centre_of(solver, cloth, after);
        ck_assert_double_lt((after[1] - before[1]) / SHORT, MOST);
    }
    percale_solver_destroy(solver);
}
END_TEST

// ---- rest ----

/// Sloping ground of random triangles.
static PercaleMesh slope(void)
{
    PercaleMesh mesh = percale_test_sheet(12, 0.5f);
    uint64_t seed = 3;
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        float *x = mesh.positions + 3 * i;
        x[0] += (float)(0.02 * (percale_test_random(&seed) - 0.5));
        x[2] += (float)(0.02 * (percale_test_random(&seed) - 0.5));
        x[1] = 0.1f * x[0]; // a third of what friction holds
    }
    return mesh;
}

/// Limp sheets fall on a slope; after half of the time they stay where they are for the other.
START_TEST(a_minute_on_the_ground_is_rest)
{
    // frames; a whole minute where it is cheap
    const int half = PERCALE_SANITIZED ? 90 : SPLITS[_i].passes == 1 ? 1800 : 3000 / SPLITS[_i].passes + 150;
    PercaleSolver *solver = solver_of(SPLITS[_i], 9.81f);
    PercaleMesh ground = slope();
    add_obstacle(solver, &ground);
    PercaleCloth cloths[2] = {add_sheet(solver, 0.015f, 0.1, 1e-6f)};
    int count = SPLITS[_i].passes == 1 && SPLITS[_i].substeps > 1 ? 2 : 1; // the cheapest that holds two
    if (count == 2) {
        cloths[1] = add_sheet(solver, 0.02f, 0.4, 1e-6f);
    }
    double middle[2][3] = {{0.0}};
    for (int frame = 0; frame < 2 * half; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        for (int i = 0; i < count && frame == half; i++) {
            centre_of(solver, cloths[i], middle[i]);
        }
    }
    for (int i = 0; i < count; i++) {
        double fastest;
        double energy;
        double end[3];
        speeds(solver, cloths[i], &fastest, &energy);
        centre_of(solver, cloths[i], end);
        double drift = hypot(hypot(end[0] - middle[i][0], end[1] - middle[i][1]), end[2] - middle[i][2]);
        ck_assert_msg(energy < HUM, "cloth %d hums with %g J/kg", i, energy);
        ck_assert_msg(drift < CREEP, "cloth %d has crept %g mm", i, 1e3 * drift);
    }
    percale_solver_destroy(solver);
}
END_TEST

/// Bumps of a few millimetres, a hand's width from top to top.
static PercaleMesh hills(double height)
{
    PercaleMesh mesh = percale_test_sheet(24, 0.5f);
    uint64_t seed = 3;
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        float *x = mesh.positions + 3 * i;
        x[0] += (float)(0.008 * (percale_test_random(&seed) - 0.5));
        x[2] += (float)(0.008 * (percale_test_random(&seed) - 0.5));
        x[1] = (float)(height * sin(60.0 * (double)x[0]) * cos(50.0 * (double)x[2]));
    }
    return mesh;
}

/// Stiffnesses whose bending acts in every 1st to 10th substep; 0: never.
static const float LIMP[] = {0.0f, 1e-6f, 1e-5f, 1e-4f};
enum { LIMP_COUNT = sizeof(LIMP) / sizeof(LIMP[0]) };

/// Between tops it is bending that holds the cloth up.
START_TEST(limp_cloth_rests_on_hills)
{
    enum { FRAMES = 300 };
    PercaleSolver *solver = solver_of(SPLITS[0], 9.81f);
    PercaleMesh ground = hills(_i % 2 == 0 ? 0.003 : 0.01);
    add_obstacle(solver, &ground);
    PercaleCloth cloth = add_sheet(solver, 0.015f, 0.1, LIMP[_i / 2]);
    for (int frame = 0; frame < FRAMES; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    double fastest;
    double energy;
    speeds(solver, cloth, &fastest, &energy);
    ck_assert_msg(energy < HUM, "%g J/kg", energy);
    percale_solver_destroy(solver);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("rest");
    TCase *pop = tcase_create("pop");
    tcase_set_tags(pop, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(pop, 0);
    tcase_add_loop_test(pop, half_a_thickness_from_an_obstacle_nothing_pops, 0, SPLIT_COUNT);
    tcase_add_loop_test(pop, half_a_thickness_from_another_cloth_nothing_pops, 0, SPLIT_COUNT);
    tcase_add_loop_test(pop, five_millimetres_inside_a_body_nothing_pops, 0, SPLIT_COUNT);
    tcase_add_loop_test(pop, out_of_a_body_cloth_goes_no_faster_than_the_cap, 0, SPLIT_COUNT);
    suite_add_tcase(suite, pop);
    TCase *rest = tcase_create("rest");
    tcase_set_tags(rest, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(rest, 0);
    tcase_add_loop_test(rest, a_minute_on_the_ground_is_rest, 0, SPLIT_COUNT);
    tcase_add_loop_test(rest, limp_cloth_rests_on_hills, 0, 2 * LIMP_COUNT);
    suite_add_tcase(suite, rest);
    return percale_test_run(suite);
}
