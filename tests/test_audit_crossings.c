// The audit's crossings and stretch: against all pairs of triangles, and the laws of what these figures mean.

#include "audit/audit.h"
#include "audit/audit_exact.h"
#include "audit_testing.h"

#include <string.h>

// ---- twins ----

// Does the segment pass through the inside of the triangle? By Cramer's rule.
static bool twin_pierces(Vector p, Vector q, const Vector t[3])
{
    Vector u = plus(t[1], -1.0, t[0]);
    Vector v = plus(t[2], -1.0, t[0]);
    Vector w = plus(p, -1.0, q);
    Vector s = plus(p, -1.0, t[0]);
    double determinant = inner(u, outer(v, w));
    double along_u = inner(s, outer(v, w)) / determinant;
    double along_v = inner(u, outer(s, w)) / determinant;
    double time = inner(u, outer(v, s)) / determinant;
    return along_u > 0.0 && along_v > 0.0 && along_u + along_v < 1.0 && time > 0.0 && time < 1.0;
}

static uint32_t twin_crossings(const PercaleAuditMesh *a, const PercaleAuditMesh *b)
{
    uint32_t count = 0;
    for (size_t i = 0; i < a->triangle_count; i++) {
        for (size_t j = a == b ? i + 1 : 0; j < b->triangle_count; j++) {
            Vector s[3];
            Vector t[3];
            bool is_shared = false;
            bool is_pierced = false;
            for (size_t k = 0; k < 3; k++) {
                s[k] = vector_at(a->positions, a->triangles[3 * i + k]);
                t[k] = vector_at(b->positions, b->triangles[3 * j + k]);
                for (size_t l = 0; a == b && l < 3; l++)
                    is_shared |= a->triangles[3 * i + k] == b->triangles[3 * j + l];
            }
            for (size_t k = 0; k < 3; k++)
                is_pierced |= twin_pierces(s[k], s[(k + 1) % 3], t) || twin_pierces(t[k], t[(k + 1) % 3], s);
            count += is_pierced && !is_shared;
        }
    }
    return count;
}

__extension__ typedef __int128 Wide;

static int twin_orient(int32_t points[4][3])
{
    Wide row[3][3];
    for (size_t i = 0; i < 3; i++) {
        for (size_t axis = 0; axis < 3; axis++)
            row[i][axis] = points[i][axis] - points[3][axis];
    }
    Wide determinant = row[0][0] * (row[1][1] * row[2][2] - row[1][2] * row[2][1]) +
                       row[0][1] * (row[1][2] * row[2][0] - row[1][0] * row[2][2]) +
                       row[0][2] * (row[1][0] * row[2][1] - row[1][1] * row[2][0]);
    return (determinant > 0) - (determinant < 0);
}

// ---- crossings ----

START_TEST(orientation_has_the_sign_of_the_integer_determinant)
{
    uint64_t seed = 3;
    int zero_count = 0;
    for (int trial = 0; trial < 20000; trial++) {
        // Four points a step or two beside a line: determinants down to 0 below products of 2^63.
        int32_t whole[4][3];
        float point[4][3];
        for (size_t axis = 0; axis < 3; axis++) {
            double direction = floor(2e6 * percale_test_random(&seed));
            for (size_t i = 0; i < 4; i++) {
                double beside = floor(3.0 * percale_test_random(&seed));
                whole[i][axis] = (int32_t)(direction * (double)i + beside);
                point[i][axis] = (float)whole[i][axis];
            }
        }
        int sign = percale_audit_orient(point[0], point[1], point[2], point[3]);
        ck_assert_int_eq(sign, twin_orient(whole));
        zero_count += sign == 0;
    }
    ck_assert_int_ge(zero_count, 100);
}
END_TEST

START_TEST(orientation_in_the_plane_is_right_where_differences_round)
{
    // (y, z) and a point beside the diagonal by the last bit of 2^-30, between -1 and 2^24.
    const float below[] = {0.0f, -1.0f, -1.0f};
    const float above[] = {0.0f, 0x1p24f, 0x1p24f};
    float point[] = {0.0f, 0x1p-30f, 0x1p-30f};
    ck_assert_int_eq(percale_audit_orient_yz(below, above, point), 0);
    point[2] = nextafterf(0x1p-30f, 1.0f);
    ck_assert_int_eq(percale_audit_orient_yz(below, above, point), 1);
    ck_assert_int_eq(percale_audit_orient_yz(above, below, point), -1);
    point[2] = nextafterf(0x1p-30f, 0.0f);
    ck_assert_int_eq(percale_audit_orient_yz(below, above, point), -1);
}
END_TEST

START_TEST(crossings_equal_those_of_all_pairs)
{
    uint64_t seed = 5;
    PercaleMesh sheets[2] = {percale_test_sheet(9, 1.0f), percale_test_sheet(12, 1.2f)};
    PercaleMesh ball = percale_test_sphere(1, 0.4f);
    PercaleAuditMesh cloths[2];
    for (size_t i = 0; i < 2; i++) {
        jitter(&sheets[i], 0.2, &seed);
        cloths[i] = as_audit(&sheets[i]);
    }
    PercaleAuditMesh body = as_audit(&ball);
    uint32_t self_count = twin_crossings(&cloths[0], &cloths[0]) + twin_crossings(&cloths[1], &cloths[1]);
    uint32_t cloth_count = twin_crossings(&cloths[0], &cloths[1]);
    uint32_t body_count = twin_crossings(&cloths[0], &body) + twin_crossings(&cloths[1], &body);
    PercaleQuality quality;
    PERCALE_TEST_OK(NULL, percale_audit(cloths, 2, &body, 1, &quality));
    ck_assert_uint_gt(self_count, 100);
    ck_assert_double_eq(quality.ef_cloth_cloth, (double)(self_count + cloth_count));
    ck_assert_double_eq(quality.ef_cloth_obstacle, (double)body_count);
    ck_assert_double_eq(quality.ef_seam, 0.0);
    cloths[0].mask = 2; // the two no longer meet, nor the first one and the body
    PERCALE_TEST_OK(NULL, percale_audit(cloths, 2, &body, 1, &quality));
    ck_assert_double_eq(quality.ef_cloth_cloth, (double)self_count);
    ck_assert_double_eq(quality.ef_cloth_obstacle, (double)twin_crossings(&cloths[1], &body));
    for (size_t i = 0; i < 2; i++)
        percale_mesh_free(&sheets[i]);
    percale_mesh_free(&ball);
}
END_TEST

// Crossings of the triangle (0, 0, 0) (4, 0, 0) (0, 4, 0) with that of the other three corners.
static double crossings_with(const float other[3][3])
{
    static const uint32_t CORNERS[] = {0, 1, 2, 3, 4, 5};
    float x[6][3] = {{0.0f, 0.0f, 0.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, 4.0f, 0.0f}};
    memcpy(x[3], other, 3 * sizeof x[3]);
    PercaleAuditMesh cloth = as_triangles(x[0], 6, CORNERS, 2);
    return judge(&cloth, NULL).ef_cloth_cloth;
}

START_TEST(going_through_is_crossing_and_touching_is_not)
{
    static const float THROUGH[][3][3] = {
        {{1.0f, 1.0f, -1.0f}, {1.0f, 1.0f, 1.0f}, {9.0f, 9.0f, 0.5f}},   // one edge pierces
        {{1.0f, 1.0f, -1.0f}, {1.5f, 1.0f, 1.0f}, {1.0f, 1.5f, 1.0f}},   // two edges pierce
        {{1.0f, 0.0f, -1.0f}, {1.0f, 0.0f, 1.0f}, {1.0f, 9.0f, 0.0f}},   // from edge to edge
        {{0.0f, 0.0f, 0.0f}, {4.0f, 4.0f, -1.0f}, {4.0f, 4.0f, 1.0f}},   // from a corner in common
        {{2.0f, 2.0f, -1.0f}, {-1.0f, -1.0f, 0.0f}, {2.0f, 2.0f, 1.0f}}, // through a corner
    };
    static const float BESIDE[][3][3] = {
        {{5.0f, 1.0f, -1.0f}, {5.0f, 1.0f, 1.0f}, {9.0f, 9.0f, 0.0f}},     // cuts the plane elsewhere
        {{1.0f, 1.0f, 0.0f}, {1.0f, 2.0f, 1.0f}, {2.0f, 1.0f, 1.0f}},      // a corner on the face
        {{1.0f, 1.0f, 0.0f}, {2.0f, 1.0f, 0.0f}, {2.0f, 1.0f, 1.0f}},      // an edge on the face
        {{1.0f, 1.0f, 0.0f}, {2.0f, 1.0f, 0.0f}, {1.0f, 2.0f, 0.0f}},      // in the same plane
        {{2.0f, 0.0f, -1.0f}, {2.0f, 0.0f, 1.0f}, {2.0f, -3.0f, 0.0f}},    // edge on edge
        {{0.0f, 0.0f, 0.0f}, {-4.0f, -4.0f, -1.0f}, {-4.0f, -4.0f, 1.0f}}, // a corner in common
        {{1.0f, 1.0f, -1.0f}, {1.0f, 1.0f, 0.0f}, {1.0f, 1.0f, 1.0f}},     // without area
        {{0.0f, 0.0f, 0.0f}, {4.0f, 0.0f, 0.0f}, {0.0f, -4.0f, 1.0f}},     // an edge in common
    };
    for (size_t i = 0; i < sizeof THROUGH / sizeof THROUGH[0]; i++)
        ck_assert_msg(crossings_with(THROUGH[i]) == 1.0, "through %zu", i);
    for (size_t i = 0; i < sizeof BESIDE / sizeof BESIDE[0]; i++)
        ck_assert_msg(crossings_with(BESIDE[i]) == 0.0, "beside %zu", i);
}
END_TEST

START_TEST(crossings_beside_a_sewn_vertex_are_counted_apart)
{
    // Two triangles with a corner at the origin that cross along (1, 0.5, 0), then beside each other.
    float x[6][3] = {{0.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {2.0f, 2.0f, 0.0f},
                     {0.0f, 0.0f, 0.0f}, {1.0f, 0.5f, 1.0f}, {1.0f, 0.5f, -1.0f}};
    const uint32_t apart[] = {0, 1, 2, 3, 4, 5};
    const uint32_t joined[] = {0, 1, 2, 0, 4, 5};
    const uint32_t sewn[] = {70000, 70000 - 65536, 2, 70000, 4, 5};
    const uint32_t each_alone[] = {0, 1, 2, 3, 4, 5};
    const uint32_t sewn_twice[] = {70000, 9, 2, 70000, 9, 5};
    PercaleAuditMesh cloth = as_triangles(x[0], 6, apart, 2);
    ck_assert_double_eq(judge(&cloth, NULL).ef_cloth_cloth, 1.0);
    ck_assert_double_eq(judge(&cloth, NULL).ef_seam, 0.0);
    cloth.weld = sewn;
    for (int gap = 0; gap < 2; gap++) { // shut, and 1 mm open
        x[3][2] = 1e-3f * (float)gap;
        ck_assert_double_eq(judge(&cloth, NULL).ef_cloth_cloth, 0.0);
        ck_assert_double_eq(judge(&cloth, NULL).ef_seam, 1.0);
    }
    cloth.weld = sewn_twice;
    ck_assert_double_eq(judge(&cloth, NULL).ef_seam, 0.0);
    cloth.weld = NULL;
    cloth.triangles = joined; // plain neighbours
    ck_assert_double_eq(judge(&cloth, NULL).ef_cloth_cloth + judge(&cloth, NULL).ef_seam, 0.0);
    cloth.weld = each_alone;
    ck_assert_double_eq(judge(&cloth, NULL).ef_cloth_cloth + judge(&cloth, NULL).ef_seam, 0.0);
    cloth.triangles = apart;
    cloth.weld = sewn;
    for (size_t i = 4; i < 6; i++) { // the other way: only the sewn corner is common
        x[i][0] = -1.0f;
        x[i][1] = -0.5f;
    }
    ck_assert_double_eq(judge(&cloth, NULL).ef_cloth_cloth + judge(&cloth, NULL).ef_seam, 0.0);
}
END_TEST

START_TEST(welds_join_cloths_and_no_weld_joins_nothing)
{
    const float x[2][3][3] = {{{0.0f, 0.0f, 0.0f}, {2.0f, 0.0f, 0.0f}, {2.0f, 2.0f, 0.0f}},
                              {{0.0f, 0.0f, 0.0f}, {1.0f, 0.5f, 1.0f}, {1.0f, 0.5f, -1.0f}}};
    const uint32_t triangle[] = {0, 1, 2};
    const uint32_t welds[2][3] = {{0, 1, 2}, {0, 4, 5}};
    PercaleAuditMesh cloths[2] = {as_triangles(x[0][0], 3, triangle, 1),
                                  as_triangles(x[1][0], 3, triangle, 1)};
    PercaleQuality quality;
    cloths[0].weld = welds[0];
    PERCALE_TEST_OK(NULL, percale_audit(cloths, 2, NULL, 0, &quality));
    ck_assert_double_eq(quality.ef_cloth_cloth, 1.0);
    cloths[1].weld = welds[1];
    PERCALE_TEST_OK(NULL, percale_audit(cloths, 2, NULL, 0, &quality));
    ck_assert_double_eq(quality.ef_cloth_cloth, 0.0);
    ck_assert_double_eq(quality.ef_seam, 1.0);
}
END_TEST

// ---- stretch ----

START_TEST(a_scaled_sheet_is_stretched_by_its_scale)
{
    const float scales[] = {1.25f, 0.5f, 1.0f};
    for (size_t i = 0; i < 3; i++) {
        PercaleMesh sheet = percale_test_sheet(5, 1.0f);
        float *rest = rest_lengths_of(&sheet);
        for (size_t k = 0; k < 3 * (size_t)sheet.vertex_count; k++)
            sheet.positions[k] *= scales[i];
        PercaleAuditMesh cloth = as_audit(&sheet);
        ck_assert_double_eq(judge(&cloth, NULL).stretch_max, 0.0); // without rest lengths
        cloth.rest_lengths = rest;
        ck_assert_double_eq_tol(judge(&cloth, NULL).stretch_max, (double)scales[i] - 1.0, 1e-7);
        ck_assert_double_eq_tol(judge(&cloth, NULL).stretch_p99, (double)scales[i] - 1.0, 1e-7);
        free(rest);
        percale_mesh_free(&sheet);
    }
}
END_TEST

START_TEST(an_edge_counts_once_however_many_triangles_have_it)
{
    // 85 edges in 150 sides: of 85 the 99th percentile is the largest, of 150 the second.
    PercaleMesh sheet = percale_test_sheet(6, 1.0f);
    float *rest = rest_lengths_of(&sheet);
    PercaleAuditMesh cloth = as_audit(&sheet);
    cloth.rest_lengths = rest;
    size_t side = 0; // of the rim: at z = -0.5 at both ends
    while (sheet.positions[3 * sheet.triangles[side] + 2] > -0.5f ||
           sheet.positions[3 * sheet.triangles[side % 3 == 2 ? side - 2 : side + 1] + 2] > -0.5f)
        side++;
    rest[side] *= 0.5f;
    ck_assert_double_eq_tol(judge(&cloth, NULL).stretch_max, 1.0, 1e-6);
    ck_assert_double_eq_tol(judge(&cloth, NULL).stretch_p99, 1.0, 1e-6);
    free(rest);
    percale_mesh_free(&sheet);
}
END_TEST

START_TEST(seams_have_no_stretch_and_sewn_panels_share_their_edge)
{
    // Vertices 1 and 3, 2 and 4 are sewn, the first pair 1 mm open: side 1-2 of the first panel is side 3-4
    // of the second.
    const float x[][3] = {{0.0f, 0.0f, 0.0f},  {3.0f, 0.0f, 0.0f}, {0.0f, 4.0f, 0.0f},
                          {3.0f, 0.0f, 1e-3f}, {0.0f, 4.0f, 0.0f}, {3.0f, 4.0f, 0.0f}};
    const uint32_t triangles[] = {0, 1, 2, 3, 5, 4, 1, 3, 5};
    const uint32_t weld[] = {0, 1, 2, 1, 2, 5};
    const float rest[] = {3.0f, 5.0f, 4.0f, 4.0f, 3.0f, 4.0f, 1e-4f, 4.0f, 4.0f};
    PercaleAuditMesh cloth = as_triangles(x[0], 6, triangles, 3);
    cloth.weld = weld;
    cloth.rest_lengths = rest;
    ck_assert_double_eq_tol(judge(&cloth, NULL).stretch_max, 0.25, 1e-6); // 5 / 4 - 1, the larger of its two
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("audit_crossings");
    TCase *crossings = tcase_create("crossings");
    tcase_add_test(crossings, orientation_has_the_sign_of_the_integer_determinant);
    tcase_add_test(crossings, orientation_in_the_plane_is_right_where_differences_round);
    tcase_add_test(crossings, crossings_equal_those_of_all_pairs);
    tcase_add_test(crossings, going_through_is_crossing_and_touching_is_not);
    tcase_add_test(crossings, crossings_beside_a_sewn_vertex_are_counted_apart);
    tcase_add_test(crossings, welds_join_cloths_and_no_weld_joins_nothing);
    suite_add_tcase(suite, crossings);
    TCase *stretch = tcase_create("stretch");
    tcase_add_test(stretch, a_scaled_sheet_is_stretched_by_its_scale);
    tcase_add_test(stretch, an_edge_counts_once_however_many_triangles_have_it);
    tcase_add_test(stretch, seams_have_no_stretch_and_sewn_panels_share_their_edge);
    suite_add_tcase(suite, stretch);
    return percale_test_run(suite);
}
