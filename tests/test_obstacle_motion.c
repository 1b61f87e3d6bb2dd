// Where a deforming obstacle is within a step: on straight lines, or on cubics with given velocities.

#include "predict/obstacle_motion.h"
#include "solver.h"
#include "testing.h"

#include <math.h>
#include <string.h>

static const double STEP = 1.0 / 30.0; // s
static const double TURN = 0.23;       // rad in a step: 13 degrees
enum { CORNERS = 8 };

/// An arm of a metre that turns about the z axis.
typedef struct Arm {
    PercaleSolver *solver;
    PercaleMesh mesh;
    PercaleObstacle obstacle;
} Arm;

static Arm make_arm(void)
{
    Arm arm = {.solver = percale_test_solver(percale_solver_def_default()),
               .mesh = percale_test_box(1.0f, 0.1f, 0.1f)};
    percale_test_translate(&arm.mesh, 0.5f, 0.0f, 0.0f);
    arm.obstacle = percale_test_add_obstacle(arm.solver, &arm.mesh);
    (void)percale_test_add_cloth(arm.solver, &arm.mesh); // a step has to have something to do
    return arm;
}

static void free_arm(Arm *arm)
{
    percale_solver_destroy(arm->solver);
    percale_mesh_free(&arm->mesh);
}

/// Sends it to where it has turned `steps` steps' way.
static void send(Arm *arm, int steps, bool with_velocities)
{
    float to[3 * CORNERS];
    float velocities[3 * CORNERS];
    double angle = TURN * steps;
    for (size_t i = 0; i < CORNERS; i++) {
        const float *x = arm->mesh.positions + 3 * i;
        double along = cos(angle) * (double)x[0] - sin(angle) * (double)x[1];
        double up = sin(angle) * (double)x[0] + cos(angle) * (double)x[1];
        to[3 * i] = (float)along;
        to[3 * i + 1] = (float)up;
        to[3 * i + 2] = x[2];
        velocities[3 * i] = (float)(-up * TURN / STEP);
        velocities[3 * i + 1] = (float)(along * TURN / STEP);
        velocities[3 * i + 2] = 0.0f;
    }
    PERCALE_TEST_OK(arm->solver, percale_obstacle_move(arm->solver, arm->obstacle, to, 0,
                                                       with_velocities ? velocities : NULL, 0));
}

/// One of its corners at a fraction of the step that it has been sent on.
static f32x4 corner_at(Arm *arm, uint32_t corner, double fraction)
{
    PERCALE_TEST_OK(arm->solver, percale_solver_prepare(arm->solver));
    PercaleModel *model = &arm->solver->model;
    (void)percale_motion_apply(model, 0, &arm->solver->objects.obstacles[0], fraction, STEP,
                               percale_team_alone());
    return model->predicted[model->obstacles[0].first_point + corner];
}

/// By how much the corners come nearer to the axis within the step, m.
static double shrinkage(Arm *arm)
{
    double most = 0.0;
    for (uint32_t corner = 0; corner < CORNERS; corner++) {
        const float *x = arm->mesh.positions + 3 * (size_t)corner;
        double radius = hypot((double)x[0], (double)x[1]);
        for (int i = 1; i < 8; i++) {
            f32x4 now = corner_at(arm, corner, i / 8.0);
            most = fmax(most, radius - hypot((double)now[0], (double)now[1]));
        }
    }
    return most;
}

START_TEST(with_velocities_a_limb_keeps_its_length)
{
    for (int with_velocities = 0; with_velocities < 2; with_velocities++) {
        Arm arm = make_arm();
        send(&arm, 1, with_velocities);
        PERCALE_TEST_OK(arm.solver, percale_solver_step(arm.solver, STEP));
        send(&arm, 2, with_velocities);
        double shrunk = shrinkage(&arm);
        ck_assert_msg(with_velocities ? shrunk < 2e-5 : shrunk > 6e-3, "%d: %g m", with_velocities, shrunk);
        free_arm(&arm);
    }
}
END_TEST

START_TEST(a_step_begins_with_the_velocity_of_the_last)
{
    const double MOMENT = 1e-3; // of a step
    Arm arm = make_arm();
    send(&arm, 1, true);
    f32x4 before = corner_at(&arm, 1, 1.0 - MOMENT);
    f32x4 there = corner_at(&arm, 1, 1.0);
    PERCALE_TEST_OK(arm.solver, percale_solver_step(arm.solver, STEP));
    send(&arm, 2, true);
    ck_assert(!(length3(corner_at(&arm, 1, 0.0) - there) > 0.0f));
    f32x4 after = corner_at(&arm, 1, MOMENT);
    float change = length3((after - there) - (there - before));
    ck_assert(change < 0.01f * length3(after - there));
    free_arm(&arm);
}
END_TEST

/// After a step in a straight line, or none, the first cubic begins along the chord.
START_TEST(nothing_is_left_of_velocities_that_are_not_given_again)
{
    Arm fresh = make_arm();
    Arm used = make_arm();
    send(&used, 1, true);
    PERCALE_TEST_OK(used.solver, percale_solver_step(used.solver, STEP));
    send(&used, 0, true);
    send(&used, 0, false); // what was said last holds
    f32x4 half = corner_at(&used, 1, 0.5);
    f32x4 straight = (corner_at(&used, 1, 0.0) + corner_at(&used, 1, 1.0)) * 0.5f;
    ck_assert(length3(half - straight) < 1e-6f);
    PERCALE_TEST_OK(used.solver, percale_solver_step(used.solver, STEP));
    send(&used, 1, true);
    send(&fresh, 1, true);
    ck_assert(!(length3(corner_at(&used, 1, 0.3) - corner_at(&fresh, 1, 0.3)) > 0.0f));
    free_arm(&fresh);
    free_arm(&used);
}
END_TEST

START_TEST(a_velocity_that_is_no_number_is_refused_and_nothing_is_changed)
{
    Arm arm = make_arm();
    float velocities[3 * CORNERS] = {0.0f};
    velocities[7] = NAN;
    send(&arm, 1, true);
    f32x4 before = corner_at(&arm, 1, 0.5);
    ck_assert_int_eq(percale_obstacle_move(arm.solver, arm.obstacle, arm.mesh.positions, 0, velocities, 0),
                     PERCALE_INVALID_ARGUMENT);
    ck_assert_ptr_nonnull(strstr(percale_solver_last_error(arm.solver), "vertex 2"));
    ck_assert(!(length3(corner_at(&arm, 1, 0.5) - before) > 0.0f));
    free_arm(&arm);
}
END_TEST

// ---- the setting of a scene ----

/// Where a vertex of the body goes in the step to a frame.
static void body_at(PercaleScene *scene, PercaleSolver *solver, uint32_t frame, uint32_t vertex, double x[3])
{
    PercaleSceneError error = {""};
    ck_assert_msg(percale_scene_move(scene, solver, frame, &error), "%s", error.text);
    for (size_t axis = 0; axis < 3; axis++) {
        x[axis] = (double)percale_scene_obstacle(scene, 0).positions[3 * (size_t)vertex + axis];
    }
}

START_TEST(with_hermite_a_body_has_the_velocity_between_its_neighbouring_frames)
{
    enum { MOMENT = 40, VERTEX = 100 };
    PercaleSceneError error = {""};
    PercaleScene *scene = percale_scene_open("dress", 1000, &error);
    ck_assert_msg(scene != NULL, "%s", error.text);
    PercaleSolver *solver = percale_scene_build(scene, 1, &error);
    ck_assert_msg(solver != NULL, "%s", error.text);
    double before[3];
    double here[3];
    double after[3];
    body_at(scene, solver, MOMENT - 1, VERTEX, before);
    body_at(scene, solver, MOMENT + 1, VERTEX, after);
    ck_assert_ptr_null(solver->objects.obstacles[0].velocity_to);
    ck_assert_msg(percale_scene_set(scene, "hermite", "on", &error), "%s", error.text);
    body_at(scene, solver, MOMENT, VERTEX, here);
    const PercaleObstacleObject *body = &solver->objects.obstacles[0];
    ck_assert_ptr_nonnull(body->velocity_to);
    double moved = 0.0;
    for (size_t axis = 0; axis < 3; axis++) {
        double velocity = 0.5 * (after[axis] - before[axis]) * percale_scene_frame_rate(scene);
        size_t at = 3 * (size_t)VERTEX + axis;
        ck_assert_double_eq_tol((double)body->velocity_to[at], velocity, 1e-4);
        ck_assert_double_eq_tol((double)body->to[at], here[axis], 1e-9);
        moved += fabs(velocity);
    }
    ck_assert_double_gt(moved, 0.05);
    percale_solver_destroy(solver);
    percale_scene_close(scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("obstacle_motion");
    TCase *motion = tcase_create("motion");
    tcase_set_tags(motion, PERCALE_ONE_THREAD);
    tcase_add_test(motion, with_velocities_a_limb_keeps_its_length);
    tcase_add_test(motion, a_step_begins_with_the_velocity_of_the_last);
    tcase_add_test(motion, nothing_is_left_of_velocities_that_are_not_given_again);
    tcase_add_test(motion, a_velocity_that_is_no_number_is_refused_and_nothing_is_changed);
    tcase_add_test(motion, with_hermite_a_body_has_the_velocity_between_its_neighbouring_frames);
    tcase_set_timeout(motion, 0);
    suite_add_tcase(suite, motion);
    return percale_test_run(suite);
}
