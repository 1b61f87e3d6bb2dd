// Tangles come apart, or what remains is said; nothing is made worse, nothing moves that must not.

#include "kernel_testing.h"
#include "tangle_sheet.h"
#include "tangle_testing.h"
#include "untangle/descent.h"
#include "untangle/regions.h"

#include <string.h>

static PercaleUntangleReport untangle(PercaleSolver *solver)
{
    PercaleUntangleDef def = percale_untangle_def_default();
    PercaleUntangleReport report;
    PERCALE_TEST_OK(solver, percale_solver_untangle(solver, &def, &report));
    return report;
}

// ---- the seven standard cases ----

enum { STANDARD_COUNT = TANGLE_STANDARD * TANGLE_DEPTHS * TANGLE_RESOLUTIONS };

/// All of them within 10 rounds, and nothing moves more than 3 edges farther than the tangle reaches.
START_TEST(standard_case_comes_apart)
{
    const int ROUNDS = 10;
    const double FARTHER = 3.0; // edges
    TangleCase tangle;
    ck_assert(tangle_case_make((uint32_t)_i, &tangle));
    PercaleSolver *solver = solver_of_case(&tangle);
    PercaleUntangleReport report = untangle(solver);
    double left = pairs_of(solver);
    ck_assert_msg(report.ef_after == 0 && left == 0.0, "%s: %.0f pairs are left", tangle.name, left);
    ck_assert_msg(report.iterations <= ROUNDS, "%s: %d rounds", tangle.name, report.iterations);
    ck_assert_msg(report.displacement_max <= tangle.extent + FARTHER * tangle.edge, "%s: %g m", tangle.name,
                  report.displacement_max);
    percale_solver_destroy(solver);
    tangle_case_free(&tangle);
}
END_TEST

// ---- the random ones ----

static const uint32_t EVERY = PERCALE_SANITIZED ? 37 : 10; // of the seeded set is tried here

/// ef_after <= ef_before, also when it has to stop after a round; and the audit agrees.
START_TEST(nothing_is_made_worse)
{
    uint32_t count = 0;
    uint32_t apart = 0;
    for (uint32_t i = STANDARD_COUNT + (uint32_t)_i; i < tangle_case_count(); i += EVERY) {
        TangleCase tangle;
        ck_assert(tangle_case_make(i, &tangle));
        PercaleSolver *solver = solver_of_case(&tangle);
        double before = pairs_of(solver);
        PercaleUntangleDef def = percale_untangle_def_default();
        PercaleUntangleReport report;
        def.rounds = _i == 0 ? 1 : def.rounds;
        PERCALE_TEST_OK(solver, percale_solver_untangle(solver, &def, &report));
        double after = pairs_of(solver);
        ck_assert_msg(after <= before && report.ef_after <= report.ef_before, "%s: %.0f, before %.0f",
                      tangle.name, after, before);
        ck_assert_msg(before == (double)report.ef_before && after == (double)report.ef_after,
                      "%s: the audit counts %.0f and %.0f", tangle.name, before, after);
        count++;
        apart += after == 0.0;
        percale_solver_destroy(solver);
        tangle_case_free(&tangle);
    }
    ck_assert_msg(_i == 0 || 100 * apart >= 95 * count, "%u of %u", apart, count);
}
END_TEST

/// |sum m dx| <= 1e-5 sum m |dx| of two cloths.
START_TEST(momentum_survives_untangling)
{
    const double DRIFT = 1e-5;
    const uint32_t FARTHER = PERCALE_SANITIZED ? 148 : 36;
    uint32_t step = 4;
    for (uint32_t i = (uint32_t)_i; i < tangle_case_count(); i += step) {
        step = i < STANDARD_COUNT ? 4 : FARTHER;
        TangleCase tangle;
        ck_assert(tangle_case_make(i, &tangle));
        if (tangle.body.vertex_count == 0) {
            PercaleSolver *solver = solver_of_case(&tangle);
            PercaleUntangleReport report = untangle(solver);
            ck_assert_msg(report.momentum_drift <= DRIFT, "%s: %g", tangle.name, report.momentum_drift);
            percale_solver_destroy(solver);
        }
        tangle_case_free(&tangle);
    }
}
END_TEST

static uint64_t hash_after(uint32_t index, int thread_count)
{
    TangleCase tangle;
    ck_assert(tangle_case_make(index, &tangle));
    PercaleSolver *solver = solver_of_case(&tangle);
    PERCALE_TEST_OK(solver, percale_solver_set_thread_count(solver, thread_count));
    (void)untangle(solver);
    uint64_t hash = percale_solver_hash(solver);
    percale_solver_destroy(solver);
    tangle_case_free(&tangle);
    return hash;
}

START_TEST(one_thread_equals_seven)
{
    const uint32_t FIRST_OF_KIND[TANGLE_KINDS] = {11, 42, 108, 174, 240};
    uint64_t one = hash_after(FIRST_OF_KIND[_i], 1);
    ck_assert(hash_after(FIRST_OF_KIND[_i], 2) == one);
    ck_assert(hash_after(FIRST_OF_KIND[_i], 7) == one);
}
END_TEST

// ---- what stays ----

/// Of two layers the outer one goes to the side to which the inner one is turned, however much of it that is.
START_TEST(layers_decide_which_side_is_wrong)
{
    for (int32_t layer = -1; layer <= 1; layer += 2) {
        PercaleSolver *solver = lay_two(percale_solver_def_default(), 0.004f, layer);
        ck_assert(pairs_of(solver) > 0.0);
        (void)untangle(solver);
        ck_assert(pairs_of(solver) == 0.0);
        double first = mean_height(solver, (PercaleCloth){1});
        double second = mean_height(solver, (PercaleCloth){2});
        ck_assert_msg((second > first) == (layer > 0), "layer %d: heights %g and %g", (int)layer, first,
                      second);
        percale_solver_destroy(solver);
    }
}
END_TEST

START_TEST(what_is_clean_stays_bit_for_bit)
{
    PercaleSolver *solver = lay_two(percale_solver_def_default(), -0.004f, 0);
    for (int round = 0; round < 2; round++) {
        (void)untangle(solver);
        uint64_t hash = percale_solver_hash(solver);
        PercaleUntangleReport report = untangle(solver);
        ck_assert(report.iterations == 0 && report.ef_before == 0 && report.displacement_max == 0.0);
        ck_assert(percale_solver_hash(solver) == hash);
    }
    percale_solver_destroy(solver);
}
END_TEST

/// A correction is no motion; pins hold.
START_TEST(velocities_and_pins_stay)
{
    PercaleSolver *solver = lay_two(percale_solver_def_default(), 0.004f, 0);
    float velocities[2][3 * 21 * 21] = {{0}};
    float positions[2][3 * 21 * 21];
    const uint32_t pinned[2] = {220, 221}; // in the middle
    PercalePinDef def = percale_pin_def_default();
    PercalePin pin;
    for (size_t k = 0; k < sizeof velocities[0] / sizeof velocities[0][0]; k++) {
        velocities[0][k] = 0.01f * (float)(k % 7);
    }
    def.cloth = (PercaleCloth){1};
    def.vertices = pinned;
    def.vertex_count = 2;
    PERCALE_TEST_OK(solver, percale_pin_add(solver, &def, &pin));
    const float targets[2][3] = {{0.0f, 0.1f, 0.0f}, {0.02f, 0.1f, 0.0f}}; // of the next step, not of this
    PERCALE_TEST_OK(solver, percale_pin_move(solver, pin, targets[0], 0));
    PERCALE_TEST_OK(solver, percale_cloth_set_velocities(solver, def.cloth, velocities[0], 0));
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, def.cloth, positions[0], 0));
    (void)untangle(solver);
    ck_assert(pairs_of(solver) == 0.0);
    PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, def.cloth, velocities[1], 0));
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, def.cloth, positions[1], 0));
    ck_assert(same_bits(velocities[0], velocities[1], sizeof velocities[0]));
    for (int k = 0; k < 2; k++) {
        size_t first = 3 * (size_t)pinned[k];
        ck_assert(same_bits(positions[0] + first, positions[1] + first, 3 * sizeof(float)));
    }
    ck_assert(!same_bits(positions[0], positions[1], sizeof positions[0]));
    percale_solver_destroy(solver);
}
END_TEST

/// Time stands still: what an obstacle has been told to do next changes nothing.
START_TEST(an_obstacle_waits)
{
    const double turn[4] = {0.0, 0.0, 0.0, 1.0};
    const double stay[3] = {0.0, 0.0, 0.0};
    const double shift[3] = {0.0, -0.2, 0.0}; // through the sheets
    uint64_t hashes[2];
    for (int told = 0; told < 2; told++) {
        PercaleSolver *solver = lay_two(percale_solver_def_default(), 0.004f, 0);
        PercaleMesh mesh = percale_test_sphere(2, 0.08f);
        percale_test_translate(&mesh, 0.0f, 0.087f, 0.0f);
        PercaleObstacle ball = percale_test_add_obstacle(solver, &mesh);
        PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, ball, turn, stay));
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1e-6)); // it is a rigid one now
        if (told == 1) {
            PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, ball, turn, shift));
        }
        ck_assert(pairs_of(solver) > 0.0);
        (void)untangle(solver);
        ck_assert(pairs_of(solver) == 0.0);
        hashes[told] = percale_solver_hash(solver);
        percale_mesh_free(&mesh);
        percale_solver_destroy(solver);
    }
    ck_assert_uint_eq(hashes[0], hashes[1]);
}
END_TEST

START_TEST(bad_arguments_are_refused)
{
    PercaleSolver *solver = lay_two(percale_solver_def_default(), 0.004f, 0);
    PercaleUntangleReport report;
    uint64_t hash = percale_solver_hash(solver);
    for (int k = 0; k < 4; k++) {
        PercaleUntangleDef def = percale_untangle_def_default();
        def.size -= k == 0;
        def.rounds = k == 1 ? 0 : def.rounds;
        def.sweeps = k == 2 ? 1001 : def.sweeps;
        def.patience = k == 3 ? 101 : def.patience;
        ck_assert_int_eq(percale_solver_untangle(solver, &def, &report), PERCALE_INVALID_ARGUMENT);
        ck_assert(strstr(percale_solver_last_error(solver), "ntangle") != NULL);
    }
    ck_assert(percale_solver_hash(solver) == hash);
    percale_solver_destroy(solver);
}
END_TEST

// ---- memory ----

typedef struct Heap {
    size_t calls, fail_at, held;
} Heap;

static void *take(void *user, size_t size, size_t alignment)
{
    Heap *heap = user;
    if (heap->calls++ == heap->fail_at) {
        return NULL;
    }
    heap->held++;
    size_t rounded = (size + alignment - 1) / alignment * alignment;
    return aligned_alloc(alignment, rounded > 0 ? rounded : alignment);
}

static void give(void *user, void *memory)
{
    ((Heap *)user)->held -= memory != NULL;
    free(memory);
}

/// Without memory nothing has changed, and everything comes back; in a step the last good substep stays.
START_TEST(every_allocation_may_fail)
{
    TangleCase tangle;
    ck_assert(tangle_case_make_standard("BLI", 1, 0, &tangle));
    bool has_failed = true;
    size_t n = 0;
    for (; has_failed; n++) {
        Heap heap = {.fail_at = SIZE_MAX};
        PercaleSolverDef solver_def = percale_solver_def_default();
        solver_def.allocate = take;
        solver_def.release = give;
        solver_def.allocator_user = &heap;
        solver_def.self_collision = solver_def.edge_edge = _i;
        PercaleSolver *solver = percale_test_solver(solver_def);
        (void)percale_test_add_cloth(solver, &tangle.cloths[0]);
        uint64_t hash = percale_solver_hash(solver);
        heap.fail_at = heap.calls + n;
        PercaleUntangleDef def = percale_untangle_def_default();
        PercaleUntangleReport report;
        PercaleResult result = _i == 1 ? percale_solver_step(solver, 1.0 / 60.0)
                                       : percale_solver_untangle(solver, &def, &report);
        has_failed = heap.calls > heap.fail_at;
        heap.fail_at = SIZE_MAX;
        ck_assert_int_eq(result, has_failed ? PERCALE_OUT_OF_MEMORY : PERCALE_OK);
        ck_assert(_i == 1 || (percale_solver_hash(solver) == hash) == has_failed);
        ck_assert(pairs_of(solver) >= 0.0);
        percale_solver_destroy(solver);
        ck_assert_uint_eq(heap.held, 0);
    }
    ck_assert_uint_gt(n, 40);
    tangle_case_free(&tangle);
}
END_TEST

// ---- regions and descent ----

/// A strip that hangs through a level sheet: the trace on the strip cuts off its lower end, that on the sheet
/// nothing.
START_TEST(a_trace_cuts_off_the_smaller_part)
{
    TangleCase strip;
    ck_assert(tangle_case_make_standard("BBII", 2, 0, &strip));
    Tangle *tangle = look(solver_of_case(&strip), 1);
    PercaleRegionFlood flood;
    const f32x4 *x = tangle->solver->model.position;
    ck_assert(percale_region_flood_open(&flood, &tangle->mesh, x, &tangle->memory));
    flood.crossings = &tangle->crossings;
    flood.contours = &tangle->contours;
    uint32_t cloth_of[2];
    PercaleTangleRegion regions[2];
    for (uint32_t trace = 0; trace < 2; trace++) {
        cloth_of[trace] = tangle->mesh.object_of[tangle->contours.items[0].triangles[trace]];
        PercaleTangleRegion *region = &regions[cloth_of[trace]];
        ck_assert(percale_region_find(&flood, 0, trace, SIDE_SMALLER, &tangle->memory, region));
        for (uint32_t i = 0; region->is_cut_off && i < region->count; i++) {
            ck_assert(x[region->points[i]][1] < 0.002f);
        }
    }
    ck_assert(!regions[0].is_cut_off && regions[1].is_cut_off);
    double area = 0.44 * TANGLE_SIZE * 3.2 * strip.edge;
    ck_assert_msg(fabs(regions[1].area - area) < 0.25 * area, "%g m^2 instead of about %g", regions[1].area,
                  area);
    percale_region_flood_close(&flood, &tangle->memory);
    look_away(tangle);
    tangle_case_free(&strip);
}
END_TEST

/// Length of the contours when the second cloth is shifted.
static double length_shifted(const TangleCase *dent, const float shift[3])
{
    TangleCase moved = *dent;
    float *positions = moved.cloths[1].positions;
    size_t count = 3 * (size_t)moved.cloths[1].vertex_count;
    float *kept = malloc(count * sizeof(float));
    ck_assert_ptr_nonnull(kept);
    memcpy(kept, positions, count * sizeof(float));
    for (size_t k = 0; k < count; k++) {
        positions[k] += shift[k % 3];
    }
    Tangle *tangle = look(solver_of_case(&moved), 1);
    double length = percale_contours_length(&tangle->contours);
    look_away(tangle);
    memcpy(positions, kept, count * sizeof(float));
    free(kept);
    return length;
}

/// The gradient is the change of the contour's length: the coefficient is 1 (some programs have 2).
START_TEST(the_descent_gradient_is_the_change_of_length)
{
    const float STEP = 1e-4f; // m
    TangleCase dent;
    ck_assert(tangle_case_make_standard("Closed", 2, 0, &dent));
    Tangle *tangle = look(solver_of_case(&dent), 1);
    PercaleTangleStage stage = {.mesh = &tangle->mesh,
                                .crossings = &tangle->crossings,
                                .contours = &tangle->contours,
                                .x = tangle->solver->model.position};
    Vec3 gradient = vec3(0.0, 0.0, 0.0);
    const PercaleContour *contour = &tangle->contours.items[0];
    for (uint32_t i = 0; i < contour->count; i++) {
        uint32_t face = tangle->crossings.items[tangle->contours.steps[contour->first + i].crossing].face;
        double sign = tangle->mesh.object_of[face] == 0 ? 1.0 : -1.0; // the edge moves, or the face
        gradient = vadd(gradient, vscale(sign, percale_descent_gradient(&stage, contour, i)));
    }
    const double slopes[3] = {gradient.x, gradient.y, gradient.z};
    for (int axis = 0; axis < 3; axis++) {
        float shift[3] = {0.0f, 0.0f, 0.0f};
        shift[axis] = STEP;
        double far = length_shifted(&dent, shift);
        shift[axis] = -STEP;
        double slope = (far - length_shifted(&dent, shift)) / (2.0 * (double)STEP);
        ck_assert_msg(fabs(slope - slopes[axis]) < 0.03 * vlength(gradient), "axis %d: %g instead of %g",
                      axis, slopes[axis], slope);
    }
    look_away(tangle);
    tangle_case_free(&dent);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("untangle");
    TCase *sets = tcase_create("sets");
    tcase_add_loop_test(sets, standard_case_comes_apart, 0, STANDARD_COUNT);
    tcase_add_loop_test(sets, nothing_is_made_worse, 0, 2);
    tcase_add_loop_test(sets, momentum_survives_untangling, 0, 4);
    tcase_set_tags(sets, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(sets, 60.0);
    TCase *threads = tcase_create("threads");
    tcase_add_loop_test(threads, one_thread_equals_seven, 0, TANGLE_KINDS);
    tcase_set_timeout(threads, 60.0);
    TCase *laws = tcase_create("laws");
    tcase_add_test(laws, layers_decide_which_side_is_wrong);
    tcase_add_test(laws, what_is_clean_stays_bit_for_bit);
    tcase_add_test(laws, velocities_and_pins_stay);
    tcase_add_test(laws, an_obstacle_waits);
    tcase_add_test(laws, bad_arguments_are_refused);
    tcase_add_loop_test(laws, every_allocation_may_fail, 0, 2);
    tcase_add_test(laws, a_trace_cuts_off_the_smaller_part);
    tcase_add_test(laws, the_descent_gradient_is_the_change_of_length);
    tcase_set_timeout(laws, 60.0);
    suite_add_tcase(suite, sets);
    suite_add_tcase(suite, threads);
    suite_add_tcase(suite, laws);
    return percale_test_run(suite);
}
