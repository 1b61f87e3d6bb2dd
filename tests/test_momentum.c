// Contact between cloth and cloth only exchanges momentum: the law for a crumpling sheet, and what it stands
// on, the weights of each stencil.
//
// `test_momentum --full` throws 10,816 vertices together for 300 steps, which takes many minutes.

#include "solver.h"
#include "testing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double DRIFT_MAX = 3e-4;   // of the sum of m |v| at the start
static const float SPACING = 0.01f;     // m, along an edge

// ---- a sheet that crumples ----

/// Linear momentum of the cloth and the sum of m |v|, kg m/s.
static double momentum_of(PercaleSolver *solver, PercaleCloth cloth, double sum[3])
{
    PercaleClothView view;
    PERCALE_TEST_OK(solver, percale_cloth_view(solver, cloth, &view));
    double size = 0.0;
    sum[0] = sum[1] = sum[2] = 0.0;
    for (uint32_t i = 0; i < view.vertex_count; i++) {
        uint32_t slot = view.order[i];
        const float *v = view.velocities + 4 * (size_t)slot;
        double mass = 1.0 / (double)view.positions[4 * (size_t)slot + 3];
        double square = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            sum[axis] += mass * (double)v[axis];
            square += (double)v[axis] * (double)v[axis];
        }
        size += mass * sqrt(square);
    }
    return size;
}

/// Inwards at 4/s of the distance, and out of the plane at random.
static PercaleCloth add_thrown_sheet(PercaleSolver *solver, PercaleMesh *mesh)
{
    const float INWARDS = -4.0f;    // 1/s
    const double UP_AND_DOWN = 0.4; // m/s; the sheet as a whole moves too
    float *velocities = calloc(3 * (size_t)mesh->vertex_count, sizeof(float));
    ck_assert_ptr_nonnull(velocities);
    uint64_t seed = 5;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        velocities[3 * i] = INWARDS * mesh->positions[3 * i];
        velocities[3 * i + 2] = INWARDS * mesh->positions[3 * i + 2];
        velocities[3 * i + 1] = (float)(percale_test_random(&seed) - UP_AND_DOWN);
    }
    PercaleClothDef def = percale_test_cloth_def(mesh);
    def.velocities = velocities;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    free(velocities);
    return cloth;
}

typedef struct Size {
    uint32_t side; // vertices
    int frames;
} Size;

/// The last one is the full one.
static const Size SIZES[] = {{40, PERCALE_SANITIZED ? 8 : 15}, {104, 300}};

START_TEST(a_sheet_that_crumples_keeps_its_momentum)
{
    Size size = SIZES[_i];
    PercaleSolverDef def = percale_solver_def_default();
    memset(def.gravity, 0, sizeof(def.gravity));
    def.damping = 0.0f;
    def.substeps = 20;
    def.self_collision = def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh mesh = percale_test_sheet(size.side, SPACING * (float)(size.side - 1));
    PercaleCloth cloth = add_thrown_sheet(solver, &mesh);
    double before[3];
    double after[3];
    double worst = 0.0;
    double whole = momentum_of(solver, cloth, before);
    for (int frame = 0; frame < size.frames; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        (void)momentum_of(solver, cloth, after);
        for (int axis = 0; axis < 3; axis++) {
            worst = fmax(worst, fabs(after[axis] - before[axis]) / whole);
        }
    }
    PercaleCounters counters = percale_solver_counters(solver);
    printf("%u vertices, %d steps: drift %g; %llu stencils of faces, %llu of edges\n", mesh.vertex_count,
           size.frames, worst, (unsigned long long)counters.stencils_vf,
           (unsigned long long)counters.stencils_ee);
    (void)fflush(stdout);
    ck_assert_uint_gt(counters.stencils_vf, 1000);
    ck_assert_uint_gt(counters.stencils_ee, 1000);
    ck_assert_msg(worst <= DRIFT_MAX, "%g of the momentum is lost", worst);
    percale_solver_destroy(solver);
    percale_mesh_free(&mesh);
}
END_TEST

// ---- the weights of a stencil ----

/// Crumples the cloth anew, in the space around the obstacles.
static void scatter(PercaleSolver *solver, PercaleCloth cloth, const PercaleMesh *mesh, uint64_t *seed)
{
    const double ROOM = 0.04; // m, to either side of the flat sheet
    float *x = malloc(3 * sizeof(float) * mesh->vertex_count);
    ck_assert_ptr_nonnull(x);
    for (size_t i = 0; i < 3 * (size_t)mesh->vertex_count; i++) {
        x[i] = mesh->positions[i] + (float)(ROOM * (2.0 * percale_test_random(seed) - 1.0));
    }
    PERCALE_TEST_OK(solver, percale_cloth_set_positions(solver, cloth, x, 0));
    free(x);
}

/// Stencils by the number of points with weight.
static void count_weights(const PercaleStencilList *stencils, uint64_t counts[5])
{
    for (size_t i = 0; i < stencils->count; i++) {
        const float *weights = stencils->items[i].weights;
        float sum = 0.0f;
        int used = 0;
        for (int k = 0; k < 4; k++) {
            sum += weights[k];
            used += weights[k] != 0.0f;
        }
        ck_assert_msg(sum == 0.0f, "%g %g %g %g leave %g", (double)weights[0], (double)weights[1],
                      (double)weights[2], (double)weights[3], (double)sum);
        counts[used]++;
    }
}

/// With cloth, bodies and open surfaces in one heap.
START_TEST(the_weights_of_every_stencil_sum_to_zero)
{
    enum { ROUNDS = PERCALE_SANITIZED ? 5 : 60, SIDE = 12 };
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = 1;
    def.self_collision = def.edge_edge = 1;
    def.untangle = 0; // else most pairs of such a heap would be released
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh mesh = percale_test_sheet(SIDE, 0.2f);
    PercaleMesh body = percale_test_sphere(1, 0.03f);
    PercaleMesh box = percale_test_box(0.05f, 0.03f, 0.04f);
    percale_test_translate(&box, 0.06f, 0.0f, 0.02f);
    (void)percale_test_add_obstacle(solver, &body);
    (void)percale_test_add_obstacle(solver, &box);
    PercaleCloth cloth = percale_test_add_cloth(solver, &mesh);
    uint64_t seed = 11;
    uint64_t counts[5] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        scatter(solver, cloth, &mesh, &seed);
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        count_weights(&solver->stencils, counts);
    }
    ck_assert_uint_eq(counts[0] + counts[1], 0);
    for (int used = 2; used <= 4; used++) { // corners, sides, faces and edges
        ck_assert_uint_gt(counts[used], used == 2 ? 0 : 10 * (uint64_t)ROUNDS);
    }
    percale_solver_destroy(solver);
    percale_mesh_free(&mesh);
    percale_mesh_free(&body);
    percale_mesh_free(&box);
}
END_TEST

int main(int argc, char **argv)
{
    bool full = argc > 1 && strcmp(argv[1], "--full") == 0;
    Suite *suite = suite_create("momentum");
    TCase *momentum = tcase_create("momentum");
    tcase_set_tags(momentum, PERCALE_ONE_THREAD);
    tcase_set_timeout(momentum, 0);
    tcase_add_loop_test(momentum, a_sheet_that_crumples_keeps_its_momentum, full ? 1 : 0, full ? 2 : 1);
    tcase_add_test(momentum, the_weights_of_every_stencil_sum_to_zero);
    suite_add_tcase(suite, momentum);
    return percale_test_run(suite);
}
