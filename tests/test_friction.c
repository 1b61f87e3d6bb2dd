// Friction that holds: on obstacles, on cloth, in stacks; for every way to split a step into substeps, sweeps
// and passes.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double PI = 3.14159265358979323846;
static const double FRAME = 1.0 / 60.0;  // s
static const double GRAVITY = 9.81;      // m/s^2
static const float FRICTION = 0.4f;      // of each pair of surfaces
static const float THICKNESS = 0.002f;   // m, too
static const double ONE_DEGREE = 0.0175; // rad; a little more
static const double CREEP = 1e-4;        // m/s: 1 mm in 10 s

enum { SHEETS_MAX = 3, SIDE = 5, VERTICES = SIDE * SIDE };

/// How a step is split.
typedef struct Split {
    int substeps, iterations, passes;
} Split;

// ---- an incline ----

typedef struct Incline {
    PercaleSolver *solver;
    double angle; // rad; downhill is towards +x
    PercaleCloth sheets[SHEETS_MAX];
    int sheet_count;
} Incline;

static void tilt(PercaleMesh *mesh, double angle)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *x = mesh->positions + 3 * i;
        double along = (double)x[0];
        double up = (double)x[1];
        x[0] = (float)(cos(angle) * along + sin(angle) * up);
        x[1] = (float)(cos(angle) * up - sin(angle) * along);
    }
}

/// A plane of triangles of all shapes.
static PercaleMesh random_ground(uint32_t side_count, float width)
{
    PercaleMesh mesh = percale_test_sheet(side_count, width);
    double reach = 0.6 * (double)width / (double)(side_count - 1);
    uint64_t seed = 7;
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        uint32_t row = i / side_count;
        uint32_t column = i % side_count;
        if (row % (side_count - 1) != 0 && column % (side_count - 1) != 0) {
            mesh.positions[3 * i] += (float)(reach * (percale_test_random(&seed) - 0.5));
            mesh.positions[3 * i + 2] += (float)(reach * (percale_test_random(&seed) - 0.5));
        }
    }
    return mesh;
}

static Incline incline_of(Split split, double angle, float ground_friction)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = split.substeps;
    def.iterations = split.iterations;
    def.passes = split.passes;
    def.damping = 0.0f;
    def.self_collision = 1;
    def.edge_edge = 1;
    Incline incline = {percale_test_solver(def), angle, {{0}}, 0};
    PercaleMesh ground = random_ground(25, 2.4f);
    tilt(&ground, angle);
    PercaleObstacleDef obstacle_def = percale_test_obstacle_def(&ground);
    obstacle_def.friction = ground_friction;
    obstacle_def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(incline.solver, percale_obstacle_add(incline.solver, &obstacle_def, &obstacle));
    percale_mesh_free(&ground);
    return incline;
}

/// Lays a stiff sheet on top of the others, turned against them, so that no vertices meet.
static void add_sheet(Incline *incline, float width, float x, float friction, double speed)
{
    int index = incline->sheet_count++;
    PercaleMesh mesh = percale_test_sheet(SIDE, width);
    double turn = 0.3 * index + 0.2;
    float velocities[3 * VERTICES];
    for (size_t i = 0; i < VERTICES; i++) {
        float *p = mesh.positions + 3 * i;
        double a = (double)p[0];
        double b = (double)p[2];
        p[0] = (float)(cos(turn) * a - sin(turn) * b) + x;
        p[1] = THICKNESS * (float)(index + 1);
        p[2] = (float)(sin(turn) * a + cos(turn) * b);
        velocities[3 * i] = (float)(speed * cos(incline->angle));
        velocities[3 * i + 1] = (float)(-speed * sin(incline->angle));
        velocities[3 * i + 2] = 0.0f;
    }
    tilt(&mesh, incline->angle);
    PercaleClothDef def = percale_test_cloth_def(&mesh);
    def.velocities = velocities;
    def.material.friction = friction;
    def.material.thickness = THICKNESS;
    def.material.bending_stiffness = 1e-3f;
    PERCALE_TEST_OK(incline->solver, percale_cloth_add(incline->solver, &def, &incline->sheets[index]));
    percale_mesh_free(&mesh);
}

static void pin_sheet(Incline *incline, int sheet)
{
    uint32_t vertices[VERTICES];
    for (uint32_t i = 0; i < VERTICES; i++) {
        vertices[i] = i;
    }
    PercalePinDef def = percale_pin_def_default();
    def.cloth = incline->sheets[sheet];
    def.vertices = vertices;
    def.vertex_count = VERTICES;
    PercalePin pin;
    PERCALE_TEST_OK(incline->solver, percale_pin_add(incline->solver, &def, &pin));
}

static void run(Incline *incline, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(incline->solver, percale_solver_step(incline->solver, FRAME));
    }
}

/// Mean coordinate down the slope, m, or speed, m/s.
static double downhill(Incline *incline, int sheet, bool speed)
{
    float values[3 * VERTICES];
    PercaleCloth cloth = incline->sheets[sheet];
    PERCALE_TEST_OK(incline->solver, speed ? percale_cloth_get_velocities(incline->solver, cloth, values, 0)
                                           : percale_cloth_get_positions(incline->solver, cloth, values, 0));
    double sum = 0.0;
    for (size_t i = 0; i < VERTICES; i++) {
        sum += cos(incline->angle) * (double)values[3 * i] - sin(incline->angle) * (double)values[3 * i + 1];
    }
    return sum / VERTICES;
}

// ---- below the angle ----

/// Ways to split a step; those that try all passes take the first of each.
static const Split SPLITS[] = {{20, 1, 20}, {5, 4, 20}, {1, 20, 20}, {20, 1, 5},
                               {20, 1, 1},  {5, 4, 5},  {1, 20, 1}};
enum { SPLIT_COUNT = sizeof(SPLITS) / sizeof(SPLITS[0]), WORK_SPLIT_COUNT = 3 };

/// Nobody creeps faster than 1 mm in 10 s, the settling of the first moment included.
static void expect_hold(Incline *incline, int frames)
{
    ck_assert_int_le(incline->sheet_count, SHEETS_MAX);
    double before[SHEETS_MAX] = {0.0};
    for (int i = 0; i < incline->sheet_count; i++) {
        before[i] = downhill(incline, i, false);
    }
    run(incline, frames);
    for (int i = 0; i < incline->sheet_count; i++) {
        double moved = downhill(incline, i, false) - before[i];
        ck_assert_msg(fabs(moved) <= CREEP * FRAME * frames, "sheet %d has crept %g mm in %d frames", i,
                      1e3 * moved, frames);
    }
    percale_solver_destroy(incline->solver);
}

static double holding_angle(void)
{
    return atan((double)FRICTION) - ONE_DEGREE;
}

START_TEST(a_sheet_holds_below_the_friction_angle)
{
    Incline incline = incline_of(SPLITS[_i], holding_angle(), FRICTION);
    add_sheet(&incline, 0.1f, 0.0f, FRICTION, 0.0);
    expect_hold(&incline, PERCALE_SANITIZED ? 60 : 600);
}
END_TEST

START_TEST(a_sheet_holds_on_pinned_cloth)
{
    Incline incline = incline_of(SPLITS[_i], holding_angle(), FRICTION);
    add_sheet(&incline, 0.2f, 0.0f, FRICTION, 0.0);
    pin_sheet(&incline, 0);
    add_sheet(&incline, 0.1f, 0.0f, FRICTION, 0.0);
    expect_hold(&incline, PERCALE_SANITIZED ? 20 : 60 + 540 / SPLITS[_i].passes);
}
END_TEST

/// All of it is loose: the lowest sheet's friction carries the weight of three.
START_TEST(a_stack_of_three_holds)
{
    Incline incline = incline_of(SPLITS[_i], holding_angle(), FRICTION);
    for (int sheet = 0; sheet < 3; sheet++) {
        add_sheet(&incline, 0.1f, 0.0f, FRICTION, 0.0);
    }
    expect_hold(&incline, PERCALE_SANITIZED ? 60 : 60 + 540 / SPLITS[_i].passes);
}
END_TEST

// ---- above the angle ----

/// Mean acceleration of the sheets from `first` on over the second half of the frames, over Coulomb's.
static double share_of_coulomb(Incline *incline, int first, int frames)
{
    int half = frames / 2;
    double gained = 0.0;
    run(incline, half);
    for (int sheet = first; sheet < incline->sheet_count; sheet++) {
        gained -= downhill(incline, sheet, true);
    }
    run(incline, half);
    for (int sheet = first; sheet < incline->sheet_count; sheet++) {
        gained += downhill(incline, sheet, true);
    }
    double acceleration = gained / (incline->sheet_count - first) / (FRAME * half);
    double coulomb = GRAVITY * (sin(incline->angle) - (double)FRICTION * cos(incline->angle));
    percale_solver_destroy(incline->solver);
    return acceleration / coulomb;
}

static double sliding_angle(void)
{
    return atan((double)FRICTION) + ONE_DEGREE;
}

/// Puts nothing, pinned cloth, or two loose sheets below a sheet: all slide, or only it.
typedef enum Below { BARE_GROUND, PINNED_CLOTH, LOOSE_STACK } Below;

static void expect_coulomb(Split split, Below below)
{
    for (int passes = 1; passes <= 20; passes += PERCALE_SANITIZED ? 19 : passes == 1 ? 6 : 13) {
        split.passes = passes;
        Incline incline = incline_of(split, sliding_angle(), FRICTION);
        if (below == PINNED_CLOTH) {
            add_sheet(&incline, 0.2f, 0.0f, FRICTION, 0.0);
            pin_sheet(&incline, 0);
        }
        for (int sheet = 0; below == LOOSE_STACK && sheet < 2; sheet++) {
            add_sheet(&incline, 0.1f, 0.0f, FRICTION, 0.0);
        }
        add_sheet(&incline, 0.1f, below == PINNED_CLOTH ? -0.03f : 0.0f, FRICTION, 0.0);
        double share = share_of_coulomb(&incline, below == PINNED_CLOTH, PERCALE_SANITIZED ? 20 : 60);
        ck_assert_msg(fabs(share - 1.0) <= 0.03, "%d x %d, %d passes: %g of Coulomb's acceleration",
                      split.substeps, split.iterations, passes, share);
    }
}

START_TEST(above_the_friction_angle_a_sheet_slides_as_coulomb_says)
{
    expect_coulomb(SPLITS[_i], BARE_GROUND);
}
END_TEST

/// In 1/60 s it falls 2.7 mm, through the other, did the substep not look for contacts without gravity; and
/// with one pass it slides over edges that were ahead of it.
START_TEST(above_the_friction_angle_cloth_slides_on_cloth_as_coulomb_says)
{
    expect_coulomb(SPLITS[_i], PINNED_CLOTH);
}
END_TEST

/// Between two of its sheets and below it friction is at its limit: which of them slips, nobody says.
START_TEST(above_the_friction_angle_a_stack_slides_as_coulomb_says)
{
    expect_coulomb(SPLITS[_i], LOOSE_STACK);
}
END_TEST

// ---- without friction ----

/// The edges below it and their vertices are flat: nothing there to stumble over.
START_TEST(a_frictionless_slide_over_random_triangles_keeps_its_speed)
{
    const double SPEED = 1.0; // m/s
    Incline incline = incline_of(SPLITS[_i], 0.0, 0.0f);
    add_sheet(&incline, 0.1f, -0.5f, 0.0f, SPEED);
    double before = downhill(&incline, 0, false);
    int frames = PERCALE_SANITIZED ? 10 : 60;
    run(&incline, frames);
    double way = SPEED * FRAME * frames;
    ck_assert_double_eq_tol(downhill(&incline, 0, false) - before, way, 0.5e-3 * way); // the mean of the loss
    percale_solver_destroy(incline.solver);
}
END_TEST

// ---- a turntable ----

/// Where the sheet's vertex is when it is as turned as the table.
static double lag_of(PercaleSolver *solver, PercaleCloth cloth, const float *start, double angle)
{
    float x[3 * VERTICES];
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
    double lag = 0.0;
    for (size_t i = 0; i < VERTICES; i++) {
        double along = cos(angle) * (double)start[3 * i] + sin(angle) * (double)start[3 * i + 2];
        double across = cos(angle) * (double)start[3 * i + 2] - sin(angle) * (double)start[3 * i];
        lag = fmax(lag, hypot((double)x[3 * i] - along, (double)x[3 * i + 2] - across));
    }
    return lag;
}

/// One turn in four seconds about the y axis, after a soft start; at the rim friction has to give 0.4 m/s^2
/// of the 3.9 it can.
START_TEST(a_turntable_carries_cloth_a_full_circle)
{
    enum { FRAMES = PERCALE_SANITIZED ? 24 : 255 };
    const float OFFSET = 0.1f; // m, of the sheet's centre
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = SPLITS[_i].substeps;
    def.iterations = SPLITS[_i].iterations;
    def.passes = SPLITS[_i].passes;
    def.edge_edge = 1;
    def.self_collision = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh table = percale_test_box(0.6f, 0.1f, 0.6f);
    percale_test_translate(&table, 0.0f, -0.05f, 0.0f);
    PercaleObstacleDef obstacle_def = percale_test_obstacle_def(&table);
    obstacle_def.friction = FRICTION;
    obstacle_def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &obstacle_def, &obstacle));
    PercaleMesh sheet = percale_test_sheet(SIDE, 0.1f);
    percale_test_translate(&sheet, OFFSET, THICKNESS, 0.013f);
    PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
    cloth_def.material.friction = FRICTION;
    cloth_def.material.thickness = THICKNESS;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    for (int frame = 1; frame <= FRAMES; frame++) {
        double turned = frame < 30 ? frame * frame / 60.0 : frame - 15.0; // frames at full speed
        double angle = 2.0 * PI / 240.0 * turned;
        const double rotation[4] = {0.0, sin(0.5 * angle), 0.0, cos(0.5 * angle)};
        const double translation[3] = {0.0, 0.0, 0.0};
        PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, obstacle, rotation, translation));
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        double lag = lag_of(solver, cloth, sheet.positions, angle);
        ck_assert_msg(lag < 1e-3, "frame %d: %g mm behind", frame, 1e3 * lag);
    }
    percale_solver_destroy(solver);
    percale_mesh_free(&table);
    percale_mesh_free(&sheet);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("friction");
    TCase *holding = tcase_create("holding");
    tcase_set_tags(holding, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(holding, 0);
    tcase_add_loop_test(holding, a_sheet_holds_below_the_friction_angle, 0, SPLIT_COUNT);
    tcase_add_loop_test(holding, a_sheet_holds_on_pinned_cloth, 0, SPLIT_COUNT);
    tcase_add_loop_test(holding, a_stack_of_three_holds, 0, SPLIT_COUNT);
    tcase_add_loop_test(holding, a_turntable_carries_cloth_a_full_circle, 0, SPLIT_COUNT);
    suite_add_tcase(suite, holding);
    TCase *sliding = tcase_create("sliding");
    tcase_set_tags(sliding, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(sliding, 0);
    tcase_add_loop_test(sliding, above_the_friction_angle_a_sheet_slides_as_coulomb_says, 0,
                        WORK_SPLIT_COUNT);
    tcase_add_loop_test(sliding, above_the_friction_angle_cloth_slides_on_cloth_as_coulomb_says, 0,
                        WORK_SPLIT_COUNT);
    tcase_add_loop_test(sliding, above_the_friction_angle_a_stack_slides_as_coulomb_says, 0,
                        WORK_SPLIT_COUNT);
    tcase_add_loop_test(sliding, a_frictionless_slide_over_random_triangles_keeps_its_speed, 0, SPLIT_COUNT);
    suite_add_tcase(suite, sliding);
    return percale_test_run(suite);
}
