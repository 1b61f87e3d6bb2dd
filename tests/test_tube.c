// A sheet sewn to a tube that carries weight, with contact of cloth and cloth: it closes, and stays closed.

#include "solver.h"
#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double PI = 3.14159265358979323846;
static const double GAP_MAX = 1e-4; // m; between the points of a closed seam

enum { COLUMNS = 25, ROWS = 21 };     // vertices; the first and the last column are sewn
static const double SPACING = 0.0125; // m
static const double OPENING = 0.012;  // m; of the tube before it is sewn
static const float HEAVY = 2.0f;      // kg/m^2

typedef struct Tube {
    PercaleSolver *solver;
    PercaleMesh flat, rolled;
    PercaleCloth cloth;
} Tube;

static float *column_row(const PercaleMesh *mesh, uint32_t column, uint32_t row)
{
    return mesh->positions + 3 * (size_t)(row * COLUMNS + column);
}

/// The sheet's place on a tube of which `opening` m are missing, hanging down from y = 0.
static void roll(PercaleMesh *mesh, double opening)
{
    double width = SPACING * (COLUMNS - 1);
    double radius = (width + opening) / (2.0 * PI);
    for (uint32_t row = 0; row < ROWS; row++) {
        for (uint32_t column = 0; column < COLUMNS; column++) {
            double angle = (0.5 * opening + SPACING * column) / radius;
            float *x = column_row(mesh, column, row);
            x[0] = (float)(radius * cos(angle));
            x[1] = (float)(-SPACING * row);
            x[2] = (float)(radius * sin(angle));
        }
    }
}

/// A square sheet has room for it; its rows are cut off.
static PercaleMesh sheet(void)
{
    PercaleMesh mesh = percale_test_sheet(COLUMNS, (float)(SPACING * (COLUMNS - 1)));
    mesh.vertex_count = COLUMNS * ROWS;
    mesh.triangle_count = 2 * (COLUMNS - 1) * (ROWS - 1);
    return mesh;
}

/// The upper rim is held where the closed tube has it, but for the sewn points, which close first.
static void pin_rim(Tube *tube)
{
    PercaleMesh closed = sheet();
    roll(&closed, 0.0);
    uint32_t vertices[COLUMNS - 2];
    for (uint32_t i = 0; i < COLUMNS - 2; i++) {
        vertices[i] = i + 1;
    }
    PercalePinDef def = percale_pin_def_default();
    def.cloth = tube->cloth;
    def.vertices = vertices;
    def.vertex_count = COLUMNS - 2;
    def.targets = column_row(&closed, 1, 0);
    PercalePin pin;
    PERCALE_TEST_OK(tube->solver, percale_pin_add(tube->solver, &def, &pin));
    percale_mesh_free(&closed);
}

static void sew(Tube *tube)
{
    uint32_t sides[2][ROWS];
    for (uint32_t row = 0; row < ROWS; row++) {
        sides[0][row] = row * COLUMNS;
        sides[1][row] = row * COLUMNS + COLUMNS - 1;
    }
    PercaleSeamDef def = percale_seam_def_default();
    def.cloth_a = def.cloth_b = tube->cloth;
    def.vertices_a = sides[0];
    def.vertices_b = sides[1];
    def.pair_count = ROWS;
    PercaleSeam seam;
    PERCALE_TEST_OK(tube->solver, percale_seam_add(tube->solver, &def, &seam));
}

static Tube create(int substeps)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = substeps;
    def.self_collision = def.edge_edge = 1;
    Tube tube = {.solver = percale_test_solver(def), .flat = sheet(), .rolled = sheet()};
    roll(&tube.rolled, OPENING);
    PercaleClothDef cloth = percale_test_cloth_def(&tube.rolled);
    cloth.rest_positions = tube.flat.positions;
    cloth.material.density = HEAVY;
    cloth.material.thickness = 0.002f;
    PERCALE_TEST_OK(tube.solver, percale_cloth_add(tube.solver, &cloth, &tube.cloth));
    pin_rim(&tube);
    sew(&tube);
    return tube;
}

static void destroy(Tube *tube)
{
    percale_solver_destroy(tube->solver);
    percale_mesh_free(&tube->flat);
    percale_mesh_free(&tube->rolled);
}

/// Widest gap of a sewn pair, m.
static double widest_gap(Tube *tube)
{
    PERCALE_TEST_OK(tube->solver,
                    percale_cloth_get_positions(tube->solver, tube->cloth, tube->rolled.positions, 0));
    double widest = 0.0;
    for (uint32_t row = 0; row < ROWS; row++) {
        const float *a = column_row(&tube->rolled, 0, row);
        const float *b = column_row(&tube->rolled, COLUMNS - 1, row);
        double sum = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            sum += ((double)a[axis] - (double)b[axis]) * ((double)a[axis] - (double)b[axis]);
        }
        widest = fmax(widest, sqrt(sum));
    }
    return widest;
}

static bool has_point(const PercaleStencil *stencil, uint32_t point)
{
    bool has = false;
    for (int k = 0; k < 4; k++) {
        has = has || (stencil->points[k] == point && stencil->weights[k] != 0.0f);
    }
    return has;
}

/// Contacts of the last pass between the two points of a pair that is still open.
static uint32_t contacts_across(const PercaleSolver *solver)
{
    uint32_t count = 0;
    for (uint32_t s = 0; s < solver->model.open_seam_count; s++) {
        const uint32_t *slots = solver->model.open_seams[s].slots;
        for (size_t i = 0; i < solver->stencils.count; i++) {
            const PercaleStencil *stencil = &solver->stencils.items[i];
            count += has_point(stencil, slots[0]) && has_point(stencil, slots[1]);
        }
    }
    return count;
}

/// The cloth's thickness is twice the distance within which a seam welds: contact must not hold it open.
START_TEST(a_tube_under_load_closes_and_stays_closed)
{
    enum { FRAMES = PERCALE_SANITIZED ? 6 : 20, CLOSED_BY = 4 };
    Tube tube = create(_i == 0 ? 20 : 80);
    ck_assert_double_gt(widest_gap(&tube), 0.9 * OPENING);
    for (int frame = 0; frame < FRAMES; frame++) {
        PercaleQuality quality;
        PERCALE_TEST_OK(tube.solver, percale_solver_step(tube.solver, FRAME));
        PERCALE_TEST_OK(tube.solver, percale_solver_quality(tube.solver, &quality));
        ck_assert_uint_eq(contacts_across(tube.solver), 0);
        double gap = widest_gap(&tube);
        ck_assert_msg(quality.ef_seam <= 0.0, "frame %d: %g crossings at the seam", frame, quality.ef_seam);
        ck_assert_msg(quality.ef_cloth_cloth <= 0.0, "frame %d: %g crossings", frame, quality.ef_cloth_cloth);
        ck_assert_msg(frame < CLOSED_BY || gap <= GAP_MAX, "frame %d: a gap of %g m", frame, gap);
    }
    destroy(&tube);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("tube");
    TCase *tube = tcase_create("tube");
    tcase_set_timeout(tube, 0);
    tcase_add_loop_test(tube, a_tube_under_load_closes_and_stays_closed, 0, 2);
    suite_add_tcase(suite, tube);
    return percale_test_run(suite);
}
