// Tethers: distances along the cloth, who gets one, and what they promise. And how often bending has to act.

#include "model/geodesic.h"
#include "solve/solve_arrays.h"
#include "solver.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 21 };
static const float SHEET = 1.0f; // m, along a side

// ---- distances along the cloth ----

/// A sheet without some of its triangles, and room for the answers.
typedef struct Geodesic {
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleMesh mesh;
    float (*lengths)[3];
    uint32_t *first_triangle, *triangles_around;
    float *distances;
    uint32_t *nearest;
    PercaleGeodesicMesh input;
} Geodesic;

static double length_between(const PercaleMesh *mesh, uint32_t a, uint32_t b)
{
    double sum = 0.0;
    for (size_t axis = 0; axis < 3; axis++) {
        double d =
            (double)mesh->positions[3 * (size_t)a + axis] - (double)mesh->positions[3 * (size_t)b + axis];
        sum += d * d;
    }
    return sqrt(sum);
}

static void find_triangles_around(Geodesic *geodesic)
{
    const PercaleMesh *mesh = &geodesic->mesh;
    uint32_t filled = 0;
    for (uint32_t v = 0; v < mesh->vertex_count; v++) {
        geodesic->first_triangle[v] = filled;
        for (uint32_t t = 0; t < mesh->triangle_count; t++) {
            const uint32_t *corners = mesh->triangles + 3 * (size_t)t;
            if (corners[0] == v || corners[1] == v || corners[2] == v) {
                geodesic->triangles_around[filled++] = t;
            }
        }
    }
    geodesic->first_triangle[mesh->vertex_count] = filled;
}

/// Keeps the triangles that have no corner in the cut, a rectangle of cells.
static void cut(PercaleMesh *mesh, uint32_t low_x, uint32_t high_x, uint32_t low_y, uint32_t high_y)
{
    uint32_t kept = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        bool inside = false;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t x = mesh->triangles[3 * t + k] % SIDE;
            uint32_t y = mesh->triangles[3 * t + k] / SIDE;
            inside = inside || (x > low_x && x < high_x && y > low_y && y < high_y);
        }
        if (!inside) {
            memmove(mesh->triangles + 3 * (size_t)kept++, mesh->triangles + 3 * (size_t)t,
                    3 * sizeof(uint32_t));
        }
    }
    mesh->triangle_count = kept;
}

static void open_geodesic(Geodesic *geodesic, PercaleMesh mesh)
{
    *geodesic = (Geodesic){.allocator = percale_allocator_default(), .mesh = mesh};
    geodesic->memory.allocator = &geodesic->allocator;
    geodesic->lengths = malloc((mesh.triangle_count + 1) * sizeof(geodesic->lengths[0]));
    geodesic->first_triangle = malloc((mesh.vertex_count + 1) * sizeof(uint32_t));
    geodesic->triangles_around = malloc((3 * (size_t)mesh.triangle_count + 1) * sizeof(uint32_t));
    geodesic->distances = malloc((mesh.vertex_count + 1) * sizeof(float));
    geodesic->nearest = malloc((mesh.vertex_count + 1) * sizeof(uint32_t));
    if (geodesic->lengths == NULL || geodesic->first_triangle == NULL || geodesic->triangles_around == NULL ||
        geodesic->distances == NULL || geodesic->nearest == NULL) {
        ck_abort_msg("no memory");
    }
    for (uint32_t t = 0; t < mesh.triangle_count; t++) {
        for (uint32_t k = 0; k < 3; k++) {
            geodesic->lengths[t][k] =
                (float)length_between(&mesh, mesh.triangles[3 * t + k], mesh.triangles[3 * t + (k + 1) % 3]);
        }
    }
    find_triangles_around(geodesic);
    geodesic->input = (PercaleGeodesicMesh){mesh.vertex_count,        mesh.triangle_count,
                                            mesh.triangles,           (const float(*)[3])geodesic->lengths,
                                            geodesic->first_triangle, geodesic->triangles_around};
}

static void run_geodesic(Geodesic *geodesic, const uint32_t *sources, uint32_t source_count)
{
    ck_assert(percale_geodesic_run(&geodesic->input, sources, source_count, &geodesic->memory,
                                   geodesic->distances, geodesic->nearest));
}

static void close_geodesic(Geodesic *geodesic)
{
    ck_assert_uint_eq(geodesic->memory.bytes, 0);
    free(geodesic->lengths);
    free(geodesic->first_triangle);
    free(geodesic->triangles_around);
    free(geodesic->distances);
    free(geodesic->nearest);
    percale_mesh_free(&geodesic->mesh);
}

START_TEST(on_a_flat_sheet_the_way_is_the_straight_line)
{
    static const uint32_t SOURCES[] = {0, SIDE - 1, SIDE * SIDE / 2, 3 * SIDE + 7, SIDE * SIDE - 1};
    Geodesic geodesic;
    open_geodesic(&geodesic, percale_test_sheet(SIDE, SHEET));
    for (size_t s = 0; s < sizeof(SOURCES) / sizeof(SOURCES[0]); s++) {
        run_geodesic(&geodesic, &SOURCES[s], 1);
        for (uint32_t v = 0; v < geodesic.mesh.vertex_count; v++) {
            double straight = length_between(&geodesic.mesh, SOURCES[s], v);
            ck_assert_double_eq_tol((double)geodesic.distances[v], straight, 2e-6);
            ck_assert_uint_eq(geodesic.nearest[v], 0);
        }
    }
    close_geodesic(&geodesic);
}
END_TEST

// The way around a hole is straight to its corner and straight on; the diagonal of the cell there may cut the
// corner.
START_TEST(around_a_hole_the_way_goes_by_its_corner)
{
    const uint32_t source = 10 * SIDE; // left of the hole, at half height
    const uint32_t target = source + SIDE - 1;
    PercaleMesh mesh = percale_test_sheet(SIDE, SHEET);
    cut(&mesh, 5, 15, 5, 15);
    Geodesic geodesic;
    open_geodesic(&geodesic, mesh);
    run_geodesic(&geodesic, &source, 1);
    const double cell = (double)SHEET / (SIDE - 1);
    double longest = cell * (2.0 * sqrt(25.0 + 25.0) + 10.0);
    double shortest = cell * (2.0 * (sqrt(25.0 + 16.0) + sqrt(2.0)) + 8.0);
    ck_assert_double_ge((double)geodesic.distances[target], shortest * 0.9999);
    ck_assert_double_le((double)geodesic.distances[target], longest * 1.001);
    close_geodesic(&geodesic);
}
END_TEST

START_TEST(the_nearest_source_is_named_and_what_none_reaches_is_infinite)
{
    const uint32_t sources[2] = {0, SIDE - 1};
    PercaleMesh mesh = percale_test_sheet(SIDE, SHEET);
    cut(&mesh, 0, SIDE, 9, 12); // rows 10 and 11 have no triangles: the rest falls apart
    Geodesic geodesic;
    open_geodesic(&geodesic, mesh);
    run_geodesic(&geodesic, sources, 2);
    for (uint32_t v = 0; v < geodesic.mesh.vertex_count; v++) {
        if (v / SIDE > 12) {
            ck_assert(isinf(geodesic.distances[v]));
            ck_assert_uint_eq(geodesic.nearest[v], UINT32_MAX);
        } else if (v / SIDE < 9 && v % SIDE != SIDE / 2) {
            ck_assert_uint_eq(geodesic.nearest[v], v % SIDE > SIDE / 2);
        }
    }
    close_geodesic(&geodesic);
}
END_TEST

// ---- tethers ----

typedef struct Hung {
    PercaleMesh sheet;
    PercaleSolver *solver;
    PercaleCloth cloth;
    PercalePin pin;
} Hung;

static Hung hang(PercaleSolverDef def, float compliance, const uint32_t *pinned, uint32_t pinned_count)
{
    Hung hung = {.sheet = percale_test_sheet(SIDE, SHEET), .solver = percale_test_solver(def)};
    PercaleClothDef cloth = percale_test_cloth_def(&hung.sheet);
    cloth.material.stretch_compliance = compliance;
    PERCALE_TEST_OK(hung.solver, percale_cloth_add(hung.solver, &cloth, &hung.cloth));
    PercalePinDef pin = percale_pin_def_default();
    pin.cloth = hung.cloth;
    pin.vertices = pinned;
    pin.vertex_count = pinned_count;
    PERCALE_TEST_OK(hung.solver, percale_pin_add(hung.solver, &pin, &hung.pin));
    PERCALE_TEST_OK(hung.solver, percale_solver_validate(hung.solver));
    return hung;
}

static void let_go(Hung *hung)
{
    percale_solver_destroy(hung->solver);
    percale_mesh_free(&hung->sheet);
}

static const uint32_t CORNERS[2] = {0, SIDE - 1};

// By far the worst case for constraints that act from edge to edge: one sweep in a substep, and few of them.
START_TEST(nothing_falls_farther_from_a_pin_than_the_cloth_is_long)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = 4;
    Hung hung = hang(def, 0.0f, CORNERS, 2);
    float positions[3 * SIDE * SIDE];
    for (int frame = 0; frame < 60; frame++) {
        PERCALE_TEST_OK(hung.solver, percale_solver_step(hung.solver, 1.0 / 60.0));
        PERCALE_TEST_OK(hung.solver, percale_cloth_get_positions(hung.solver, hung.cloth, positions, 0));
        PercaleMesh now = hung.sheet;
        now.positions = positions;
        for (uint32_t v = 0; v < SIDE * SIDE; v++) {
            for (int c = 0; c < 2; c++) {
                double most = length_between(&hung.sheet, CORNERS[c], v) * 1.0002;
                // the second corner's tether comes last; the first one's may be a little too long again
                ck_assert_double_le(length_between(&now, CORNERS[c], v), c == 1 ? most + 1e-5 : most * 1.05);
            }
        }
    }
    let_go(&hung);
}
END_TEST

START_TEST(pins_that_touch_are_one_island_and_many_islands_share_a_layer)
{
    static const uint32_t ROW[4] = {0, 1, 2, 3};
    static const uint32_t ALL_FOUR[4] = {0, SIDE - 1, SIDE * (SIDE - 1), SIDE * SIDE - 1};
    static const uint32_t FIVE[5] = {0, SIDE - 1, SIDE * (SIDE - 1), SIDE * SIDE - 1, SIDE * SIDE / 2};
    static const struct {
        const uint32_t *pinned;
        uint32_t count, layers;
    } CASES[] = {{ROW, 4, 1}, {CORNERS, 2, 2}, {ALL_FOUR, 4, 4}, {FIVE, 5, 1}};
    for (size_t i = 0; i < sizeof(CASES) / sizeof(CASES[0]); i++) {
        Hung hung = hang(percale_solver_def_default(), 0.0f, CASES[i].pinned, CASES[i].count);
        ck_assert_uint_eq(hung.solver->model.tether_layers, CASES[i].layers);
        ck_assert_uint_eq(hung.solver->model.tether_count, CASES[i].layers * (SIDE * SIDE - CASES[i].count));
        let_go(&hung);
    }
}
END_TEST

START_TEST(a_cloth_that_may_stretch_and_one_without_pins_have_none)
{
    PercaleSolverDef def = percale_solver_def_default();
    Hung compliant = hang(def, 1e-4f, CORNERS, 2);
    ck_assert_uint_eq(compliant.solver->model.tether_layers, 0);
    let_go(&compliant);
    Hung freed = hang(def, 0.0f, CORNERS, 2);
    PERCALE_TEST_OK(freed.solver, percale_pin_remove(freed.solver, freed.pin));
    PERCALE_TEST_OK(freed.solver, percale_solver_step(freed.solver, 1.0 / 60.0));
    ck_assert_uint_eq(freed.solver->model.tether_layers, 0);
    ck_assert_uint_eq(percale_solver_counters(freed.solver).projections_tether, 0);
    let_go(&freed);
    def.tethers = 0;
    Hung refused = hang(def, 0.0f, CORNERS, 2);
    ck_assert_ptr_null(refused.solver->model.tether_lengths);
    let_go(&refused);
}
END_TEST

// ---- how often bending acts ----

static uint32_t bend_interval(float stiffness, int substeps, uint64_t *projections)
{
    PercaleMesh sheet = percale_test_sheet(SIDE, SHEET);
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = substeps;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleClothDef cloth = percale_test_cloth_def(&sheet);
    PercaleCloth handle;
    cloth.material.bending_stiffness = stiffness;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, &handle));
    PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / 60.0));
    *projections = percale_solver_counters(solver).projections_bend / solver->model.hinge_count;
    uint32_t interval = solver->bend_interval;
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    return interval;
}

START_TEST(the_softer_bending_is_the_less_often_it_acts_at_a_divisor_of_the_substeps)
{
    uint64_t projections;
    for (int substeps = 15; substeps <= 20; substeps++) {
        uint32_t previous = 1;
        uint32_t between = 0; // stiffnesses with neither the least nor the largest interval
        for (int halvings = 0; halvings <= 33; halvings++) {
            float stiffness = ldexpf(1.0f, -halvings);
            uint32_t interval = bend_interval(stiffness, substeps, &projections);
            ck_assert_uint_eq((uint32_t)substeps % interval, 0);
            ck_assert_uint_eq(projections, (uint32_t)substeps / interval);
            ck_assert_uint_ge(interval, previous);
            ck_assert(halvings > 0 || interval == 1);
            between += interval > 1 && interval < (uint32_t)substeps;
            previous = interval;
        }
        ck_assert_uint_eq(previous, (uint32_t)substeps);
        ck_assert(substeps == 17 || substeps == 19 || between > 0); // primes
    }
}
END_TEST

enum { BENT = 9, BENT_COUNT = BENT * BENT };

/// A sheet that is flat at rest, rolled to a piece of a tube, free in space.
static PercaleSolver *roll_sheet(float stiffness, int substeps, PercaleCloth *handle)
{
    const double RADIUS = 0.15; // m
    PercaleMesh sheet = percale_test_sheet(BENT, 0.2f);
    float rolled[3 * BENT_COUNT];
    for (size_t i = 0; i < 3 * BENT_COUNT; i += 3) {
        double angle = (double)sheet.positions[i] / RADIUS;
        rolled[i] = (float)(RADIUS * sin(angle));
        rolled[i + 1] = (float)(RADIUS * cos(angle));
        rolled[i + 2] = sheet.positions[i + 2];
    }
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = def.passes = substeps;
    def.iterations = 1;
    def.gravity[0] = def.gravity[1] = def.gravity[2] = 0.0f;
    def.self_collision = 0;
    def.damping = 0.0f;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleClothDef cloth = percale_test_cloth_def(&sheet);
    cloth.positions = rolled;
    cloth.rest_positions = sheet.positions;
    cloth.material.bending_stiffness = stiffness;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, handle));
    percale_mesh_free(&sheet);
    return solver;
}

/// Steps of one substep each are as long, and leave no substep out.
START_TEST(bending_at_an_interval_moves_cloth_as_that_of_every_substep)
{
    enum { SUBSTEPS = 20, FRAMES = 30 };
    PercaleCloth cloths[2];
    PercaleSolver *seldom = roll_sheet(2e-6f, SUBSTEPS, &cloths[0]);
    PercaleSolver *often = roll_sheet(2e-6f, 1, &cloths[1]);
    float start[3 * BENT_COUNT];
    float x[2][3 * BENT_COUNT];
    PERCALE_TEST_OK(seldom, percale_cloth_get_positions(seldom, cloths[0], start, 0));
    for (int frame = 0; frame < FRAMES; frame++) {
        PERCALE_TEST_OK(seldom, percale_solver_step(seldom, 1.0 / 60.0));
        for (int i = 0; i < SUBSTEPS; i++) {
            PERCALE_TEST_OK(often, percale_solver_step(often, 1.0 / 60.0 / SUBSTEPS));
        }
    }
    ck_assert_uint_ge(seldom->bend_interval, 4);
    ck_assert_uint_eq(often->bend_interval, 1);
    PERCALE_TEST_OK(seldom, percale_cloth_get_positions(seldom, cloths[0], x[0], 0));
    PERCALE_TEST_OK(often, percale_cloth_get_positions(often, cloths[1], x[1], 0));
    double way = 0.0;
    double apart = 0.0;
    for (int i = 0; i < 3 * BENT_COUNT; i++) {
        way = fmax(way, fabs((double)(x[1][i] - start[i])));
        apart = fmax(apart, fabs((double)(x[0][i] - x[1][i])));
    }
    ck_assert_double_gt(way, 2e-3); // m
    ck_assert_double_lt(apart, 0.05 * way);
    percale_solver_destroy(seldom);
    percale_solver_destroy(often);
}
END_TEST

/// A force that is older than the shape would feed the ripples of the mesh.
START_TEST(bending_at_an_interval_feeds_no_swing)
{
    enum { FRAMES = PERCALE_SANITIZED ? 240 : 900 };
    PercaleCloth cloth;
    PercaleSolver *solver = roll_sheet(2e-6f, 20, &cloth);
    double most = 0.0; // in the first second
    double last = 0.0;
    for (int frame = 0; frame < FRAMES; frame++) {
        float v[3 * BENT_COUNT];
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / 60.0));
        PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, cloth, v, 0));
        last = 0.0;
        for (int i = 0; i < 3 * BENT_COUNT; i++) {
            last += (double)v[i] * (double)v[i] / (2 * BENT_COUNT);
        }
        most = frame < 60 ? fmax(most, last) : most;
    }
    ck_assert_uint_ge(solver->bend_interval, 4);
    ck_assert_double_lt(last, most);
    percale_solver_destroy(solver);
}
END_TEST

/// The pins' places ahead, too, are ahead: a sheet that goes along with them isn't bent.
START_TEST(a_flat_sheet_that_its_pins_carry_is_not_bent)
{
    enum { FRAMES = 30 };
    const float SPEED = 3.0f; // m/s, across the sheet
    PercaleSolverDef def = percale_solver_def_default();
    def.gravity[0] = def.gravity[1] = def.gravity[2] = 0.0f;
    def.damping = 0.0f;
    const uint32_t corners[2] = {0, SIDE - 1};
    Hung hung = hang(def, 0.0f, corners, 2);
    float velocities[3 * SIDE * SIDE];
    for (int i = 0; i < 3 * SIDE * SIDE; i++) {
        velocities[i] = i % 3 == 1 ? SPEED : 0.0f;
    }
    PERCALE_TEST_OK(hung.solver, percale_cloth_set_velocities(hung.solver, hung.cloth, velocities, 0));
    for (int frame = 1; frame <= FRAMES; frame++) {
        float targets[6];
        for (int i = 0; i < 6; i++) {
            float way = i % 3 == 1 ? SPEED * (float)frame / 60.0f : 0.0f;
            targets[i] = hung.sheet.positions[3 * corners[i / 3] + (uint32_t)i % 3] + way;
        }
        PERCALE_TEST_OK(hung.solver, percale_pin_move(hung.solver, hung.pin, targets, 0));
        PERCALE_TEST_OK(hung.solver, percale_solver_step(hung.solver, 1.0 / 60.0));
    }
    ck_assert_uint_ge(hung.solver->bend_interval, 4);
    float x[3 * SIDE * SIDE];
    PERCALE_TEST_OK(hung.solver, percale_cloth_get_positions(hung.solver, hung.cloth, x, 0));
    for (int i = 1; i < 3 * SIDE * SIDE; i += 3) { // flat, where the pins are
        ck_assert_double_lt(fabs((double)(x[i] - x[1])), 5e-5);
    }
    let_go(&hung);
}
END_TEST

// The impulse of n substeps at once: to first order in the stiffness the movement is n times as large.
START_TEST(bending_at_an_interval_is_as_strong_as_the_substeps_it_stands_for)
{
    const uint32_t interval = 3;
    PercaleMesh sheet = percale_test_sheet(SIDE, SHEET);
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    (void)percale_test_add_cloth(solver, &sheet);
    PERCALE_TEST_OK(solver, percale_solver_validate(solver));
    const PercaleModel *model = &solver->model;
    f32x4 *once = calloc(model->hinge_count, sizeof(f32x4));
    f32x4 *often = calloc(model->hinge_count, sizeof(f32x4));
    ck_assert(once != NULL && often != NULL);
    percale_solve_bend_prepare(model, 1e-5f, 1, once, NULL);
    percale_solve_bend_prepare(model, 1e-5f, interval, often, NULL);
    for (uint32_t h = 0; h < model->hinge_count; h++) {
        for (int k = 0; k < 4; k++) { // the movement goes with the square of the weights
            float ratio = often[h][k] * often[h][k] / (once[h][k] * once[h][k]);
            ck_assert(fabsf(once[h][k]) < 1e-12f || fabsf(ratio - (float)interval) < 1e-3f);
        }
    }
    free(once);
    free(often);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("tethers");
    TCase *distances = tcase_create("distances along the cloth");
    tcase_add_test(distances, on_a_flat_sheet_the_way_is_the_straight_line);
    tcase_add_test(distances, around_a_hole_the_way_goes_by_its_corner);
    tcase_add_test(distances, the_nearest_source_is_named_and_what_none_reaches_is_infinite);
    suite_add_tcase(suite, distances);
    TCase *tethers = tcase_create("tethers");
    tcase_add_test(tethers, nothing_falls_farther_from_a_pin_than_the_cloth_is_long);
    tcase_add_test(tethers, pins_that_touch_are_one_island_and_many_islands_share_a_layer);
    tcase_add_test(tethers, a_cloth_that_may_stretch_and_one_without_pins_have_none);
    suite_add_tcase(suite, tethers);
    TCase *bending = tcase_create("bending");
    tcase_add_test(bending, the_softer_bending_is_the_less_often_it_acts_at_a_divisor_of_the_substeps);
    tcase_add_test(bending, bending_at_an_interval_moves_cloth_as_that_of_every_substep);
    tcase_add_test(bending, bending_at_an_interval_feeds_no_swing);
    tcase_add_test(bending, a_flat_sheet_that_its_pins_carry_is_not_bent);
    tcase_add_test(bending, bending_at_an_interval_is_as_strong_as_the_substeps_it_stands_for);
    suite_add_tcase(suite, bending);
    return percale_test_run(suite);
}
