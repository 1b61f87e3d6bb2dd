#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void percale_test_expect(const PercaleSolver *solver, PercaleResult result, const char *call,
                         const char *file, int line)
{
    if (result != PERCALE_OK) {
        ck_abort_msg("%s:%d: %s: %s (%s)", file, line, call, percale_result_string(result),
                     solver ? percale_solver_last_error(solver) : "no solver");
    }
}

int percale_test_run(Suite *suite)
{
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_ENV);
    const int failed_count = srunner_ntests_failed(runner);
    const int run_count = srunner_ntests_run(runner);
    srunner_free(runner);
    const bool may_be_none = getenv("CK_EXCLUDE_TAGS") != NULL; // NOLINT(concurrency-mt-unsafe): one thread
    return failed_count == 0 && (run_count > 0 || may_be_none) ? EXIT_SUCCESS : EXIT_FAILURE;
}

// xorshift64*: Vigna 2016, "An experimental exploration of Marsaglia's xorshift generators, scrambled".
double percale_test_random(uint64_t *state)
{
    uint64_t x = *state;
    if (x == 0) { // an assertion writes a message when it passes, too: too slow here
        ck_abort_msg("percale_test_random needs a seed other than 0");
    }
    x ^= x >> 12;
    x ^= x << 25;
    x ^= x >> 27;
    *state = x;
    return (double)((x * UINT64_C(0x2545F4914F6CDD1D)) >> 11) * 0x1p-53;
}

// ---- meshes ----

static PercaleMesh make_mesh(const char *name, uint32_t vertex_count, uint32_t triangle_count)
{
    PercaleMesh mesh = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    mesh.name = calloc(strlen(name) + 1, 1);
    mesh.positions = calloc((size_t)vertex_count * 3, sizeof mesh.positions[0]);
    mesh.triangles = calloc((size_t)triangle_count * 3, sizeof mesh.triangles[0]);
    if (!mesh.name || !mesh.positions || !mesh.triangles)
        ck_abort_msg("no memory for the mesh of a test");
    memcpy(mesh.name, name, strlen(name));
    return mesh;
}

PercaleMesh percale_test_sheet(uint32_t side_count, float width)
{
    const uint32_t cell_count = side_count - 1;
    PercaleMesh mesh = make_mesh("sheet", side_count * side_count, 2 * cell_count * cell_count);
    const float step = width / (float)cell_count;
    for (uint32_t row = 0; row < side_count; row++) {
        for (uint32_t column = 0; column < side_count; column++) {
            float *point = &mesh.positions[(size_t)3 * (row * side_count + column)];
            point[0] = step * (float)column - 0.5f * width;
            point[2] = step * (float)row - 0.5f * width;
        }
    }
    uint32_t *corner = mesh.triangles;
    for (uint32_t row = 0; row < cell_count; row++) {
        for (uint32_t column = 0; column < cell_count; column++) {
            const uint32_t first = row * side_count + column;
            const uint32_t below = first + side_count;
            const uint32_t cell[6] = {first, below, first + 1, first + 1, below, below + 1};
            memcpy(corner, cell, sizeof cell);
            corner += 6;
        }
    }
    return mesh;
}

PercaleMesh percale_test_box(float width_x, float width_y, float width_z)
{
    // Vertex i stands at the low (0) or high (1) end of x, y, z by its bits 0, 1, 2.
    static const uint32_t BOX_TRIANGLES[12][3] = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5},
                                                  {0, 1, 5}, {0, 5, 4}, {2, 6, 7}, {2, 7, 3},
                                                  {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    PercaleMesh mesh = make_mesh("box", 8, 12);
    const float width[3] = {width_x, width_y, width_z};
    for (uint32_t i = 0; i < 8; i++) {
        for (uint32_t axis = 0; axis < 3; axis++)
            mesh.positions[3 * i + axis] = width[axis] * ((i >> axis & 1) ? 0.5f : -0.5f);
    }
    memcpy(mesh.triangles, BOX_TRIANGLES, sizeof BOX_TRIANGLES);
    return mesh;
}

static void place_on_sphere(float point[3], const double direction[3], float radius)
{
    const double length =
        sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    for (int axis = 0; axis < 3; axis++)
        point[axis] = (float)(direction[axis] / length * (double)radius);
}

static PercaleMesh make_icosahedron(float radius)
{
    static const uint32_t ICOSAHEDRON_TRIANGLES[20][3] = {
        {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
        {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
        {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
    static const double GOLDEN = 1.6180339887498949; // (1 + sqrt 5) / 2
    PercaleMesh mesh = make_mesh("sphere", 12, 20);
    for (uint32_t i = 0; i < 12; i++) {
        // Three golden rectangles, one per pair of axes; the order is the one that the triangles above
        // expect.
        const uint32_t axis = i / 4;
        const double small = (i & 1) ? 1.0 : -1.0;
        const double large = (i & 2) ? -GOLDEN : GOLDEN;
        double direction[3] = {0.0, 0.0, 0.0};
        direction[axis] = small;
        direction[(axis + 1) % 3] = large;
        place_on_sphere(&mesh.positions[(size_t)3 * i], direction, radius);
    }
    memcpy(mesh.triangles, ICOSAHEDRON_TRIANGLES, sizeof ICOSAHEDRON_TRIANGLES);
    return mesh;
}

/// The vertex amid the edge a b: found among those already made, whose ends are in `parents`, or made.
static uint32_t split_edge(PercaleMesh *mesh, uint32_t (*parents)[2], uint32_t old_count, float radius,
                           uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b;
    const uint32_t high = a < b ? b : a;
    for (uint32_t i = old_count; i < mesh->vertex_count; i++) {
        if (parents[i - old_count][0] == low && parents[i - old_count][1] == high)
            return i;
    }
    const uint32_t made = mesh->vertex_count++;
    parents[made - old_count][0] = low;
    parents[made - old_count][1] = high;
    double middle[3];
    for (size_t axis = 0; axis < 3; axis++)
        middle[axis] = (double)mesh->positions[3 * (size_t)low + axis] +
                       (double)mesh->positions[3 * (size_t)high + axis];
    place_on_sphere(&mesh->positions[(size_t)3 * made], middle, radius);
    return made;
}

static PercaleMesh split_triangles(const PercaleMesh *coarse, float radius)
{
    const uint32_t edge_count = coarse->triangle_count / 2 * 3;
    PercaleMesh fine = make_mesh(coarse->name, coarse->vertex_count + edge_count, 4 * coarse->triangle_count);
    uint32_t(*parents)[2] = calloc(edge_count, sizeof *parents);
    if (!parents)
        ck_abort_msg("no memory for the mesh of a test");
    memcpy(fine.positions, coarse->positions, sizeof(float) * 3 * coarse->vertex_count);
    fine.vertex_count = coarse->vertex_count;
    for (uint32_t t = 0; t < coarse->triangle_count; t++) {
        const uint32_t *corner = &coarse->triangles[(size_t)3 * t];
        uint32_t middle[3];
        for (uint32_t k = 0; k < 3; k++)
            middle[k] =
                split_edge(&fine, parents, coarse->vertex_count, radius, corner[k], corner[(k + 1) % 3]);
        const uint32_t split[4][3] = {{corner[0], middle[0], middle[2]},
                                      {corner[1], middle[1], middle[0]},
                                      {corner[2], middle[2], middle[1]},
                                      {middle[0], middle[1], middle[2]}};
        memcpy(&fine.triangles[(size_t)12 * t], split, sizeof split);
    }
    free(parents);
    return fine;
}

PercaleMesh percale_test_sphere(uint32_t level, float radius)
{
    PercaleMesh mesh = make_icosahedron(radius);
    for (uint32_t i = 0; i < level; i++) {
        PercaleMesh fine = split_triangles(&mesh, radius);
        percale_mesh_free(&mesh);
        mesh = fine;
    }
    return mesh;
}

void percale_test_translate(PercaleMesh *mesh, float x, float y, float z)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        mesh->positions[3 * i] += x;
        mesh->positions[3 * i + 1] += y;
        mesh->positions[3 * i + 2] += z;
    }
}

// ---- scenes ----

PercaleClothDef percale_test_cloth_def(const PercaleMesh *mesh)
{
    PercaleClothDef def = percale_cloth_def_default();
    def.name = mesh->name;
    def.positions = mesh->positions;
    def.vertex_count = mesh->vertex_count;
    def.triangles = mesh->triangles;
    def.triangle_count = mesh->triangle_count;
    return def;
}

PercaleObstacleDef percale_test_obstacle_def(const PercaleMesh *mesh)
{
    PercaleObstacleDef def = percale_obstacle_def_default();
    def.name = mesh->name;
    def.positions = mesh->positions;
    def.vertex_count = mesh->vertex_count;
    def.triangles = mesh->triangles;
    def.triangle_count = mesh->triangle_count;
    return def;
}

PercaleSolver *percale_test_solver(PercaleSolverDef def)
{
    PercaleSolver *solver = NULL;
    PERCALE_TEST_OK(NULL, percale_solver_create(def, &solver));
    return solver;
}

PercaleCloth percale_test_add_cloth(PercaleSolver *solver, const PercaleMesh *mesh)
{
    const PercaleClothDef def = percale_test_cloth_def(mesh);
    PercaleCloth cloth = {0};
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    return cloth;
}

PercaleObstacle percale_test_add_obstacle(PercaleSolver *solver, const PercaleMesh *mesh)
{
    const PercaleObstacleDef def = percale_test_obstacle_def(mesh);
    PercaleObstacle obstacle = {0};
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &def, &obstacle));
    return obstacle;
}
