// Laws of mechanics that a step has to keep.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static PercaleSolverDef quiet_def(void)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.damping = 0.0f;
    def.thread_count = 2;
    return def;
}

static float *positions_of(PercaleSolver *solver, PercaleCloth cloth, uint32_t count)
{
    float *positions = calloc(3 * (size_t)count + 1, sizeof(float));
    ck_assert_ptr_nonnull(positions);
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, positions, 0));
    return positions;
}

static float *velocities_of(PercaleSolver *solver, PercaleCloth cloth, uint32_t count)
{
    float *velocities = calloc(3 * (size_t)count + 1, sizeof(float));
    ck_assert_ptr_nonnull(velocities);
    PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, cloth, velocities, 0));
    return velocities;
}

static void run(PercaleSolver *solver, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / 60.0));
    }
}

// Symplectic Euler falls g t^2 / 2 plus half a substep's share, g t dt / 2.
START_TEST(free_fall_matches_the_parabola)
{
    PercaleMesh sheet = percale_test_sheet(12, 0.5f);
    PercaleSolver *solver = percale_test_solver(quiet_def());
    PercaleCloth cloth = percale_test_add_cloth(solver, &sheet);
    run(solver, 60);
    float *x = positions_of(solver, cloth, sheet.vertex_count);
    double expected = -0.5 * 9.81 * (1.0 + 1.0 / 1200.0);
    for (uint32_t i = 0; i < sheet.vertex_count; i++) {
        ck_assert_double_eq_tol((double)x[3 * i + 1], expected, 2e-3);
        ck_assert_double_eq_tol((double)x[3 * i], (double)sheet.positions[3 * i], 1e-3);
    }
    free(x);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
}
END_TEST

// A crumpled, spinning sheet without outer forces: the sum of m v stays where it was, in the mass-weighted
// sense of the area masses (a regular sheet's interior vertices all weigh the same, so they alone are given
// velocities).
START_TEST(momentum_survives_inner_forces)
{
    PercaleMesh sheet = percale_test_sheet(20, 1.0f);
    uint64_t seed = 7;
    float *velocities = calloc(3 * (size_t)sheet.vertex_count, sizeof(float));
    for (uint32_t i = 0; i < 3 * sheet.vertex_count; i++) {
        velocities[i] = (float)(percale_test_random(&seed) - 0.3);
    }
    PercaleSolverDef def = quiet_def();
    memset(def.gravity, 0, sizeof(def.gravity));
    PercaleSolver *solver = percale_test_solver(def);
    PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
    cloth_def.velocities = velocities;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    PercaleClothView view;
    double before[3] = {0};
    double after[3] = {0};
    double total = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        double *sum = pass == 0 ? before : after;
        PERCALE_TEST_OK(solver, percale_cloth_view(solver, cloth, &view));
        for (uint32_t i = 0; i < view.vertex_count; i++) {
            const float *x = view.positions + 4 * (size_t)view.order[i];
            const float *v = view.velocities + 4 * (size_t)view.order[i];
            for (int axis = 0; axis < 3; axis++) {
                sum[axis] += (double)v[axis] / (double)x[3];
                total += pass == 0 ? fabs((double)v[axis]) / (double)x[3] : 0.0;
            }
        }
        if (pass == 0) {
            run(solver, 30);
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        ck_assert_double_lt(fabs(after[axis] - before[axis]), 3e-4 * total);
    }
    free(velocities);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
}
END_TEST

// One triangle hung from a corner pair swings as a compound pendulum: its energy stays, within what a step
// that is symplectic but not exact loses in a second.
START_TEST(a_pendulum_keeps_its_energy)
{
    float positions[] = {0.0f, 0.0f, -0.05f, 0.0f, 0.0f, 0.05f, 1.0f, 0.0f, 0.0f};
    uint32_t triangle[] = {0, 1, 2};
    uint32_t pinned[] = {0, 1};
    PercaleSolverDef def = quiet_def();
    def.substeps = 80;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleClothDef cloth_def = percale_cloth_def_default();
    cloth_def.positions = positions;
    cloth_def.vertex_count = 3;
    cloth_def.triangles = triangle;
    cloth_def.triangle_count = 1;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    PercalePinDef pin_def = percale_pin_def_default();
    pin_def.cloth = cloth;
    pin_def.vertices = pinned;
    pin_def.vertex_count = 2;
    PercalePin pin;
    PERCALE_TEST_OK(solver, percale_pin_add(solver, &pin_def, &pin));
    double lowest = 0.0;
    for (int frame = 0; frame < 120; frame++) {
        run(solver, 1);
        float *x = positions_of(solver, cloth, 3);
        float *v = velocities_of(solver, cloth, 3);
        double speed2 =
            (double)v[6] * (double)v[6] + (double)v[7] * (double)v[7] + (double)v[8] * (double)v[8];
        double energy = 0.5 * speed2 + 9.81 * (double)x[7]; // per mass, 0 at the start
        ck_assert_double_eq_tol(energy, 0.0, 0.02 * 9.81);
        ck_assert_double_eq_tol((double)(x[6] * x[6] + x[7] * x[7] + x[8] * x[8]), 1.0, 1e-3);
        lowest = (double)x[7] < lowest ? (double)x[7] : lowest;
        free(x);
        free(v);
    }
    ck_assert_double_lt(lowest, -0.99); // it did swing
    percale_solver_destroy(solver);
}
END_TEST

// ---- incline ----

/// A small, stiff patch on a plane tilted by `degrees`; its mean acceleration down the slope over the second
/// half of a second, m/s^2, and how far it went, m.
static void slide(double degrees, float friction, double *acceleration, double *distance)
{
    double angle = degrees * 3.14159265358979323846 / 180.0;
    float c = (float)cos(angle);
    float s = (float)sin(angle);
    float plane[] = {-10 * c, 10 * s, -10, -10 * c, 10 * s, 10, 10 * c, -10 * s, 10, 10 * c, -10 * s, -10};
    uint32_t plane_triangles[] = {0, 1, 2, 0, 2, 3};
    PercaleMesh sheet = percale_test_sheet(5, 0.1f);
    for (uint32_t i = 0; i < sheet.vertex_count; i++) { // lay it on the slope, a thickness above
        float *x = sheet.positions + 3 * i;
        float along = x[0];
        x[0] = along * c + 0.002f * s;
        x[1] = -along * s + 0.002f * c;
    }
    PercaleSolver *solver = percale_test_solver(quiet_def());
    PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
    cloth_def.material.thickness = 0.002f;
    cloth_def.material.friction = friction;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    PercaleObstacleDef def = percale_obstacle_def_default();
    def.positions = plane;
    def.vertex_count = 4;
    def.triangles = plane_triangles;
    def.triangle_count = 2;
    def.friction = friction;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &def, &obstacle));
    double speed[2];
    for (int half = 0; half < 2; half++) {
        run(solver, 30);
        float *v = velocities_of(solver, cloth, sheet.vertex_count);
        speed[half] = 0.0;
        for (uint32_t i = 0; i < sheet.vertex_count; i++) {
            speed[half] +=
                ((double)v[3 * i] * cos(angle) - (double)v[3 * i + 1] * sin(angle)) / sheet.vertex_count;
        }
        free(v);
    }
    *acceleration = (speed[1] - speed[0]) / 0.5;
    float *x = positions_of(solver, cloth, sheet.vertex_count);
    *distance = 0.0;
    for (uint32_t i = 0; i < 3 * sheet.vertex_count; i++) {
        double moved = fabs((double)x[i] - (double)sheet.positions[i]);
        *distance = moved > *distance ? moved : *distance;
    }
    free(x);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
}

static const double FRICTION_ANGLE = 21.801409486351815; // atan(0.4), degrees

START_TEST(a_patch_holds_below_the_friction_angle)
{
    double acceleration;
    double distance;
    slide(FRICTION_ANGLE - 1.0, 0.4f, &acceleration, &distance);
    ck_assert_double_lt(distance, 1e-3);
    ck_assert_double_lt(fabs(acceleration), 0.01);
}
END_TEST

START_TEST(a_patch_slides_above_it_as_coulomb_says)
{
    for (int i = 0; i < 4; i++) {
        double degrees = FRICTION_ANGLE + 2.0 + 12.0 * i;
        double acceleration;
        double distance;
        slide(degrees, 0.4f, &acceleration, &distance);
        double angle = degrees * 3.14159265358979323846 / 180.0;
        double expected = 9.81 * (sin(angle) - 0.4 * cos(angle));
        ck_assert_double_eq_tol(acceleration, expected, 0.03 * expected);
    }
}
END_TEST

START_TEST(without_friction_nothing_holds)
{
    double acceleration;
    double distance;
    slide(5.0, 0.0f, &acceleration, &distance);
    ck_assert_double_eq_tol(acceleration, 9.81 * sin(5.0 * 3.14159265358979323846 / 180.0), 0.01);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("laws");
    TCase *motion = tcase_create("motion");
    tcase_add_test(motion, free_fall_matches_the_parabola);
    tcase_add_test(motion, momentum_survives_inner_forces);
    tcase_add_test(motion, a_pendulum_keeps_its_energy);
    suite_add_tcase(suite, motion);
    TCase *friction = tcase_create("friction");
    tcase_add_test(friction, a_patch_holds_below_the_friction_angle);
    tcase_add_test(friction, a_patch_slides_above_it_as_coulomb_says);
    tcase_add_test(friction, without_friction_nothing_holds);
    suite_add_tcase(suite, friction);
    return percale_test_run(suite);
}
