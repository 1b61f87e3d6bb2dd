// Cloth that falls on bodies, leaves them, lies on them and rides on them.

#include "testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double PI = 3.14159265358979323846;

static float *positions_of(PercaleSolver *solver, PercaleCloth cloth, uint32_t count)
{
    float *positions = malloc(3 * sizeof(float) * count);
    ck_assert_ptr_nonnull(positions);
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, positions, 0));
    return positions;
}

static double fastest(PercaleSolver *solver, PercaleCloth cloth)
{
    PercaleClothView view;
    PERCALE_TEST_OK(solver, percale_cloth_view(solver, cloth, &view));
    double most = 0.0;
    for (uint32_t i = 0; i < view.vertex_count; i++) {
        const float *v = view.velocities + 4 * (size_t)view.order[i];
        most = fmax(most, sqrt((double)(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])));
    }
    return most;
}

/// Farthest that a vertex stands from where it stood before, m.
static double drift(const float *before, const float *after, uint32_t count)
{
    double most = 0.0;
    for (size_t i = 0; i < count; i++) {
        double sum = 0.0;
        for (size_t axis = 0; axis < 3; axis++) {
            double d = (double)after[3 * i + axis] - (double)before[3 * i + axis];
            sum += d * d;
        }
        most = fmax(most, sqrt(sum));
    }
    return most;
}

static PercaleQuality quality_of(PercaleSolver *solver)
{
    PercaleQuality quality;
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    return quality;
}

static void run(PercaleSolver *solver, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
}

static PercaleSolver *create(int substeps)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = substeps;
    return percale_test_solver(def);
}

static PercaleCloth add_cloth(PercaleSolver *solver, const PercaleMesh *mesh, float friction)
{
    PercaleClothDef def = percale_test_cloth_def(mesh);
    def.material.thickness = 0.002f;
    def.material.friction = friction;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    return cloth;
}

static PercaleObstacle add_obstacle(PercaleSolver *solver, const PercaleMesh *mesh, float friction)
{
    PercaleObstacleDef def = percale_test_obstacle_def(mesh);
    def.friction = friction;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &def, &obstacle));
    return obstacle;
}

// ---- drops ----

enum { CONE_SIDES = 24 };

/// Closed cone, its tip up at y = 0.
static PercaleMesh make_cone(float radius, float height)
{
    PercaleMesh cone =
        percale_test_sphere(1, 1.0f); // has room for the vertices; the name and the ownership fit
    ck_assert(cone.vertex_count >= CONE_SIDES + 2 && cone.triangle_count >= 2 * CONE_SIDES);
    cone.vertex_count = CONE_SIDES + 2;
    cone.triangle_count = 2 * CONE_SIDES;
    const float ends[6] = {0.0f, 0.0f, 0.0f, 0.0f, -height, 0.0f};
    memcpy(cone.positions + 3 * (size_t)CONE_SIDES, ends, sizeof(ends));
    for (uint32_t i = 0; i < CONE_SIDES; i++) {
        double angle = 2.0 * PI * i / CONE_SIDES;
        const float p[3] = {radius * (float)cos(angle), -height, -radius * (float)sin(angle)};
        memcpy(cone.positions + 3 * (size_t)i, p, sizeof(p));
        uint32_t next = (i + 1) % CONE_SIDES;
        const uint32_t sides[6] = {i, next, CONE_SIDES, next, i, CONE_SIDES + 1};
        memcpy(cone.triangles + 6 * (size_t)i, sides, sizeof(sides));
    }
    return cone;
}

static PercaleMesh make_body(int kind)
{
    if (kind == 2) {
        return make_cone(0.15f, 0.6f);
    }
    PercaleMesh body = kind == 0 ? percale_test_box(0.4f, 0.4f, 0.4f) : percale_test_sphere(3, 0.2f);
    percale_test_translate(&body, 0.0f, -0.2f, 0.0f);
    return body;
}

START_TEST(a_dropped_sheet_stays_outside)
{
    static const int SUBSTEPS[] = {1, 5, 20};
    PercaleMesh body = make_body(_i / 3);
    PercaleMesh sheet = percale_test_sheet(PERCALE_SANITIZED ? 11 : 31, 0.8f);
    percale_test_translate(&sheet, 0.013f, 0.15f, 0.007f);
    PercaleSolver *solver = create(SUBSTEPS[_i % 3]);
    (void)add_cloth(solver, &sheet, 0.3f);
    (void)add_obstacle(solver, &body, 0.3f);
    double contact = 0.0;
    for (int k = 0; k < (PERCALE_SANITIZED ? 5 : 20); k++) {
        run(solver, 4);
        PercaleQuality quality = quality_of(solver);
        ck_assert_double_eq(quality.vertices_inside, 0.0);
        ck_assert_double_eq(quality.penetration_max_mm, 0.0);
        ck_assert_double_eq(quality.nonfinite, 0.0);
        contact = fmax(contact, quality.contact_fraction);
    }
    ck_assert_double_gt(contact, 0.0); // it did land
    ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    percale_mesh_free(&body);
}
END_TEST

// ---- out of a body ----

/// A patch of a sphere's own shape, `depth` below its surface, at the top.
static PercaleMesh make_patch(float radius, float depth)
{
    PercaleMesh patch = percale_test_sheet(9, 0.12f);
    for (size_t i = 0; i < patch.vertex_count; i++) {
        float *p = patch.positions + 3 * i;
        float r = radius - depth;
        p[1] = sqrtf(r * r - p[0] * p[0] - p[2] * p[2]);
    }
    return patch;
}

/// Lets the patch rise out of the sphere; the fastest of it, by its way and by its velocity, m/s.
static void leave(float depth, int substeps, bool by_gravity, double *speed, int *frames_inside)
{
    PercaleMesh body = percale_test_sphere(4, 0.5f);
    PercaleMesh patch = make_patch(0.5f, depth);
    PercaleSolverDef def = percale_solver_def_default();
    def.substeps = substeps;
    if (!by_gravity) {
        memset(def.gravity, 0, sizeof(def.gravity));
    }
    PercaleSolver *solver = percale_test_solver(def);
    PercaleCloth cloth = add_cloth(solver, &patch, 0.3f);
    (void)add_obstacle(solver, &body, 0.3f);
    *speed = 0.0;
    *frames_inside = 0;
    float *before = positions_of(solver, cloth, patch.vertex_count);
    for (int frame = 0; frame < 40; frame++) {
        run(solver, 1);
        float *after = positions_of(solver, cloth, patch.vertex_count);
        *speed = fmax(*speed, drift(before, after, patch.vertex_count) / FRAME);
        *speed = fmax(*speed, fastest(solver, cloth));
        *frames_inside += quality_of(solver).vertices_inside > 0.0;
        free(before);
        before = after;
    }
    free(before);
    ck_assert_double_eq(quality_of(solver).vertices_inside, 0.0);
    percale_solver_destroy(solver);
    percale_mesh_free(&patch);
    percale_mesh_free(&body);
}

START_TEST(cloth_that_starts_inside_leaves_without_a_shot)
{
    const int substeps = _i == 0 ? 1 : 20;
    double speed;
    int frames;
    leave(0.005f, substeps, true, &speed, &frames);
    ck_assert_double_lt(speed, 0.65); // EXIT_SPEED is 0.5 m/s; the ways out of neighbours differ a little
    ck_assert_int_lt(frames, 5);
}
END_TEST

START_TEST(cloth_that_starts_deep_inside_leaves_too)
{
    double speed;
    int frames;
    leave(0.1f, 20, _i == 1, &speed, &frames);
    ck_assert_double_lt(speed, 0.75);
    ck_assert_int_gt(frames, 8); // 10 cm at 0.5 m/s
    ck_assert_int_lt(frames, 20);
}
END_TEST

// ---- at rest ----

START_TEST(what_lies_on_the_ground_stays_there)
{
    PercaleMesh ground = percale_test_box(4.0f, 1.0f, 4.0f);
    percale_test_translate(&ground, 0.0f, -0.5f, 0.0f);
    PercaleMesh sheet = percale_test_sheet(15, 0.3f);
    percale_test_translate(&sheet, 0.011f, 0.002f, 0.017f);
    PercaleSolver *solver = create(_i == 0 ? 20 : 3);
    PercaleCloth cloth = add_cloth(solver, &sheet, 0.3f);
    (void)add_obstacle(solver, &ground, 0.3f);
    run(solver, 30); // it settles
    float *before = positions_of(solver, cloth, sheet.vertex_count);
    run(solver, PERCALE_SANITIZED ? 60 : 600);
    float *after = positions_of(solver, cloth, sheet.vertex_count);
    ck_assert_double_lt(drift(before, after, sheet.vertex_count), 1e-3);
    ck_assert_double_lt(fastest(solver, cloth), 2e-3);
    ck_assert_double_eq(quality_of(solver).vertices_inside, 0.0);
    free(before);
    free(after);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    percale_mesh_free(&ground);
}
END_TEST

// ---- riding ----

/// Mean angle about the y axis by which the cloth has turned, rad (less than half a turn).
static double turned(const float *before, const float *after, uint32_t count)
{
    double along = 0.0;
    double across = 0.0;
    for (size_t i = 0; i < count; i++) {
        const float *a = before + 3 * i;
        const float *b = after + 3 * i;
        along += (double)a[0] * (double)b[0] + (double)a[2] * (double)b[2];
        across += (double)a[2] * (double)b[0] - (double)a[0] * (double)b[2];
    }
    return atan2(across, along);
}

START_TEST(a_turntable_carries_its_cloth)
{
    const double RATE = 1.0; // rad/s; at 0.35 m that asks for 0.35 m/s^2 of the friction's 4.9
    PercaleMesh table = percale_test_box(2.0f, 0.1f, 2.0f);
    percale_test_translate(&table, 0.0f, -0.05f, 0.0f);
    PercaleMesh sheet = percale_test_sheet(7, 0.1f);
    percale_test_translate(&sheet, 0.3f, 0.002f, 0.0f);
    PercaleSolver *solver = create(20);
    PercaleCloth cloth = add_cloth(solver, &sheet, 0.5f);
    PercaleObstacle obstacle = add_obstacle(solver, &table, 0.5f);
    run(solver, 10);
    float *before = positions_of(solver, cloth, sheet.vertex_count);
    double angle = 0.0;
    for (int frame = 0; frame < 120; frame++) {
        angle += RATE * FRAME * fmin(1.0, (frame + 0.5) / 20.0); // a gentle start
        const double rotation[4] = {0.0, sin(0.5 * angle), 0.0, cos(0.5 * angle)};
        const double translation[3] = {0.0, 0.0, 0.0};
        PERCALE_TEST_OK(solver, percale_obstacle_set_transform(solver, obstacle, rotation, translation));
        run(solver, 1);
    }
    float *after = positions_of(solver, cloth, sheet.vertex_count);
    ck_assert_double_eq_tol(turned(before, after, sheet.vertex_count), angle, 0.005 * angle);
    for (size_t i = 0; i < sheet.vertex_count; i++) {
        double radius = hypot((double)before[3 * i], (double)before[3 * i + 2]);
        ck_assert_double_eq_tol(hypot((double)after[3 * i], (double)after[3 * i + 2]), radius, 2e-3);
        ck_assert(after[3 * i + 1] > 0.0f);
    }
    free(before);
    free(after);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
    percale_mesh_free(&table);
}
END_TEST

// ---- over an edge ----

// A small stiff patch slides off a table without friction: from the edge on it falls freely. A contact plane
// that is kept beyond the edge would carry it on.
START_TEST(beyond_a_convex_edge_nothing_carries)
{
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    percale_test_translate(&box, 0.0f, -0.5f, 0.0f);
    const float SPEED = 2.0f; // m/s
    float positions[9] = {0.30f, 0.002f, 0.0f, 0.31f, 0.002f, 0.01f, 0.31f, 0.002f, -0.01f};
    float velocities[9] = {SPEED, 0.0f, 0.0f, SPEED, 0.0f, 0.0f, SPEED, 0.0f, 0.0f};
    uint32_t triangle[3] = {0, 1, 2};
    PercaleSolverDef solver_def = percale_solver_def_default();
    solver_def.damping = 0.0f;
    PercaleSolver *solver = percale_test_solver(solver_def);
    PercaleClothDef def = percale_cloth_def_default();
    def.positions = positions;
    def.velocities = velocities;
    def.vertex_count = 3;
    def.triangles = triangle;
    def.triangle_count = 1;
    def.material.thickness = 0.002f;
    def.material.friction = 0.0f;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    (void)add_obstacle(solver, &box, 0.0f);
    run(solver, 15); // the last vertex has left the edge at 0.1 s
    float end[9];
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, end, 0));
    double mean_x = ((double)end[0] + (double)end[3] + (double)end[6]) / 3.0;
    double mean_y = ((double)end[1] + (double)end[4] + (double)end[7]) / 3.0;
    ck_assert_double_eq_tol(mean_x, 0.3067 + 2.0 * 0.25, 0.01);
    ck_assert_double_eq_tol(mean_y, -0.5 * 9.81 * 0.15 * 0.15, 0.015);
    percale_solver_destroy(solver);
    percale_mesh_free(&box);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("drops");
    TCase *drops = tcase_create("drops");
    tcase_set_tags(drops, PERCALE_ONE_THREAD);
    tcase_set_timeout(drops, 60.0);
    tcase_add_loop_test(drops, a_dropped_sheet_stays_outside, 0, 9);
    suite_add_tcase(suite, drops);
    TCase *inside = tcase_create("out of a body");
    tcase_set_tags(inside, PERCALE_ONE_THREAD);
    tcase_set_timeout(inside, 60.0);
    tcase_add_loop_test(inside, cloth_that_starts_inside_leaves_without_a_shot, 0, 2);
    tcase_add_loop_test(inside, cloth_that_starts_deep_inside_leaves_too, 0, 2);
    suite_add_tcase(suite, inside);
    TCase *contact = tcase_create("contact");
    tcase_set_tags(contact, PERCALE_ONE_THREAD);
    tcase_set_timeout(contact, 60.0);
    tcase_add_loop_test(contact, what_lies_on_the_ground_stays_there, 0, 2);
    tcase_add_test(contact, a_turntable_carries_its_cloth);
    tcase_add_test(contact, beyond_a_convex_edge_nothing_carries);
    suite_add_tcase(suite, contact);
    return percale_test_run(suite);
}
