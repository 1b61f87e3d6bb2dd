// Sides on the whole engine: contacts that turn, slide over ridges and rims, pass through parallel, part and
// meet again stay on the side that they came from.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double PI = 3.14159265358979323846;
static const float THICKNESS = 2e-3f; // m

// ---- rigs: a cloth, some of whose vertices are moved by the test ----

enum { MOST_VERTICES = 1024 };

/// One cloth of a scene; its pinned vertices, with the places where they start.
typedef struct Rig {
    PercaleMesh mesh;
    PercaleCloth cloth;
    PercalePin pin;
    uint32_t pinned[MOST_VERTICES];
    float start[3 * MOST_VERTICES];
    uint32_t pinned_count;
    float slack; // its rest shape is this much longer along x
} Rig;

static PercaleSolver *make_solver(float gravity)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    def.gravity[0] = def.gravity[2] = 0.0f;
    def.gravity[1] = gravity;
    return percale_test_solver(def);
}

/// A grid of columns along its profile and rows along z: rows are 10 mm apart.
static PercaleMesh make_grid(uint32_t columns, uint32_t rows, float row_step)
{
    PercaleMesh mesh = percale_test_sheet(2, 1.0f);
    uint32_t cells = (columns - 1) * (rows - 1);
    mesh.vertex_count = columns * rows;
    mesh.triangle_count = 2 * cells;
    free(mesh.positions);
    free(mesh.triangles);
    mesh.positions = calloc(3 * (size_t)mesh.vertex_count, sizeof(float));
    mesh.triangles = calloc(3 * (size_t)mesh.triangle_count, sizeof(uint32_t));
    ck_assert(mesh.positions != NULL && mesh.triangles != NULL);
    for (uint32_t row = 0; row < rows; row++) {
        for (uint32_t column = 0; column < columns; column++) {
            mesh.positions[3 * (row * columns + column) + 2] =
                row_step * ((float)row - 0.5f * (float)(rows - 1));
        }
    }
    for (uint32_t cell = 0; cell < cells; cell++) {
        uint32_t first = cell / (columns - 1) * columns + cell % (columns - 1);
        uint32_t across = first + columns;
        const uint32_t corners[6] = {first, across, first + 1, first + 1, across, across + 1};
        memcpy(mesh.triangles + 6 * (size_t)cell, corners, sizeof(corners));
    }
    return mesh;
}

static void pin_vertex(Rig *rig, uint32_t vertex)
{
    ck_assert_uint_lt(rig->pinned_count, MOST_VERTICES);
    memcpy(rig->start + 3 * (size_t)rig->pinned_count, rig->mesh.positions + 3 * (size_t)vertex,
           3 * sizeof(float));
    rig->pinned[rig->pinned_count++] = vertex;
}

static void add_rig(PercaleSolver *solver, Rig *rig, float speed)
{
    float *velocities = calloc(3 * (size_t)rig->mesh.vertex_count, sizeof(float));
    for (size_t i = 0; i < rig->mesh.vertex_count; i++) {
        velocities[3 * i + 1] = speed;
    }
    float *rest = calloc(3 * (size_t)rig->mesh.vertex_count, sizeof(float));
    for (size_t i = 0; i < 3 * (size_t)rig->mesh.vertex_count; i++) {
        rest[i] = rig->mesh.positions[i] * (i % 3 == 0 ? 1.0f + rig->slack : 1.0f);
    }
    PercaleClothDef def = percale_test_cloth_def(&rig->mesh);
    def.rest_positions = rest;
    def.velocities = velocities;
    def.material.thickness = THICKNESS;
    def.material.friction = 0.0f;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &rig->cloth));
    free(velocities);
    free(rest);
    if (rig->pinned_count > 0) {
        PercalePinDef pin_def = percale_pin_def_default();
        pin_def.cloth = rig->cloth;
        pin_def.vertices = rig->pinned;
        pin_def.vertex_count = rig->pinned_count;
        PERCALE_TEST_OK(solver, percale_pin_add(solver, &pin_def, &rig->pin));
    }
}

/// Turns the pinned vertices about the axis z (2) or y (1).
static void turn_pins(PercaleSolver *solver, const Rig *rig, int axis, double angle)
{
    float targets[3 * MOST_VERTICES];
    int first = (axis + 1) % 3;
    int second = (axis + 2) % 3;
    for (size_t i = 0; i < rig->pinned_count; i++) {
        double u = (double)rig->start[3 * i + (size_t)first];
        double v = (double)rig->start[3 * i + (size_t)second];
        targets[3 * i + (size_t)axis] = rig->start[3 * i + (size_t)axis];
        targets[3 * i + (size_t)first] = (float)(cos(angle) * u - sin(angle) * v);
        targets[3 * i + (size_t)second] = (float)(sin(angle) * u + cos(angle) * v);
    }
    PERCALE_TEST_OK(solver, percale_pin_move(solver, rig->pin, targets, 0));
}

static void get(PercaleSolver *solver, const Rig *rig, float *x)
{
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, rig->cloth, x, 0));
}

/// Lowest and highest height of a cloth, turned round where `sign` is -1.
static void heights(PercaleSolver *solver, const Rig *rig, float sign, float range[2])
{
    float x[3 * MOST_VERTICES];
    get(solver, rig, x);
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (size_t i = 0; i < rig->mesh.vertex_count; i++) {
        range[0] = fminf(range[0], sign * x[3 * i + 1]);
        range[1] = fmaxf(range[1], sign * x[3 * i + 1]);
    }
}

/// One frame; nothing crosses, and `least` contacts have been there in each substep.
static void step(PercaleSolver *solver, int frame, uint64_t least)
{
    PercaleCounters before = percale_solver_counters(solver);
    PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    PercaleCounters after = percale_solver_counters(solver);
    PercaleQuality quality;
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    ck_assert_msg(quality.ef_cloth_cloth <= 0.0, "frame %d: %g pairs cross", frame, quality.ef_cloth_cloth);
    ck_assert(quality.nonfinite <= 0.0);
    uint64_t contacts = after.projections_contact - before.projections_contact;
    uint64_t substeps = (uint64_t)percale_solver_def_default().substeps;
    ck_assert_msg(contacts >= least * substeps, "frame %d: %u contacts", frame,
                  (unsigned)(contacts / substeps));
}

static void close_rigs(PercaleSolver *solver, Rig *rigs, int count)
{
    percale_solver_destroy(solver);
    for (int i = 0; i < count; i++) {
        percale_mesh_free(&rigs[i].mesh);
    }
}

// ---- a fold that turns ----

enum { FLAP = 9, FOLD_ROWS = 9 }; // vertices of a flap along x; the other comes back over it

/// A sheet folded at x = -0.04 m, pinned there and at the far ends. Its upper flap is longer, so that it
/// hangs down on the lower one; turned over, the lower one on the upper.
static void make_fold(Rig *rig, float gap)
{
    const float CELL = 0.01f; // m
    *rig = (Rig){.mesh = make_grid(2 * FLAP, FOLD_ROWS, CELL), .slack = 0.01f};
    for (uint32_t i = 0; i < rig->mesh.vertex_count; i++) {
        uint32_t column = i % (2 * FLAP);
        bool upper = column >= FLAP;
        uint32_t from_end = upper ? 2 * FLAP - 1 - column : column;
        float *x = rig->mesh.positions + 3 * (size_t)i;
        x[0] = 0.04f - CELL * (float)(FLAP - 1 - from_end);
        x[1] = upper ? 0.5f * gap : -0.5f * gap;
        x[0] = -x[0];
        x[2] += upper ? 0.3f * CELL * (float)from_end / FLAP : 0.0f; // so that no vertices meet
        if (from_end == 0 || from_end == FLAP - 1) {
            pin_vertex(rig, i);
        }
    }
}

/// Each vertex of the upper flap is above its like in the lower one, along the common normal.
static void check_flaps(PercaleSolver *solver, const Rig *rig, double angle)
{
    const float normal[2] = {(float)-sin(angle), (float)cos(angle)};
    float x[3 * MOST_VERTICES];
    get(solver, rig, x);
    for (uint32_t row = 0; row < FOLD_ROWS; row++) {
        for (uint32_t column = 0; column < FLAP; column++) {
            const float *low = x + 3 * (size_t)(row * 2 * FLAP + column);
            const float *high = x + 3 * (size_t)(row * 2 * FLAP + 2 * FLAP - 1 - column);
            float above = (high[0] - low[0]) * normal[0] + (high[1] - low[1]) * normal[1];
            ck_assert_msg(above > 0.0f, "row %u, column %u: %g mm", row, column, (double)(1e3f * above));
        }
    }
}

START_TEST(a_fold_that_turns_all_the_way_round_keeps_its_flaps_apart)
{
    enum { FRAMES = 60 }; // of a turn
    PercaleSolver *solver = make_solver(-9.81f);
    Rig rig;
    make_fold(&rig, THICKNESS);
    add_rig(solver, &rig, 0.0f);
    for (int frame = 1; frame <= FRAMES; frame++) {
        double angle = 2.0 * PI * frame / FRAMES;
        turn_pins(solver, &rig, 2, angle);
        step(solver, frame, 20);
        check_flaps(solver, &rig, angle);
    }
    ck_assert_uint_eq(percale_solver_counters(solver).born_crossed, 0);
    close_rigs(solver, &rig, 1);
}
END_TEST

// ---- strips that scissor ----

enum { COLUMNS = 17, STRIP_ROWS = 3 };

/// A strip along x, level or upright, at a height, pinned at its ends.
static void make_strip(Rig *rig, bool upright, float height)
{
    const float CELL = 0.01f; // m
    *rig = (Rig){.mesh = make_grid(COLUMNS, STRIP_ROWS, CELL)};
    for (uint32_t i = 0; i < rig->mesh.vertex_count; i++) {
        float *x = rig->mesh.positions + 3 * (size_t)i;
        x[0] = CELL * ((float)(i % COLUMNS) - 0.5f * (COLUMNS - 1));
        x[1] = height;
        if (upright) { // it goes on away from the height 0
            x[1] += (height > 0.0f ? 1.0f : -1.0f) * (x[2] + CELL);
            x[2] = 0.0f;
        }
        if (i % COLUMNS == 0 || i % COLUMNS == COLUMNS - 1) {
            pin_vertex(rig, i);
        }
    }
}

/// Height of a strip where it meets the other: in the middle, or of its rim.
static float middle_height(PercaleSolver *solver, const Rig *rig, bool upright)
{
    float x[3 * MOST_VERTICES];
    get(solver, rig, x);
    return x[3 * ((upright ? 0 : STRIP_ROWS / 2) * COLUMNS + COLUMNS / 2) + 1];
}

static void scissor(bool upright, float gravity, float gap)
{
    enum { FRAMES = 60, PARALLEL_FRAME = 30 };
    const double WIDEST = PI / 6.0;
    PercaleSolver *solver = make_solver(gravity);
    Rig rigs[2];
    make_strip(&rigs[0], upright, -0.5f * gap);
    make_strip(&rigs[1], upright, 0.5f * gap);
    for (size_t i = 0; i < rigs[1].mesh.vertex_count; i++) { // it starts turned
        float *x = rigs[1].mesh.positions + 3 * i;
        double u = (double)x[2];
        double v = (double)x[0];
        x[2] = (float)(cos(WIDEST) * u - sin(WIDEST) * v);
        x[0] = (float)(sin(WIDEST) * u + cos(WIDEST) * v);
    }
    rigs[1].slack = upright ? 0.0f : 0.02f; // it hangs down on the other
    add_rig(solver, &rigs[0], 0.0f);
    add_rig(solver, &rigs[1], 0.0f);
    for (uint32_t i = 0; i < rigs[1].pinned_count; i++) {
        memcpy(rigs[1].start + 3 * (size_t)i, rigs[1].mesh.positions + 3 * (size_t)rigs[1].pinned[i],
               3 * sizeof(float));
    }
    for (int frame = 1; frame <= FRAMES; frame++) {
        turn_pins(solver, &rigs[1], 1, -WIDEST * frame / PARALLEL_FRAME);
        step(solver, frame, 1);
        float low = middle_height(solver, &rigs[0], upright);
        float high = middle_height(solver, &rigs[1], upright);
        ck_assert_msg(high > low, "frame %d: %g is not above %g", frame, (double)high, (double)low);
    }
    ck_assert_uint_eq(percale_solver_counters(solver).born_crossed, 0);
    close_rigs(solver, rigs, 2);
}

START_TEST(strips_that_turn_through_parallel_stay_on_their_sides)
{
    scissor(false, -9.81f, THICKNESS);
}
END_TEST

START_TEST(rims_that_turn_through_parallel_stay_on_their_sides)
{
    scissor(true, 0.0f, 0.95f * THICKNESS);
}
END_TEST

// ---- sheets that meet a held one ----

static void make_level(Rig *rig, uint32_t side, float width, float height, float turn)
{
    *rig = (Rig){.mesh = percale_test_sheet(side, width)};
    for (size_t i = 0; i < rig->mesh.vertex_count; i++) {
        float *x = rig->mesh.positions + 3 * i;
        float level[2] = {x[0], x[2]};
        x[0] = cosf(turn) * level[0] - sinf(turn) * level[1];
        x[1] = height;
        x[2] = sinf(turn) * level[0] + cosf(turn) * level[1];
    }
}

/// Pins the rim of a level sheet of side x side vertices.
static void pin_rim(Rig *rig, uint32_t side)
{
    for (uint32_t i = 0; i < rig->mesh.vertex_count; i++) {
        uint32_t row = i / side;
        uint32_t column = i % side;
        if (row == 0 || column == 0 || row == side - 1 || column == side - 1) {
            pin_vertex(rig, i);
        }
    }
}

/// A sheet falls on one whose rim is held, downwards or upwards.
static void fall(float sign)
{
    enum { SIDE = 13, FRAMES = 40 };
    PercaleSolver *solver = make_solver(sign * -9.81f);
    Rig rigs[2];
    float ranges[2][2];
    make_level(&rigs[0], SIDE, 0.2f, 0.0f, 0.0f);
    pin_rim(&rigs[0], SIDE);
    make_level(&rigs[1], SIDE, 0.1f, sign * 0.03f, 0.3f);
    add_rig(solver, &rigs[0], 0.0f);
    add_rig(solver, &rigs[1], 0.0f);
    for (int frame = 1; frame <= FRAMES; frame++) {
        step(solver, frame, frame > FRAMES / 2 ? 50 : 0);
    }
    heights(solver, &rigs[0], sign, ranges[0]);
    heights(solver, &rigs[1], sign, ranges[1]);
    ck_assert_msg(ranges[1][0] > ranges[0][0], "%g lies below %g", (double)ranges[1][0],
                  (double)ranges[0][0]);
    ck_assert_uint_eq(percale_solver_counters(solver).born_crossed, 0);
    close_rigs(solver, rigs, 2);
}

START_TEST(a_sheet_rests_on_a_held_one_on_the_side_that_it_came_from)
{
    fall(1.0f);
    fall(-1.0f);
}
END_TEST

/// It lies on a held sheet, leaves it at 5 m/s and is back as fast after a tenth of a second: three times.
START_TEST(a_sheet_that_leaves_comes_back_to_the_same_side)
{
    enum { SIDE = 9, FRAMES = 20, ROUND = 6 };
    const float SPEED = 5.0f;
    PercaleSolver *solver = make_solver(-100.0f);
    Rig rigs[2];
    make_level(&rigs[0], SIDE, 0.1f, 0.0f, 0.0f);
    for (uint32_t i = 0; i < rigs[0].mesh.vertex_count; i++) {
        pin_vertex(&rigs[0], i);
    }
    make_level(&rigs[1], SIDE, 0.07f, THICKNESS, 0.3f);
    add_rig(solver, &rigs[0], 0.0f);
    add_rig(solver, &rigs[1], SPEED);
    for (int frame = 1; frame <= FRAMES; frame++) {
        float range[2];
        step(solver, frame, 0);
        heights(solver, &rigs[1], 1.0f, range);
        ck_assert_msg(range[0] > 0.0f, "frame %d: at %g", frame, (double)range[0]);
        ck_assert(frame != ROUND / 2 || range[0] > 0.05f); // it was away
    }
    ck_assert_uint_eq(percale_solver_counters(solver).born_crossed, 0);
    close_rigs(solver, rigs, 2);
}
END_TEST

// ---- a vertex that slides over ridges and rims of its own cloth ----

enum { SLOPE_CELLS = 4, ROOF_COLUMNS = 2 * SLOPE_CELLS + 1, ROOF_ROWS = 6, ROOF = ROOF_COLUMNS * ROOF_ROWS };
static const float ROOF_CELL = 0.02f; // m
static const float DRAG = 0.03f;      // m; sides of the triangle that is dragged along

/// Of a roof's profile, at a distance from the ridge along it.
static void profile_at(float along, float angle, float x[2])
{
    x[0] = along * sinf(0.5f * angle);
    x[1] = -fabsf(along) * cosf(0.5f * angle);
}

/// A held roof with a ridge along z, and a triangle: of the same cloth, but apart. Its tip is free, the other
/// two corners are the last two that are pinned.
static void make_roof(Rig *rig, float angle, const float drag[2])
{
    PercaleMesh roof = make_grid(ROOF_COLUMNS, ROOF_ROWS, ROOF_CELL);
    PercaleMesh *mesh = &rig->mesh;
    *rig = (Rig){.mesh = make_grid(ROOF_COLUMNS, ROOF_ROWS + 1, ROOF_CELL)}; // room for more
    memcpy(mesh->triangles, roof.triangles, 3 * sizeof(uint32_t) * roof.triangle_count);
    memcpy(mesh->positions, roof.positions, 3 * sizeof(float) * ROOF);
    mesh->vertex_count = ROOF + 3;
    mesh->triangle_count = roof.triangle_count + 1;
    for (uint32_t i = 0; i < ROOF; i++) {
        profile_at(ROOF_CELL * ((float)(i % ROOF_COLUMNS) - SLOPE_CELLS), angle,
                   mesh->positions + 3 * (size_t)i);
        pin_vertex(rig, i);
    }
    for (uint32_t k = 0; k < 3; k++) { // the tip hangs below the others, between two rows
        const float corner[3] = {drag[0], drag[1] - (k == 0 ? 0.866f * DRAG : 0.0f),
                                 0.003f + 0.5f * DRAG * ((float)(k == 2) - (float)(k == 1))};
        memcpy(mesh->positions + 3 * (size_t)(ROOF + k), corner, sizeof(corner));
        mesh->triangles[3 * roof.triangle_count + k] = ROOF + k;
    }
    pin_vertex(rig, ROOF + 1);
    pin_vertex(rig, ROOF + 2);
    percale_mesh_free(&roof);
}

/// Takes the triangle's held corners to a place, and one frame; its tip's place then.
static void drag_to(PercaleSolver *solver, const Rig *rig, const float place[2], int frame, float tip[3])
{
    float targets[3 * MOST_VERTICES];
    float x[3 * MOST_VERTICES];
    memcpy(targets, rig->start, sizeof(targets));
    for (size_t i = rig->pinned_count - 2; i < rig->pinned_count; i++) {
        targets[3 * i] = place[0];
        targets[3 * i + 1] = place[1];
    }
    PERCALE_TEST_OK(solver, percale_pin_move(solver, rig->pin, targets, 0));
    step(solver, frame, 0);
    get(solver, rig, x);
    memcpy(tip, x + 3 * (size_t)ROOF, 3 * sizeof(float));
}

/// Over the ridge and back, the tip hanging down so far that it lies on the slopes.
static void slide_over_ridge(int degrees)
{
    enum { FRAMES = 40 };         // there, and as many back
    const float FARTHEST = 0.06f; // m; from the ridge
    const float LIFT = 0.02f;
    float angle = (float)degrees * (float)(PI / 180.0);
    float place[2];
    float tip[3];
    Rig rig;
    profile_at(-FARTHEST, angle, place);
    place[0] -= LIFT * cosf(0.5f * angle); // at first the tip is beside the slope
    place[1] += LIFT;
    PercaleSolver *solver = make_solver(-9.81f);
    make_roof(&rig, angle, (const float[2]){place[0] - 0.02f, place[1] + 0.02f});
    add_rig(solver, &rig, 0.0f);
    for (int frame = 1; frame <= 2 * FRAMES; frame++) {
        float along = FARTHEST * (1.0f - fabsf((float)frame / FRAMES - 1.0f) * 2.0f);
        profile_at(along, angle, place);
        place[1] += LIFT;
        drag_to(solver, &rig, place, frame, tip);
        float roof = -fabsf(tip[0]) / tanf(0.5f * angle);
        ck_assert_msg(tip[1] > roof, "%d degrees, frame %d: %g at %g is below %g", degrees, frame,
                      (double)tip[1], (double)tip[0], (double)roof);
        ck_assert_msg(frame % FRAMES != 0 || tip[0] * along > 0.0f, "%d degrees: held back at %g", degrees,
                      (double)tip[0]);
    }
    ck_assert_uint_eq(percale_solver_counters(solver).born_crossed, 0);
    ck_assert_msg(percale_solver_counters(solver).projections_contact > 1000, "%d degrees: no contact",
                  degrees);
    close_rigs(solver, &rig, 1);
}

START_TEST(a_vertex_slides_over_ridges_of_its_own_cloth)
{
    for (int degrees = 30; degrees <= 150; degrees += 30) {
        slide_over_ridge(degrees);
    }
}
END_TEST

/// From above a level sheet around its rim to below it, and back. Without gravity: the tip follows.
START_TEST(a_vertex_slides_around_a_rim_and_back)
{
    enum { FRAMES = 60 };
    const float RIM = SLOPE_CELLS * 0.02f; // m; where it is
    const float AWAY = 0.02f;              // m; from the sheet
    const float WAY = 0.05f;               // m; along it, above and below
    float tip[3];
    Rig rig;
    PercaleSolver *solver = make_solver(0.0f);
    make_roof(&rig, (float)PI, (const float[2]){RIM - WAY, AWAY + 0.01f});
    add_rig(solver, &rig, 0.0f);
    for (int frame = 1; frame <= 2 * FRAMES; frame++) {
        float along = (1.0f - fabsf((float)frame / FRAMES - 1.0f)) * (2.0f * WAY + (float)PI * AWAY) - WAY;
        float turn = fminf(fmaxf(along / AWAY, 0.0f), (float)PI);
        float beyond = along < 0.0f ? along : fminf(-(along - (float)PI * AWAY), 0.0f);
        const float place[2] = {RIM + beyond + AWAY * sinf(turn), AWAY * cosf(turn)};
        drag_to(solver, &rig, place, frame, tip);
        if (frame == FRAMES) {
            ck_assert_msg(tip[0] < RIM && tip[1] < 0.0f, "held above: %g %g", (double)tip[0], (double)tip[1]);
        }
    }
    ck_assert_msg(tip[0] < RIM && tip[1] > 0.0f, "held below: %g %g", (double)tip[0], (double)tip[1]);
    ck_assert_uint_eq(percale_solver_counters(solver).born_crossed, 0);
    ck_assert_uint_gt(percale_solver_counters(solver).projections_contact, 50);
    close_rigs(solver, &rig, 1);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("sides_moving");
    TCase *sides = tcase_create("sides_moving");
    tcase_set_tags(sides, PERCALE_ONE_THREAD);
    tcase_set_timeout(sides, 0);
    tcase_add_test(sides, a_fold_that_turns_all_the_way_round_keeps_its_flaps_apart);
    tcase_add_test(sides, strips_that_turn_through_parallel_stay_on_their_sides);
    tcase_add_test(sides, rims_that_turn_through_parallel_stay_on_their_sides);
    tcase_add_test(sides, a_sheet_rests_on_a_held_one_on_the_side_that_it_came_from);
    tcase_add_test(sides, a_sheet_that_leaves_comes_back_to_the_same_side);
    tcase_add_test(sides, a_vertex_slides_over_ridges_of_its_own_cloth);
    tcase_add_test(sides, a_vertex_slides_around_a_rim_and_back);
    suite_add_tcase(suite, sides);
    return percale_test_run(suite);
}
