// Bodies that touch each other, or themselves, with cloth in between: it rides along between them, and when
// they part again nothing is tangled.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const float THICKNESS = 2e-3f;   // m
static const double EXIT = 0.5;         // m/s at which contact undoes an overlap, and a pinch drifts
static const double OPEN = 0.04;        // m; gap at the start and at the end
static const double CLOSING_TIME = 0.4; // s
static const double CLOSED_TIME = PERCALE_SANITIZED ? 0.3 : 1.0; // s
static const double SLOWEST_PRESS =
    0.25; // s; later than this after the gap has closed nothing swings any more

enum { LAYERS_MOST = 3, SIDE = 11, VERTICES = SIDE * SIDE };

typedef enum Shape { PLATES, SPHERES, PLATE_AND_SPHERE } Shape;

/// Two bodies that close on cloth.
typedef struct Press {
    const char *name;
    Shape shape;
    bool one_body;     // both are one obstacle, which touches itself
    bool one_moves;    // else both
    double gap;        // m, when closed
    double slide;      // m; both move sideways, to and fro once a second
    double shear;      // share of it by which the second goes the other way
    int layers, pairs; // of cloth; 1: cloth collides with cloth, and edges with edges
    int substeps, iterations;
    PercaleCcd ccd;
    float plate; // m; its width
    float thick; // m; and height
    float friction;
} Press;

/// A running press.
typedef struct Rig {
    const Press *press;
    double closed; // s; how long
    PercaleSolver *solver;
    PercaleCloth cloths[LAYERS_MOST];
    PercaleMesh bodies[2];
    PercaleObstacle obstacles[2];
    float *places; // [3 * vertices of both bodies] m
} Rig;

/// Gap of the bodies, m.
static double gap_at(const Rig *rig, double time)
{
    double late = 2.0 * CLOSING_TIME + rig->closed - time;
    double share = fmax(0.0, fmin(1.0, fmin(time, late) / CLOSING_TIME));
    return OPEN + (rig->press->gap - OPEN) * share * share * (3.0 - 2.0 * share);
}

/// The farthest that a body moves in a second, m/s.
static double fastest(const Press *press)
{
    const double TURN = 6.283185307179586;
    double across = 1.5 * (OPEN - press->gap) / CLOSING_TIME * (press->one_moves ? 1.0 : 0.5);
    return across + TURN * press->slide * fmax(1.0, fabs(press->shear));
}

static void place_bodies(Rig *rig, double time)
{
    const Press *press = rig->press;
    const double TURN = 6.283185307179586;
    double gap = gap_at(rig, time);
    double low = press->one_moves ? -0.5 * OPEN : -0.5 * gap;
    double aside = press->slide * sin(TURN * time);
    float *to = rig->places;
    for (int k = 0; k < 2; k++) {
        const PercaleMesh *body = &rig->bodies[k];
        double up = k == 0 ? low : low + gap;
        double sideways = k == 0 ? aside : aside * (1.0 - 2.0 * press->shear);
        for (size_t i = 0; i < body->vertex_count; i++, to += 3) {
            to[0] = body->positions[3 * i] + (float)sideways;
            to[1] = body->positions[3 * i + 1] + (float)up;
            to[2] = body->positions[3 * i + 2];
        }
    }
}

static void add_obstacle(Rig *rig, int k, const float *positions, const PercaleMesh *mesh)
{
    PercaleObstacleDef def = percale_test_obstacle_def(mesh);
    def.positions = positions;
    def.thickness = THICKNESS;
    def.friction = rig->press->friction;
    PERCALE_TEST_OK(rig->solver, percale_obstacle_add(rig->solver, &def, &rig->obstacles[k]));
}

static void add_bodies(Rig *rig)
{
    static const float RADIUS = 0.1f; // m
    for (int k = 0; k < 2; k++) {
        bool plate = rig->press->shape == PLATES || (rig->press->shape == PLATE_AND_SPHERE && k == 0);
        rig->bodies[k] = plate ? percale_test_box(rig->press->plate, rig->press->thick, rig->press->plate)
                               : percale_test_sphere(3, RADIUS);
        float half = plate ? 0.5f * rig->press->thick : RADIUS;
        percale_test_translate(&rig->bodies[k], 0.0f, k == 0 ? -half : half, 0.0f);
    }
    const PercaleMesh *a = &rig->bodies[0];
    const PercaleMesh *b = &rig->bodies[1];
    uint32_t vertex_count = a->vertex_count + b->vertex_count;
    rig->places = calloc(3 * (size_t)vertex_count, sizeof(float));
    ck_assert_ptr_nonnull(rig->places);
    place_bodies(rig, 0.0);
    if (!rig->press->one_body) {
        add_obstacle(rig, 0, rig->places, a);
        add_obstacle(rig, 1, rig->places + 3 * (size_t)a->vertex_count, b);
        return;
    }
    uint32_t corner_count = 3 * (a->triangle_count + b->triangle_count);
    uint32_t *corners = calloc(corner_count, sizeof(uint32_t));
    ck_assert_ptr_nonnull(corners);
    memcpy(corners, a->triangles, 3 * (size_t)a->triangle_count * sizeof(uint32_t));
    for (uint32_t i = 3 * a->triangle_count; i < corner_count; i++) {
        corners[i] = b->triangles[i - 3 * a->triangle_count] + a->vertex_count;
    }
    PercaleMesh both = {.name = a->name,
                        .vertex_count = vertex_count,
                        .triangles = corners,
                        .triangle_count = corner_count / 3};
    add_obstacle(rig, 0, rig->places, &both);
    free(corners);
}

static void open_rig(Rig *rig, const Press *press, int threads)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = press->substeps;
    def.iterations = press->iterations;
    def.ccd = press->ccd;
    def.self_collision = def.edge_edge = press->pairs;
    def.thread_count = threads;
    *rig = (Rig){.press = press, .closed = CLOSED_TIME, .solver = percale_test_solver(def)};
    for (int i = 0; i < press->layers; i++) {
        PercaleMesh mesh = percale_test_sheet(SIDE, 0.14f);
        percale_test_translate(&mesh, 0.0f, 1.3f * THICKNESS * ((float)i - 0.5f * (float)(press->layers - 1)),
                               0.0f);
        PercaleClothDef cloth_def = percale_test_cloth_def(&mesh);
        cloth_def.material.thickness = THICKNESS;
        cloth_def.material.friction = press->friction;
        PERCALE_TEST_OK(rig->solver, percale_cloth_add(rig->solver, &cloth_def, &rig->cloths[i]));
        percale_mesh_free(&mesh);
    }
    add_bodies(rig);
}

static void close_rig(Rig *rig)
{
    percale_solver_destroy(rig->solver);
    percale_mesh_free(&rig->bodies[0]);
    percale_mesh_free(&rig->bodies[1]);
    free(rig->places);
}

static void step_rig(Rig *rig, int frame)
{
    place_bodies(rig, (frame + 1) * FRAME);
    for (int k = 0; k < (rig->press->one_body ? 1 : 2); k++) {
        const float *to = rig->places + (k == 0 ? 0 : 3 * (size_t)rig->bodies[0].vertex_count);
        PERCALE_TEST_OK(rig->solver, percale_obstacle_move(rig->solver, rig->obstacles[k], to, 0, NULL, 0));
    }
    PERCALE_TEST_OK(rig->solver, percale_solver_step(rig->solver, FRAME));
}

/// The fastest vertex amid the press, m/s: by its velocity, and by how far it has gone since `before`.
static double speed_amid(Rig *rig, int layer, float *before)
{
    static const double AMID = 0.02; // m from the axis: around it the bodies touch
    float x[3 * VERTICES];
    float v[3 * VERTICES];
    PERCALE_TEST_OK(rig->solver, percale_cloth_get_positions(rig->solver, rig->cloths[layer], x, 0));
    PERCALE_TEST_OK(rig->solver, percale_cloth_get_velocities(rig->solver, rig->cloths[layer], v, 0));
    double most = 0.0;
    for (size_t i = 0; i < 3 * (size_t)VERTICES; i += 3) {
        if (hypot((double)x[i], (double)x[i + 2]) < AMID) {
            double speed = sqrt((double)(v[i] * v[i] + v[i + 1] * v[i + 1] + v[i + 2] * v[i + 2]));
            double gone = hypot(hypot((double)(x[i] - before[i]), (double)(x[i + 1] - before[i + 1])),
                                (double)(x[i + 2] - before[i + 2]));
            most = fmax(most, fmax(speed, gone / FRAME));
        }
    }
    memcpy(before, x, sizeof(x));
    return most;
}

/// Closes, stays, opens; while closed the cloth amid is no faster than the bodies and what drifts between
/// them.
static void run_press(Rig *rig)
{
    const Press *press = rig->press;
    static const double REST = 0.3; // s
    float before[LAYERS_MOST][3 * VERTICES] = {{0}};
    int frames = (int)((2.0 * CLOSING_TIME + rig->closed + REST) / FRAME);
    for (int frame = 0; frame < frames; frame++) {
        step_rig(rig, frame);
        double closed = frame * FRAME - CLOSING_TIME;
        for (int i = 0; i < press->layers; i++) {
            double speed = speed_amid(rig, i, before[i]);
            ck_assert_msg(closed < 0.0 || closed > rig->closed || speed <= fastest(press) + EXIT,
                          "%s, frame %d: %g m/s", press->name, frame, speed);
            ck_assert_msg(closed < SLOWEST_PRESS || closed > rig->closed || press->slide > 0.0 ||
                              speed < 0.05,
                          "%s, frame %d: %g m/s between bodies at rest", press->name, frame, speed);
        }
    }
}

static void check_free(Rig *rig)
{
    const char *name = rig->press->name;
    PercaleQuality quality;
    PERCALE_TEST_OK(rig->solver, percale_solver_quality(rig->solver, &quality));
    PercaleCounters counters = percale_solver_counters(rig->solver);
    ck_assert_msg(quality.ef_cloth_cloth <= 0.0, "%s: %g crossings", name, quality.ef_cloth_cloth);
    ck_assert_msg(quality.ef_cloth_obstacle <= 0.0, "%s: %g crossings with bodies", name,
                  quality.ef_cloth_obstacle);
    ck_assert_msg(quality.penetration_max_mm <= 0.0 && quality.vertices_inside <= 0.0, "%s: %g mm inside",
                  name, quality.penetration_max_mm);
    ck_assert_msg(counters.left_inside == 0, "%s: %u left inside", name, (unsigned)counters.left_inside);
    ck_assert_msg(counters.pinched > 0, "%s: nothing was pinched", name);
}

#define WIDE   0.3f  // m; plates that are wider than the cloth
#define NARROW 0.08f // m; and that are not
#define THICK  0.05f // m
#define MU     0.3f

// clang-format off
static const Press PRESSES[] = {
    {"plates, nearly closed",       PLATES, false, false, 0.001, 0.0, 0.0, 1, 0, 5, 1, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"plates, closed, swift",       PLATES, false, false, 0.0, 0.0, 0.0, 1, 0, 2, 5, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"plates, overlap, accurate",   PLATES, false, false, -0.01, 0.0, 0.0, 1, 0, 40, 1, PERCALE_CCD_OFF, WIDE, THICK, MU},
    {"one plate moves, deep",       PLATES, false, true, -0.02, 0.0, 0.0, 1, 0, 5, 4, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"plates, one body",            PLATES, true, false, -0.02, 0.0, 0.0, 1, 0, 5, 1, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"plates, sideways, exact",     PLATES, false, false, -0.01, 0.02, 0.0, 1, 1, 5, 1, PERCALE_CCD_EXACT, WIDE, THICK, MU},
    {"plates, three layers, deep",  PLATES, false, false, -0.01, 0.0, 0.0, 3, 1, 5, 4, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"plates, narrower",            PLATES, false, false, -0.01, 0.0, 0.0, 1, 1, 5, 4, PERCALE_CCD_RAY, NARROW, THICK, MU},
    {"plates, narrower, one body",  PLATES, true, false, -0.01, 0.0, 0.0, 1, 1, 5, 4, PERCALE_CCD_RAY, NARROW, THICK, MU},
    {"plates, narrower, smooth",    PLATES, false, false, -0.01, 0.0, 0.0, 1, 1, 5, 4, PERCALE_CCD_EXACT, NARROW, THICK, 0.0f},
    {"plates, narrower, thin",      PLATES, false, false, 0.001, 0.0, 0.0, 1, 1, 20, 1, PERCALE_CCD_RAY, NARROW, 0.002f, MU},
    {"spheres, one body",           SPHERES, true, false, -0.02, 0.0, 0.0, 1, 0, 10, 1, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"spheres, shear",              SPHERES, false, false, -0.02, 0.02, 1.0, 1, 0, 10, 1, PERCALE_CCD_OFF, WIDE, THICK, MU},
    {"spheres, edges",              SPHERES, false, false, -0.005, 0.0, 0.0, 1, 1, 5, 4, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"spheres, two layers",         SPHERES, false, false, -0.01, 0.0, 0.0, 2, 1, 20, 1, PERCALE_CCD_RAY, WIDE, THICK, MU},
    {"spheres, three layers",       SPHERES, false, false, -0.01, 0.0, 0.0, 3, 1, 20, 1, PERCALE_CCD_EXACT, WIDE, THICK, MU},
    {"plate and sphere, smooth",    PLATE_AND_SPHERE, false, false, -0.01, 0.02, 0.0, 1, 1, 5, 1, PERCALE_CCD_RAY, WIDE, THICK, 0.0f},
    {"plate and sphere",            PLATE_AND_SPHERE, false, false, -0.01, 0.0, 0.0, 1, 1, 5, 4, PERCALE_CCD_RAY, WIDE, THICK, MU},
};
// clang-format on
enum { PRESS_COUNT = sizeof PRESSES / sizeof PRESSES[0] };

START_TEST(what_is_pinched_rides_along_and_comes_out_untangled)
{
    Rig rig;
    open_rig(&rig, &PRESSES[_i], 1);
    run_press(&rig);
    check_free(&rig);
    close_rig(&rig);
}
END_TEST

/// What is held only in part must not swing under a plate that is thinner than it hangs down.
START_TEST(however_long_a_thin_plate_closes_nothing_gets_under_it)
{
    static const double TIMES[] = {0.1, 0.2, 0.4, 0.8, 0.9}; // s
    const Press *press = PRESSES;
    while (strcmp(press->name, "plates, narrower, thin") != 0) {
        press++;
    }
    for (size_t i = 0; i < (PERCALE_SANITIZED ? 2 : sizeof TIMES / sizeof TIMES[0]); i++) {
        Rig rig;
        open_rig(&rig, press, 1);
        rig.closed = TIMES[i];
        run_press(&rig);
        check_free(&rig);
        close_rig(&rig);
    }
}
END_TEST

START_TEST(a_pinch_is_the_same_for_one_thread_and_three)
{
    static const Press PRESS = {"plate and sphere",
                                PLATE_AND_SPHERE,
                                false,
                                false,
                                -0.01,
                                0.02,
                                1.0,
                                2,
                                1,
                                5,
                                4,
                                PERCALE_CCD_RAY,
                                WIDE,
                                THICK,
                                MU};
    uint64_t hashes[2];
    for (int k = 0; k < 2; k++) {
        Rig rig;
        open_rig(&rig, &PRESS, k == 0 ? 1 : 3);
        for (int frame = 0; frame < 36; frame++) {
            step_rig(&rig, frame);
        }
        ck_assert_uint_gt(percale_solver_counters(rig.solver).pinched, 0);
        hashes[k] = percale_solver_hash(rig.solver);
        close_rig(&rig);
    }
    ck_assert_uint_eq(hashes[0], hashes[1]);
}
END_TEST

START_TEST(what_starts_between_overlapping_plates_drifts_to_their_middle_and_no_faster)
{
    static const float ASIDE = 9.5e-3f; // m; the plates overlap by 20 mm
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    PercaleMesh sheet = percale_test_sheet(SIDE, 0.14f);
    percale_test_translate(&sheet, 0.0f, ASIDE, 0.0f);
    PercaleCloth cloth = percale_test_add_cloth(solver, &sheet);
    for (int k = 0; k < 2; k++) {
        PercaleMesh plate = percale_test_box(0.3f, 0.05f, 0.3f);
        percale_test_translate(&plate, 0.0f, k == 0 ? -0.015f : 0.015f, 0.0f);
        (void)percale_test_add_obstacle(solver, &plate);
        percale_mesh_free(&plate);
    }
    float x[3 * VERTICES];
    float v[3 * VERTICES];
    for (int frame = 0; frame < 3; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
        PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, cloth, v, 0));
        double least = fmax(0.0, (double)ASIDE - EXIT * FRAME * (frame + 1)) - 2e-4;
        for (size_t i = 1; i < 3 * (size_t)VERTICES; i += 3) {
            ck_assert_msg((double)x[i] > least, "frame %d: at %g mm", frame, 1e3 * (double)x[i]);
            ck_assert_msg(frame < 2 || (double)x[i] < 1e-3, "it is still at %g mm", 1e3 * (double)x[i]);
            ck_assert_msg(fabsf(v[i]) <= 0.0f, "a drift is no velocity: %g m/s", (double)v[i]);
        }
    }
    ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
}
END_TEST

START_TEST(bodies_that_leave_room_pinch_nothing)
{
    static const Press PRESS = {"plates", PLATES, false, false,           0.0045, 0.0,   0.0, 1,
                                0,        5,      4,     PERCALE_CCD_RAY, WIDE,   THICK, MU};
    Rig rig;
    open_rig(&rig, &PRESS, 1);
    for (int frame = 0; frame < 60; frame++) {
        step_rig(&rig, frame);
    }
    ck_assert_uint_eq(percale_solver_counters(rig.solver).pinched, 0);
    close_rig(&rig);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("pinch");
    TCase *pinch = tcase_create("pinch");
    tcase_set_tags(pinch, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(pinch, 0);
    tcase_add_loop_test(pinch, what_is_pinched_rides_along_and_comes_out_untangled, 0, PRESS_COUNT);
    tcase_add_test(pinch, however_long_a_thin_plate_closes_nothing_gets_under_it);
    tcase_add_test(pinch, what_starts_between_overlapping_plates_drifts_to_their_middle_and_no_faster);
    tcase_add_test(pinch, bodies_that_leave_room_pinch_nothing);
    suite_add_tcase(suite, pinch);
    TCase *threads = tcase_create("threads");
    tcase_set_tags(threads, PERCALE_ANY_ENGINE);
    tcase_set_timeout(threads, 0);
    tcase_add_test(threads, a_pinch_is_the_same_for_one_thread_and_three);
    suite_add_tcase(suite, threads);
    return percale_test_run(suite);
}
