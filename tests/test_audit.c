// The audit against slow, obvious twins (all pairs, all triangles, the sum of all solid angles) and the laws
// of what each figure means.

#include "audit/audit.h"
#include "audit_testing.h"

#include <string.h>

static const double ROUNDING_MM = 1e-6; // of distances of positions in float, some of which are not exact
static const double PI = 3.14159265358979323846;

static PercaleMesh room_for(uint32_t vertex_count, uint32_t triangle_count)
{
    size_t position_count = 3 * (size_t)vertex_count;
    size_t corner_count = 3 * (size_t)triangle_count;
    PercaleMesh mesh = {.vertex_count = vertex_count, .triangle_count = triangle_count};
    ck_assert(position_count > 0 && corner_count > 0);
    mesh.positions = calloc(position_count, sizeof *mesh.positions);
    mesh.triangles = calloc(corner_count, sizeof *mesh.triangles);
    ck_assert(mesh.positions && mesh.triangles);
    return mesh;
}

// A closed mesh and its copy as one mesh.
static PercaleMesh twice(const PercaleMesh *mesh)
{
    size_t position_count = 3 * (size_t)mesh->vertex_count;
    size_t corner_count = 3 * (size_t)mesh->triangle_count;
    PercaleMesh both = room_for(2 * mesh->vertex_count, 2 * mesh->triangle_count);
    for (size_t i = 0; i < position_count; i++) {
        both.positions[i] = mesh->positions[i];
        both.positions[position_count + i] = mesh->positions[i];
    }
    for (size_t i = 0; i < corner_count; i++) {
        both.triangles[i] = mesh->triangles[i];
        both.triangles[corner_count + i] = mesh->triangles[i] + mesh->vertex_count;
    }
    return both;
}

// Two bumpy balls of radius 0.1 m that overlap by a third, as one closed mesh.
static PercaleMesh overlapping_balls(uint64_t *seed)
{
    PercaleMesh ball = percale_test_sphere(2, 0.1f);
    PercaleMesh both = twice(&ball);
    for (size_t i = ball.vertex_count; i < both.vertex_count; i++)
        both.positions[3 * i] += 0.13f;
    jitter(&both, 0.004, seed);
    percale_mesh_free(&ball);
    return both;
}

// ---- twins ----

// Van Oosterom and Strackee 1983, over all triangles.
static double twin_winding(const PercaleAuditMesh *body, Vector point)
{
    double angle = 0.0;
    for (size_t t = 0; t < body->triangle_count; t++) {
        Vector a = plus(vector_at(body->positions, body->triangles[3 * t]), -1.0, point);
        Vector b = plus(vector_at(body->positions, body->triangles[3 * t + 1]), -1.0, point);
        Vector c = plus(vector_at(body->positions, body->triangles[3 * t + 2]), -1.0, point);
        double la = length_of(a);
        double lb = length_of(b);
        double lc = length_of(c);
        angle += 2.0 * atan2(inner(a, outer(b, c)),
                             la * lb * lc + inner(a, b) * lc + inner(b, c) * la + inner(c, a) * lb);
    }
    return angle / (4.0 * PI);
}

// Regions of the plane's coordinates, after Ericson 2005, section 5.1.5.
static double twin_triangle_distance(Vector p, Vector a, Vector b, Vector c)
{
    Vector ab = plus(b, -1.0, a);
    Vector ac = plus(c, -1.0, a);
    double d1 = inner(ab, plus(p, -1.0, a));
    double d2 = inner(ac, plus(p, -1.0, a));
    double d3 = inner(ab, plus(p, -1.0, b));
    double d4 = inner(ac, plus(p, -1.0, b));
    double d5 = inner(ab, plus(p, -1.0, c));
    double d6 = inner(ac, plus(p, -1.0, c));
    double va = d3 * d6 - d5 * d4;
    double vb = d5 * d2 - d1 * d6;
    double vc = d1 * d4 - d3 * d2;
    Vector nearest;
    if (d1 <= 0.0 && d2 <= 0.0)
        nearest = a;
    else if (d3 >= 0.0 && d4 <= d3)
        nearest = b;
    else if (d6 >= 0.0 && d5 <= d6)
        nearest = c;
    else if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0)
        nearest = plus(a, d1 / (d1 - d3), ab);
    else if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0)
        nearest = plus(a, d2 / (d2 - d6), ac);
    else if (va <= 0.0 && d4 >= d3 && d5 >= d6)
        nearest = plus(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), plus(c, -1.0, b));
    else
        nearest = plus(plus(a, vb / (va + vb + vc), ab), vc / (va + vb + vc), ac);
    return length_of(plus(p, -1.0, nearest));
}

static double twin_distance(const PercaleAuditMesh *body, Vector point)
{
    double nearest = (double)INFINITY;
    for (size_t t = 0; t < body->triangle_count; t++) {
        Vector corners[3];
        for (size_t k = 0; k < 3; k++)
            corners[k] = vector_at(body->positions, body->triangles[3 * t + k]);
        nearest = fmin(nearest, twin_triangle_distance(point, corners[0], corners[1], corners[2]));
    }
    return nearest;
}

// ---- penetration ----

START_TEST(depths_equal_those_of_all_triangles)
{
    enum { POINT_COUNT = 600 };
    uint64_t seed = 7;
    PercaleMesh balls = overlapping_balls(&seed);
    PercaleAuditMesh body = as_audit(&balls);
    float points[3 * POINT_COUNT];
    float depths[POINT_COUNT];
    for (size_t i = 0; i < 3 * (size_t)POINT_COUNT; i++)
        points[i] = random_between(&seed, -0.12, i % 3 == 0 ? 0.25 : 0.12);
    PercaleAuditMesh cloud = as_points(points, POINT_COUNT);
    PERCALE_TEST_OK(NULL, percale_audit_penetration(&cloud, &body, 1, depths));
    double deepest = 0.0;
    double inside_count = 0.0;
    double double_count = 0.0;
    for (size_t i = 0; i < POINT_COUNT; i++) {
        double winding = twin_winding(&body, vector_at(points, i));
        double depth = winding > 0.5 ? twin_distance(&body, vector_at(points, i)) : 0.0;
        ck_assert_double_eq_tol((double)depths[i], depth, 1e-8);
        deepest = fmax(deepest, depth);
        inside_count += winding > 0.5;
        double_count += winding > 1.5;
    }
    PercaleQuality quality = judge(&cloud, &body);
    ck_assert_double_eq_tol(quality.penetration_max_mm, 1e3 * deepest, ROUNDING_MM);
    ck_assert_double_eq(quality.vertices_inside, inside_count);
    ck_assert_double_gt(double_count, 10.0); // inside both balls: winding number 2
    percale_mesh_free(&balls);
}
END_TEST

START_TEST(rays_through_edges_and_vertices_are_counted_once)
{
    // The rays of these points run exactly through vertices and along edges and faces of the box.
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    PercaleAuditMesh body = as_audit(&box);
    const float points[][3] = {{0.25f, 0.0f, 0.0f},   {0.0f, 0.125f, 0.125f}, {-0.4f, 0.2f, -0.2f},
                               {-0.75f, 0.0f, 0.0f},  {-0.75f, 0.5f, 0.5f},   {-0.75f, 0.5f, 0.0f},
                               {-0.75f, -0.5f, 0.1f}, {0.75f, 0.0f, 0.0f},    {0.0f, 0.5f, 0.0f},
                               {0.5f, 0.5f, 0.5f},    {-0.5f, 0.1f, 0.2f},    {-0.6f, -0.5f, -0.5f}};
    const float expected[] = {0.25f, 0.375f, 0.1f};
    float depths[12];
    PercaleAuditMesh cloud = as_points(points[0], 12);
    PERCALE_TEST_OK(NULL, percale_audit_penetration(&cloud, &body, 1, depths));
    for (size_t i = 0; i < 12; i++)
        ck_assert_double_eq_tol((double)depths[i], i < 3 ? (double)expected[i] : 0.0, 1e-7);
    percale_mesh_free(&box);
}
END_TEST

START_TEST(an_open_surface_counts_5_mm_behind_it_but_not_behind_its_rim)
{
    PercaleMesh sheet = percale_test_sheet(5, 0.4f);
    PercaleAuditMesh surface = as_audit(&sheet);
    // before; behind; 5 mm exceeded; on it; behind an edge and a vertex; beside the rim; below a corner
    const float points[][3] = {{0.03f, 1e-3f, 0.01f},   {0.03f, -4e-3f, 0.01f}, {0.03f, -6e-3f, 0.01f},
                               {0.03f, 0.0f, 0.01f},    {0.0f, -2e-3f, 0.05f},  {0.1f, -3e-3f, 0.1f},
                               {0.203f, -1e-3f, 0.03f}, {0.2f, -1e-3f, 0.2f}};
    surface.thickness = 10e-3f; // the contact is looked for farther than 5 mm
    const double expected_mm[] = {0.0, 4.0, 0.0, 0.0, 2.0, 3.0, 0.0, 0.0};
    float depths[8];
    PercaleAuditMesh cloud = as_points(points[0], 8);
    PERCALE_TEST_OK(NULL, percale_audit_penetration(&cloud, &surface, 1, depths));
    for (size_t i = 0; i < 8; i++)
        ck_assert_double_eq_tol(1e3 * (double)depths[i], expected_mm[i], ROUNDING_MM);
    ck_assert_double_eq(judge(&cloud, &surface).vertices_inside, 3.0);
    percale_mesh_free(&sheet);
}
END_TEST

START_TEST(an_open_top_and_the_closed_body_agree_near_the_top)
{
    // A crooked pyramid: one face's side alone would misjudge points beside its sharp top.
    const float x[][3] = {{0.0f, 0.5f, 0.0f},
                          {0.02f, 0.0f, 0.01f},
                          {0.1f, 0.0f, -0.4f},
                          {-0.3f, 0.0f, -0.01f},
                          {-0.02f, 0.0f, 0.03f}};
    const uint32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 1, 4, 2, 2, 4, 3};
    PercaleAuditMesh closed = as_triangles(x[0], 5, triangles, 6);
    PercaleAuditMesh open = as_triangles(x[0], 5, triangles, 4);
    enum { POINT_COUNT = 4000 };
    uint64_t seed = 11;
    float points[3 * POINT_COUNT];
    static float closed_depths[POINT_COUNT];
    static float open_depths[POINT_COUNT];
    for (size_t i = 0; i < 3 * (size_t)POINT_COUNT; i++)
        points[i] = random_between(&seed, -3e-3, 3e-3) + (i % 3 == 1 ? 0.4985f : 0.0f);
    PercaleAuditMesh cloud = as_points(points, POINT_COUNT);
    PERCALE_TEST_OK(NULL, percale_audit_penetration(&cloud, &closed, 1, closed_depths));
    PERCALE_TEST_OK(NULL, percale_audit_penetration(&cloud, &open, 1, open_depths));
    ck_assert_mem_eq(closed_depths, open_depths, sizeof closed_depths);
    ck_assert_double_gt(judge(&cloud, &open).vertices_inside, 100.0);
}
END_TEST

START_TEST(a_vertex_on_the_surface_is_not_inside)
{
    // Exactly on a face, where the rounded distance is not always 0: (2 a + b + c) / 4 has no rounding here.
    const uint32_t triangles[] = {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2};
    uint64_t seed = 13;
    for (int trial = 0; trial < 400; trial++) {
        float x[4][3];
        float point[3];
        for (size_t axis = 0; axis < 3; axis++) {
            for (size_t i = 0; i < 4; i++)
                x[i][axis] = (float)floor(0x1p20 * percale_test_random(&seed)) * 0x1p-18f;
            point[axis] = 0.5f * x[0][axis] + 0.25f * (x[1][axis] + x[2][axis]);
        }
        PercaleAuditMesh body = as_triangles(x[0], 4, triangles, 4);
        PercaleAuditMesh cloud = as_points(point, 1);
        ck_assert_double_eq(judge(&cloud, &body).vertices_inside, 0.0);
        ck_assert_double_eq(judge(&cloud, &body).contact_fraction, 1.0);
    }
}
END_TEST

START_TEST(a_body_with_a_triangle_turned_over_is_open)
{
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    PercaleAuditMesh body = as_audit(&box);
    const float centre[] = {0.0f, 0.1f, 0.2f};
    PercaleAuditMesh cloud = as_points(centre, 1);
    ck_assert_double_eq(judge(&cloud, &body).vertices_inside, 1.0);
    uint32_t swapped = box.triangles[0];
    box.triangles[0] = box.triangles[1];
    box.triangles[1] = swapped;
    ck_assert_double_eq(judge(&cloud, &body).vertices_inside, 0.0);
    percale_mesh_free(&box);
}
END_TEST

START_TEST(the_percentile_is_over_all_finite_cloth_vertices)
{
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    PercaleAuditMesh body = as_audit(&box);
    float points[201][3];
    for (size_t i = 0; i < 201; i++)
        memcpy(points[i], (const float[]){0.0f, 2.0f, 0.0f}, sizeof points[i]);
    points[5][1] = 0.499f;
    points[70][1] = 0.498f;
    points[200][1] = NAN;
    PercaleAuditMesh cloud = as_points(points[0], 201);
    // Index ceil(0.99 * 200) - 1 = 197 of 200: the third from the end.
    ck_assert_double_eq(judge(&cloud, &body).penetration_p99_mm, 0.0);
    points[71][1] = 0.497f;
    ck_assert_double_eq_tol(judge(&cloud, &body).penetration_p99_mm, 1.0, 1e-4);
    ck_assert_double_eq_tol(judge(&cloud, &body).penetration_max_mm, 3.0, 1e-4);
    percale_mesh_free(&box);
}
END_TEST

START_TEST(contact_is_within_one_and_a_half_thicknesses_of_the_pair)
{
    PercaleMesh box = percale_test_box(1.0f, 1.0f, 1.0f);
    PercaleAuditMesh body = as_audit(&box);
    body.thickness = 1e-3f; // the pair's: 1.5 mm, so contact reaches 2.25 mm
    const float points[][3] = {{0.1f, 0.5022f, 0.0f},
                               {0.1f, 0.5023f, 0.0f},
                               {0.1f, 0.499f, 0.0f},
                               {0.1f, 0.4f, 0.0f},
                               {0.1f, NAN, 0.0f}};
    PercaleAuditMesh cloud = as_points(points[0], 5);
    ck_assert_double_eq(judge(&cloud, &body).contact_fraction, 0.5);
    cloud.mask = 2;
    ck_assert_double_eq(judge(&cloud, &body).contact_fraction, 0.0);
    ck_assert_double_eq(judge(&cloud, &body).vertices_inside, 0.0);
    percale_mesh_free(&box);
}
END_TEST

// ---- obstacle vertices ----

START_TEST(a_spike_stands_out_by_its_height_above_the_cloth)
{
    // The spike's top is 12 mm above a cloth of two triangles none of whose vertices is near.
    const float spike[][3] = {{0.01f, 0.0f, 0.0f}, {0.0f, 0.0f, -0.01f}, {-0.01f, 0.0f, 0.0f},
                              {0.0f, 0.0f, 0.01f}, {0.0f, 0.015f, 0.0f}, {0.0f, -0.5f, 0.0f}};
    const uint32_t faces[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 1, 0, 5, 2, 1, 5, 3, 2, 5, 0, 3, 5};
    PercaleAuditMesh body = as_triangles(spike[0], 6, faces, 8);
    PercaleMesh sheet = percale_test_sheet(2, 2.0f);
    percale_test_translate(&sheet, 0.1f, 0.003f, 0.0f);
    PercaleAuditMesh cloth = as_audit(&sheet);
    PercaleQuality quality = judge(&cloth, &body);
    ck_assert_double_eq_tol(quality.penetration_obstacle_mm, 12.0, 1e-5);
    ck_assert_double_eq(quality.vertices_inside, 0.0);
    ck_assert_double_eq(quality.ef_cloth_obstacle, 4.0);
    percale_test_translate(&sheet, 0.0f, 0.013f, 0.0f); // above the spike
    ck_assert_double_eq(judge(&cloth, &body).penetration_obstacle_mm, 0.0);
    percale_test_translate(&sheet, 0.0f, -0.026f, 0.0f); // 25 mm below the top: beyond the reach
    ck_assert_double_lt(judge(&cloth, &body).penetration_obstacle_mm, 20.0);
    percale_mesh_free(&sheet);
}
END_TEST

START_TEST(nothing_stands_out_beyond_the_bodys_own_opposite_surface)
{
    PercaleMesh plate = percale_test_box(0.5f, 1e-3f, 0.5f);
    PercaleMesh sheet = percale_test_sheet(2, 2.0f);
    PercaleAuditMesh body = as_audit(&plate);
    PercaleAuditMesh cloth = as_audit(&sheet);
    ck_assert_double_gt(judge(&cloth, &body).penetration_obstacle_mm, 0.5); // in the middle of the plate
    percale_test_translate(&sheet, 0.0f, -3e-3f, 0.0f);                     // below the plate
    ck_assert_double_eq(judge(&cloth, &body).penetration_obstacle_mm, 0.0);
    percale_mesh_free(&sheet);
    percale_mesh_free(&plate);
}
END_TEST

START_TEST(a_ray_stays_inside_from_body_to_body)
{
    // One plate begins within the other, 0.3 mm below its top; the cloth is in the lower one alone.
    PercaleMesh plate = percale_test_box(0.5f, 1e-3f, 0.5f);
    PercaleMesh sheet = percale_test_sheet(2, 2.0f);
    percale_test_translate(&sheet, 0.1f, -0.6e-3f, 0.0f);
    PercaleAuditMesh cloth = as_audit(&sheet);
    for (size_t lower = 0; lower < 2; lower++) {
        PercaleMesh plates = twice(&plate);
        for (size_t i = 0; i < plate.vertex_count; i++)
            plates.positions[3 * (lower * plate.vertex_count + i) + 1] -= 0.3e-3f;
        PercaleAuditMesh body = as_audit(&plates);
        // From a corner, 1.1 mm above the cloth, the way in goes along the diagonal of a cube.
        ck_assert_double_eq_tol(judge(&cloth, &body).penetration_obstacle_mm, sqrt(3.0) * 1.1, 1e-4);
        percale_mesh_free(&plates);
    }
    percale_mesh_free(&sheet);
    percale_mesh_free(&plate);
}
END_TEST

// ---- all ----

START_TEST(vertices_that_are_not_finite_are_counted_and_left_out)
{
    PercaleMesh sheet = percale_test_sheet(4, 0.3f);
    PercaleMesh ball = percale_test_sphere(2, 0.1f);
    percale_test_translate(&sheet, 0.0f, 0.05f, 0.0f);
    float *rest = rest_lengths_of(&sheet);
    PercaleAuditMesh cloth = as_audit(&sheet);
    PercaleAuditMesh body = as_audit(&ball);
    cloth.rest_lengths = rest;
    PercaleQuality whole = judge(&cloth, &body);
    ck_assert_double_eq(whole.nonfinite, 0.0);
    ck_assert_double_eq(whole.vertices_inside, 4.0);
    sheet.positions[3 * 5 + 1] = NAN; // one of the four inside
    sheet.positions[3 * 15] = INFINITY;
    PercaleQuality torn = judge(&cloth, &body);
    ck_assert_double_eq(torn.nonfinite, 2.0);
    ck_assert_double_eq(torn.vertices_inside, 3.0);
    ck_assert_double_eq_tol(torn.stretch_max, 0.0, 1e-6);
    ck_assert_double_lt(torn.ef_cloth_obstacle, whole.ef_cloth_obstacle);
    ball.positions[0] = NAN; // opens the body
    ck_assert(isfinite(judge(&cloth, &body).penetration_max_mm));
    free(rest);
    percale_mesh_free(&ball);
    percale_mesh_free(&sheet);
}
END_TEST

// The same mesh with its vertices, triangles and corners in another order.
static PercaleMesh reordered(const PercaleMesh *mesh, bool is_turned_over)
{
    PercaleMesh other = room_for(mesh->vertex_count, mesh->triangle_count);
    uint32_t last = mesh->vertex_count - 1;
    for (size_t i = 0; i <= last; i++)
        memcpy(other.positions + 3 * (last - i), mesh->positions + 3 * i, 3 * sizeof(float));
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *corners = other.triangles + 3 * (mesh->triangle_count - 1 - t);
        for (size_t k = 0; k < 3; k++)
            corners[k] = last - mesh->triangles[3 * t + (is_turned_over ? 5 - k : 1 + k + t) % 3];
    }
    return other;
}

// Judges a sheet, at rest about half as long as it is, on a body.
static PercaleQuality judge_on(const PercaleMesh *sheet, const PercaleMesh *mesh)
{
    float *rest = rest_lengths_of(sheet);
    for (size_t side = 0; side < 3 * (size_t)sheet->triangle_count; side++)
        rest[side] = 0.5f * rest[side] + 0.02f;
    PercaleAuditMesh cloth = as_audit(sheet);
    PercaleAuditMesh body = as_audit(mesh);
    cloth.rest_lengths = rest;
    PercaleQuality quality = judge(&cloth, &body);
    free(rest);
    return quality;
}

START_TEST(order_and_winding_do_not_matter)
{
    uint64_t seed = 23;
    PercaleMesh balls = overlapping_balls(&seed);
    PercaleMesh sheet = percale_test_sheet(14, 0.4f);
    jitter(&sheet, 0.03, &seed);
    PercaleMesh other_balls = reordered(&balls, false);
    PercaleMesh other_sheet = reordered(&sheet, true);
    PercaleQuality quality = judge_on(&sheet, &balls);
    PercaleQuality other = judge_on(&other_sheet, &other_balls);
#define PERCALE_EXPECT_SAME(name) ck_assert_double_eq_tol(quality.name, other.name, ROUNDING_MM);
    PERCALE_QUALITIES(PERCALE_EXPECT_SAME)
#undef PERCALE_EXPECT_SAME
    ck_assert_double_gt(quality.penetration_obstacle_mm, 0.0);
    ck_assert_double_gt(quality.ef_cloth_cloth, 0.0);
    percale_mesh_free(&other_sheet);
    percale_mesh_free(&other_balls);
    percale_mesh_free(&sheet);
    percale_mesh_free(&balls);
}
END_TEST

START_TEST(nothing_is_judged_as_zero)
{
    PercaleMesh ball = percale_test_sphere(1, 0.1f);
    PercaleAuditMesh body = as_audit(&ball);
    const float point[] = {0.0f, 0.0f, 0.0f};
    PercaleAuditMesh cloth = as_points(point, 1);
    PercaleAuditMesh empty = as_points(NULL, 0);
    const uint32_t nonsense[] = {0, 0, 0, 0, 1, 2};
    PercaleAuditMesh broken = as_triangles(point, 1, nonsense, 2);
    const PercaleQuality qualities[] = {judge(NULL, NULL), judge(NULL, &body), judge(&cloth, &empty),
                                        judge(&empty, &body), judge(&broken, &broken)};
    for (size_t i = 0; i < sizeof qualities / sizeof qualities[0]; i++) {
#define PERCALE_EXPECT_ZERO(name) ck_assert_double_eq(qualities[i].name, 0.0);
        PERCALE_QUALITIES(PERCALE_EXPECT_ZERO)
#undef PERCALE_EXPECT_ZERO
    }
    percale_mesh_free(&ball);
}
END_TEST

// An allocator that fails once its budget is spent.
typedef struct Budget {
    int granted_count;
    int limit;
    int held_count;
} Budget;

static void *allocate_in_budget(void *user, size_t size, size_t alignment)
{
    Budget *budget = user;
    ck_assert_uint_le(alignment, 16);
    if (budget->granted_count == budget->limit)
        return NULL;
    budget->granted_count++;
    budget->held_count++;
    return malloc(size);
}

static void release_to_budget(void *user, void *memory)
{
    Budget *budget = user;
    budget->held_count--;
    free(memory);
}

START_TEST(every_allocation_may_fail)
{
    PercaleMesh sheet = percale_test_sheet(4, 0.4f);
    PercaleMesh ball = percale_test_sphere(1, 0.1f);
    PercaleAuditMesh cloth = as_audit(&sheet);
    PercaleAuditMesh body = as_audit(&ball);
    for (int is_depth_only = 0; is_depth_only < 2; is_depth_only++) {
        PercaleResult result = PERCALE_OUT_OF_MEMORY;
        int limit = 0;
        for (; result != PERCALE_OK; limit++) {
            Budget budget = {.limit = limit};
            PercaleAuditMemory memory = {allocate_in_budget, release_to_budget, &budget};
            PercaleQuality quality = {.nonfinite = -1.0};
            float depths[16];
            result = is_depth_only ? percale_audit_penetration_with(memory, &cloth, &body, 1, depths)
                                   : percale_audit_with(memory, &cloth, 1, &body, 1, &quality, NULL);
            ck_assert_int_eq(budget.held_count, 0);
            if (result == PERCALE_OK)
                break;
            ck_assert_int_eq(result, PERCALE_OUT_OF_MEMORY);
            ck_assert_double_eq(quality.nonfinite, -1.0);
        }
        ck_assert_int_gt(limit, 12);
    }
    percale_mesh_free(&ball);
    percale_mesh_free(&sheet);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("audit");
    TCase *penetration = tcase_create("penetration");
    tcase_add_test(penetration, depths_equal_those_of_all_triangles);
    tcase_add_test(penetration, rays_through_edges_and_vertices_are_counted_once);
    tcase_add_test(penetration, an_open_surface_counts_5_mm_behind_it_but_not_behind_its_rim);
    tcase_add_test(penetration, an_open_top_and_the_closed_body_agree_near_the_top);
    tcase_add_test(penetration, a_vertex_on_the_surface_is_not_inside);
    tcase_add_test(penetration, a_body_with_a_triangle_turned_over_is_open);
    tcase_add_test(penetration, the_percentile_is_over_all_finite_cloth_vertices);
    tcase_add_test(penetration, contact_is_within_one_and_a_half_thicknesses_of_the_pair);
    tcase_add_test(penetration, a_spike_stands_out_by_its_height_above_the_cloth);
    tcase_add_test(penetration, nothing_stands_out_beyond_the_bodys_own_opposite_surface);
    tcase_add_test(penetration, a_ray_stays_inside_from_body_to_body);
    suite_add_tcase(suite, penetration);
    TCase *all = tcase_create("all");
    tcase_add_test(all, vertices_that_are_not_finite_are_counted_and_left_out);
    tcase_add_test(all, order_and_winding_do_not_matter);
    tcase_add_test(all, nothing_is_judged_as_zero);
    tcase_add_test(all, every_allocation_may_fail);
    suite_add_tcase(suite, all);
    return percale_test_run(suite);
}
