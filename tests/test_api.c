// Every call of percale.h: what it refuses, with whose name, and that a refusal changes nothing.

#include "api_scene.h"

#include <math.h>

// ---- solver ----

static void expect_no_solver(PercaleSolverDef def, PercaleResult expected, const char *culprit)
{
    Log log = {0};
    def.log = keep_line;
    def.log_user = &log;
    PercaleSolver *solver = (PercaleSolver *)&log; // anything but NULL
    ck_assert_int_eq(percale_solver_create(def, &solver), expected);
    ck_assert_ptr_null(solver);
    ck_assert_int_eq(log.line_count, 1);
    ck_assert_msg(strstr(log.last, culprit) != NULL, "'%s' does not name '%s'", log.last, culprit);
}

/// Expects a default Def with one field changed to be refused.
#define PERCALE_NO_SOLVER(FIELD, VALUE, EXPECTED, CULPRIT)   \
    do {                                                     \
        PercaleSolverDef def = percale_solver_def_default(); \
        def.FIELD = (VALUE);                                 \
        expect_no_solver(def, (EXPECTED), (CULPRIT));        \
    } while (0)

START_TEST(an_unusable_solver_def_is_refused)
{
    PERCALE_NO_SOLVER(substeps, 0, PERCALE_INVALID_ARGUMENT, "substeps 0");
    PERCALE_NO_SOLVER(substeps, 1001, PERCALE_INVALID_ARGUMENT, "substeps 1001");
    PERCALE_NO_SOLVER(iterations, 0, PERCALE_INVALID_ARGUMENT, "iterations 0");
    PERCALE_NO_SOLVER(iterations, 1001, PERCALE_INVALID_ARGUMENT, "iterations 1001");
    PERCALE_NO_SOLVER(passes, 21, PERCALE_INVALID_ARGUMENT, "passes 21");
    PERCALE_NO_SOLVER(passes, -1, PERCALE_INVALID_ARGUMENT, "passes -1");
    PERCALE_NO_SOLVER(thread_count, 0, PERCALE_INVALID_ARGUMENT, "thread count 0");
    PERCALE_NO_SOLVER(thread_count, 257, PERCALE_INVALID_ARGUMENT, "thread count 257");
    PERCALE_NO_SOLVER(thread_count, 100000000, PERCALE_INVALID_ARGUMENT, "thread count 100000000");
    PERCALE_NO_SOLVER(gravity[2], NAN, PERCALE_INVALID_ARGUMENT, "gravity");
    PERCALE_NO_SOLVER(wind[0], INFINITY, PERCALE_INVALID_ARGUMENT, "wind");
    PERCALE_NO_SOLVER(origin[1], (double)NAN, PERCALE_INVALID_ARGUMENT, "origin");
    PERCALE_NO_SOLVER(damping, -0.1f, PERCALE_INVALID_ARGUMENT, "damping");
    PERCALE_NO_SOLVER(damping, NAN, PERCALE_INVALID_ARGUMENT, "damping");
    PERCALE_NO_SOLVER(speed_max, 0.0f, PERCALE_INVALID_ARGUMENT, "speed_max");
    PERCALE_NO_SOLVER(ccd, (PercaleCcd)9, PERCALE_INVALID_ARGUMENT, "ccd 9");
    PERCALE_NO_SOLVER(reuse, (PercaleReuse)9, PERCALE_INVALID_ARGUMENT, "reuse 9");
    PERCALE_NO_SOLVER(speed_max, NAN, PERCALE_INVALID_ARGUMENT, "speed_max");
    PercaleSolverDef def = percale_solver_def_default();
    def.size = 12; // another version's: not even its log can be trusted
    PercaleSolver *solver = NULL;
    ck_assert_int_eq(percale_solver_create(def, &solver), PERCALE_INVALID_ARGUMENT);
    ck_assert_ptr_null(solver);
}
END_TEST

START_TEST(what_this_version_lacks_is_said)
{
    PERCALE_NO_SOLVER(isa, (PercaleIsa)4, PERCALE_INVALID_ARGUMENT, "isa 4");
    Scene *scene = create();
    ck_assert_int_ne(percale_solver_isa(scene->solver), PERCALE_ISA_AUTO);
    destroy(scene);
}
END_TEST

START_TEST(a_step_has_a_length)
{
    Scene *scene = create();
    PERCALE_REFUSED(scene, percale_solver_step(scene->solver, 0.0), PERCALE_INVALID_ARGUMENT, "step");
    PERCALE_REFUSED(scene, percale_solver_step(scene->solver, -1.0), PERCALE_INVALID_ARGUMENT, "step");
    PERCALE_REFUSED(scene, percale_solver_step(scene->solver, (double)NAN), PERCALE_INVALID_ARGUMENT, "step");
    PERCALE_REFUSED(scene, percale_solver_step(scene->solver, 1e9), PERCALE_INVALID_ARGUMENT, "step");
    PERCALE_REFUSED(scene, percale_solver_set_thread_count(scene->solver, 0), PERCALE_INVALID_ARGUMENT, "0");
    PERCALE_REFUSED(scene, percale_solver_set_thread_count(scene->solver, 257), PERCALE_INVALID_ARGUMENT,
                    "257");
    PERCALE_TEST_OK(scene->solver, percale_solver_set_thread_count(scene->solver, 256));
    run(scene->solver, 1);
    ck_assert_str_eq(percale_solver_last_error(scene->solver), "");
    destroy(scene);
}
END_TEST

// ---- meshes ----

/// A sheet's Def in which a test breaks one thing.
typedef struct Broken {
    float positions[12], rest[12], uvs[8], velocities[12];
    uint32_t triangles[6];
    PercaleClothDef def;
} Broken;

static Broken make_whole(void)
{
    Broken broken = {.positions = {0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 1},
                     .uvs = {0, 0, 1, 0, 0, 1, 1, 1},
                     .triangles = {0, 2, 1, 1, 2, 3},
                     .def = percale_cloth_def_default()};
    memcpy(broken.rest, broken.positions, sizeof(broken.rest));
    broken.def.name = "scarf";
    broken.def.vertex_count = 4;
    broken.def.triangle_count = 2;
    return broken;
}

static PercaleResult add_broken(Scene *scene, Broken *broken, bool with_rest)
{
    broken->def.positions = broken->positions;
    broken->def.triangles = broken->triangles;
    broken->def.velocities = broken->velocities;
    broken->def.rest_positions = with_rest ? broken->rest : NULL;
    PercaleCloth cloth = {77};
    PercaleResult result = percale_cloth_add(scene->solver, &broken->def, &cloth);
    ck_assert(result == PERCALE_OK || cloth.id == 0);
    return result;
}

/// Expects a cloth with one thing set to a bad value to be refused.
#define PERCALE_NO_CLOTH(SCENE, PLACE, VALUE, CULPRIT)                                                     \
    do {                                                                                                   \
        Broken broken = make_whole();                                                                      \
        broken.PLACE = (VALUE);                                                                            \
        PERCALE_REFUSED((SCENE), add_broken((SCENE), &broken, true), PERCALE_INVALID_ARGUMENT, (CULPRIT)); \
    } while (0)

START_TEST(an_unusable_cloth_is_refused)
{
    Scene *scene = create();
    Broken whole = make_whole();
    PERCALE_TEST_OK(scene->solver, add_broken(scene, &whole, true));
    PERCALE_NO_CLOTH(scene, positions[7], NAN, "scarf: vertex 2");
    PERCALE_NO_CLOTH(scene, positions[7], -INFINITY, "scarf: vertex 2");
    PERCALE_NO_CLOTH(scene, positions[7], 2e6f, "scarf: vertex 2");
    PERCALE_NO_CLOTH(scene, velocities[9], NAN, "scarf: vertex 3");
    PERCALE_NO_CLOTH(scene, rest[0], INFINITY, "scarf: vertex 0");
    PERCALE_NO_CLOTH(scene, triangles[4], 4, "scarf: triangle 1");
    PERCALE_NO_CLOTH(scene, triangles[4], UINT32_MAX, "scarf: triangle 1");
    PERCALE_NO_CLOTH(scene, triangles[4], 1, "scarf: triangle 1");
    PERCALE_NO_CLOTH(scene, rest[8], 0.0f, "scarf: triangle 0 has no area");
    PERCALE_NO_CLOTH(scene, def.vertex_count, 0, "empty");
    PERCALE_NO_CLOTH(scene, def.triangle_count, 0, "empty");
    PERCALE_NO_CLOTH(scene, def.triangle_count, UINT32_MAX / 2, "scarf");
    PERCALE_NO_CLOTH(scene, def.vertex_count, (1u << 28) - 1,
                     "scarf is too large"); // with those that are there
    PERCALE_NO_CLOTH(scene, def.position_stride, 4, "stride");
    PERCALE_NO_CLOTH(scene, def.material.density, 0.0f, "scarf: density");
    PERCALE_NO_CLOTH(scene, def.material.density, NAN, "scarf: density");
    PERCALE_NO_CLOTH(scene, def.material.friction, -0.1f, "scarf: friction");
    PERCALE_NO_CLOTH(scene, def.material.thickness, -0.1f, "scarf: thickness");
    PERCALE_NO_CLOTH(scene, def.material.stretch_compliance, -1.0f, "scarf: stretch");
    PERCALE_NO_CLOTH(scene, def.material.bending_stiffness, INFINITY, "scarf: bending");
    PERCALE_NO_CLOTH(scene, def.size, 0, "percale_cloth_def_default");
    Broken flat = make_whole();
    flat.uvs[2] = 0.0f;
    flat.def.rest_uvs = flat.uvs;
    PERCALE_REFUSED(scene, add_broken(scene, &flat, false), PERCALE_INVALID_ARGUMENT,
                    "triangle 0 has no area");
    Broken none = make_whole();
    PercaleCloth cloth;
    PERCALE_REFUSED(scene, percale_cloth_add(scene->solver, &none.def, &cloth), PERCALE_INVALID_ARGUMENT,
                    "scarf");
    PERCALE_REFUSED(scene, percale_cloth_add(scene->solver, NULL, &cloth), PERCALE_INVALID_ARGUMENT, "cloth");
    destroy(scene);
}
END_TEST

/// Expects a box with one field of its Def changed to be refused.
#define PERCALE_NO_OBSTACLE(SCENE, FIELD, VALUE, CULPRIT)                                \
    do {                                                                                 \
        PercaleObstacleDef def = percale_test_obstacle_def(&(SCENE)->box);               \
        PercaleObstacle obstacle;                                                        \
        def.FIELD = (VALUE);                                                             \
        PERCALE_REFUSED((SCENE), percale_obstacle_add((SCENE)->solver, &def, &obstacle), \
                        PERCALE_INVALID_ARGUMENT, (CULPRIT));                            \
    } while (0)

START_TEST(an_unusable_obstacle_is_refused)
{
    Scene *scene = create();
    PERCALE_NO_OBSTACLE(scene, positions, NULL, "box");
    PERCALE_NO_OBSTACLE(scene, triangles, NULL, "box");
    PERCALE_NO_OBSTACLE(scene, vertex_count, 7, "box: triangle");
    PERCALE_NO_OBSTACLE(scene, vertex_count, (1u << 28) - 1, "box is too large");
    PERCALE_NO_OBSTACLE(scene, friction, -1.0f, "friction");
    PERCALE_NO_OBSTACLE(scene, thickness, NAN, "thickness");
    PERCALE_NO_OBSTACLE(scene, size, 1, "percale_obstacle_def_default");
    PercaleObstacle obstacle;
    PERCALE_REFUSED(scene, percale_obstacle_add(scene->solver, NULL, &obstacle), PERCALE_INVALID_ARGUMENT,
                    "obstacle");
    PercaleMesh flat = percale_test_box(1.0f, 0.0f, 1.0f);
    PercaleObstacleDef def = percale_test_obstacle_def(&flat);
    PERCALE_REFUSED(scene, percale_obstacle_add(scene->solver, &def, &obstacle), PERCALE_INVALID_ARGUMENT,
                    "has no area");
    percale_mesh_free(&flat);
    destroy(scene);
}
END_TEST

START_TEST(an_unusable_motion_is_refused)
{
    Scene *scene = create();
    PercaleObstacle obstacle = scene->obstacle;
    PercaleSolver *solver = scene->solver;
    const double turn[4] = {0.0, 0.0, 0.0, 2.0};
    const double nowhere[4] = {0.0, 0.0, 0.0, 0.0};
    const double not_a_turn[4] = {0.0, (double)NAN, 0.0, 1.0};
    const double shift[3] = {0.0, 0.1, 0.0};
    const double not_a_shift[3] = {0.0, (double)NAN, 0.0};
    const double far_shift[3] = {0.0, 1e7, 0.0};
    const PercaleResult bad = PERCALE_INVALID_ARGUMENT;
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, obstacle, nowhere, shift), bad, "box");
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, obstacle, not_a_turn, shift), bad, "box");
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, obstacle, turn, not_a_shift), bad, "box");
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, obstacle, turn, far_shift), bad, "box");
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, obstacle, NULL, shift), bad, "box");
    PERCALE_REFUSED(scene, percale_obstacle_move(solver, obstacle, NULL, 0, NULL, 0), bad, "box");
    scene->box.positions[3] = NAN;
    PERCALE_REFUSED(scene, percale_obstacle_move(solver, obstacle, scene->box.positions, 0, NULL, 0), bad,
                    "box: vertex 1");
    scene->box.positions[3] = 0.5f;
    PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, obstacle, turn, shift));
    PERCALE_REFUSED(scene, percale_obstacle_move(solver, obstacle, scene->box.positions, 0, NULL, 0), bad,
                    "box");
    PercaleObstacle soft = percale_test_add_obstacle(solver, &scene->box);
    PERCALE_TEST_OK(solver, percale_obstacle_move(solver, soft, scene->box.positions, 0, NULL, 0));
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, soft, turn, shift), bad, "box");
    destroy(scene);
}
END_TEST

START_TEST(unusable_pins_and_seams_are_refused)
{
    Scene *scene = create();
    const PercaleResult bad = PERCALE_INVALID_ARGUMENT;
    const float nan_target[3] = {0.0f, NAN, 0.0f};
    PercalePin pin;
    PercaleSeam seam;
    PERCALE_REFUSED(scene, pin_vertex(scene, 64, NULL, &pin), bad, "vertex 64");
    PERCALE_REFUSED(scene, pin_vertex(scene, 5, nan_target, &pin), bad, "not finite");
    PERCALE_REFUSED(scene, percale_pin_move(scene->solver, scene->pin, nan_target, 0), bad, "not finite");
    PERCALE_REFUSED(scene, percale_pin_move(scene->solver, scene->pin, NULL, 0), bad, "pin");
    PercalePinDef empty_pin = percale_pin_def_default();
    PERCALE_REFUSED(scene, percale_pin_add(scene->solver, &empty_pin, &pin), bad, "pin");
    PERCALE_REFUSED(scene, percale_pin_add(scene->solver, NULL, &pin), bad, "pin");
    PERCALE_REFUSED(scene, sew(scene, scene->patch_cloth, 64, 0, &seam), bad, "vertex 64");
    PERCALE_REFUSED(scene, sew(scene, scene->patch_cloth, 0, 16, &seam), bad, "vertex 16");
    PERCALE_REFUSED(scene, sew(scene, scene->cloth, 5, 5, &seam), bad, "vertex 5");
    PERCALE_REFUSED(scene, sew(scene, (PercaleCloth){99}, 0, 0, &seam), PERCALE_INVALID_HANDLE, "99");
    PercaleSeamDef empty_seam = percale_seam_def_default();
    PERCALE_REFUSED(scene, percale_seam_add(scene->solver, &empty_seam, &seam), bad, "seam");
    PERCALE_REFUSED(scene, percale_seam_add(scene->solver, NULL, &seam), bad, "seam");
    destroy(scene);
}
END_TEST

// ---- handles ----

START_TEST(a_wrong_handle_is_named)
{
    Scene *scene = create();
    PercaleSolver *solver = scene->solver;
    const PercaleResult bad = PERCALE_INVALID_HANDLE;
    const PercaleCloth no_cloth = {901};
    const PercaleObstacle no_obstacle = {902};
    const PercalePin no_pin = {903};
    const PercaleSeam no_seam = {904};
    float *points = scene->sheet.positions;
    const double turn[4] = {0.0, 0.0, 0.0, 1.0};
    const double shift[3] = {0.0, 0.0, 0.0};
    PercaleClothView view;
    PERCALE_REFUSED(scene, percale_cloth_remove(solver, no_cloth), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_get_positions(solver, no_cloth, points, 0), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_get_velocities(solver, no_cloth, points, 0), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_set_positions(solver, no_cloth, points, 0), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_set_velocities(solver, no_cloth, points, 0), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_view(solver, no_cloth, &view), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_set_material(solver, no_cloth, percale_material_default()), bad,
                    "901");
    PERCALE_REFUSED(scene, percale_cloth_set_layer(solver, no_cloth, 1), bad, "901");
    PERCALE_REFUSED(scene, percale_cloth_set_mask(solver, no_cloth, 1), bad, "901");
    PERCALE_REFUSED(scene, percale_obstacle_remove(solver, no_obstacle), bad, "902");
    PERCALE_REFUSED(scene, percale_obstacle_move(solver, no_obstacle, points, 0, NULL, 0), bad, "902");
    PERCALE_REFUSED(scene, percale_obstacle_set_transform(solver, no_obstacle, turn, shift), bad, "902");
    PERCALE_REFUSED(scene, percale_pin_remove(solver, no_pin), bad, "903");
    PERCALE_REFUSED(scene, percale_pin_move(solver, no_pin, points, 0), bad, "903");
    PERCALE_REFUSED(scene, percale_seam_remove(solver, no_seam), bad, "904");
    PERCALE_REFUSED(scene, percale_cloth_remove(solver, (PercaleCloth){0}), bad, "0");
    PERCALE_REFUSED(scene, percale_cloth_remove(solver, (PercaleCloth){scene->obstacle.id}), bad, "handle");
    destroy(scene);
}
END_TEST

START_TEST(a_cloth_takes_its_pins_and_seams_along)
{
    Scene *scene = create();
    run(scene->solver, 2);
    PERCALE_TEST_OK(scene->solver, percale_cloth_remove(scene->solver, scene->cloth));
    PERCALE_REFUSED(scene, percale_pin_remove(scene->solver, scene->pin), PERCALE_INVALID_HANDLE, "pin");
    PERCALE_REFUSED(scene, percale_seam_remove(scene->solver, scene->seam), PERCALE_INVALID_HANDLE, "seam");
    PERCALE_REFUSED(scene, percale_cloth_remove(scene->solver, scene->cloth), PERCALE_INVALID_HANDLE,
                    "cloth");
    PercaleCloth again = percale_test_add_cloth(scene->solver, &scene->sheet);
    ck_assert_uint_ne(again.id, scene->cloth.id); // handles are never reused
    run(scene->solver, 2);
    destroy(scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("api");
    TCase *refusals = tcase_create("refusals");
    tcase_set_timeout(refusals, 60.0);
    tcase_add_test(refusals, an_unusable_solver_def_is_refused);
    tcase_add_test(refusals, what_this_version_lacks_is_said);
    tcase_add_test(refusals, a_step_has_a_length);
    tcase_add_test(refusals, an_unusable_cloth_is_refused);
    tcase_add_test(refusals, an_unusable_obstacle_is_refused);
    tcase_add_test(refusals, an_unusable_motion_is_refused);
    tcase_add_test(refusals, unusable_pins_and_seams_are_refused);
    tcase_add_test(refusals, a_wrong_handle_is_named);
    tcase_add_test(refusals, a_cloth_takes_its_pins_and_seams_along);
    suite_add_tcase(suite, refusals);
    return percale_test_run(suite);
}
