// Which objects meet, and at which distance: masks, and thicknesses of their own.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s

static PercaleSolverDef def_of(void)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = 20;
    def.self_collision = def.edge_edge = 1;
    return def;
}

static void run(PercaleSolver *solver, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
}

static void turn(PercaleMesh *mesh, double angle)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float *x = mesh->positions + 3 * i;
        double turned[2] = {cos(angle) * (double)x[0] - sin(angle) * (double)x[2],
                            sin(angle) * (double)x[0] + cos(angle) * (double)x[2]};
        x[0] = (float)turned[0];
        x[2] = (float)turned[1];
    }
}

/// Lowest, mean and highest y of a cloth.
typedef struct Heights {
    double low, mean, high;
} Heights;

static Heights heights_of(PercaleSolver *solver, PercaleCloth cloth, const PercaleMesh *mesh)
{
    float *x = malloc(3 * sizeof(float) * mesh->vertex_count);
    ck_assert_ptr_nonnull(x);
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, x, 0));
    Heights heights = {HUGE_VAL, 0.0, -HUGE_VAL};
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double y = (double)x[3 * i + 1];
        heights.low = fmin(heights.low, y);
        heights.high = fmax(heights.high, y);
        heights.mean += y / mesh->vertex_count;
    }
    free(x);
    return heights;
}

// ---- masks ----

/// A sheet falls through, or onto, another one that lies on a box.
typedef struct Stack {
    PercaleSolver *solver;
    PercaleMesh box, meshes[2];
    PercaleCloth cloths[2]; // the lower, the upper
} Stack;

static const float TOP = 0.1f; // m; of the box

static Stack stack_up(uint32_t box_mask, uint32_t lower_mask, uint32_t upper_mask)
{
    enum { SIDE = 11 };
    const uint32_t masks[2] = {lower_mask, upper_mask};
    Stack stack = {.solver = percale_test_solver(def_of()), .box = percale_test_box(1.0f, 2.0f * TOP, 1.0f)};
    PercaleObstacleDef box = percale_test_obstacle_def(&stack.box);
    box.mask = box_mask;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(stack.solver, percale_obstacle_add(stack.solver, &box, &obstacle));
    for (int i = 0; i < 2; i++) {
        stack.meshes[i] = percale_test_sheet(SIDE, 0.2f);
        turn(&stack.meshes[i], 0.3 * i);
        percale_test_translate(&stack.meshes[i], 0.0f, TOP + 0.01f + 0.02f * (float)i, 0.0f);
        PercaleClothDef def = percale_test_cloth_def(&stack.meshes[i]);
        def.mask = masks[i];
        PERCALE_TEST_OK(stack.solver, percale_cloth_add(stack.solver, &def, &stack.cloths[i]));
    }
    return stack;
}

static void take_down(Stack *stack)
{
    percale_solver_destroy(stack->solver);
    percale_mesh_free(&stack->box);
    percale_mesh_free(&stack->meshes[0]);
    percale_mesh_free(&stack->meshes[1]);
}

/// Both fall as if alone: 0.4 s, 0.78 m, past the box.
START_TEST(what_shares_no_mask_passes_freely)
{
    enum { FRAMES = 24 };
    Stack stack = stack_up(1, 2, 4);
    run(stack.solver, FRAMES);
    PercaleCounters counters = percale_solver_counters(stack.solver);
    ck_assert_uint_eq(counters.stencils_vf + counters.stencils_ee, 0);
    ck_assert_uint_eq(counters.projections_contact, 0);
    ck_assert_uint_eq(counters.truncated, 0);
    for (int i = 0; i < 2; i++) {
        Heights heights = heights_of(stack.solver, stack.cloths[i], &stack.meshes[i]);
        double start = (double)stack.meshes[i].positions[1];
        ck_assert_double_lt(heights.high, start - 0.7);
        ck_assert_double_lt(heights.high - heights.low, 1e-3); // flat, as nothing has touched it
    }
    take_down(&stack);
}
END_TEST

/// The box holds one sheet and lets the other pass, whichever it is; the two are strangers to each other.
START_TEST(an_obstacle_holds_what_shares_its_mask)
{
    enum { FRAMES = 24 };
    Stack stack = stack_up(6, _i == 0 ? 2 : 8, _i == 0 ? 8 : 4);
    run(stack.solver, FRAMES);
    Heights held = heights_of(stack.solver, stack.cloths[_i], &stack.meshes[_i]);
    Heights gone = heights_of(stack.solver, stack.cloths[1 - _i], &stack.meshes[1 - _i]);
    ck_assert_double_gt(held.low, (double)TOP);
    ck_assert_double_lt(gone.high, -(double)TOP);
    take_down(&stack);
}
END_TEST

/// The box knows the lower sheet only; the upper one is held by that.
START_TEST(a_cloth_holds_what_shares_its_mask)
{
    enum { FRAMES = 24 };
    Stack stack = stack_up(1, 3, 2);
    run(stack.solver, FRAMES);
    Heights lower = heights_of(stack.solver, stack.cloths[0], &stack.meshes[0]);
    Heights upper = heights_of(stack.solver, stack.cloths[1], &stack.meshes[1]);
    ck_assert_double_gt(lower.low, (double)TOP);
    // at the rims, which the turned sheets don't share, it hangs down a little
    ck_assert_double_gt(upper.mean, lower.mean);
    take_down(&stack);
}
END_TEST

/// A sheet without any mask doesn't even meet itself: folded and pressed together it goes through.
START_TEST(without_a_mask_a_cloth_does_not_meet_itself)
{
    enum { SIDE = 11, FRAMES = 12 };
    uint64_t stencils[2];
    for (uint32_t mask = 0; mask < 2; mask++) {
        PercaleSolverDef def = def_of();
        memset(def.gravity, 0, sizeof(def.gravity));
        PercaleSolver *solver = percale_test_solver(def);
        PercaleMesh mesh = percale_test_sheet(SIDE, 0.2f);
        float velocities[3 * SIDE * SIDE] = {0};
        for (size_t i = 0; i < mesh.vertex_count; i++) { // the halves fold up and meet
            velocities[3 * i] = -10.0f * mesh.positions[3 * i];
            velocities[3 * i + 1] = 20.0f * fabsf(mesh.positions[3 * i]);
        }
        PercaleClothDef cloth = percale_test_cloth_def(&mesh);
        cloth.velocities = velocities;
        cloth.mask = mask;
        PercaleCloth added;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, &added));
        run(solver, FRAMES);
        PercaleCounters counters = percale_solver_counters(solver);
        stencils[mask] = counters.stencils_vf + counters.stencils_ee;
        percale_solver_destroy(solver);
        percale_mesh_free(&mesh);
    }
    ck_assert_uint_eq(stencils[0], 0);
    ck_assert_uint_gt(stencils[1], 100);
}
END_TEST

// ---- thickness ----

static const float THICKNESSES[3] = {0.004f, 0.001f, 0.003f}; // m; of the floor, the lower, the upper sheet

static const float SHORT = 0.002f; // m; the smaller mean of a pair

/// Lengths of the edges, in SHORT.
static const float EDGES[] = {1.0f, 4.0f, 20.0f};
enum { EDGE_COUNT = sizeof(EDGES) / sizeof(EDGES[0]) };

/// Farthest that a vertex of the sheet is from a height, m.
static double off_by(Heights heights, double height)
{
    return fmax(fabs(heights.low - height), fabs(heights.high - height));
}

/// One sheet on the other on a floor. The lower one is larger, so that the upper one hangs nowhere down.
START_TEST(two_surfaces_rest_at_the_mean_of_their_thicknesses)
{
    enum { FRAMES = PERCALE_SANITIZED ? 6 : 10, SIDE = 9 };
    const double SLACK = 0.05; // of the distance
    PercaleSolver *solver = percale_test_solver(def_of());
    PercaleMesh floor = percale_test_sheet(2, 4.0f);
    PercaleObstacleDef obstacle = percale_test_obstacle_def(&floor);
    obstacle.thickness = THICKNESSES[0];
    PercaleObstacle added;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &obstacle, &added));
    PercaleMesh meshes[2];
    PercaleCloth cloths[2];
    double expected[2]; // m
    double below = 0.0;
    for (uint32_t i = 0; i < 2; i++) {
        expected[i] = below + 0.5 * (double)(THICKNESSES[i] + THICKNESSES[i + 1]);
        below = expected[i];
        uint32_t side = i == 0 ? SIDE + 6 : SIDE;
        meshes[i] = percale_test_sheet(side, EDGES[_i] * SHORT * (float)(side - 1));
        turn(&meshes[i], 0.3 * i);
        percale_test_translate(&meshes[i], 0.0f, (float)expected[i] + 0.0005f * (float)(i + 1), 0.0f);
        PercaleClothDef def = percale_test_cloth_def(&meshes[i]);
        def.material.thickness = THICKNESSES[i + 1];
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloths[i]));
    }
    run(solver, FRAMES);
    Heights lower = heights_of(solver, cloths[0], &meshes[0]);
    Heights upper = heights_of(solver, cloths[1], &meshes[1]);
    ck_assert_double_lt(off_by(lower, expected[0]), SLACK * expected[0]);
    ck_assert_double_lt(off_by(upper, expected[1]), SLACK * (expected[1] - expected[0]));
    percale_solver_destroy(solver);
    percale_mesh_free(&floor);
    percale_mesh_free(&meshes[0]);
    percale_mesh_free(&meshes[1]);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("masks");
    TCase *masks = tcase_create("masks");
    tcase_set_timeout(masks, 0);
    tcase_add_test(masks, what_shares_no_mask_passes_freely);
    tcase_add_loop_test(masks, an_obstacle_holds_what_shares_its_mask, 0, 2);
    tcase_add_test(masks, a_cloth_holds_what_shares_its_mask);
    tcase_add_test(masks, without_a_mask_a_cloth_does_not_meet_itself);
    suite_add_tcase(suite, masks);
    TCase *thickness = tcase_create("thickness");
    tcase_set_timeout(thickness, 0);
    tcase_add_loop_test(thickness, two_surfaces_rest_at_the_mean_of_their_thicknesses, 0, EDGE_COUNT);
    suite_add_tcase(suite, thickness);
    return percale_test_run(suite);
}
