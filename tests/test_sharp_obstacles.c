// Cloth on sharp things, ten times coarser and ten times finer than they are: nothing goes in, nothing comes
// through.

#include "color/coloring.h"
#include "testing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0;    // s
static const float THICKNESS = 0.002f;     // m
static const float LONG = 0.1f;            // m; edge of the coarser of the two
static const double PENETRATION_MAX = 1.0; // mm

// ---- sharp things ----

/// The vertex at this point: found, or made.
static uint32_t vertex_at(PercaleMesh *mesh, const double point[3])
{
    const double SAME = 1e-6; // m
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const float *x = mesh->positions + 3 * (size_t)i;
        double away = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            away = fmax(away, fabs((double)x[axis] - point[axis]));
        }
        if (away < SAME) {
            return i;
        }
    }
    for (int axis = 0; axis < 3; axis++) {
        mesh->positions[3 * (size_t)mesh->vertex_count + (size_t)axis] = (float)point[axis];
    }
    return mesh->vertex_count++;
}

/// A triangle that is being cut.
typedef struct Cut {
    PercaleMesh *fine;
    const PercaleMesh *mesh;
    const uint32_t *corners;
    uint32_t parts;
} Cut;

/// The vertex `i` parts along the triangle's first side and `k` along its second.
static uint32_t lattice_vertex(const Cut *cut, uint32_t i, uint32_t k)
{
    double parts = (double)cut->parts;
    double b[3] = {(double)(cut->parts - i - k) / parts, (double)i / parts, (double)k / parts};
    double point[3] = {0.0, 0.0, 0.0};
    for (int c = 0; c < 3; c++) {
        for (int axis = 0; axis < 3; axis++) {
            point[axis] += b[c] * (double)cut->mesh->positions[3 * (size_t)cut->corners[c] + (size_t)axis];
        }
    }
    return vertex_at(cut->fine, point);
}

/// The one or two small triangles at a place of the lattice; returns how many corners were written.
static size_t cut_cell(const Cut *cut, uint32_t i, uint32_t k, uint32_t *corner)
{
    uint32_t right = lattice_vertex(cut, i + 1, k);
    uint32_t left = lattice_vertex(cut, i, k + 1);
    corner[0] = lattice_vertex(cut, i, k);
    corner[1] = right;
    corner[2] = left;
    if (i + k + 1 == cut->parts) {
        return 3;
    }
    corner[3] = right;
    corner[4] = lattice_vertex(cut, i + 1, k + 1);
    corner[5] = left;
    return 6;
}

/// The same surface with every edge cut into `parts`. Frees the old one.
static void refine(PercaleMesh *mesh, uint32_t parts)
{
    size_t count = (size_t)mesh->triangle_count * parts * parts;
    PercaleMesh fine = {.triangle_count = (uint32_t)count};
    fine.positions = calloc(9 * count, sizeof(float));
    fine.triangles = calloc(3 * count, sizeof(uint32_t));
    ck_assert(fine.positions != NULL && fine.triangles != NULL);
    uint32_t *corner = fine.triangles;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        Cut cut = {&fine, mesh, mesh->triangles + 3 * (size_t)t, parts};
        for (uint32_t i = 0; i < parts; i++) {
            for (uint32_t k = 0; i + k < parts; k++) {
                corner += cut_cell(&cut, i, k, corner);
            }
        }
    }
    percale_mesh_free(mesh);
    *mesh = fine;
}

/// Turns the mesh about z, then about x, in degrees.
static void turn(PercaleMesh *mesh, double about_z, double about_x)
{
    const double DEGREE = 3.14159265358979323846 / 180.0;
    double c[2] = {cos(DEGREE * about_z), cos(DEGREE * about_x)};
    double s[2] = {sin(DEGREE * about_z), sin(DEGREE * about_x)};
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *p = mesh->positions + 3 * i;
        double x = (double)p[0];
        double y = (double)p[1];
        double z = (double)p[2];
        double up = s[0] * x + c[0] * y;
        p[0] = (float)(c[0] * x - s[0] * y);
        p[1] = (float)(c[1] * up - s[1] * z);
        p[2] = (float)(s[1] * up + c[1] * z);
    }
}

typedef enum Shape { RIDGE, CORNER, SPIKE, SHAPE_COUNT } Shape;

static const char *const NAMES[SHAPE_COUNT] = {"ridge", "corner", "spike"};

/// A pyramid with four sides, six times as high as it is wide.
static PercaleMesh pyramid(float height)
{
    static const uint32_t PYRAMID_TRIANGLES[6][3] = {{0, 1, 3}, {0, 3, 2}, {0, 4, 1},
                                                     {1, 4, 3}, {3, 4, 2}, {2, 4, 0}};
    PercaleMesh mesh = percale_test_box(height / 6.0f, height, height / 6.0f); // has room for it
    for (uint32_t i = 0; i < 4; i++) {
        float *x = mesh.positions + 3 * (size_t)i;
        x[0] = (i & 1) != 0 ? height / 12.0f : -height / 12.0f;
        x[1] = -0.5f * height;
        x[2] = (i & 2) != 0 ? height / 12.0f : -height / 12.0f;
    }
    const float tip[3] = {0.0f, 0.5f * height, 0.0f};
    memcpy(mesh.positions + 3 * 4, tip, sizeof(tip));
    memcpy(mesh.triangles, PYRAMID_TRIANGLES, sizeof(PYRAMID_TRIANGLES));
    mesh.vertex_count = 5;
    mesh.triangle_count = 6;
    return mesh;
}

/// Its highest point at y = 0; `size` is the length of its edges.
static PercaleMesh sharp_thing(Shape shape, float size)
{
    PercaleMesh mesh = shape == SPIKE ? pyramid(size) : percale_test_box(size, size, size);
    if (shape != SPIKE) {
        const double UPRIGHT = 54.735610317245346; // degrees; a cube's diagonal and its edge
        turn(&mesh, 45.0, shape == CORNER ? 90.0 - UPRIGHT : 0.0);
    }
    float top = -INFINITY;
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        top = fmaxf(top, mesh.positions[3 * i + 1]);
    }
    percale_test_translate(&mesh, 0.0f, -top, 0.0f);
    return mesh;
}

// ---- a sheet falls on it ----

typedef struct Drop {
    Shape shape;
    bool coarse; // the cloth, against the thing
    int substeps;
} Drop;

/// Thing and sheet; neither vertices nor edges are in line.
static PercaleSolver *set_up(const Drop *drop, PercaleMesh *thing, PercaleMesh *sheet)
{
    enum { PARTS = 10, COARSE_SIDE = 7, FINE_SIDE = 21 };
    const float ABOVE = 0.02f; // m
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = drop->substeps;
    def.self_collision = def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    *thing = sharp_thing(drop->shape, drop->coarse ? LONG : 2.0f * LONG);
    if (drop->coarse) {
        refine(thing, PARTS);
    }
    uint32_t side = drop->coarse ? COARSE_SIDE : FINE_SIDE;
    float edge = drop->coarse ? LONG : 2.0f * LONG / (float)PARTS;
    *sheet = percale_test_sheet(side, edge * (float)(side - 1));
    percale_test_translate(sheet, 0.31f * edge, ABOVE, 0.17f * edge);
    PercaleObstacleDef obstacle_def = percale_test_obstacle_def(thing);
    obstacle_def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &obstacle_def, &obstacle));
    PercaleClothDef cloth_def = percale_test_cloth_def(sheet);
    cloth_def.material.thickness = THICKNESS;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    return solver;
}

/// The worst over all frames.
static PercaleQuality drop_sheet(const Drop *drop)
{
    enum { FRAMES = PERCALE_SANITIZED ? 6 : 18 };
    PercaleMesh thing;
    PercaleMesh sheet;
    PercaleSolver *solver = set_up(drop, &thing, &sheet);
    PercaleQuality worst = {0};
    for (int frame = 0; frame < FRAMES; frame++) {
        PercaleQuality now;
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        PERCALE_TEST_OK(solver, percale_solver_quality(solver, &now));
        worst.penetration_max_mm = fmax(worst.penetration_max_mm, now.penetration_max_mm);
        worst.penetration_obstacle_mm = fmax(worst.penetration_obstacle_mm, now.penetration_obstacle_mm);
        worst.ef_cloth_obstacle = fmax(worst.ef_cloth_obstacle, now.ef_cloth_obstacle);
        worst.nonfinite += now.nonfinite;
    }
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_gt(counters.stencils_vf + counters.stencils_ee, 0); // they have met
    percale_solver_destroy(solver);
    percale_mesh_free(&thing);
    percale_mesh_free(&sheet);
    return worst;
}

START_TEST(nothing_sharp_goes_through_the_cloth)
{
    const Drop drop = {(Shape)(_i / 4), _i / 2 % 2 == 0, _i % 2 == 0 ? 20 : 80};
    PercaleQuality worst = drop_sheet(&drop);
    char text[200];
    (void)snprintf(text, sizeof(text),
                   "%s, %s cloth, %d substeps: vertices %g mm, the thing %g mm, %g crossings",
                   NAMES[drop.shape], drop.coarse ? "coarse" : "fine", drop.substeps,
                   worst.penetration_max_mm, worst.penetration_obstacle_mm, worst.ef_cloth_obstacle);
    ck_assert_msg(worst.penetration_max_mm <= PENETRATION_MAX, "%s", text);
    ck_assert_msg(worst.penetration_obstacle_mm <= PENETRATION_MAX, "%s", text);
    ck_assert_msg(worst.ef_cloth_obstacle <= 0.0, "%s", text);
    ck_assert_msg(worst.nonfinite <= 0.0, "%s", text);
}
END_TEST

// ---- a fold on a tip ----

/// Two triangles that hang from their common edge's ends like a roof turned over: that edge is the lowest,
/// and right above the tip.
static PercaleMesh trough(float height)
{
    const float DEPTH = 0.02f; // m
    PercaleMesh mesh = percale_test_sheet(2, LONG);
    mesh.positions[3 * 1 + 1] -= DEPTH; // the two ends of the diagonal
    mesh.positions[3 * 2 + 1] -= DEPTH;
    percale_test_translate(&mesh, 0.0f, DEPTH + height, 0.0f);
    return mesh;
}

/// The tip is in the region of the edge alone, not above one of the faces.
START_TEST(a_tip_holds_an_edge_of_the_cloth_at_its_thickness)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh thing = sharp_thing(CORNER, LONG);
    PercaleMesh sheet = trough(1.5f * THICKNESS);
    PercaleObstacleDef obstacle_def = percale_test_obstacle_def(&thing);
    obstacle_def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &obstacle_def, &obstacle));
    PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
    cloth_def.material.thickness = THICKNESS;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    float x[3 * 4];
    for (int frame = 0; frame < 4; frame++) { // before it tips over
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
        float above = 0.5f * (x[3 * 1 + 1] + x[3 * 2 + 1]);
        ck_assert_double_ge((double)above, 0.99 * (double)THICKNESS);
    }
    ck_assert_double_le(0.5 * (double)(x[3 * 1 + 1] + x[3 * 2 + 1]), 1.01 * (double)THICKNESS);
    percale_solver_destroy(solver);
    percale_mesh_free(&thing);
    percale_mesh_free(&sheet);
}
END_TEST

// ---- a bed of nails ----

enum { NAIL_VERTICES = 5, NAIL_TRIANGLES = 6 };

/// A square of pyramids, as one obstacle, their tips at y = 0.
static PercaleMesh bed_of_nails(uint32_t side, float width)
{
    const float HEIGHT = 0.02f; // m
    PercaleMesh nail = pyramid(HEIGHT);
    PercaleMesh bed = percale_test_sheet(3 * side, width); // has room for them
    bed.vertex_count = NAIL_VERTICES * side * side;
    bed.triangle_count = NAIL_TRIANGLES * side * side;
    for (uint32_t i = 0; i < bed.vertex_count; i++) {
        uint32_t row = i / NAIL_VERTICES / side;
        uint32_t column = i / NAIL_VERTICES % side;
        const float *from = nail.positions + 3 * (size_t)(i % NAIL_VERTICES);
        float step = width / (float)side;
        float *to = bed.positions + 3 * (size_t)i;
        to[0] = from[0] + step * ((float)column + 0.5f) - 0.5f * width;
        to[1] = from[1] - 0.5f * HEIGHT;
        to[2] = from[2] + step * ((float)row + 0.5f) - 0.5f * width;
    }
    for (uint32_t i = 0; i < 3 * bed.triangle_count; i++) {
        bed.triangles[i] =
            nail.triangles[i % (3 * NAIL_TRIANGLES)] + NAIL_VERTICES * (i / (3 * NAIL_TRIANGLES));
    }
    percale_mesh_free(&nail);
    return bed;
}

/// Nails to a side; with the larger bed each triangle lies on 72, and all of them need a colour each: more
/// than a round of the coloring has.
static const uint32_t BEDS[] = {6, 12};

START_TEST(two_triangles_lie_on_many_nails)
{
    const double SLACK = 0.05; // of the thickness
    PercaleSolverDef def = percale_solver_def_default();
    def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh bed = bed_of_nails(BEDS[_i], LONG);
    PercaleMesh sheet = percale_test_sheet(2, 1.1f * LONG);
    percale_test_translate(&sheet, 0.0f, 1.5f * THICKNESS, 0.0f);
    PercaleObstacleDef obstacle_def = percale_test_obstacle_def(&bed);
    obstacle_def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &obstacle_def, &obstacle));
    PercaleClothDef cloth_def = percale_test_cloth_def(&sheet);
    cloth_def.material.thickness = THICKNESS;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth_def, &cloth));
    for (int frame = 0; frame < 10; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    float x[3 * 4];
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
    for (int i = 0; i < 4; i++) {
        ck_assert_double_eq_tol((double)x[3 * i + 1], (double)THICKNESS, SLACK * (double)THICKNESS);
    }
    PercaleCounters counters = percale_solver_counters(solver);
    uint32_t nails = BEDS[_i] * BEDS[_i];
    ck_assert_uint_ge(counters.colors_max, nails);
    ck_assert_uint_eq(counters.overflow, 0);
    percale_solver_destroy(solver);
    percale_mesh_free(&bed);
    percale_mesh_free(&sheet);
}
END_TEST

/// Edges of the cloth and of the ground get nothing to do where vertices and faces keep them apart.
START_TEST(edges_wait_while_vertices_and_faces_keep_them_apart)
{
    enum { SIDE = 17 };
    PercaleSolverDef def = percale_solver_def_default();
    def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh ground = percale_test_sheet(9, 1.0f);
    PercaleObstacleDef below = percale_test_obstacle_def(&ground);
    below.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &below, &obstacle));
    PercaleMesh sheet = percale_test_sheet(SIDE, 0.5f);
    percale_test_translate(&sheet, 0.011f, THICKNESS, 0.007f);
    PercaleClothDef cloth = percale_test_cloth_def(&sheet);
    float velocities[3 * SIDE * SIDE] = {0.0f};
    for (size_t i = 0; i < sheet.vertex_count; i++) {
        velocities[3 * i] = 0.3f; // m/s; it slides
    }
    cloth.velocities = velocities;
    cloth.material.thickness = THICKNESS;
    PercaleCloth added;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, &added));
    for (int frame = 0; frame < 20; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_gt(counters.stencils_vf, 1000);
    ck_assert_uint_eq(counters.stencils_ee, 0);
    percale_solver_destroy(solver);
    percale_mesh_free(&ground);
    percale_mesh_free(&sheet);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("sharp_obstacles");
    TCase *sharp = tcase_create("sharp");
    tcase_set_tags(sharp, PERCALE_ONE_THREAD);
    tcase_set_timeout(sharp, 0);
    tcase_add_loop_test(sharp, nothing_sharp_goes_through_the_cloth, 0, 4 * SHAPE_COUNT);
    tcase_add_loop_test(sharp, two_triangles_lie_on_many_nails, 0, 2);
    tcase_add_test(sharp, edges_wait_while_vertices_and_faces_keep_them_apart);
    tcase_add_test(sharp, a_tip_holds_an_edge_of_the_cloth_at_its_thickness);
    suite_add_tcase(suite, sharp);
    return percale_test_run(suite);
}
