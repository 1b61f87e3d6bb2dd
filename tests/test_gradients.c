// The solver's inner forces against central differences of the energy or length that they stand for.

#include "kernel_testing.h"

#include "solve/solve_arrays.h"
#include "solver.h"

#include <math.h>
#include <stdlib.h>

enum { TRIALS = 300 };
static const float DT = 1.0f / 1200.0f; // s

// ---- stretch ----

static double edge_stretch(const Vec3 x[POINTS], const void *rest_length)
{
    return vlength(vsub(x[0], x[1])) - *(const double *)rest_length;
}

typedef struct Stretch {
    uint32_t edge[1][2];
    float length, compliance, multiplier; // m, m/N, N s^2
    PercaleModel model;
    PercaleSolveArrays arrays;
} Stretch;

/// One edge between the first two points.
static void open_stretch(Stretch *stretch, f32x4 x[POINTS], float length, float compliance)
{
    *stretch = (Stretch){.edge = {{0, POINT_BYTES}}, .length = length, .compliance = compliance};
    stretch->model.edge_count = 1;
    stretch->model.edges = stretch->edge;
    stretch->model.edge_lengths = &stretch->length;
    stretch->model.edge_compliances = compliance > 0.0f ? &stretch->compliance : NULL;
    stretch->arrays =
        (PercaleSolveArrays){.model = &stretch->model,
                             .x = x,
                             .start = x,
                             .dt = DT,
                             .edge_multipliers = compliance > 0.0f ? &stretch->multiplier : NULL};
}

START_TEST(stretch_moves_along_its_gradient)
{
    uint64_t seed = 1;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x4 x[POINTS];
        Vec3 points[POINTS];
        Vec3 gradient[POINTS];
        Stretch stretch;
        random_points(&seed, x);
        load_points(x, points);
        float length = random_float(&seed, 0.2, 2.0);
        float compliance = trial % 3 == 0 ? 0.0f : random_float(&seed, 0.1, 10.0) * DT * DT;
        open_stretch(&stretch, x, length, compliance);
        double rest = (double)length;
        differentiate(edge_stretch, &rest, points, 1e-4, gradient);
        double alpha = (double)compliance / ((double)DT * (double)DT);
        double stiffness = mobility(x, gradient) + alpha;
        f32x4 before[POINTS];
        memcpy(before, x, sizeof(before));
        percale_solve_stretch(&stretch.arrays, 0, 1);
        double lambda = stiffness > 0.0 ? -edge_stretch(points, &rest) / stiffness : 0.0;
        expect_moved_along((const f32x4 *)before, (const f32x4 *)x, (const Vec3 *)gradient, lambda);
    }
}
END_TEST

static double stretch_energy(const Vec3 x[POINTS], const void *given)
{
    const Stretch *stretch = given;
    double rest = (double)stretch->length;
    double c = edge_stretch(x, &rest);
    return 0.5 * c * c / (double)stretch->compliance;
}

// Sweeps end where the mass times the movement is dt^2 times the force: an implicit step.
START_TEST(stretch_ends_at_the_force_of_its_energy)
{
    uint64_t seed = 2;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x4 x[POINTS];
        f32x4 before[POINTS];
        Vec3 points[POINTS];
        Vec3 gradient[POINTS];
        Stretch stretch;
        random_points(&seed, x);
        memcpy(before, x, sizeof(before));
        open_stretch(&stretch, x, random_float(&seed, 0.2, 2.0), random_float(&seed, 0.5, 10.0) * DT * DT);
        for (int sweep = 0; sweep < 100; sweep++) {
            percale_solve_stretch(&stretch.arrays, 0, 1);
        }
        load_points(x, points);
        differentiate(stretch_energy, &stretch, points, 1e-4, gradient);
        expect_moved_along((const f32x4 *)before, (const f32x4 *)x, (const Vec3 *)gradient,
                           -(double)DT * (double)DT);
    }
}
END_TEST

START_TEST(stretch_without_direction_or_mobility_does_nothing)
{
    f32x4 same[POINTS] = {{0.5f, 1.0f, 2.0f, 1.0f}, {0.5f, 1.0f, 2.0f, 1.0f}};
    f32x4 fixed[POINTS] = {{0.0f, 0.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f, 0.0f}};
    for (int i = 0; i < 2; i++) {
        f32x4 *x = i == 0 ? same : fixed;
        f32x4 before[POINTS];
        Stretch stretch;
        memcpy(before, x, sizeof(before));
        open_stretch(&stretch, x, 1.0f, 0.0f);
        percale_solve_stretch(&stretch.arrays, 0, 1);
        ck_assert_mem_eq(before, x, sizeof(before));
    }
}
END_TEST

// ---- seam ----

START_TEST(seam_closes_to_its_target_and_no_further)
{
    uint64_t seed = 3;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x4 x[POINTS];
        f32x4 before[POINTS];
        Vec3 points[POINTS];
        Vec3 gradient[POINTS];
        random_points(&seed, x);
        memcpy(before, x, sizeof(before));
        load_points(x, points);
        PercaleOpenSeam seam = {.slots = {0, 1}};
        PercaleModel model = {.open_seam_count = 1, .open_seams = &seam};
        float target = random_float(&seed, 0.0, 2.0);
        PercaleSolveArrays arrays = {.model = &model, .x = x, .start = x, .dt = DT, .seam_targets = &target};
        double gap = (double)target;
        differentiate(edge_stretch, &gap, points, 1e-4, gradient);
        double excess = fmax(edge_stretch(points, &gap), 0.0);
        percale_solve_seam(&arrays, 0, 1);
        double stiffness = mobility(before, gradient);
        expect_moved_along((const f32x4 *)before, (const f32x4 *)x, (const Vec3 *)gradient,
                           stiffness > 0.0 ? -excess / stiffness : 0.0);
    }
}
END_TEST

// ---- bending ----

static const float RIGIDITY = 2e-3f; // N m; so stiff that the movement is well above float32's grain

/// Two triangles 0 1 2 and 1 0 3 with a common edge, flat at rest.
typedef struct Hinge {
    Vec3 rest[POINTS];
    double rigidity; // N m
} Hinge;

/// Cotangent of the angle at `corner`.
static double cotangent(Vec3 corner, Vec3 p, Vec3 q)
{
    Vec3 u = vsub(p, corner);
    Vec3 v = vsub(q, corner);
    return vdot(u, v) / vlength(vcross(u, v));
}

/// D / 2 |K x|^2 / (A0 + A1) with Bergou's K from the rest shape, computed from scratch.
static double hinge_energy(const Vec3 x[POINTS], const void *given)
{
    const Hinge *hinge = given;
    const Vec3 *r = hinge->rest;
    double c01 = cotangent(r[0], r[1], r[2]);
    double c02 = cotangent(r[0], r[1], r[3]);
    double c03 = cotangent(r[1], r[0], r[2]);
    double c04 = cotangent(r[1], r[0], r[3]);
    Vec3 k = vscale(c03 + c04, x[0]);
    k = vadd(k, vscale(c01 + c02, x[1]));
    k = vsub(k, vscale(c01 + c03, x[2]));
    k = vsub(k, vscale(c02 + c04, x[3]));
    double areas = 0.5 * (vlength(vcross(vsub(r[1], r[0]), vsub(r[2], r[0]))) +
                          vlength(vcross(vsub(r[1], r[0]), vsub(r[3], r[0]))));
    return 0.5 * hinge->rigidity * vdot(k, k) / areas;
}

static PercaleSolver *new_cloth_solver(const float *positions, uint32_t vertex_count,
                                       const uint32_t *triangles, uint32_t triangle_count)
{
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    PercaleClothDef def = percale_cloth_def_default();
    PercaleCloth cloth;
    def.positions = positions;
    def.vertex_count = vertex_count;
    def.triangles = triangles;
    def.triangle_count = triangle_count;
    def.material.bending_stiffness = RIGIDITY;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    PERCALE_TEST_OK(solver, percale_solver_prepare(solver));
    return solver;
}

static PercaleSolver *new_hinge_solver(uint64_t *seed, Hinge *hinge)
{
    static const uint32_t TRIANGLES[6] = {0, 1, 2, 1, 0, 3};
    float positions[3 * POINTS] = {0.0f};
    positions[3] = random_float(seed, 0.05, 0.2);
    positions[6] = random_float(seed, -0.05, 0.2);
    positions[7] = random_float(seed, 0.05, 0.2);
    positions[9] = random_float(seed, -0.05, 0.2);
    positions[10] = random_float(seed, -0.2, -0.05);
    for (int k = 0; k < POINTS; k++) {
        hinge->rest[k] = vec3((double)positions[3 * k], (double)positions[3 * k + 1], 0.0);
    }
    hinge->rigidity = (double)RIGIDITY;
    return new_cloth_solver(positions, POINTS, TRIANGLES, 2);
}

// One projection of the linear constraint is the exact implicit step: mass times movement is dt^2 times the
// force at its end.
START_TEST(bending_force_is_the_gradient_of_its_energy)
{
    uint64_t seed = 4;
    for (int trial = 0; trial < TRIALS / 3; trial++) {
        Hinge hinge;
        PercaleSolver *solver = new_hinge_solver(&seed, &hinge);
        PercaleModel *model = &solver->model;
        ck_assert_uint_eq(model->hinge_count, 1);
        f32x4 x[POINTS]; // by slot
        f32x4 before[POINTS];
        f32x4 after[POINTS]; // by vertex
        f32x4 multiplier = {0};
        const uint32_t *slots = model->cloths[0].slots;
        for (int k = 0; k < POINTS; k++) {
            float mass = trial % 5 == 0 && k == 1 ? 0.0f : model->position[slots[k]][3];
            f32x4 bent = f32x4_of(hinge.rest[k], mass);
            for (int axis = 0; axis < 3; axis++) {
                bent[axis] += random_float(&seed, -0.05, 0.05);
            }
            before[k] = x[slots[k]] = bent;
            model->position[slots[k]][3] = mass;
        }
        f32x4 weights;
        float relaxation;
        percale_solve_bend_prepare(model, 4.0f * DT, 1, &weights, &relaxation);
        PercaleSolveArrays arrays = {.model = model,
                                     .x = x,
                                     .start = x,
                                     .dt = 4.0f * DT,
                                     .bend_weights = &weights,
                                     .bend_relaxations = &relaxation,
                                     .hinge_multipliers = &multiplier};
        for (int sweep = 0; sweep < 1 + trial % 3; sweep++) { // the first sweep is final
            percale_solve_bend(&arrays, 0, 1);
        }
        Vec3 points[POINTS];
        Vec3 gradient[POINTS];
        for (int k = 0; k < POINTS; k++) {
            after[k] = x[slots[k]];
        }
        load_points(after, points);
        differentiate(hinge_energy, &hinge, points, 1e-4, gradient);
        expect_moved_along((const f32x4 *)before, (const f32x4 *)after, (const Vec3 *)gradient,
                           -16.0 * (double)DT * (double)DT);
        percale_solver_destroy(solver);
    }
}
END_TEST

enum { GRID = 24 }; // vertices along a side

typedef enum Grid { RIGHT_TRIANGLES, EQUILATERAL } Grid;

/// A flat sheet in the plane y = 0, 1 cm a cell.
static PercaleSolver *new_grid_solver(Grid grid, float positions[3 * GRID * GRID])
{
    PercaleMesh sheet = percale_test_sheet(GRID, 0.01f * (GRID - 1));
    for (uint32_t i = 0; i < GRID * GRID && grid == EQUILATERAL; i++) {
        float *x = sheet.positions + 3 * (size_t)i;
        x[0] += 0.5f * x[2]; // the diagonal becomes as long as the sides
        x[2] *= 0.8660254f;
    }
    memcpy(positions, sheet.positions, 3 * (size_t)(GRID * GRID) * sizeof(float));
    PercaleSolver *solver =
        new_cloth_solver(sheet.positions, sheet.vertex_count, sheet.triangles, sheet.triangle_count);
    percale_mesh_free(&sheet);
    return solver;
}

/// The energy that the solver's hinges hold, per rest area of the cloth around them, when the sheet is rolled
/// to a cylinder of this radius, `angle` between the x axis and the direction of the bend; over D / (2 R^2).
static double cylinder_energy(Grid grid, double radius, double angle)
{
    static float rest[3 * GRID * GRID];
    PercaleSolver *solver = new_grid_solver(grid, rest);
    const PercaleModel *model = &solver->model;
    Vec3 *bent = calloc(model->slot_count, sizeof(Vec3));
    ck_assert_ptr_nonnull(bent);
    for (uint32_t i = 0; i < GRID * GRID; i++) {
        double x = (double)rest[3 * i];
        double z = (double)rest[3 * i + 2];
        double along = cos(angle) * x + sin(angle) * z;
        double across = cos(angle) * z - sin(angle) * x;
        bent[model->cloths[0].slots[i]] =
            vec3(radius * sin(along / radius), radius * cos(along / radius), across);
    }
    double energy = 0.0;
    for (uint32_t h = 0; h < model->hinge_count; h++) {
        Vec3 k = {0.0, 0.0, 0.0};
        for (int i = 0; i < POINTS; i++) {
            k = vadd(k, vscale((double)model->hinge_weights[h][i], bent[slot_at(model->hinges[h][i])]));
        }
        energy += 0.5 * (double)model->hinge_stiffnesses[h] * vdot(k, k);
    }
    // Of a cell's three edges each belongs to one kind; GRID - 1 or GRID - 2 of a row's are inner ones, so
    // the area is that of the mean number of cells.
    double cell = grid == EQUILATERAL ? 0.8660254 * 1e-4 : 1e-4;
    double area = cell * (double)model->hinge_count / 3.0;
    free(bent);
    percale_solver_destroy(solver);
    return energy / area / (0.5 * (double)RIGIDITY / (radius * radius));
}

static const double PI = 3.14159265358979323846;

// With the factor 3 of the paper's equation these would all be 3.
START_TEST(a_cylinder_holds_the_energy_of_a_plate)
{
    static const double RADII[] = {0.05, 0.2, 0.8}; // m, of a sheet of 0.23 m
    for (int i = 0; i < 3; i++) {
        ck_assert_double_eq_tol(cylinder_energy(RIGHT_TRIANGLES, RADII[i], 0.0), 1.0, 0.05);
        ck_assert_double_eq_tol(cylinder_energy(RIGHT_TRIANGLES, RADII[i], 0.5 * PI), 1.0, 0.05);
        for (int direction = 0; direction < 12; direction++) {
            double angle = PI / 12.0 * direction;
            ck_assert_double_eq_tol(cylinder_energy(EQUILATERAL, RADII[i], angle), 1.0, 0.05);
        }
    }
}
END_TEST

// Right triangles with all diagonals alike are not isotropic: MATH.md, section 5.
START_TEST(right_triangles_are_as_stiff_as_derived)
{
    for (int direction = 0; direction < 12; direction++) {
        double angle = PI / 12.0 * direction;
        double s = sin(2.0 * angle);
        double expected = 1.0 + s * s - s; // the diagonals run along x = -z
        ck_assert_double_eq_tol(cylinder_energy(RIGHT_TRIANGLES, 0.3, angle), expected, 0.08);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("gradients");
    TCase *inner = tcase_create("inner forces");
    tcase_add_test(inner, stretch_moves_along_its_gradient);
    tcase_add_test(inner, stretch_ends_at_the_force_of_its_energy);
    tcase_add_test(inner, stretch_without_direction_or_mobility_does_nothing);
    tcase_add_test(inner, seam_closes_to_its_target_and_no_further);
    tcase_add_test(inner, bending_force_is_the_gradient_of_its_energy);
    tcase_add_test(inner, a_cylinder_holds_the_energy_of_a_plate);
    tcase_add_test(inner, right_triangles_are_as_stiff_as_derived);
    suite_add_tcase(suite, inner);
    return percale_test_run(suite);
}
