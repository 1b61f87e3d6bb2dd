// Cloth that meets cloth, and edges and spikes: laws of its contact.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s

static PercaleSolverDef def_of(int substeps, bool edges)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = substeps;
    def.self_collision = 1;
    def.edge_edge = edges;
    def.damping = 0.0f;
    return def;
}

static void run(PercaleSolver *solver, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
}

static PercaleQuality quality_of(PercaleSolver *solver)
{
    PercaleQuality quality;
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    return quality;
}

// ---- cloth on cloth ----

/// A sheet at a height with a level speed downward and friction mu; the sheets of a scene are turned against
/// each other, so that no vertices meet.
static PercaleCloth add_sheet(PercaleSolver *solver, PercaleMesh *mesh, float height, float speed, float turn,
                              float friction)
{
    *mesh = percale_test_sheet(17, 0.2f);
    float *velocities = calloc(3 * (size_t)mesh->vertex_count, sizeof(float));
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *x = mesh->positions + 3 * i;
        float turned[2] = {cosf(turn) * x[0] - sinf(turn) * x[2], sinf(turn) * x[0] + cosf(turn) * x[2]};
        x[0] = turned[0];
        x[2] = turned[1];
        velocities[3 * i + 1] = speed;
    }
    percale_test_translate(mesh, 0.0f, height, 0.0f);
    PercaleClothDef def = percale_test_cloth_def(mesh);
    def.velocities = velocities;
    def.material.friction = friction;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    free(velocities);
    return cloth;
}

/// Lowest and highest y of a cloth.
static void heights(PercaleSolver *solver, PercaleCloth cloth, uint32_t count, float range[2])
{
    float *x = malloc(3 * sizeof(float) * count);
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
    range[0] = INFINITY;
    range[1] = -INFINITY;
    for (size_t i = 0; i < count; i++) {
        range[0] = fminf(range[0], x[3 * i + 1]);
        range[1] = fmaxf(range[1], x[3 * i + 1]);
    }
    free(x);
}

/// Two sheets meet in the air, 2 m/s each; whichever comes from above stays above, whatever its winding.
START_TEST(a_sheet_stays_on_the_side_that_it_came_from)
{
    for (int turned = 0; turned < 2; turned++) {
        PercaleSolverDef def = def_of(20, true);
        def.gravity[1] = 0.0f;
        PercaleSolver *solver = percale_test_solver(def);
        PercaleMesh meshes[2];
        float sign = turned ? -1.0f : 1.0f;
        PercaleCloth first = add_sheet(solver, &meshes[0], sign * 0.05f, sign * -2.0f, 0.0f, 0.0f);
        PercaleCloth second = add_sheet(solver, &meshes[1], sign * -0.05f, sign * 2.0f, 0.3f, 0.0f);
        float ranges[2][2];
        for (int frame = 0; frame < 20; frame++) {
            run(solver, 1);
            PercaleQuality quality = quality_of(solver);
            ck_assert(quality.ef_cloth_cloth <= 0.0);
            ck_assert(quality.nonfinite <= 0.0);
        }
        heights(solver, first, meshes[0].vertex_count, ranges[0]);
        heights(solver, second, meshes[1].vertex_count, ranges[1]);
        const float *above = ranges[turned ? 1 : 0];
        const float *below = ranges[turned ? 0 : 1];
        ck_assert_msg(above[0] > below[1], "%d: %g is not above %g", turned, (double)above[0],
                      (double)below[1]);
        percale_solver_destroy(solver);
        percale_mesh_free(&meshes[0]);
        percale_mesh_free(&meshes[1]);
    }
}
END_TEST

/// Without it they pass through each other: the test above can fail.
START_TEST(without_self_collision_the_sheets_change_sides)
{
    PercaleSolverDef def = def_of(20, true);
    def.gravity[1] = 0.0f;
    def.self_collision = 0;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh meshes[2];
    PercaleCloth first = add_sheet(solver, &meshes[0], 0.05f, -2.0f, 0.0f, 0.0f);
    (void)add_sheet(solver, &meshes[1], -0.05f, 2.0f, 0.3f, 0.0f);
    float range[2];
    run(solver, 20);
    heights(solver, first, meshes[0].vertex_count, range);
    ck_assert(range[1] < -0.05f);
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_eq(counters.candidates, 0);
    ck_assert_uint_eq(counters.projections_contact, 0);
    percale_solver_destroy(solver);
    percale_mesh_free(&meshes[0]);
    percale_mesh_free(&meshes[1]);
}
END_TEST

// ---- coarse cloth on sharp things ----

/// A pyramid with its tip up, narrower than a triangle of the cloth.
static PercaleMesh spike(void)
{
    PercaleMesh mesh = percale_test_box(0.04f, 0.2f, 0.04f);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        if (mesh.positions[3 * i + 1] > 0.0f) {
            mesh.positions[3 * i] *= 0.05f;
            mesh.positions[3 * i + 2] *= 0.05f;
        }
    }
    return mesh;
}

/// A level sheet of 6 x 6 vertices, its middle triangle above the tip, falls onto it.
static double deepest_in_spike(bool edges)
{
    PercaleSolverDef def = def_of(20, edges);
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh tip = spike();
    PercaleMesh sheet = percale_test_sheet(6, 0.5f);
    (void)percale_test_add_obstacle(solver, &tip);
    percale_test_translate(&sheet, 0.013f, 0.12f, 0.021f);
    (void)percale_test_add_cloth(solver, &sheet);
    double deepest = 0.0;
    for (int frame = 0; frame < 15; frame++) {
        run(solver, 1);
        deepest = fmax(deepest, quality_of(solver).penetration_obstacle_mm);
    }
    percale_solver_destroy(solver);
    percale_mesh_free(&tip);
    percale_mesh_free(&sheet);
    return deepest;
}

START_TEST(a_spike_does_not_pierce_a_coarse_cloth)
{
    ck_assert_double_gt(deepest_in_spike(false), 2.0);
    ck_assert_double_le(deepest_in_spike(true), 1.0);
}
END_TEST

// ---- the same bits ----

START_TEST(one_hash_for_any_number_of_threads)
{
    const int THREADS[] = {1, 2, 3, 7};
    uint64_t hashes[4];
    for (int t = 0; t < 4; t++) {
        PercaleSolverDef def = def_of(10, true);
        def.thread_count = THREADS[t];
        PercaleSolver *solver = percale_test_solver(def);
        PercaleMesh body = percale_test_sphere(2, 0.08f);
        PercaleMesh sheet = percale_test_sheet(33, 0.4f);
        (void)percale_test_add_obstacle(solver, &body);
        percale_test_translate(&sheet, 0.01f, 0.1f, 0.0f);
        (void)percale_test_add_cloth(solver, &sheet);
        run(solver, PERCALE_SANITIZED ? 5 : 20);
        hashes[t] = percale_solver_hash(solver);
        ck_assert_uint_eq(hashes[t], hashes[0]);
        percale_solver_destroy(solver);
        percale_mesh_free(&body);
        percale_mesh_free(&sheet);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("cloth_contact");
    TCase *contact = tcase_create("contact");
    tcase_set_timeout(contact, 0);
    tcase_add_test(contact, a_sheet_stays_on_the_side_that_it_came_from);
    tcase_add_test(contact, without_self_collision_the_sheets_change_sides);
    tcase_add_test(contact, a_spike_does_not_pierce_a_coarse_cloth);
    tcase_add_test(contact, one_hash_for_any_number_of_threads);
    suite_add_tcase(suite, contact);
    return percale_test_run(suite);
}
