// Cloth that goes through cloth comes apart while the simulation goes on, and what doesn't never notices.

#include "tangle_testing.h"
#include "untangle/watch.h"

#include <string.h>

static const double FRAME = 1.0 / 60.0; // s

/// Nothing pulls, everything collides.
static PercaleSolverDef floating(void)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.gravity[1] = 0.0f;
    def.self_collision = def.edge_edge = 1;
    return def;
}

// ---- sheets ----

/// Within a few steps, and it stays so; without untangling it stays tangled.
START_TEST(two_sheets_come_apart)
{
    const int STEPS = 30;
    const uint64_t CLEAN_AFTER = 10; // steps
    for (int untangle = 0; untangle < 2; untangle++) {
        PercaleSolverDef def = floating();
        def.untangle = untangle;
        def.edge_edge = _i;
        PercaleSolver *solver = lay_two(def, 0.004f, 0);
        ck_assert(pairs_of(solver) > 0.0);
        for (uint64_t step = 1; step <= (uint64_t)STEPS; step++) {
            PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
            ck_assert(step < CLEAN_AFTER || (pairs_of(solver) == 0.0) == (untangle == 1));
        }
        uint64_t last = percale_solver_counters(solver).last_crossed_frame;
        ck_assert_msg(last < CLEAN_AFTER, "step %d", (int)last);
        percale_solver_destroy(solver);
    }
}
END_TEST

/// Of two layers the outer one goes to the side to which the inner one is turned.
START_TEST(layers_decide_which_side_is_wrong)
{
    for (int32_t layer = -1; layer <= 1; layer += 2) {
        PercaleSolver *solver = lay_two(floating(), 0.004f, layer);
        for (int step = 0; step < 10; step++) {
            PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        }
        ck_assert(pairs_of(solver) == 0.0);
        double first = mean_height(solver, (PercaleCloth){1});
        double second = mean_height(solver, (PercaleCloth){2});
        ck_assert_msg((second > first) == (layer > 0), "layer %d: heights %g and %g", (int)layer, first,
                      second);
        percale_solver_destroy(solver);
    }
}
END_TEST

/// Taking apart gives no velocity and keeps momentum.
START_TEST(what_has_come_apart_stays_where_it_is)
{
    const float SLOW = 0.1f; // m/s; sheets that sprang apart would have EXIT_SPEED, five times that
    const double ROUNDING = 0x1p-24 * 0.2 * 1200.0; // m/s; of a coordinate of 0.2 m in a substep
    PercaleSolver *solver = lay_two(floating(), 0.004f, 0);
    double sum[3] = {0.0, 0.0, 0.0};
    double mass = 0.0;
    float fastest = 0.0f;
    for (int step = 0; step < 10; step++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    ck_assert(pairs_of(solver) == 0.0);
    const PercaleModel *model = &solver->model;
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        mass += 1.0 / (double)model->position[slot][3];
        for (int axis = 0; axis < 3; axis++) {
            fastest = fmaxf(fastest, fabsf(model->velocity[slot][axis]));
            double momentum = (double)model->velocity[slot][axis] / (double)model->position[slot][3];
            sum[axis] += momentum;
        }
    }
    ck_assert_msg(fastest < SLOW, "%g m/s", (double)fastest);
    for (int axis = 0; axis < 3; axis++) {
        ck_assert_msg(fabs(sum[axis]) <= ROUNDING * mass, "%g kg m/s of %g kg", sum[axis], mass);
    }
    percale_solver_destroy(solver);
}
END_TEST

/// Cloth that collides with nothing isn't taken apart either: not in steps, not on request.
START_TEST(what_collides_with_nothing_stays_crossed)
{
    TangleCase tangle;
    uint64_t hashes[2];
    ck_assert(tangle_case_make_standard("BLI", 1, 0, &tangle));
    for (int untangle = 0; untangle < 2; untangle++) {
        PercaleSolverDef def = floating();
        def.untangle = untangle;
        PercaleSolver *solver = percale_test_solver(def);
        PercaleCloth cloth = percale_test_add_cloth(solver, &tangle.cloths[0]);
        ck_assert(pairs_of(solver) > 0.0);
        PERCALE_TEST_OK(solver, percale_cloth_set_mask(solver, cloth, 0));
        for (int step = 0; step < 5; step++) {
            PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        }
        hashes[untangle] = percale_solver_hash(solver);
        ck_assert_uint_eq(percale_solver_counters(solver).last_crossed_frame, 0);
        PercaleUntangleDef untangle_def = percale_untangle_def_default();
        PercaleUntangleReport report;
        PERCALE_TEST_OK(solver, percale_solver_untangle(solver, &untangle_def, &report));
        ck_assert_int_eq(report.iterations, 0);
        ck_assert_uint_eq(percale_solver_hash(solver), hashes[untangle]);
        percale_solver_destroy(solver);
    }
    ck_assert_uint_eq(hashes[0], hashes[1]);
    tangle_case_free(&tangle);
}
END_TEST

// ---- the watch ----

/// The edges of a tangle, one by one and together.
typedef struct Look {
    PercaleSolver *solver;
    const uint8_t *crosses; // [edges]
    uint32_t seen;          // looks that saw something
} Look;

static void look_at_each(PercaleTeam *team, void *context)
{
    Look *given = context;
    PercaleSolver *solver = given->solver;
    PercaleWatchStage stage = {.model = &solver->model,
                               .faces = &solver->candidates.faces,
                               .x = solver->model.position,
                               .collectors = &solver->collectors,
                               .memory = &solver->detect_memory,
                               .team = team};
    uint32_t count = solver->model.cloth.edges.edge_count;
    for (uint32_t width = 1; width <= count; width = width < 9 ? width + 4 : 8 * width) {
        for (uint32_t first = 0; first < count; first += width) {
            uint32_t end = first + width < count ? first + width : count;
            bool expected = memchr(given->crosses + first, 1, end - first) != NULL;
            bool crossed;
            ck_assert(percale_watch_run(&stage, first, end, &crossed));
            ck_assert_msg(crossed == expected, "edges %u to %u", first, end - 1);
            given->seen += crossed;
        }
    }
}

static PercaleSolver *solver_with_contact(const TangleCase *tangle)
{
    PercaleSolver *solver = percale_test_solver(floating());
    for (uint32_t i = 0; i < tangle->cloth_count; i++) {
        PercaleClothDef def = percale_test_cloth_def(&tangle->cloths[i]);
        PercaleCloth cloth;
        def.material.thickness = tangle->thickness;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    }
    return solver;
}

/// Two triangles that share a point, and the side of one beyond it goes through the other.
static PercaleSolver *cross_neighbours(void)
{
    float positions[] = {0.0f, 0.0f,  0.0f,  0.1f, 0.0f,  -0.1f, 0.1f, 0.0f,
                         0.1f, 0.05f, -0.1f, 0.0f, 0.05f, 0.1f,  0.0f};
    uint32_t triangles[] = {0, 1, 2, 0, 3, 4};
    const PercaleMesh mesh = {
        .positions = positions, .vertex_count = 5, .triangles = triangles, .triangle_count = 2};
    PercaleSolver *solver = percale_test_solver(floating());
    (void)percale_test_add_cloth(solver, &mesh);
    return solver;
}

/// It sees the edges that go through a face of which one of their triangles shares no point, and no others:
/// in the last of the cases only neighbours cross.
START_TEST(the_watch_sees_every_edge_that_crosses)
{
    TangleCase tangle;
    bool are_apart = _i < TANGLE_STANDARD;
    uint32_t kind = are_apart ? (uint32_t)_i : 0;
    ck_assert(tangle_case_make((kind * TANGLE_DEPTHS + 1) * TANGLE_RESOLUTIONS, &tangle));
    Tangle *seen = look(are_apart ? solver_with_contact(&tangle) : cross_neighbours(), 1);
    ck_assert_uint_gt(seen->crossings.count, 0);
    uint8_t *crosses = calloc(seen->mesh.edges.edge_count, 1);
    ck_assert_ptr_nonnull(crosses);
    for (size_t i = 0; i < seen->crossings.count; i++) {
        const PercaleTangleCrossing *crossing = &seen->crossings.items[i];
        for (uint32_t k = 0; k < triangles_of_edge(&seen->mesh, crossing->edge); k++) {
            uint32_t triangle = triangle_of_edge(&seen->mesh, crossing->edge, k);
            crosses[crossing->edge] |= !do_triangles_meet(&seen->mesh, triangle, crossing->face);
        }
    }
    Look all = {seen->solver, crosses, 0};
    PercaleCrowding crowding = {0, 0};
    percale_team_open(1, &crowding, look_at_each, &all);
    ck_assert((all.seen > 0) == are_apart);
    free(crosses);
    look_away(seen);
    tangle_case_free(&tangle);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("heal");
    TCase *sheets = tcase_create("sheets");
    tcase_add_loop_test(sheets, two_sheets_come_apart, 0, 2);
    tcase_add_test(sheets, layers_decide_which_side_is_wrong);
    tcase_add_test(sheets, what_has_come_apart_stays_where_it_is);
    tcase_add_test(sheets, what_collides_with_nothing_stays_crossed);
    tcase_add_loop_test(sheets, the_watch_sees_every_edge_that_crosses, 0, TANGLE_STANDARD + 1);
    tcase_set_tags(sheets, PERCALE_ONE_THREAD);
    suite_add_tcase(suite, sheets);
    return percale_test_run(suite);
}
