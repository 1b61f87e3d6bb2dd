// What is thrown together as hard as one likes ends without a crossing.
//
// `test_violent --full [first count]` makes 1,000 runs of 500 to 2,000 vertices, or some of them.

#include "solver.h"
#include "testing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double PI = 3.14159265358979323846;
static const float SPACING = 0.01f; // m, along an edge
static const double SLOWEST = 5.0;  // m/s
static const double FASTEST = 50.0; // m/s

enum { SHEETS_MOST = 3 };

static int first_run = 0;
static int run_count = PERCALE_SANITIZED ? 2 : 12;
static uint32_t vertices_least = 200;
static uint32_t vertices_most = 400;

static double between(uint64_t *seed, double least, double most)
{
    return least + (most - least) * percale_test_random(seed);
}

/// Unit.
static void random_direction(uint64_t *seed, double direction[3])
{
    double z = between(seed, -1.0, 1.0);
    double angle = between(seed, 0.0, 2.0 * PI);
    double across = sqrt(1.0 - z * z);
    direction[0] = across * cos(angle);
    direction[1] = across * sin(angle);
    direction[2] = z;
}

/// A frame whose axes are the rows.
static void random_axes(uint64_t *seed, double axes[3][3])
{
    double other[3];
    random_direction(seed, axes[0]);
    random_direction(seed, other);
    for (int k = 1; k < 3; k++) { // across the other and the one before
        const double *a = axes[k - 1];
        double *c = axes[k];
        for (int i = 0; i < 3; i++) {
            c[i] = a[(i + 1) % 3] * other[(i + 2) % 3] - a[(i + 2) % 3] * other[(i + 1) % 3];
        }
        double length = sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
        for (int i = 0; i < 3; i++) {
            c[i] /= length;
            other[i] = axes[0][i];
        }
    }
}

/// Anywhere around the origin, its own way up, thrown at it and whirling.
static PercaleCloth add_sheet(PercaleSolver *solver, uint64_t *seed, uint32_t side, double from, double speed)
{
    PercaleMesh mesh = percale_test_sheet(side, SPACING * (float)(side - 1));
    double axes[3][3];
    double centre[3];
    double spin[3];
    random_axes(seed, axes);
    random_direction(seed, centre);
    random_direction(seed, spin);
    double whirl = between(seed, 0.0, 0.5 * speed / (0.5 * (double)mesh.vertex_count * (double)SPACING));
    float *velocities = calloc(3 * (size_t)mesh.vertex_count, sizeof(float));
    ck_assert_ptr_nonnull(velocities);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        double local[3];
        for (int k = 0; k < 3; k++) {
            local[k] = 0.0;
            for (int axis = 0; axis < 3; axis++) {
                local[k] += axes[axis][k] * (double)mesh.positions[3 * i + (size_t)axis];
            }
        }
        for (int k = 0; k < 3; k++) {
            double turning = spin[(k + 1) % 3] * local[(k + 2) % 3] - spin[(k + 2) % 3] * local[(k + 1) % 3];
            double jitter = between(seed, -0.02, 0.02) * speed;
            mesh.positions[3 * i + (size_t)k] = (float)(local[k] + from * centre[k]);
            velocities[3 * i + (size_t)k] = (float)(-speed * centre[k] + whirl * turning + jitter);
        }
    }
    PercaleClothDef def = percale_test_cloth_def(&mesh);
    def.velocities = velocities;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    free(velocities);
    percale_mesh_free(&mesh);
    return cloth;
}

/// All come to the origin at the same moment; *frames later they have met. *first is the nearest one.
static PercaleSolver *throw_sheets(uint64_t *seed, int *frames, PercaleCloth *first)
{
    static const int PRESETS[][2] = {{2, 5}, {20, 1}, {80, 1}}; // swift, balanced, accurate
    PercaleSolverDef def = percale_solver_def_default();
    const int *preset = PRESETS[(int)between(seed, 0.0, 3.0)];
    def.substeps = preset[0];
    def.iterations = preset[1];
    def.self_collision = def.edge_edge = 1;
    def.ccd = PERCALE_CCD_EXACT;
    PercaleSolver *solver = percale_test_solver(def);
    int count = (int)between(seed, 2.0, 1.0 + SHEETS_MOST);
    double vertices = between(seed, vertices_least, vertices_most);
    uint32_t side = (uint32_t)sqrt(vertices / count);
    double clear = 0.8 * (double)side * (double)SPACING; // half a diagonal and some more
    double farthest = clear * (2.0 * count - 1.0);
    double moment = farthest / between(seed, SLOWEST, FASTEST);
    for (int i = 0; i < count; i++) { // one behind the other, so that they start apart
        double from = clear * (1.0 + 2.0 * i);
        PercaleCloth cloth = add_sheet(solver, seed, side, from, from / moment);
        *first = i == 0 ? cloth : *first;
    }
    *frames = (int)ceil(2.0 * moment / FRAME) + 4;
    return solver;
}

/// Runs to the end. Returns the crossings, and what the guard has left.
static double crossings_at_end(PercaleSolver *solver, int frames, void (*lead)(PercaleSolver *, void *, int),
                               void *context)
{
    PercaleQuality quality = {0};
    for (int frame = 0; frame < frames; frame++) {
        if (lead != NULL) {
            lead(solver, context, frame);
        }
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    ck_assert(!(quality.nonfinite > 0.0));
    return quality.ef_cloth_cloth;
}

/// The second time all of them are guarded but once a step, over the whole way of it.
START_TEST(what_is_thrown_together_ends_without_a_crossing)
{
    int crossed = 0;
    for (int i = first_run; i < first_run + run_count; i++) {
        uint64_t seed = 977 * (uint64_t)i + 13;
        int frames;
        PercaleCloth first = {0};
        PercaleSolver *solver = throw_sheets(&seed, &frames, &first);
        if (_i == 1) {
            solver->def.passes = solver->def.guard_passes = 1;
        }
        double crossings = crossings_at_end(solver, frames, NULL, NULL);
        if (crossings > 0.0) {
            crossed++;
            PercaleCounters counters = percale_solver_counters(solver);
            printf("run %d: %g crossings, %g left by the guard\n", i, crossings,
                   (double)counters.left_crossed);
        }
        percale_solver_destroy(solver);
    }
    ck_assert_int_eq(crossed, 0);
}
END_TEST

START_TEST(without_the_guard_some_cross)
{
    double crossings = 0.0;
    for (int i = 0; i < 3; i++) {
        uint64_t seed = 977 * (uint64_t)i + 13;
        int frames;
        PercaleCloth first = {0};
        PercaleSolver *solver = throw_sheets(&seed, &frames, &first);
        solver->def.guard = 0;
        crossings += crossings_at_end(solver, frames, NULL, NULL);
        percale_solver_destroy(solver);
    }
    ck_assert_double_gt(crossings, 0.0);
}
END_TEST

enum { LED_MOST = 40 * 40 };

/// A sheet that pins carry along at one speed.
typedef struct Led {
    PercalePin pin;
    uint32_t vertices[LED_MOST];
    uint32_t count;
    float start[3 * LED_MOST];
    double velocity[3]; // m/s
} Led;

static void lead_sheet(PercaleSolver *solver, void *context, int frame)
{
    const Led *led = context;
    float targets[3 * LED_MOST];
    for (uint32_t i = 0; i < 3 * led->count; i++) {
        targets[i] = (float)((double)led->start[i] + led->velocity[i % 3] * FRAME * (frame + 1));
    }
    PERCALE_TEST_OK(solver, percale_pin_move(solver, led->pin, targets, 0));
}

/// The sheet goes on as it flies, whatever is in its way.
static void pin_sheet(PercaleSolver *solver, PercaleCloth cloth, Led *led)
{
    PercaleClothView view;
    PERCALE_TEST_OK(solver, percale_solver_validate(solver));
    PERCALE_TEST_OK(solver, percale_cloth_view(solver, cloth, &view));
    float velocities[3 * LED_MOST];
    led->count = view.vertex_count;
    ck_assert_uint_le(led->count, LED_MOST);
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, led->start, 0));
    PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, cloth, velocities, 0));
    for (uint32_t i = 0; i < led->count; i++) {
        led->vertices[i] = i;
        for (int k = 0; k < 3; k++) {
            led->velocity[k] += (double)velocities[3 * i + (uint32_t)k] / led->count;
        }
    }
    PercalePinDef pin = percale_pin_def_default();
    pin.cloth = cloth;
    pin.vertices = led->vertices;
    pin.vertex_count = led->count;
    PERCALE_TEST_OK(solver, percale_pin_add(solver, &pin, &led->pin));
}

/// What pins lead can't be held back: what lies before it goes along.
START_TEST(what_pins_lead_into_others_takes_them_along)
{
    int crossed = 0;
    for (int i = first_run; i < first_run + run_count; i++) {
        uint64_t seed = 977 * (uint64_t)i + 13;
        int frames;
        PercaleCloth first = {0};
        PercaleSolver *solver = throw_sheets(&seed, &frames, &first);
        static Led led;
        led = (Led){0};
        pin_sheet(solver, first, &led);
        double crossings = crossings_at_end(solver, frames, lead_sheet, &led);
        PercaleCounters counters = percale_solver_counters(solver);
        if (crossings > 0.0 || counters.left_crossed > 0) {
            crossed++;
            printf("run %d: %g crossings, %g left by the guard\n", i, crossings,
                   (double)counters.left_crossed);
        }
        percale_solver_destroy(solver);
    }
    ck_assert_int_eq(crossed, 0);
}
END_TEST

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--full") == 0) {
        first_run = argc > 2 ? (int)strtol(argv[2], NULL, 10) : 0;
        run_count = argc > 3 ? (int)strtol(argv[3], NULL, 10) : 1000;
        vertices_least = 500;
        vertices_most = 2000;
    }
    Suite *suite = suite_create("violent");
    TCase *violent = tcase_create("violent");
    tcase_set_tags(violent, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(violent, 0);
    tcase_add_loop_test(violent, what_is_thrown_together_ends_without_a_crossing, 0, 2);
    tcase_add_test(violent, without_the_guard_some_cross);
    tcase_add_test(violent, what_pins_lead_into_others_takes_them_along);
    suite_add_tcase(suite, violent);
    return percale_test_run(suite);
}
