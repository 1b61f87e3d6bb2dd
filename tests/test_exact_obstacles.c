// With ccd=exact no way of a cloth vertex leads through the front of an obstacle, however that moves.
//
// The way of a vertex through a substep is judged against the straight ways of all triangles in exact
// integers (impact_oracle.h). To be seen, every substep here is a step of its own.

#include "exact_ways.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float LOOSE = 1e9f; // m/N; such an edge doesn't pull

// ---- scenes ----

static PercaleSolverDef weightless(PercaleCcd ccd, int threads)
{
    PercaleSolverDef def = percale_solver_def_default();
    memset(def.gravity, 0, sizeof(def.gravity));
    def.damping = 0.0f;
    def.speed_max = 1000.0f;
    def.substeps = 1;
    def.ccd = ccd;
    def.thread_count = threads;
    return def;
}

/// Vertices without cloth: triangles that share nothing and hardly resist being stretched.
enum { PARTICLES = 300 };

typedef struct Particles {
    float start[3 * PARTICLES];
    float velocity[3 * PARTICLES]; // m/s
    float end[3 * PARTICLES];
    PercaleCloth cloth;
} Particles;

static void add_particles(PercaleSolver *solver, Particles *particles)
{
    uint32_t triangles[PARTICLES];
    float pattern[2 * PARTICLES]; // their places may be anything, a rest shape must have an area
    for (uint32_t i = 0; i < PARTICLES; i++) {
        triangles[i] = i;
        pattern[2 * (size_t)i] = i % 3 == 1 ? 1.0f : 0.0f;
        pattern[2 * (size_t)i + 1] = i % 3 == 2 ? 1.0f : 0.0f;
    }
    PercaleClothDef def = percale_cloth_def_default();
    def.positions = particles->start;
    def.velocities = particles->velocity;
    def.vertex_count = PARTICLES;
    def.triangles = triangles;
    def.triangle_count = PARTICLES / 3;
    def.rest_uvs = pattern;
    def.material.stretch_compliance = LOOSE;
    def.material.thickness = THICKNESS;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &particles->cloth));
}

/// Each from a random place of a box, by the same way in a step.
static void scatter(Particles *particles, const double low[3], const double high[3], const double way[3])
{
    uint64_t seed = 5;
    for (size_t i = 0; i < PARTICLES; i++) {
        for (size_t axis = 0; axis < 3; axis++) {
            particles->start[3 * i + axis] = (float)between(&seed, low[axis], high[axis]);
            particles->velocity[3 * i + axis] = (float)(way[axis] / FRAME);
        }
    }
}

static void turn_to(PercaleSolver *solver, PercaleObstacle obstacle, double degrees, const double shift[3])
{
    double half = 0.5 * degrees * PI / 180.0;
    const double rotation[4] = {0.0, 0.0, sin(half), cos(half)};
    PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, obstacle, rotation, shift));
}

// ---- through many sheets ----

/// Square sheets that face up, one below the other, as one mesh; the first is at y = 0.
static PercaleMesh stack_of(uint32_t count, float apart)
{
    PercaleMesh mesh = percale_test_sheet(2 * count, 1.0f); // has room for it
    mesh.vertex_count = 4 * count;
    mesh.triangle_count = 2 * count;
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        uint32_t sheet = i / 4;
        mesh.positions[3 * (size_t)i] = (i & 1) != 0 ? 4.0f : -4.0f;
        mesh.positions[3 * (size_t)i + 1] = -apart * (float)sheet;
        mesh.positions[3 * (size_t)i + 2] = (i & 2) != 0 ? 4.0f : -4.0f;
    }
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t corners[6] = {4 * i, 4 * i + 2, 4 * i + 1, 4 * i + 1, 4 * i + 2, 4 * i + 3};
        memcpy(mesh.triangles + 6 * (size_t)i, corners, sizeof(corners));
    }
    return mesh;
}

typedef enum Pile { ONE_MESH, FROM_BELOW, FROM_ABOVE, PLATES, PILE_COUNT } Pile;

static void add_pile(PercaleSolver *solver, Pile pile, uint32_t count, float apart)
{
    if (pile == ONE_MESH) {
        PercaleMesh mesh = stack_of(count, apart);
        (void)add_obstacle(solver, &mesh);
        percale_mesh_free(&mesh);
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t place = pile == FROM_BELOW ? count - 1 - i : i;
        PercaleMesh mesh =
            pile == PLATES ? percale_test_box(8.0f, 0.5f * apart, 8.0f) : percale_test_sheet(9, 8.0f);
        percale_test_translate(&mesh, 0.0f, -apart * (float)place - (pile == PLATES ? 0.25f * apart : 0.0f),
                               0.0f);
        (void)add_obstacle(solver, &mesh);
        percale_mesh_free(&mesh);
    }
}

static const struct {
    uint32_t count;
    float apart; // m
} PILES[] = {{2, 0.3f}, {2, 0.0015f}, {8, 0.3f}};

START_TEST(a_way_through_many_sheets_ends_before_the_first)
{
    const double low[3] = {-1.0, 0.0005, -1.0};
    const double high[3] = {1.0, 2.0, 1.0};
    const double way[3] = {0.7, -10.0, 0.3};
    Particles particles;
    scatter(&particles, low, high, way);
    PercaleSolver *solver = percale_test_solver(weightless(PERCALE_CCD_EXACT, 2));
    add_particles(solver, &particles);
    add_pile(solver, (Pile)(_i % PILE_COUNT), PILES[_i / PILE_COUNT].count, PILES[_i / PILE_COUNT].apart);
    for (int k = 0; k < 5; k++) {
        ck_assert_uint_eq(step_and_count(solver, FRAME, NULL), 0);
        PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, particles.cloth, particles.end, 0));
        for (size_t i = 0; i < PARTICLES; i++) {
            ck_assert(particles.end[3 * i + 1] > 0.0f);
            ck_assert(particles.end[3 * i + 1] < 0.01f);
        }
    }
    ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
    percale_solver_destroy(solver);
}
END_TEST

// ---- into a corner ----

/// A wall that rises from the valley on the z axis, at an angle to the vertical, facing the other one.
static PercaleMesh wall(double degrees, int side)
{
    PercaleMesh mesh = percale_test_sheet(5, 4.0f);
    double angle = degrees * PI / 180.0;
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        float *x = mesh.positions + 3 * i;
        double up = (double)x[0] + 2.0;
        x[0] = (float)(side * up * sin(angle));
        x[1] = (float)(up * cos(angle));
    }
    if (side > 0) {
        return mesh;
    }
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        uint32_t *corner = mesh.triangles + 3 * t;
        uint32_t swapped = corner[1];
        corner[1] = corner[2];
        corner[2] = swapped;
    }
    return mesh;
}

/// Both as one mesh; their ridge is the same vertices.
static PercaleMesh valley(double degrees)
{
    PercaleMesh left = wall(degrees, -1);
    PercaleMesh right = wall(degrees, 1);
    PercaleMesh mesh = percale_test_sheet(12, 1.0f); // has room for it
    ck_assert(mesh.vertex_count >= 2 * left.vertex_count && mesh.triangle_count >= 2 * left.triangle_count);
    mesh.vertex_count = 2 * left.vertex_count;
    mesh.triangle_count = 2 * left.triangle_count;
    memcpy(mesh.positions, left.positions, 3 * sizeof(float) * left.vertex_count);
    memcpy(mesh.positions + 3 * (size_t)left.vertex_count, right.positions,
           3 * sizeof(float) * right.vertex_count);
    for (size_t i = 0; i < 3 * (size_t)left.triangle_count; i++) {
        uint32_t vertex = right.triangles[i];
        bool on_ridge = right.positions[3 * (size_t)vertex + 1] <= 0.0f;
        mesh.triangles[i] = left.triangles[i];
        mesh.triangles[3 * (size_t)left.triangle_count + i] = on_ridge ? vertex : left.vertex_count + vertex;
    }
    percale_mesh_free(&left);
    percale_mesh_free(&right);
    return mesh;
}

static const double HALF_ANGLES[] = {0.002, 0.1, 5.0, 30.0, 45.0, 70.0}; // between a wall and the vertical
enum { HALF_ANGLE_COUNT = sizeof(HALF_ANGLES) / sizeof(HALF_ANGLES[0]) };

START_TEST(a_way_into_a_corner_ends_inside_neither_wall)
{
    double degrees = HALF_ANGLES[_i % HALF_ANGLE_COUNT];
    bool moves = _i >= HALF_ANGLE_COUNT; // the corner comes to the cloth
    for (int kind = 0; kind < 2; kind++) {
        double reach = 0.9 * tan(degrees * PI / 180.0);
        const double low[3] = {-reach, 1.0, -1.0};
        const double high[3] = {reach, 1.4, 1.0};
        const double way[3] = {0.0, moves ? 0.0 : -3.0, 0.0};
        const double shift[3] = {0.0, moves ? 3.0 : 0.0, 0.0};
        Particles particles;
        scatter(&particles, low, high, way);
        PercaleSolver *solver = percale_test_solver(weightless(PERCALE_CCD_EXACT, 2));
        add_particles(solver, &particles);
        PercaleMesh walls[2] = {kind == 0 ? valley(degrees) : wall(degrees, -1), wall(degrees, 1)};
        PercaleObstacle obstacles[2];
        for (int k = 0; k <= kind; k++) {
            obstacles[k] = add_obstacle(solver, &walls[k]);
            if (moves) {
                turn_to(solver, obstacles[k], 0.0, shift);
            }
        }
        uint64_t would;
        ck_assert_uint_eq(step_and_count(solver, FRAME, &would), 0);
        ck_assert_uint_gt(would, PARTICLES / 2);
        PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, particles.cloth, particles.end, 0));
        for (size_t i = 0; i < PARTICLES; i++) {
            double across = fabs((double)particles.end[3 * i]);
            double up = (double)particles.end[3 * i + 1] - shift[1];
            ck_assert(up > 0.0);
            ck_assert(across * cos(degrees * PI / 180.0) < up * sin(degrees * PI / 180.0) + 1e-6);
        }
        ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
        percale_solver_destroy(solver);
        percale_mesh_free(&walls[0]);
        percale_mesh_free(&walls[1]);
    }
}
END_TEST

// ---- past an edge ----

/// Ways that pass the box's upper edge at x = 0.5 at most 3 thicknesses away, and end beside it, below its
/// top.
static void pass_edge(Particles *particles)
{
    uint64_t seed = 11;
    for (size_t i = 0; i < PARTICLES; i++) {
        double past = between(&seed, 0.05, 3.0) * (double)THICKNESS;
        double slope = between(&seed, 0.3, 3.0);
        double before = between(&seed, 0.1, 0.4);
        double after = between(&seed, 0.1, 0.4);
        double length = sqrt(1.0 + slope * slope);
        double x = 0.5 + past * slope / length; // square to the way, off the edge
        double y = 0.5 + past / length;
        double z = between(&seed, -0.4, 0.4);
        const double from[3] = {x - before / length, y + before * slope / length, z};
        const double way[3] = {(before + after) / length, -(before + after) * slope / length, 0.0};
        for (size_t axis = 0; axis < 3; axis++) {
            particles->start[3 * i + axis] = (float)from[axis];
            particles->velocity[3 * i + axis] = (float)(way[axis] / FRAME);
        }
    }
}

// Its top's plane is no wall beside it. The box may come along, too: then the ways are as seen from it.
static double farthest_bend(PercaleCcd ccd, bool moves)
{
    Particles particles;
    pass_edge(&particles);
    const double shift[3] = {0.0, moves ? 2.0 : 0.0, moves ? 0.5 : 0.0};
    for (size_t i = 0; i < sizeof(particles.velocity) / sizeof(float); i++) {
        particles.velocity[i] += (float)(shift[i % 3] / FRAME);
    }
    PercaleSolver *solver = percale_test_solver(weightless(ccd, 2));
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    add_particles(solver, &particles);
    PercaleObstacle obstacle = add_obstacle(solver, &box);
    if (moves) {
        turn_to(solver, obstacle, 0.0, shift);
    }
    PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, particles.cloth, particles.end, 0));
    double farthest = 0.0;
    for (size_t i = 0; i < PARTICLES; i++) {
        double bend2 = 0.0;
        for (size_t axis = 0; axis < 3; axis++) {
            double free_end =
                (double)particles.start[3 * i + axis] + (double)particles.velocity[3 * i + axis] * FRAME;
            double bend = (double)particles.end[3 * i + axis] - free_end;
            bend2 += bend * bend;
        }
        farthest = fmax(farthest, sqrt(bend2));
    }
    percale_solver_destroy(solver);
    percale_mesh_free(&box);
    return farthest;
}

START_TEST(past_a_convex_edge_the_way_is_straight)
{
    const PercaleCcd ccd = _i % 2 == 0 ? PERCALE_CCD_EXACT : PERCALE_CCD_RAY;
    ck_assert_double_lt(farthest_bend(ccd, _i / 2 == 1), (double)THICKNESS);
}
END_TEST

// ---- a blade ----

typedef enum Sweep { BLADE, PLATE, FLAPPING, SWEEP_COUNT } Sweep;

static PercaleMesh sweeping_mesh(Sweep sweep)
{
    PercaleMesh mesh =
        sweep == FLAPPING ? percale_test_sphere(2, 0.5f) : percale_test_box(2.0f, 0.001f, 1.0f);
    for (size_t i = 0; sweep == FLAPPING && i < mesh.vertex_count; i++) {
        mesh.positions[3 * i] *= 2.0f;
        mesh.positions[3 * i + 1] *= 0.01f;
    }
    if (sweep == PLATE) {
        percale_test_translate(&mesh, 0.0f, -1.1f, 0.0f);
    }
    return mesh;
}

/// The blade turns by 70 degrees, the plate goes up 2 m and tilts, the disc turns in a bend.
static void sweep_on(PercaleSolver *solver, PercaleObstacle obstacle, const PercaleMesh *mesh, Sweep sweep)
{
    const double shift[3] = {0.0, sweep == PLATE ? 2.2 : 0.0, 0.0};
    if (sweep != FLAPPING) {
        turn_to(solver, obstacle, sweep == BLADE ? 70.0 : 20.0, shift);
        return;
    }
    float *to = malloc(3 * sizeof(float) * mesh->vertex_count);
    ck_assert_ptr_nonnull(to);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        double x = (double)mesh->positions[3 * i];
        double angle = 40.0 * PI / 180.0 * (1.0 + 0.5 * x);
        to[3 * i] = (float)(x * cos(angle) - (double)mesh->positions[3 * i + 1] * sin(angle));
        to[3 * i + 1] =
            (float)(x * sin(angle) + (double)mesh->positions[3 * i + 1] * cos(angle) + 0.2 * x * x);
        to[3 * i + 2] = mesh->positions[3 * i + 2];
    }
    PERCALE_TEST_OK(solver, percale_obstacle_move(solver, obstacle, to, 0, NULL, 0));
    free(to);
}

/// Vertices that have come through, and those that were in the way.
static uint64_t sweep_over(Sweep sweep, PercaleCcd ccd, uint64_t *in_the_way)
{
    const double low[3] = {-0.9, 0.02, -0.4};
    const double high[3] = {0.9, 0.6, 0.4};
    const double way[3] = {0.1, 0.0, 0.05};
    Particles particles;
    scatter(&particles, low, high, way);
    PercaleMesh mesh = sweeping_mesh(sweep);
    PercaleSolver *solver = percale_test_solver(weightless(ccd, 2));
    add_particles(solver, &particles);
    PercaleObstacle obstacle = add_obstacle(solver, &mesh);
    sweep_on(solver, obstacle, &mesh, sweep);
    uint64_t through = step_and_count(solver, FRAME, in_the_way);
    if (ccd == PERCALE_CCD_EXACT) {
        ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
    }
    percale_solver_destroy(solver);
    percale_mesh_free(&mesh);
    return through;
}

START_TEST(what_a_blade_sweeps_over_is_taken_along)
{
    static const char *const NAMES[SWEEP_COUNT] = {"blade", "plate", "flapping disc"};
    uint64_t in_the_way;
    uint64_t by_ray = sweep_over((Sweep)_i, PERCALE_CCD_RAY, &in_the_way);
    uint64_t by_end = sweep_over((Sweep)_i, PERCALE_CCD_OFF, &in_the_way);
    printf("%s: %d vertices in the way; ccd=ray lets %d through, ccd=off %d\n", NAMES[_i], (int)in_the_way,
           (int)by_ray, (int)by_end);
    (void)fflush(stdout);
    ck_assert_uint_gt(in_the_way, PARTICLES / 10);
    ck_assert_uint_eq(sweep_over((Sweep)_i, PERCALE_CCD_EXACT, &in_the_way), 0);
}
END_TEST

// ---- no way ----

// Two boxes change places: whoever was between them comes through one.
START_TEST(what_two_obstacles_leave_no_way_is_counted)
{
    const double low[3] = {-0.5, -0.09, -0.5};
    const double high[3] = {0.5, 0.09, 0.5};
    const double way[3] = {0.1, 0.0, 0.0};
    Particles particles;
    scatter(&particles, low, high, way);
    PercaleSolver *solver = percale_test_solver(weightless(PERCALE_CCD_EXACT, 2));
    add_particles(solver, &particles);
    for (int k = -1; k <= 1; k += 2) {
        PercaleMesh box = percale_test_box(4.0f, 0.2f, 4.0f);
        percale_test_translate(&box, 0.0f, 0.2f * (float)k, 0.0f);
        const double shift[3] = {0.0, -1.0 * k, 0.0};
        turn_to(solver, add_obstacle(solver, &box), 0.0, shift);
        percale_mesh_free(&box);
    }
    ck_assert_uint_eq(step_and_count(solver, FRAME, NULL), PARTICLES);
    PercaleCounters counters = percale_solver_counters(solver);
    ck_assert_uint_ge(counters.left_inside + counters.pinched, PARTICLES);
    percale_solver_destroy(solver);
}
END_TEST

// ---- from behind ----

/// One step with a sheet over the particles that stays (0), goes down (1), or turns, too (2), or without it.
static uint64_t hash_of_flight(Particles *particles, bool with_sheet, int moves)
{
    const double shift[3] = {0.1, -10.0, 0.2};
    PercaleSolver *solver = percale_test_solver(weightless(PERCALE_CCD_EXACT, 2));
    add_particles(solver, particles);
    PercaleMesh sheet = percale_test_sheet(9, 8.0f);
    if (with_sheet) {
        PercaleObstacle obstacle = add_obstacle(solver, &sheet);
        if (moves > 0) {
            turn_to(solver, obstacle, moves == 2 ? 30.0 : 0.0, shift);
        }
    }
    PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    uint64_t hash = percale_solver_hash(solver);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    return hash;
}

// From behind an open surface is not there, nor is it when it goes back over the cloth.
START_TEST(from_behind_the_way_is_free)
{
    for (int moves = 0; moves < 3; moves++) {
        const double low[3] = {-1.0, -2.0, -1.0};
        const double high[3] = {1.0, -0.0001, 1.0};
        const double way[3] = {0.7, moves == 0 ? 10.0 : 0.0, 0.3};
        Particles particles;
        scatter(&particles, low, high, way);
        ck_assert_uint_eq(hash_of_flight(&particles, false, moves), hash_of_flight(&particles, true, moves));
    }
}
END_TEST

// ---- from the surface itself ----

// Exactly on it, on its edges and vertices, too: it begins in front.
START_TEST(what_starts_on_a_surface_starts_in_front_of_it)
{
    const double ways[3][3] = {{0.0, -1.0, 0.0}, {0.3, -0.004, 0.1}, {0.2, 0.0, 0.3}};
    const double ups[2] = {0.0, 1.3}; // m, of the surface
    for (int k = 0; k < 12; k++) {
        const double low[3] = {-1.0, 0.0, -1.0};
        const double high[3] = {1.0, 0.0, 1.0};
        Particles particles;
        scatter(&particles, low, high, ways[k % 3]);
        for (size_t i = 0; i < 3 * PARTICLES; i += 2) {
            particles.start[i] = floorf(4.0f * particles.start[i]) / 4.0f; // many on edges, some on vertices
        }
        PercaleMesh mesh = k / 3 % 2 == 0 ? percale_test_sheet(17, 8.0f) : percale_test_box(8.0f, 1.0f, 8.0f);
        percale_test_translate(&mesh, 0.0f, k / 3 % 2 == 0 ? 0.0f : -0.5f, 0.0f);
        PercaleSolver *solver = percale_test_solver(weightless(PERCALE_CCD_EXACT, 2));
        add_particles(solver, &particles);
        PercaleObstacle obstacle = add_obstacle(solver, &mesh);
        const double shift[3] = {0.0, ups[k / 6], 0.0};
        turn_to(solver, obstacle, 0.0, shift);
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, particles.cloth, particles.end, 0));
        for (size_t i = 0; i < PARTICLES; i++) {
            ck_assert(particles.end[3 * i + 1] > (float)shift[1]);
        }
        ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
        percale_solver_destroy(solver);
        percale_mesh_free(&mesh);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("exact_obstacles");
    TCase *laws = tcase_create("laws");
    tcase_add_loop_test(laws, a_way_through_many_sheets_ends_before_the_first, 0, 3 * PILE_COUNT);
    tcase_add_loop_test(laws, a_way_into_a_corner_ends_inside_neither_wall, 0, 2 * HALF_ANGLE_COUNT);
    tcase_add_loop_test(laws, past_a_convex_edge_the_way_is_straight, 0, 4);
    tcase_add_loop_test(laws, what_a_blade_sweeps_over_is_taken_along, 0, SWEEP_COUNT);
    tcase_add_test(laws, what_two_obstacles_leave_no_way_is_counted);
    tcase_add_test(laws, from_behind_the_way_is_free);
    tcase_add_test(laws, what_starts_on_a_surface_starts_in_front_of_it);
    suite_add_tcase(suite, laws);
    return percale_test_run(suite);
}
