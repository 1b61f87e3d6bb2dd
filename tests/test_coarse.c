// Coarse levels: who is a node, what links say, and what a sweep over them may and may not do.

#include "percale/percale.h"
#include "solve/coarse_sweep.h"
#include "solver.h"
#include "testing.h"

#include <math.h>
#include <string.h>

enum { SIDE = 49 };
static const float SHEET = 0.48f; // m, along a side: edges of 10 mm and their diagonals

typedef struct Cloth {
    PercaleMesh sheet;
    PercaleSolver *solver;
    PercaleCloth cloth;
} Cloth;

static Cloth spread(int levels, float compliance, int threads)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.levels = levels;
    def.thread_count = threads;
    def.tethers = 0;
    Cloth made = {.sheet = percale_test_sheet(SIDE, SHEET), .solver = percale_test_solver(def)};
    PercaleClothDef cloth = percale_test_cloth_def(&made.sheet);
    cloth.material.stretch_compliance = compliance;
    PERCALE_TEST_OK(made.solver, percale_cloth_add(made.solver, &cloth, &made.cloth));
    return made;
}

static void pin_row(Cloth *cloth)
{
    uint32_t row[SIDE];
    for (uint32_t i = 0; i < SIDE; i++) {
        row[i] = i;
    }
    PercalePin handle;
    PercalePinDef pin = percale_pin_def_default();
    pin.cloth = cloth->cloth;
    pin.vertices = row;
    pin.vertex_count = SIDE;
    PERCALE_TEST_OK(cloth->solver, percale_pin_add(cloth->solver, &pin, &handle));
}

static void fold_up(Cloth *cloth)
{
    percale_solver_destroy(cloth->solver);
    percale_mesh_free(&cloth->sheet);
}

static double distance(const f32x4 *x, uint32_t a, uint32_t b)
{
    return vlength(vsub(vec3_of(x[a]), vec3_of(x[b])));
}

/// Moves the predicted points, as one factor along x tells.
static void stretch(PercaleModel *model, float factor)
{
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        model->predicted[slot] = model->position[slot];
        model->predicted[slot][0] *= factor;
    }
}

static void sweep(PercaleSolver *solver)
{
    ck_assert(percale_coarse_sweep(&solver->model.coarse, solver->links, solver->model.predicted,
                                   percale_team_alone(), &solver->arena));
}

START_TEST(nodes_are_a_spacing_apart_and_cover_the_cloth)
{
    Cloth cloth = spread(2, 0.0f, 1);
    PERCALE_TEST_OK(cloth.solver, percale_solver_validate(cloth.solver));
    const PercaleModel *model = &cloth.solver->model;
    ck_assert_uint_eq(model->coarse.level_count, 2);
    double spacing = 0.0;
    for (uint32_t e = 0; e < model->edge_count; e++) {
        spacing += (double)model->edge_lengths[e] / model->edge_count;
    }
    for (uint32_t i = 0; i < 2; i++) {
        const PercaleCoarseLevel *level = &model->coarse.levels[i];
        spacing *= COARSE_SPACING;
        for (uint32_t a = 0; a < level->node_count; a++) {
            for (uint32_t b = 0; b < a; b++) {
                ck_assert_double_ge(distance(model->position, level->slots[a], level->slots[b]),
                                    0.9999 * spacing);
            }
        }
        for (uint32_t slot = 0; slot < model->slot_count; slot++) {
            double nearest = (double)INFINITY;
            for (uint32_t n = 0; n < level->node_count; n++) {
                nearest = fmin(nearest, distance(model->position, slot, level->slots[n]));
            }
            bool is_lower = i == 0;
            for (uint32_t n = 0; i > 0 && n < model->coarse.levels[0].node_count; n++) {
                is_lower = is_lower || model->coarse.levels[0].slots[n] == slot;
            }
            ck_assert(!is_lower || nearest <= 1.0001 * spacing); // of each point of the level below
            ck_assert(is_lower || nearest > 0.0);                // nodes are nodes there, too
        }
    }
    fold_up(&cloth);
}
END_TEST

START_TEST(a_node_leads_itself_and_shares_add_up)
{
    Cloth cloth = spread(2, 0.0f, 1);
    PERCALE_TEST_OK(cloth.solver, percale_solver_validate(cloth.solver));
    const PercaleCoarse *coarse = &cloth.solver->model.coarse;
    for (uint32_t i = 0; i < 2; i++) {
        const PercaleCoarseLevel *level = &coarse->levels[i];
        uint32_t alone = 0;
        for (uint32_t f = 0; f < level->follower_count; f++) {
            f32x4 shares = level->shares[f];
            uint32_t slot = i == 0 ? f : coarse->levels[0].slots[f];
            ck_assert_double_eq_tol((double)((shares[0] + shares[1]) + (shares[2] + shares[3])), 1.0, 1e-6);
            for (int k = 0; k < COARSE_LEADERS; k++) {
                ck_assert(level->leaders[f][k] < level->node_count && shares[k] >= 0.0f);
            }
            if (level->slots[level->leaders[f][0]] == slot) {
                ck_assert_double_eq((double)shares[0], 1.0);
                alone++;
            }
        }
        ck_assert_uint_eq(alone, level->node_count);
    }
    fold_up(&cloth);
}
END_TEST

START_TEST(a_link_is_as_long_as_the_way_along_the_cloth)
{
    Cloth cloth = spread(2, 0.0f, 1);
    PERCALE_TEST_OK(cloth.solver, percale_solver_validate(cloth.solver));
    const PercaleModel *model = &cloth.solver->model;
    for (uint32_t i = 0; i < 2; i++) {
        const PercaleCoarseLevel *level = &model->coarse.levels[i];
        ck_assert_uint_gt(level->link_count, 2 * level->node_count); // more than a tree
        for (uint32_t l = 0; l < level->link_count; l++) {
            uint32_t a = level->slots[slot_at(level->links[l][0])];
            uint32_t b = level->slots[slot_at(level->links[l][1])];
            ck_assert_double_eq_tol((double)level->link_lengths[l], distance(model->position, a, b), 2e-6);
        }
    }
    fold_up(&cloth);
}
END_TEST

START_TEST(what_is_not_too_long_stays_to_the_bit)
{
    Cloth cloth = spread(2, 0.0f, 1);
    PERCALE_TEST_OK(cloth.solver, percale_solver_validate(cloth.solver));
    PercaleModel *model = &cloth.solver->model;
    stretch(model, 0.9f);
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        model->predicted[slot][1] = 0.002f * (float)(slot % 3); // and creased
        model->predicted[slot][2] *= 0.9f;
    }
    size_t bytes = model->slot_count * sizeof(f32x4);
    f32x4 *before = percale_memory_new(&cloth.solver->solve_memory, model->slot_count, sizeof(f32x4));
    memcpy(before, model->predicted, bytes);
    sweep(cloth.solver);
    ck_assert_mem_eq(before, model->predicted, bytes);
    percale_memory_free(&cloth.solver->solve_memory, before);
    fold_up(&cloth);
}
END_TEST

/// Sum of mass times place, kg m, and how long the cloth is along x, m.
static Vec3 moment_of(const PercaleModel *model, double *width)
{
    Vec3 sum = {0};
    double low = (double)INFINITY;
    double high = -(double)INFINITY;
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        f32x4 x = model->predicted[slot];
        sum = vadd(sum, vscale(1.0 / (double)x[3], vec3_of(x)));
        low = fmin(low, (double)x[0]);
        high = fmax(high, (double)x[0]);
    }
    *width = high - low;
    return sum;
}

START_TEST(a_pull_reaches_across_the_cloth_and_keeps_its_momentum)
{
    double widths[3];
    for (int levels = 1; levels <= 2; levels++) {
        Cloth cloth = spread(levels, 0.0f, 1);
        PERCALE_TEST_OK(cloth.solver, percale_solver_validate(cloth.solver));
        PercaleModel *model = &cloth.solver->model;
        stretch(model, 1.2f);
        model->predicted[0][1] = 0.1f; // so that it isn't the same on both sides
        Vec3 before = moment_of(model, &widths[0]);
        sweep(cloth.solver);
        Vec3 after = moment_of(model, &widths[levels]);
        double mass = (double)(SHEET * SHEET) * 0.2;
        ck_assert_double_le(vlength(vsub(after, before)), 1e-6 * mass * (double)SHEET);
        fold_up(&cloth);
    }
    ck_assert_double_lt(widths[1], widths[0] - 0.01); // of 96 mm too much
    ck_assert_double_lt(widths[2], widths[1] - 0.02);
}
END_TEST

START_TEST(pins_stay_and_what_hangs_is_stretched_less)
{
    double stretches[2];
    uint64_t hashes[2] = {0, 0};
    for (int i = 0; i < 3; i++) { // without, with, with more threads
        Cloth cloth = spread(i > 0 ? 2 : 0, 0.0f, i < 2 ? 1 : 3);
        pin_row(&cloth);
        for (int frame = 0; frame < 30; frame++) {
            PERCALE_TEST_OK(cloth.solver, percale_solver_step(cloth.solver, 1.0 / 60.0));
        }
        PercaleQuality quality;
        PERCALE_TEST_OK(cloth.solver, percale_solver_quality(cloth.solver, &quality));
        const PercaleModel *model = &cloth.solver->model;
        for (uint32_t p = 0; p < model->pinned_count; p++) {
            const float *start = cloth.sheet.positions + 3 * (size_t)model->pinned_sources[p][1];
            ck_assert_mem_eq(&model->position[model->pinned_slots[p]], start, 3 * sizeof(float));
        }
        if (i < 2) {
            stretches[i] = quality.stretch_p99;
            hashes[i] = percale_solver_hash(cloth.solver);
        } else {
            ck_assert_uint_eq(percale_solver_hash(cloth.solver), hashes[1]);
        }
        ck_assert((percale_solver_counters(cloth.solver).projections_link > 0) == (i > 0));
        fold_up(&cloth);
    }
    ck_assert_double_lt(stretches[1], 0.5 * stretches[0]);
}
END_TEST

START_TEST(cloth_that_may_stretch_has_none)
{
    Cloth cloth = spread(2, 1e-4f, 1);
    PERCALE_TEST_OK(cloth.solver, percale_solver_step(cloth.solver, 1.0 / 60.0));
    ck_assert_uint_eq(cloth.solver->model.coarse.level_count, 0);
    ck_assert_uint_eq(percale_solver_counters(cloth.solver).projections_link, 0);
    fold_up(&cloth);
}
END_TEST

START_TEST(as_many_levels_as_there_is_cloth_for)
{
    Cloth cloth = spread(PERCALE_MAX_LEVELS, 0.0f, 1);
    PERCALE_TEST_OK(cloth.solver, percale_solver_step(cloth.solver, 1.0 / 60.0));
    const PercaleCoarse *coarse = &cloth.solver->model.coarse;
    ck_assert_uint_ge(coarse->level_count, 2);
    ck_assert_uint_lt(coarse->level_count, PERCALE_MAX_LEVELS);
    for (uint32_t i = 0; i < coarse->level_count; i++) {
        ck_assert_uint_gt(coarse->levels[i].link_count, 0);
    }
    fold_up(&cloth);
    PercaleSolverDef def = percale_solver_def_default();
    PercaleSolver *none = NULL;
    def.levels = PERCALE_MAX_LEVELS + 1;
    ck_assert_int_eq(percale_solver_create(def, &none), PERCALE_INVALID_ARGUMENT);
    def.levels = -1;
    ck_assert_int_eq(percale_solver_create(def, &none), PERCALE_INVALID_ARGUMENT);
    ck_assert_ptr_null(none);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("coarse");
    TCase *levels = tcase_create("levels");
    tcase_add_test(levels, nodes_are_a_spacing_apart_and_cover_the_cloth);
    tcase_add_test(levels, a_node_leads_itself_and_shares_add_up);
    tcase_add_test(levels, a_link_is_as_long_as_the_way_along_the_cloth);
    tcase_add_test(levels, as_many_levels_as_there_is_cloth_for);
    suite_add_tcase(suite, levels);
    TCase *sweeps = tcase_create("sweep");
    tcase_add_test(sweeps, what_is_not_too_long_stays_to_the_bit);
    tcase_add_test(sweeps, a_pull_reaches_across_the_cloth_and_keeps_its_momentum);
    tcase_add_test(sweeps, pins_stay_and_what_hangs_is_stretched_less);
    tcase_add_test(sweeps, cloth_that_may_stretch_has_none);
    suite_add_tcase(suite, sweeps);
    return percale_test_run(suite);
}
