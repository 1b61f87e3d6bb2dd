// The dress on the mannequin: clear of her and of itself, and well sewn.
//
// Sanitized builds leave out the large dresses.

#include "garment_testing.h"
#include "scene/garment.h"
#include "scene/mannequin.h"

#include <stdio.h>

static const uint32_t DRESS_SIZE = 5000;

// What most tests look at, made once: no OpenMP in it, so that forked tests may use it.
static PercaleMannequin *mannequin;
static PercaleMesh body;
static PercaleMesh dress;
static uint32_t (*seams)[2];
static uint32_t seam_count;

static bool make_dress(uint64_t size, float thickness, PercaleMesh *mesh, uint32_t (**pairs)[2],
                       uint32_t *pair_count, PercaleSceneError *error)
{
    return percale_garment_make(&percale_dress_cut, size, thickness, 0.0, mesh, pairs, pair_count, error);
}

static void make_both(void)
{
    PercaleSceneError error = {""};
    mannequin = percale_mannequin_make(0.0, 1.0, &body, &error);
    ck_assert_msg(mannequin != NULL, "%s", error.text);
    ck_assert_msg(make_dress(DRESS_SIZE, THICKNESS, &dress, &seams, &seam_count, &error), "%s", error.text);
}

static void free_both(void)
{
    percale_mannequin_free(mannequin);
    percale_mesh_free(&body);
    percale_mesh_free(&dress);
    free(seams);
}

START_TEST(dress_has_the_asked_number_of_vertices)
{
    static const uint64_t SIZES[] = {1000, 5000, 7777, 20000, 100000, 1000000};
    const size_t count = sizeof SIZES / sizeof *SIZES - (PERCALE_SANITIZED ? 2 : 0);
    for (size_t i = 0; i < count; i++) {
        PercaleMesh mesh;
        PercaleSceneError error;
        uint32_t(*pairs)[2];
        uint32_t pair_count;
        ck_assert(make_dress(SIZES[i], THICKNESS, &mesh, &pairs, &pair_count, &error));
        ck_assert_double_lt(fabs((double)mesh.vertex_count / (double)SIZES[i] - 1.0), 0.05);
        percale_mesh_free(&mesh);
        free(pairs);
    }
}
END_TEST

START_TEST(seams_coincide_and_none_is_there_twice)
{
    uint32_t *points = identity(dress.vertex_count);
    for (uint32_t i = 0; i < seam_count; i++) {
        const uint32_t a = seams[i][0];
        const uint32_t b = seams[i][1];
        ck_assert_uint_lt(a, dress.vertex_count);
        ck_assert_uint_lt(b, dress.vertex_count);
        ck_assert_mem_eq(dress.positions + 3 * (size_t)a, dress.positions + 3 * (size_t)b, 3 * sizeof(float));
        ck_assert_uint_ne(root_of(points, a), root_of(points, b)); // else the others imply it
        join(points, a, b);
    }
    free(points);
}
END_TEST

START_TEST(panels_are_four_discs_and_the_sewn_dress_has_four_openings)
{
    uint32_t *points = identity(dress.vertex_count);
    const Topology cut = topology_of(&dress, points);
    free(points);
    ck_assert_uint_eq(cut.tangled, 0);
    ck_assert_uint_eq(cut.pieces, 4);
    ck_assert_uint_eq(cut.loops, 4);
    ck_assert_int_eq(euler(cut), 4);
    points = weld(dress.vertex_count, seams, seam_count);
    const Topology sewn = topology_of(&dress, points);
    free(points);
    ck_assert_uint_eq(sewn.vertices, dress.vertex_count - seam_count);
    ck_assert_uint_eq(sewn.tangled, 0);
    ck_assert_uint_eq(sewn.pieces, 1);
    ck_assert_uint_eq(sewn.loops, 4); // neck, hem, two cuffs
    ck_assert_int_eq(euler(sewn), -2);
}
END_TEST

START_TEST(dress_has_well_shaped_triangles)
{
    uint32_t long_ones = 0;
    for (uint32_t t = 0; t < dress.triangle_count; t++) {
        const Shape shape = shape_of(&dress, t);
        ck_assert_double_lt(shape.aspect, 8.0);
        long_ones += shape.aspect > 4.0;
    }
    ck_assert_uint_lt(200 * long_ones, dress.triangle_count);
}
END_TEST

START_TEST(dress_has_the_same_shape_at_every_size)
{
    PercaleMesh fine;
    PercaleSceneError error;
    uint32_t(*pairs)[2];
    uint32_t pair_count;
    ck_assert(make_dress(40000, THICKNESS, &fine, &pairs, &pair_count, &error));
    const PercaleMesh *meshes[2] = {&dress, &fine};
    double area[2] = {0, 0};
    double box[2][6];
    for (int m = 0; m < 2; m++) {
        for (uint32_t t = 0; t < meshes[m]->triangle_count; t++) {
            area[m] += shape_of(meshes[m], t).area;
        }
        for (int k = 0; k < 3; k++) {
            box[m][k] = 9.0;
            box[m][k + 3] = -9.0;
            for (uint32_t i = 0; i < meshes[m]->vertex_count; i++) {
                const double x = (double)meshes[m]->positions[3 * (size_t)i + (size_t)k];
                box[m][k] = fmin(box[m][k], x);
                box[m][k + 3] = fmax(box[m][k + 3], x);
            }
        }
    }
    ck_assert_double_eq_tol(area[0] / area[1], 1.0, 0.01);
    for (int k = 0; k < 6; k++) {
        ck_assert_double_eq_tol(box[0][k], box[1][k], 0.006); // folds have crests between columns
    }
    percale_mesh_free(&fine);
    free(pairs);
}
END_TEST

START_TEST(hem_gives_room_for_a_stride)
{
    double lowest = 9.0;
    for (uint32_t i = 0; i < dress.vertex_count; i++) {
        lowest = fmin(lowest, (double)dress.positions[3 * i + 1]);
    }
    double length = 0.0;
    for (uint32_t i = 0; i < 3 * dress.triangle_count; i++) {
        double p[3];
        double q[3];
        corner(dress.positions, dress.triangles[i], p);
        corner(dress.positions, dress.triangles[i % 3 == 2 ? i - 2 : i + 1], q);
        if (fmax(p[1], q[1]) < lowest + 1e-4) {
            length += distance_between(p, q);
        }
    }
    ck_assert_double_gt(length, 1.9);
    ck_assert_double_eq_tol(lowest, 0.49, 0.05); // the knee
}
END_TEST

// Looks at every `step`-th vertex.
static void check_clearance(const PercaleMesh *mesh, uint32_t step)
{
    double nearest = 1.0;
    uint32_t close_count = 0;
    uint32_t seen = 0;
    const Balls balls = balls_of(&body, body.positions, NULL);
    for (uint32_t i = 0; i < mesh->vertex_count; i += step) {
        double point[3];
        corner(mesh->positions, i, point);
        const double distance = distance_to_balls(&balls, point, 0.01);
        nearest = fmin(nearest, distance);
        close_count += distance <= 1.5 * (double)THICKNESS;
        seen++;
    }
    free(balls.list);
    const double share = (double)close_count / seen;
    (void)printf("dress of %u: nearest %.2f mm, %.0f %% within 1.5 thicknesses, digest %016llx\n",
                 mesh->vertex_count, 1e3 * nearest, 1e2 * share, (unsigned long long)digest(mesh));
    ck_assert_double_ge(nearest, 1.1 * (double)THICKNESS);
    ck_assert_double_ge(share, 0.25);
}

START_TEST(dress_starts_clear_of_the_body_and_close_to_it)
{
    check_clearance(&dress, PERCALE_SANITIZED ? 7 : 2);
    PercaleMesh fine;
    PercaleSceneError error;
    uint32_t(*pairs)[2];
    uint32_t pair_count;
    ck_assert(make_dress(20000, THICKNESS, &fine, &pairs, &pair_count, &error));
    check_clearance(&fine, PERCALE_SANITIZED ? 29 : 11);
    percale_mesh_free(&fine);
    free(pairs);
}
END_TEST

START_TEST(dress_starts_without_a_crossing_at_any_size)
{
    static const uint64_t SIZES[] = {1000, 5000, 20000};
    const PercaleAuditMesh skin = {.positions = body.positions,
                                   .vertex_count = body.vertex_count,
                                   .triangles = body.triangles,
                                   .triangle_count = body.triangle_count,
                                   .thickness = THICKNESS,
                                   .mask = 1};
    for (size_t i = 0; i < 3; i++) {
        PercaleMesh mesh;
        PercaleSceneError error;
        PercaleQuality quality;
        uint32_t(*pairs)[2];
        uint32_t pair_count;
        ck_assert(make_dress(SIZES[i], THICKNESS, &mesh, &pairs, &pair_count, &error));
        uint32_t *points = weld(mesh.vertex_count, pairs, pair_count);
        const PercaleAuditMesh cloth = {.positions = mesh.positions,
                                        .vertex_count = mesh.vertex_count,
                                        .triangles = mesh.triangles,
                                        .triangle_count = mesh.triangle_count,
                                        .weld = points,
                                        .thickness = THICKNESS,
                                        .mask = 1};
        ck_assert_int_eq(percale_audit(&cloth, 1, &skin, 1, &quality), PERCALE_OK);
        ck_assert_msg(quality.ef_cloth_obstacle + quality.ef_cloth_cloth + quality.ef_seam <= 0.0,
                      "%g with the body, %g with itself, %g beside seams at size %llu",
                      quality.ef_cloth_obstacle, quality.ef_cloth_cloth, quality.ef_seam,
                      (unsigned long long)SIZES[i]);
        ck_assert_double_le(quality.vertices_inside, 0.0);
        ck_assert_double_ge(quality.contact_fraction, SIZES[i] < 5000 ? 0.0 : 0.25);
        free(points);
        free(pairs);
        percale_mesh_free(&mesh);
    }
}
END_TEST

START_TEST(bad_wishes_are_refused_by_name)
{
    PercaleMesh mesh;
    PercaleSceneError error;
    uint32_t(*pairs)[2];
    uint32_t pair_count;
    ck_assert(!make_dress(10, THICKNESS, &mesh, &pairs, &pair_count, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "size 10 "));
    ck_assert(!make_dress(UINT64_MAX, THICKNESS, &mesh, &pairs, &pair_count, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "size"));
    ck_assert(!make_dress(5000, NAN, &mesh, &pairs, &pair_count, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "thickness"));
    ck_assert_ptr_null(mesh.positions);
    ck_assert_ptr_null(pairs);
    ck_assert_ptr_null(percale_mannequin_make(HUGE_VAL, 1.0, &mesh, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "jump"));
    ck_assert_ptr_null(percale_mannequin_make(0.0, (double)NAN, &mesh, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "speed"));
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("garment");
    TCase *garment = tcase_create("dress");
    tcase_set_tags(garment, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_add_unchecked_fixture(garment, make_both, free_both);
    tcase_set_timeout(garment, 60);
    tcase_add_test(garment, dress_has_the_asked_number_of_vertices);
    tcase_add_test(garment, seams_coincide_and_none_is_there_twice);
    tcase_add_test(garment, panels_are_four_discs_and_the_sewn_dress_has_four_openings);
    tcase_add_test(garment, dress_has_well_shaped_triangles);
    tcase_add_test(garment, dress_has_the_same_shape_at_every_size);
    tcase_add_test(garment, hem_gives_room_for_a_stride);
    tcase_add_test(garment, dress_starts_clear_of_the_body_and_close_to_it);
    tcase_add_test(garment, dress_starts_without_a_crossing_at_any_size);
    tcase_add_test(garment, bad_wishes_are_refused_by_name);
    suite_add_tcase(suite, garment);
    return percale_test_run(suite);
}
