// What crosses when it is first seen has no side: it is counted, and nothing holds it where it is.

#include "pairs_testing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s

typedef struct Sheets {
    PercaleSolver *solver;
    PercaleMesh meshes[2];
    PercaleCloth cloths[2];
} Sheets;

/// Two sheets of side x side vertices without gravity: the second is turned in its plane, tilted about z and
/// lifted; it moves up or down.
static void open_sheets(Sheets *sheets, uint32_t side, float tilt, float height, float speed, int threads)
{
    const float TURN = 0.3f;
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    def.untangle = 0;
    def.gravity[1] = 0.0f;
    def.thread_count = threads;
    sheets->solver = percale_test_solver(def);
    for (int s = 0; s < 2; s++) {
        sheets->meshes[s] = percale_test_sheet(side, 0.2f);
        float *velocities = calloc(3 * (size_t)sheets->meshes[s].vertex_count, sizeof(float));
        for (size_t i = 0; s == 1 && i < sheets->meshes[s].vertex_count; i++) {
            float *x = sheets->meshes[s].positions + 3 * i;
            float along = cosf(TURN) * x[0] - sinf(TURN) * x[2];
            x[2] = sinf(TURN) * x[0] + cosf(TURN) * x[2] + 0.0017f;
            x[0] = cosf(tilt) * along + 0.003f; // so that no vertex is in the other's plane, none on an edge
            x[1] = sinf(tilt) * along + height;
            velocities[3 * i + 1] = speed;
        }
        PercaleClothDef cloth = percale_test_cloth_def(&sheets->meshes[s]);
        cloth.velocities = velocities;
        PERCALE_TEST_OK(sheets->solver, percale_cloth_add(sheets->solver, &cloth, &sheets->cloths[s]));
        free(velocities);
    }
}

static void close_sheets(Sheets *sheets)
{
    percale_solver_destroy(sheets->solver);
    percale_mesh_free(&sheets->meshes[0]);
    percale_mesh_free(&sheets->meshes[1]);
}

static uint64_t born_after(Sheets *sheets, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(sheets->solver, percale_solver_step(sheets->solver, FRAME));
    }
    return percale_solver_counters(sheets->solver).born_crossed;
}

// ---- counted, once ----

static Vec3 vertex_of(const PercaleMesh *mesh, uint32_t vertex)
{
    const float *x = mesh->positions + 3 * (size_t)vertex;
    return vec3((double)x[0], (double)x[1], (double)x[2]);
}

static double volume(Vec3 a, Vec3 b, Vec3 c, Vec3 d)
{
    return vdot(vsub(d, a), vcross(vsub(b, a), vsub(c, a)));
}

static bool do_cross(Vec3 p, Vec3 q, const Vec3 t[3])
{
    double turns[3] = {volume(p, q, t[0], t[1]), volume(p, q, t[1], t[2]), volume(p, q, t[2], t[0])};
    bool inside = (turns[0] > 0.0 && turns[1] > 0.0 && turns[2] > 0.0) ||
                  (turns[0] < 0.0 && turns[1] < 0.0 && turns[2] < 0.0);
    return inside && volume(t[0], t[1], t[2], p) * volume(t[0], t[1], t[2], q) < 0.0;
}

/// Edges of a that go through faces of b.
static uint64_t count_through(const PercaleMesh *a, const PercaleMesh *b, const PercaleEdges *edges)
{
    uint64_t count = 0;
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        for (uint32_t t = 0; t < b->triangle_count; t++) {
            const uint32_t *corners = b->triangles + 3 * (size_t)t;
            const Vec3 x[3] = {vertex_of(b, corners[0]), vertex_of(b, corners[1]), vertex_of(b, corners[2])};
            count += do_cross(vertex_of(a, edges->vertices[e][0]), vertex_of(a, edges->vertices[e][1]), x);
        }
    }
    return count;
}

static uint64_t count_crossings(const PercaleMesh meshes[2])
{
    PercaleAllocator allocator = percale_allocator_default();
    PercaleMemory memory = {&allocator, 0};
    uint64_t count = 0;
    for (int s = 0; s < 2; s++) {
        PercaleEdges edges;
        ck_assert(percale_edges_build(meshes[s].triangles, meshes[s].triangle_count, &memory, &edges));
        count += count_through(&meshes[s], &meshes[1 - s], &edges);
        percale_edges_free(&edges, &memory);
    }
    return count;
}

START_TEST(edges_and_faces_that_start_crossed_are_counted_once)
{
    enum { FRAMES = PERCALE_SANITIZED ? 1 : 6 };
    const double SHORT = 1e-4; // s; nothing has moved
    const float TILTS[] = {0.1f, 0.5f, 1.3f};
    for (int i = 0; i < 3; i++) {
        Sheets sheets;
        open_sheets(&sheets, 17, TILTS[i], 0.0f, 0.0f, 1);
        uint64_t expected = count_crossings(sheets.meshes);
        ck_assert_uint_gt(expected, 50);
        PERCALE_TEST_OK(sheets.solver, percale_solver_step(sheets.solver, SHORT));
        ck_assert_uint_eq(born_after(&sheets, 0), expected);
        uint64_t later = born_after(&sheets, FRAMES); // the solver loses some pairs around
        ck_assert_msg(later <= expected + expected / 4, "%u, then %u", (unsigned)expected, (unsigned)later);
        close_sheets(&sheets);
    }
}
END_TEST

START_TEST(what_starts_free_is_not_born_crossed)
{
    enum { FRAMES = PERCALE_SANITIZED ? 3 : 20 };
    Sheets sheets;
    open_sheets(&sheets, 17, 0.05f, 0.03f, -2.0f, 1);
    ck_assert_uint_eq(count_crossings(sheets.meshes), 0);
    ck_assert_uint_eq(born_after(&sheets, FRAMES), 0);
    ck_assert(FRAMES < 20 || percale_solver_counters(sheets.solver).projections_contact > 10000);
    close_sheets(&sheets);
}
END_TEST

START_TEST(the_count_is_the_same_for_any_number_of_threads)
{
    const int THREADS[] = {1, 2, 3, 7};
    uint64_t counts[4];
    uint64_t hashes[4];
    for (int t = 0; t < 4; t++) {
        Sheets sheets;
        open_sheets(&sheets, 25, 0.2f, 0.0f, 1.0f, THREADS[t]);
        counts[t] = born_after(&sheets, 1);
        hashes[t] = percale_solver_hash(sheets.solver);
        ck_assert_uint_gt(counts[t], 50);
        ck_assert_uint_eq(counts[t], counts[0]);
        ck_assert_uint_eq(hashes[t], hashes[0]);
        close_sheets(&sheets);
    }
}
END_TEST

// ---- no side ----

/// The sheets cross without touching anything else; they move along each other, out of each other. What is
/// born crossed must not be caught.
START_TEST(what_is_born_crossed_may_come_apart)
{
    enum { FRAMES = 20, SIDE = 9 };
    Sheets sheets;
    open_sheets(&sheets, SIDE, 1.5f, 0.095f, 1.0f, 1); // upright, its lower rim just through the other
    uint64_t born = count_crossings(sheets.meshes);
    ck_assert_uint_gt(born, 10);
    (void)born_after(&sheets, FRAMES);
    PercaleQuality quality;
    PERCALE_TEST_OK(sheets.solver, percale_solver_quality(sheets.solver, &quality));
    ck_assert_msg(quality.ef_cloth_cloth <= 0.0, "%g are still crossed", quality.ef_cloth_cloth);
    float x[3 * SIDE * SIDE];
    PERCALE_TEST_OK(sheets.solver, percale_cloth_get_positions(sheets.solver, sheets.cloths[0], x, 0));
    const float BRUSHED = 0.03f;               // m, in the time in which the other goes 33 cm
    for (size_t i = 0; i < SIDE * SIDE; i++) { // and nothing has been dragged along
        ck_assert_msg(fabsf(x[3 * i + 1]) < BRUSHED, "vertex %zu has moved to %g", i, (double)x[3 * i + 1]);
    }
    close_sheets(&sheets);
}
END_TEST

/// At rest they stay so: what has no side is not thrown to and fro by contact and guard around it.
START_TEST(sheets_that_start_crossed_stay_calm)
{
    enum { FRAMES = PERCALE_SANITIZED ? 4 : 20 };
    const float TILTS[] = {0.1f, 0.5f};
    for (int i = 0; i < 2; i++) {
        Sheets sheets;
        PercaleQuality first;
        PercaleQuality last;
        open_sheets(&sheets, 17, TILTS[i], 0.0f, 0.0f, 1);
        PERCALE_TEST_OK(sheets.solver, percale_solver_quality(sheets.solver, &first));
        (void)born_after(&sheets, FRAMES);
        PERCALE_TEST_OK(sheets.solver, percale_solver_quality(sheets.solver, &last));
        ck_assert_msg(last.ef_cloth_cloth <= 1.2 * first.ef_cloth_cloth, "%g cross, then %g",
                      first.ef_cloth_cloth, last.ef_cloth_cloth);
        ck_assert_msg(last.stretch_max <= 0.05, "stretched by %g", last.stretch_max);
        close_sheets(&sheets);
    }
}
END_TEST

/// A log that keeps the last line.
static void keep_line(void *user, const char *text)
{
    (void)snprintf(user, 256, "%s", text);
}

START_TEST(the_log_says_which_triangles_cross_deepest)
{
    char line[256] = "";
    PercaleSolverDef def = percale_solver_def_default();
    def.log = keep_line;
    def.log_user = line;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh sheet =
        percale_test_sheet(2, 1.0f); // two triangles, of which the first has the corner (-, -)
    PercaleMesh needle = percale_test_sheet(2, 0.01f);
    for (size_t i = 0; i < needle.vertex_count; i++) { // upright, through the first, 2 mm deep with one end
        float *x = needle.positions + 3 * i;
        const float upright[3] = {x[0] - 0.3f, x[2] + 0.003f, -0.3f};
        memcpy(x, upright, sizeof(upright));
    }
    PercaleClothDef cloth = percale_test_cloth_def(&sheet);
    PercaleCloth handle;
    cloth.name = "the sheet";
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, &handle));
    PercaleQuality quality;
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    ck_assert_str_eq(line, "");
    cloth = percale_test_cloth_def(&needle);
    cloth.name = "the needle";
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, &handle));
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    ck_assert_str_eq(line,
                     "2 pairs of triangles cross; deepest, by 2 mm: 0 of the sheet and 0 of the needle");
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    percale_mesh_free(&needle);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("born_crossed");
    TCase *born = tcase_create("born_crossed");
    tcase_set_timeout(born, 0);
    tcase_add_test(born, the_log_says_which_triangles_cross_deepest);
    tcase_add_test(born, edges_and_faces_that_start_crossed_are_counted_once);
    tcase_add_test(born, what_starts_free_is_not_born_crossed);
    tcase_add_test(born, the_count_is_the_same_for_any_number_of_threads);
    tcase_add_test(born, what_is_born_crossed_may_come_apart);
    tcase_add_test(born, sheets_that_start_crossed_stay_calm);
    suite_add_tcase(suite, born);
    return percale_test_run(suite);
}
