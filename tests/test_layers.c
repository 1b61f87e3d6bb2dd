// Layers: cloth yields to the layers below it, and they don't yield to it.

#include "testing.h"

#include <math.h>
#include <stdlib.h>

static const double FRAME = 1.0 / 60.0; // s
static const float THICKNESS = 0.002f;  // m
static const double STROKE = 1e-3;      // m that the plate rises in a frame
enum { SHEETS = 3, SIDE = 9, VERTICES = SIDE * SIDE };

/// Sheets that lie on a plate, each one thickness above the one below, turned against each other.
typedef struct Stack {
    PercaleSolver *solver;
    PercaleObstacle plate;
    PercaleCloth sheets[SHEETS];
} Stack;

/// `layers`: of the sheets, from the plate upwards.
static Stack stack_of(const int32_t layers[SHEETS])
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = def.iterations = def.passes = 1;
    def.self_collision = def.edge_edge = 1;
    def.gravity[1] = 0.0f;
    Stack stack = {.solver = percale_test_solver(def)};
    PercaleMesh box = percale_test_box(0.4f, 0.1f, 0.4f);
    percale_test_translate(&box, 0.0f, -0.05f, 0.0f);
    PercaleObstacleDef obstacle = percale_test_obstacle_def(&box);
    obstacle.thickness = THICKNESS;
    PERCALE_TEST_OK(stack.solver, percale_obstacle_add(stack.solver, &obstacle, &stack.plate));
    for (int i = 0; i < SHEETS; i++) {
        PercaleMesh mesh = percale_test_sheet(SIDE, 0.1f);
        float turn = 0.3f * (float)i + 0.2f;
        for (size_t k = 0; k < VERTICES; k++) {
            float *x = mesh.positions + 3 * k;
            const float before[2] = {x[0], x[2]};
            x[0] = cosf(turn) * before[0] - sinf(turn) * before[1];
            x[1] = THICKNESS * (float)(i + 1);
            x[2] = sinf(turn) * before[0] + cosf(turn) * before[1];
        }
        PercaleClothDef cloth = percale_test_cloth_def(&mesh);
        cloth.material.thickness = THICKNESS;
        cloth.material.friction = 0.0f;
        cloth.layer = layers[i];
        PERCALE_TEST_OK(stack.solver, percale_cloth_add(stack.solver, &cloth, &stack.sheets[i]));
        percale_mesh_free(&mesh);
    }
    percale_mesh_free(&box);
    return stack;
}

static void raise_plate(Stack *stack, double height)
{
    const double upright[4] = {0.0, 0.0, 0.0, 1.0};
    const double translation[3] = {0.0, height, 0.0};
    PERCALE_TEST_OK(stack->solver,
                    percale_obstacle_set_transform(stack->solver, stack->plate, upright, translation));
    PERCALE_TEST_OK(stack->solver, percale_solver_step(stack->solver, FRAME));
}

/// Of all its vertices, m.
static double mean_height(Stack *stack, int sheet)
{
    float x[3 * VERTICES];
    PERCALE_TEST_OK(stack->solver, percale_cloth_get_positions(stack->solver, stack->sheets[sheet], x, 0));
    double sum = 0.0;
    for (size_t i = 0; i < VERTICES; i++) {
        sum += (double)x[3 * i + 1];
    }
    return sum / VERTICES;
}

/// The least mean distance of a sheet from what is below it, in thicknesses.
static double narrowest_gap(Stack *stack, double plate)
{
    double narrowest = (double)INFINITY;
    double below = plate;
    for (int sheet = 0; sheet < SHEETS; sheet++) {
        double height = mean_height(stack, sheet);
        narrowest = fmin(narrowest, (height - below) / (double)THICKNESS);
        below = height;
    }
    return narrowest;
}

/// In one sweep. Without an order each pushes the one below halfway back.
START_TEST(what_a_body_pushes_out_pushes_all_layers_out)
{
    static const int32_t ORDERED[SHEETS] = {-3, 0, 7};
    static const int32_t ALIKE[SHEETS] = {2, 2, 2};
    for (int ordered = 0; ordered < 2; ordered++) {
        Stack stack = stack_of(ordered ? ORDERED : ALIKE);
        raise_plate(&stack, STROKE);
        double gap = narrowest_gap(&stack, STROKE);
        ck_assert_msg(ordered ? gap > 0.99 : gap < 0.9, "ordered %d: %g thicknesses", ordered, gap);
        percale_solver_destroy(stack.solver);
    }
}
END_TEST

START_TEST(a_layer_may_be_set_later)
{
    static const int32_t ORDERED[SHEETS] = {0, 1, 2};
    static const int32_t ALIKE[SHEETS] = {0, 0, 0};
    Stack stack = stack_of(ALIKE);
    raise_plate(&stack, 0.0);
    for (int sheet = 0; sheet < SHEETS; sheet++) {
        PERCALE_TEST_OK(stack.solver,
                        percale_cloth_set_layer(stack.solver, stack.sheets[sheet], ORDERED[sheet]));
    }
    raise_plate(&stack, STROKE);
    ck_assert_double_gt(narrowest_gap(&stack, STROKE), 0.99);
    percale_solver_destroy(stack.solver);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("layers");
    TCase *layers = tcase_create("layers");
    tcase_add_test(layers, what_a_body_pushes_out_pushes_all_layers_out);
    tcase_add_test(layers, a_layer_may_be_set_later);
    suite_add_tcase(suite, layers);
    return percale_test_run(suite);
}
