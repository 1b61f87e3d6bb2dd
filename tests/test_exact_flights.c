// What flies and turns, convex or with dents, stiff or bending, at cloth that flies at it: with ccd=exact no
// vertex comes through it, judged step by step in exact integers and by the audit.
//
// `test_exact_flights --full [first count]` throws 2,000 times instead of some, or some of these.

#include "exact_ways.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int first_throw = 0;
static int throw_count = PERCALE_SANITIZED ? 2 : 10;

// ---- bodies ----

typedef enum Body { SLAB, BALL, RING, STAR, SNAKE, BODY_COUNT } Body;

/// A closed tube of `around` x `along` cells; its points are set by the caller.
static PercaleMesh closed_grid(uint32_t along, uint32_t around)
{
    uint32_t side = 2;
    while (side * side < along * around + 2 ||
           2 * (side - 1) * (side - 1) < 2 * along * around + 2 * around) {
        side++;
    }
    PercaleMesh mesh = percale_test_sheet(side, 1.0f); // has room for it
    mesh.vertex_count = along * around;
    mesh.triangle_count = 0;
    for (uint32_t i = 0; i < along; i++) {
        for (uint32_t k = 0; k < around; k++) {
            uint32_t next = (i + 1) % along;
            uint32_t right = (k + 1) % around;
            const uint32_t cell[6] = {i * around + k,     i * around + right,    next * around + k,
                                      i * around + right, next * around + right, next * around + k};
            memcpy(mesh.triangles + 3 * (size_t)mesh.triangle_count, cell, sizeof(cell));
            mesh.triangle_count += 2;
        }
    }
    return mesh;
}

static PercaleMesh ring(void)
{
    enum { ALONG = 12, AROUND = 6 };
    PercaleMesh mesh = closed_grid(ALONG, AROUND);
    for (uint32_t i = 0; i < ALONG * AROUND; i++) {
        uint32_t along = i / AROUND;
        uint32_t around = i % AROUND;
        double u = 2.0 * PI * along / ALONG;
        double v = 2.0 * PI * around / AROUND;
        double r = 0.11 + 0.04 * cos(v);
        mesh.positions[3 * (size_t)i] = (float)(r * cos(u));
        mesh.positions[3 * (size_t)i + 1] = (float)(0.04 * sin(v));
        mesh.positions[3 * (size_t)i + 2] = (float)(r * sin(u));
    }
    return mesh;
}

/// A sphere with deep dents: its radius goes up and down from vertex to vertex.
static PercaleMesh star(void)
{
    PercaleMesh mesh = percale_test_sphere(1, 0.16f);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        float share = i < 12 ? 1.0f : 0.45f; // the icosahedron's own vertices stand out
        for (size_t axis = 0; axis < 3; axis++) {
            mesh.positions[3 * i + axis] *= share;
        }
    }
    return mesh;
}

static PercaleMesh make_body(Body body)
{
    if (body == SLAB) {
        return percale_test_box(0.3f, 0.001f, 0.2f);
    }
    if (body == BALL) {
        return percale_test_sphere(2, 0.13f);
    }
    return body == RING ? ring() : star();
}

/// How a body flies: it turns about an axis of its own, and goes in a straight line.
typedef struct Flight {
    Body body;
    PercaleMesh mesh;
    PercaleObstacle obstacle;
    double axis[3]; // unit
    double spin;    // rad/s
    double velocity[3];
    double seconds;
} Flight;

static void random_direction(uint64_t *seed, double direction[3])
{
    double z = between(seed, -1.0, 1.0);
    double angle = between(seed, 0.0, 2.0 * PI);
    double across = sqrt(1.0 - z * z);
    direction[0] = across * cos(angle);
    direction[1] = across * sin(angle);
    direction[2] = z;
}

/// The snake bends to and fro while it turns; as a deforming obstacle, each of its points is told.
static void move_snake(PercaleSolver *solver, const Flight *flight)
{
    float *to = malloc(3 * sizeof(float) * flight->mesh.vertex_count);
    ck_assert_ptr_nonnull(to);
    double angle = flight->spin * flight->seconds;
    for (size_t i = 0; i < flight->mesh.vertex_count; i++) {
        const float *x = flight->mesh.positions + 3 * i;
        double bend = 0.3 * sin(3.0 * angle);
        const double p[3] = {(double)x[0], (double)x[1] + bend * (double)x[0], (double)x[2] * (1.0 + bend)};
        for (size_t k = 0; k < 3; k++) { // Rodrigues
            const double *n = flight->axis;
            double along = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
            double across = n[(k + 1) % 3] * p[(k + 2) % 3] - n[(k + 2) % 3] * p[(k + 1) % 3];
            to[3 * i + k] =
                (float)(p[k] * cos(angle) + across * sin(angle) + n[k] * along * (1.0 - cos(angle)) +
                        flight->velocity[k] * flight->seconds);
        }
    }
    PERCALE_TEST_OK(solver, percale_obstacle_move(solver, flight->obstacle, to, 0, NULL, 0));
    free(to);
}

static void fly_on(PercaleSolver *solver, Flight *flight, double seconds)
{
    flight->seconds += seconds;
    if (flight->body == SNAKE) {
        move_snake(solver, flight);
        return;
    }
    double half = 0.5 * flight->spin * flight->seconds;
    const double rotation[4] = {flight->axis[0] * sin(half), flight->axis[1] * sin(half),
                                flight->axis[2] * sin(half), cos(half)};
    double translation[3];
    for (int k = 0; k < 3; k++) {
        translation[k] = flight->velocity[k] * flight->seconds;
    }
    PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, flight->obstacle, rotation, translation));
}

/// Square to each other, otherwise any.
static void random_axes(uint64_t *seed, double axes[2][3])
{
    double other[3];
    random_direction(seed, axes[0]);
    random_direction(seed, other);
    double along = 0.0;
    for (int k = 0; k < 3; k++) {
        along += axes[0][k] * other[k];
    }
    double length = sqrt(1.0 - along * along);
    for (int k = 0; k < 3; k++) {
        axes[1][k] = (other[k] - along * axes[0][k]) / length;
    }
}

/// A sheet some way off, flying at the body.
static void throw_sheet(PercaleSolver *solver, uint64_t *seed, double from, double speed)
{
    const float SPACING = 0.02f; // m
    uint32_t side = 6 + (uint32_t)between(seed, 0.0, 8.0);
    PercaleMesh mesh = percale_test_sheet(side, SPACING * (float)(side - 1));
    float *velocities = calloc(3 * (size_t)mesh.vertex_count, sizeof(float));
    ck_assert_ptr_nonnull(velocities);
    double axes[2][3];
    double centre[3];
    random_axes(seed, axes);
    random_direction(seed, centre);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        float *x = mesh.positions + 3 * i;
        const double local[2] = {(double)x[0], (double)x[2]};
        for (size_t k = 0; k < 3; k++) {
            x[k] = (float)(local[0] * axes[0][k] + local[1] * axes[1][k] + from * centre[k]);
            velocities[3 * i + k] = (float)(-speed * centre[k] + between(seed, -0.02, 0.02) * speed);
        }
    }
    PercaleClothDef def = percale_test_cloth_def(&mesh);
    def.velocities = velocities;
    def.material.thickness = THICKNESS;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    free(velocities);
    percale_mesh_free(&mesh);
}

typedef struct Throw {
    PercaleSolver *solver;
    Flight flight;
    double seconds; // of a step
    int steps;
} Throw;

static Throw begin_throw(int number, int threads)
{
    static const double STEPS_PER_FRAME[] = {1.0, 5.0, 20.0};
    uint64_t seed = 977 * (uint64_t)number + 13;
    (void)percale_test_random(&seed);
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = 1;
    def.iterations = 1 + (int)between(&seed, 0.0, 5.0);
    def.passes = 1 + (int)between(&seed, 0.0, def.iterations);
    def.self_collision = def.edge_edge = between(&seed, 0.0, 1.0) < 0.5;
    def.ccd = PERCALE_CCD_EXACT;
    def.thread_count = threads;
    Throw thrown = {.solver = percale_test_solver(def)};
    thrown.seconds = FRAME / STEPS_PER_FRAME[(int)between(&seed, 0.0, 3.0)];
    Flight *flight = &thrown.flight;
    flight->body = (Body)between(&seed, 0.0, BODY_COUNT);
    flight->mesh = make_body(flight->body);
    flight->obstacle = add_obstacle(thrown.solver, &flight->mesh);
    random_direction(&seed, flight->axis);
    random_direction(&seed, flight->velocity);
    flight->spin = between(&seed, 0.0, 60.0); // up to 57 degrees a frame
    double speed = between(&seed, 5.0, 50.0);
    for (int k = 0; k < 3; k++) {
        flight->velocity[k] *= between(&seed, 0.0, 0.3) * speed;
    }
    const double FROM = 0.45; // m
    throw_sheet(thrown.solver, &seed, FROM, speed);
    if (between(&seed, 0.0, 1.0) < 0.4) {
        throw_sheet(thrown.solver, &seed, FROM + 0.3, speed);
    }
    thrown.steps = (int)fmin(40.0, ceil(2.0 * FROM / speed / thrown.seconds) + 3.0);
    return thrown;
}

/// Returns the hash of the end. Vertices that came through, and the audit's view of all steps, are added.
static uint64_t end_throw(Throw *thrown, uint64_t *through, PercaleQuality *worst)
{
    for (int i = 0; i < thrown->steps; i++) {
        fly_on(thrown->solver, &thrown->flight, thrown->seconds);
        if (worst == NULL) {
            PERCALE_TEST_OK(thrown->solver, percale_solver_step(thrown->solver, thrown->seconds));
            continue;
        }
        PercaleQuality now;
        *through += step_and_count(thrown->solver, thrown->seconds, NULL);
        PERCALE_TEST_OK(thrown->solver, percale_solver_quality(thrown->solver, &now));
        worst->vertices_inside = fmax(worst->vertices_inside, now.vertices_inside);
        worst->penetration_max_mm = fmax(worst->penetration_max_mm, now.penetration_max_mm);
        worst->ef_cloth_obstacle = fmax(worst->ef_cloth_obstacle, now.ef_cloth_obstacle);
        worst->ef_cloth_cloth = fmax(worst->ef_cloth_cloth, now.ef_cloth_cloth);
        worst->nonfinite += now.nonfinite;
    }
    uint64_t hash = percale_solver_hash(thrown->solver);
    percale_mesh_free(&thrown->flight.mesh);
    return hash;
}

START_TEST(no_vertex_comes_through_what_flies_and_turns)
{
    uint64_t met = 0;
    uint64_t failed = 0;
    for (int i = first_throw; i < first_throw + throw_count; i++) {
        Throw thrown = begin_throw(i, 2);
        uint64_t through = 0;
        PercaleQuality worst = {0};
        (void)end_throw(&thrown, &through, &worst);
        PercaleCounters counters = percale_solver_counters(thrown.solver);
        met += counters.stencils_vf > 0;
        bool bad = through > 0 || worst.vertices_inside > 0.0 || worst.penetration_max_mm > 0.0 ||
                   worst.nonfinite > 0.0 || counters.left_inside > 0;
        bool crossed = worst.ef_cloth_obstacle > 0.0 || worst.ef_cloth_cloth > 0.0;
        bad = bad || (thrown.solver->def.edge_edge && crossed && counters.left_crossed == 0);
        if (bad) {
            printf("throw %d, body %d, steps of 1/%.0f s: %d through, %g inside, %g mm, %d left; "
                   "%g + %g crossings, %d left\n",
                   i, (int)thrown.flight.body, 1.0 / thrown.seconds, (int)through, worst.vertices_inside,
                   worst.penetration_max_mm, (int)counters.left_inside, worst.ef_cloth_obstacle,
                   worst.ef_cloth_cloth, (int)counters.left_crossed);
            (void)fflush(stdout);
        }
        failed += bad;
        percale_solver_destroy(thrown.solver);
    }
    ck_assert_uint_gt(met, (uint64_t)throw_count / 2);
    ck_assert_uint_eq(failed, 0);
}
END_TEST

START_TEST(one_thread_and_three_make_the_same)
{
    for (int i = 0; i < (PERCALE_SANITIZED ? 2 : 8); i++) {
        Throw alone = begin_throw(i, 1);
        Throw shared = begin_throw(i, 3);
        ck_assert_uint_eq(end_throw(&alone, NULL, NULL), end_throw(&shared, NULL, NULL));
        percale_solver_destroy(alone.solver);
        percale_solver_destroy(shared.solver);
    }
}
END_TEST

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--full") == 0) {
        first_throw = argc > 2 ? (int)strtol(argv[2], NULL, 10) : 0;
        throw_count = argc > 3 ? (int)strtol(argv[3], NULL, 10) : 2000;
    }
    Suite *suite = suite_create("exact_flights");
    TCase *flights = tcase_create("flights");
    tcase_set_timeout(flights, 0);
    tcase_add_test(flights, no_vertex_comes_through_what_flies_and_turns);
    tcase_add_test(flights, one_thread_and_three_make_the_same);
    suite_add_tcase(suite, flights);
    return percale_test_run(suite);
}
