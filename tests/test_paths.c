// No path leads through a closed body: random paths aimed at its very edges and vertices.
//
// The paths are those of cloth vertices without cloth: triangles that share nothing and hardly resist being
// stretched. What is asked of a vertex after the step is judged here, for convex bodies, without the engine's
// searches.
//
// `test_paths --full` casts 2 x 10^7 paths instead of 10^5, which takes minutes.

#include "testing.h"

#include "solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const float LOOSE = 1e9f;        // m/N; such an edge doesn't pull
static const double STEP = 1.0 / 64.0;  // s; a power of two, so that v = path / dt is exact
static const double SHALLOW = 2e-6;     // m; what rounding may take of a body in the judgement
static const uint32_t PER_STEP = 24000; // paths at once, a multiple of 3

/// The body that the paths are aimed at.
typedef struct Target {
    const char *name;
    PercaleMesh mesh;
    double half_width; // of a box; 0: a sphere
    double inner;      // m; radius of the ball inside the sphere's faces
} Target;

// ---- judging ----

/// How deep the straight line from a to b goes into the body's inner ball, m; below 0: it stays outside.
static double depth_in_ball(double radius, Vec3 a, Vec3 b)
{
    Vec3 along = vsub(b, a);
    double t = vdot(along, along) > 0.0 ? -vdot(a, along) / vdot(along, along) : 0.0;
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
    return radius - vlength(vadd(a, vscale(t, along)));
}

/// Whether the line from a to b meets the box that is smaller by SHALLOW on each side.
static bool meets_box(double half_width, Vec3 a, Vec3 b)
{
    const double from[3] = {a.x, a.y, a.z};
    const double to[3] = {b.x, b.y, b.z};
    double enter = 0.0;
    double leave = 1.0;
    for (int axis = 0; axis < 3; axis++) {
        double along = to[axis] - from[axis];
        double low = -(half_width - SHALLOW) - from[axis];
        double high = half_width - SHALLOW - from[axis];
        if (along == 0.0) {
            if (low > 0.0 || high < 0.0) {
                return false;
            }
            continue;
        }
        double first = (along > 0.0 ? low : high) / along;
        double second = (along > 0.0 ? high : low) / along;
        enter = first > enter ? first : enter;
        leave = second < leave ? second : leave;
    }
    return enter <= leave;
}

static bool goes_through(const Target *target, Vec3 a, Vec3 b)
{
    return target->half_width > 0.0 ? meets_box(target->half_width, a, b)
                                    : depth_in_ball(target->inner, a, b) > SHALLOW;
}

// ---- aiming ----

static Vec3 mesh_point(const PercaleMesh *mesh, uint32_t vertex)
{
    const float *p = mesh->positions + 3 * (size_t)vertex;
    return vec3((double)p[0], (double)p[1], (double)p[2]);
}

/// A vertex of the body, or a point on one of its edges; on a coarse grid of the edge, so that it is often
/// exact.
static Vec3 pick_aim(const PercaleMesh *mesh, uint64_t *seed)
{
    uint32_t triangle = (uint32_t)(percale_test_random(seed) * mesh->triangle_count);
    uint32_t corner = (uint32_t)(percale_test_random(seed) * 3.0);
    Vec3 a = mesh_point(mesh, mesh->triangles[3 * (size_t)triangle + corner]);
    Vec3 b = mesh_point(mesh, mesh->triangles[3 * (size_t)triangle + (corner + 1) % 3]);
    double share = percale_test_random(seed) < 0.3 ? 0.0 : floor(percale_test_random(seed) * 64.0) / 64.0;
    return vadd(a, vscale(share, vsub(b, a)));
}

/// A direction, one in four along an axis or a diagonal of a face.
static Vec3 pick_direction(uint64_t *seed)
{
    for (;;) {
        Vec3 d = {2.0 * percale_test_random(seed) - 1.0, 2.0 * percale_test_random(seed) - 1.0,
                  2.0 * percale_test_random(seed) - 1.0};
        if (percale_test_random(seed) < 0.25) {
            d = vec3(floor(1.5 * d.x + 0.5), floor(1.5 * d.y + 0.5), floor(1.5 * d.z + 0.5));
        }
        double length2 = vdot(d, d);
        if (length2 > 0.01) {
            return d;
        }
    }
}

static bool is_outside(const Target *target, Vec3 p)
{
    if (target->half_width > 0.0) {
        double most = fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z)));
        return most > target->half_width + 1e-4;
    }
    return vlength(p) > 0.5 + 1e-4;
}

/// Start and velocity of one vertex: from outside, exactly through a point of an edge, to the inside or
/// beyond.
static void aim(const Target *target, uint64_t *seed, float *position, float *velocity)
{
    for (;;) {
        Vec3 through = pick_aim(&target->mesh, seed);
        Vec3 direction = pick_direction(seed);
        double before =
            ldexp(1.0, -(int)(percale_test_random(seed) * 10.0)); // 1 m down to 2 mm, times |direction|
        Vec3 start = vsub(through, vscale(before, direction));
        if (!is_outside(target, start)) {
            continue;
        }
        double beyond = before * (1.0 + ldexp(1.0, (int)(percale_test_random(seed) * 12.0) - 8));
        Vec3 path = vscale(beyond, direction);
        if (vlength(path) > 12.0) {
            continue;
        }
        const double from[3] = {start.x, start.y, start.z};
        const double along[3] = {path.x, path.y, path.z};
        for (int axis = 0; axis < 3; axis++) {
            position[axis] = (float)from[axis];
            velocity[axis] = (float)(along[axis] / STEP);
        }
        return;
    }
}

// ---- the law ----

typedef struct Tally {
    uint64_t paths, through, embree_leaks, inside, passed;
} Tally;

static PercaleSolver *create(PercaleCcd ccd)
{
    PercaleSolverDef def = percale_solver_def_default();
    memset(def.gravity, 0, sizeof(def.gravity));
    def.damping = 0.0f;
    def.speed_max = 1000.0f;
    def.substeps = 1;
    def.ccd = ccd;
    def.thread_count = 2;
    return percale_test_solver(def);
}

static PercaleCloth add_particles(PercaleSolver *solver, const float *positions, const float *velocities,
                                  const float *pattern, const uint32_t *triangles, uint32_t count)
{
    PercaleClothDef def = percale_cloth_def_default();
    def.positions = positions;
    def.velocities = velocities;
    def.vertex_count = count;
    def.triangles = triangles;
    def.triangle_count = count / 3;
    def.rest_uvs = pattern; // a triangle of paths may be anything, its rest shape must have an area
    def.material.stretch_compliance = LOOSE;
    def.material.thickness = 0.002f;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    return cloth;
}

/// Casts the paths with Embree alone and with the engine's exact search.
static void count_leaks(PercaleSolver *solver, Tally *tally)
{
    PERCALE_TEST_OK(solver, percale_solver_validate(solver)); // assembles the model
    const PercaleModel *model = &solver->model;
    PercaleSurface surface = {&model->obstacles[0], &solver->proximities[0].tree, model->position, NULL};
    f32x4 *to = malloc(model->slot_count * sizeof(f32x4));
    uint8_t *flags = malloc(model->slot_count);
    ck_assert_ptr_nonnull(to);
    ck_assert_ptr_nonnull(flags);
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        to[slot] = model->position[slot] + model->velocity[slot] * (float)STEP;
    }
    memset(flags, 1, model->slot_count);
    if (solver->rays != NULL) {
        percale_rays_cast(solver->rays, 0, model->position, to, model->slot_count, flags,
                          percale_team_alone());
    }
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        PercaleCrossing crossing =
            percale_surface_first_crossing(&surface, vec3_of(model->position[slot]), vec3_of(to[slot]));
        tally->through += crossing.triangle != NO_TRIANGLE;
        tally->embree_leaks += crossing.triangle != NO_TRIANGLE && flags[slot] == 0;
    }
    free(to);
    free(flags);
}

/// Vertices below the body's surface, by the audit. Not by its quality figures: it would cross the triangles,
/// too.
static uint64_t count_inside(const Target *target, const float *ends, uint32_t count)
{
    PercaleAuditMesh cloth = {
        .positions = ends, .vertex_count = count, .thickness = 0.002f, .mask = UINT32_MAX};
    PercaleAuditMesh body = {.positions = target->mesh.positions,
                             .vertex_count = target->mesh.vertex_count,
                             .triangles = target->mesh.triangles,
                             .triangle_count = target->mesh.triangle_count,
                             .thickness = 0.002f,
                             .mask = UINT32_MAX};
    float *depths = malloc(sizeof(float) * count);
    ck_assert_ptr_nonnull(depths);
    PERCALE_TEST_OK(NULL, percale_audit_penetration(&cloth, &body, 1, depths));
    uint64_t inside = 0;
    for (uint32_t i = 0; i < count; i++) {
        inside += depths[i] > 0.0f;
    }
    free(depths);
    return inside;
}

static void cast_once(const Target *target, PercaleCcd ccd, uint64_t *seed, uint32_t count, Tally *tally)
{
    float *positions = malloc(3 * sizeof(float) * count);
    float *velocities = malloc(3 * sizeof(float) * count);
    float *ends = malloc(3 * sizeof(float) * count);
    float *pattern = malloc(2 * sizeof(float) * count);
    uint32_t *triangles = malloc(sizeof(uint32_t) * count);
    ck_assert(positions != NULL && velocities != NULL && ends != NULL && pattern != NULL &&
              triangles != NULL);
    for (uint32_t i = 0; i < count; i++) {
        aim(target, seed, positions + 3 * (size_t)i, velocities + 3 * (size_t)i);
        pattern[2 * (size_t)i] = i % 3 == 1 ? 1.0f : 0.0f;
        pattern[2 * (size_t)i + 1] = i % 3 == 2 ? 1.0f : 0.0f;
        triangles[i] = i;
    }
    PercaleSolver *solver = create(ccd);
    PercaleCloth cloth = add_particles(solver, positions, velocities, pattern, triangles, count);
    (void)percale_test_add_obstacle(solver, &target->mesh);
    count_leaks(solver, tally);
    PERCALE_TEST_OK(solver, percale_solver_step(solver, STEP));
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, ends, 0));
    for (uint32_t i = 0; i < count; i++) {
        const float *a = positions + 3 * (size_t)i;
        const float *b = ends + 3 * (size_t)i;
        tally->passed += goes_through(target, vec3((double)a[0], (double)a[1], (double)a[2]),
                                      vec3((double)b[0], (double)b[1], (double)b[2]));
    }
    tally->inside += count_inside(target, ends, count);
    tally->paths += count;
    ck_assert_uint_eq(percale_solver_counters(solver).left_inside, 0);
    percale_solver_destroy(solver);
    free(positions);
    free(velocities);
    free(ends);
    free(pattern);
    free(triangles);
}

static Target make_target(int index)
{
    Target target = {.name = "box", .half_width = 0.5};
    if (index == 3) {
        target.mesh = percale_test_box(1.0f, 1.0f, 1.0f);
        return target;
    }
    target = (Target){.name = "sphere", .mesh = percale_test_sphere(3 + (uint32_t)index, 0.5f), .inner = 0.5};
    for (uint32_t t = 0; t < target.mesh.triangle_count; t++) {
        Vec3 a = mesh_point(&target.mesh, target.mesh.triangles[3 * (size_t)t]);
        Vec3 b = mesh_point(&target.mesh, target.mesh.triangles[3 * (size_t)t + 1]);
        Vec3 c = mesh_point(&target.mesh, target.mesh.triangles[3 * (size_t)t + 2]);
        double distance = vdot(vunit(vcross(vsub(b, a), vsub(c, a))), a);
        target.inner = distance < target.inner ? distance : target.inner;
    }
    return target;
}

enum { BODIES = 4, TESTS = 2 * BODIES }; // with rays, and exactly

/// Paths for one body: the tests from number TESTS on are the full ones.
static uint64_t path_count(int test)
{
    const uint64_t USUAL = PERCALE_SANITIZED ? 1500 : test < BODIES ? 25000 : 4000;
    return test >= TESTS ? 2500000 : USUAL;
}

START_TEST(no_path_leads_into_or_through_a_closed_body)
{
    Target target = make_target(_i % BODIES);
    PercaleCcd ccd = _i % TESTS < BODIES ? PERCALE_CCD_RAY : PERCALE_CCD_EXACT;
    uint64_t seed = 77 + (uint64_t)_i;
    Tally tally = {0};
    while (tally.paths < path_count(_i)) {
        uint64_t rest = path_count(_i) - tally.paths;
        uint32_t count = rest < PER_STEP ? (uint32_t)((rest + 2) / 3 * 3) : PER_STEP;
        cast_once(&target, ccd, &seed, count, &tally);
    }
    printf("%s of %u triangles, %s: %llu paths, %llu into the body; %llu of these rays alone let through\n",
           target.name, target.mesh.triangle_count, ccd == PERCALE_CCD_RAY ? "rays" : "exact",
           (unsigned long long)tally.paths, (unsigned long long)tally.through,
           (unsigned long long)tally.embree_leaks);
    (void)fflush(stdout);
    ck_assert_uint_gt(tally.through, tally.paths / 4); // they were aimed well
    ck_assert_uint_eq(tally.inside, 0);
    ck_assert_uint_eq(tally.passed, 0);
    percale_mesh_free(&target.mesh);
}
END_TEST

int main(int argc, char **argv)
{
    bool full = argc > 1 && strcmp(argv[1], "--full") == 0;
    Suite *suite = suite_create("paths");
    TCase *bodies = tcase_create("closed bodies");
    tcase_set_timeout(bodies, full ? 7200.0 : 100.0);
    tcase_add_loop_test(bodies, no_path_leads_into_or_through_a_closed_body, full ? TESTS : 0,
                        full ? 2 * TESTS : TESTS);
    suite_add_tcase(suite, bodies);
    return percale_test_run(suite);
}
