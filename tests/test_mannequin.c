// The mannequin: closed, clear of itself, and how it walks.
//
// Sanitized builds leave out most frames of the walk.

#include "garment_testing.h"
#include "scene/mannequin.h"

#include <stdio.h>

static const double STRIDE = 1.1; // s; after so long the walk repeats
static const double BLEND = 0.9;  // s; from then on at full stride

// What all tests look at, made once: no OpenMP in it, so that forked tests may use it.
static PercaleMannequin *mannequin;
static PercaleMesh body;

static void make_body(void)
{
    PercaleSceneError error = {""};
    mannequin = percale_mannequin_make(0.0, 1.0, &body, &error);
    ck_assert_msg(mannequin != NULL, "%s", error.text);
}

static void free_body(void)
{
    percale_mannequin_free(mannequin);
    percale_mesh_free(&body);
}

static double signed_volume(const PercaleMesh *mesh)
{
    double six = 0.0;
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        double p[3][3];
        for (uint32_t k = 0; k < 3; k++) {
            corner(mesh->positions, mesh->triangles[3 * t + k], p[k]);
        }
        six += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
               p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
    }
    return six / 6.0;
}

static bool is_left_leg(double x, double y)
{
    return x > 0.0 && y < 0.77; // below the crotch
}

static bool is_right_leg(double x, double y)
{
    return x < 0.0 && y < 0.77;
}

static bool is_arm(double x, double y)
{
    return fabs(x) > 0.26 && y > 0.7; // from the middle of the upper arm to the fingers
}

static bool is_trunk_or_leg(double x, double y)
{
    return fabs(x) < 0.21 && y < 1.22; // below the armpits
}

static double part_distance(const float *positions, Part *from, Part *to, double limit)
{
    double best = limit;
    const Balls balls = balls_of(&body, positions, to);
    for (uint32_t i = 0; i < body.vertex_count; i++) {
        if (is_part(&body, from, i)) {
            double point[3];
            corner(positions, i, point);
            best = distance_to_balls(&balls, point, best);
        }
    }
    free(balls.list);
    return best;
}

static float *pose_at(double seconds)
{
    float *positions = malloc(3 * sizeof *positions * body.vertex_count);
    ck_assert_ptr_nonnull(positions);
    percale_mannequin_pose(mannequin, seconds, positions);
    return positions;
}

static double largest_shift(const float *a, const float *b)
{
    double largest = 0.0;
    for (uint32_t i = 0; i < body.vertex_count; i++) {
        double p[3];
        double q[3];
        corner(a, i, p);
        corner(b, i, q);
        largest = fmax(largest, distance_between(p, q));
    }
    return largest;
}

START_TEST(body_is_one_closed_surface_without_handles)
{
    uint32_t *points = identity(body.vertex_count);
    const Topology t = topology_of(&body, points);
    free(points);
    ck_assert_uint_eq(t.borders, 0);
    ck_assert_uint_eq(t.tangled, 0);
    ck_assert_uint_eq(t.pieces, 1);
    ck_assert_uint_eq(t.vertices, body.vertex_count);
    ck_assert_int_eq(euler(t), 2);
    ck_assert_uint_ge(t.triangles, 12000);
    ck_assert_uint_le(t.triangles, 20000);
    ck_assert_double_gt(signed_volume(&body), 0.04); // counter-clockwise from outside; a slender woman
    ck_assert_double_lt(signed_volume(&body), 0.08);
    (void)printf("body: %u triangles, digest %016llx\n", body.triangle_count,
                 (unsigned long long)digest(&body));
}
END_TEST

START_TEST(body_has_no_slivers)
{
    for (uint32_t t = 0; t < body.triangle_count; t++) {
        ck_assert_double_lt(shape_of(&body, t).smallest, cos(0.40)); // 23 degrees
    }
}
END_TEST

START_TEST(body_stands_on_the_floor_and_is_170_cm_tall)
{
    double lower = 1.0;
    double upper = 0.0;
    for (uint32_t i = 0; i < body.vertex_count; i++) {
        lower = fmin(lower, (double)body.positions[3 * i + 1]);
        upper = fmax(upper, (double)body.positions[3 * i + 1]);
    }
    ck_assert_double_lt(fabs(lower), 0.01);
    ck_assert_double_eq_tol(upper - lower, 1.70, 0.03);
}
END_TEST

START_TEST(walk_starts_from_the_mesh_and_from_rest)
{
    static const double MOMENT = 0.002; // s
    float *start = pose_at(0.0);
    float *soon = pose_at(MOMENT);
    ck_assert_mem_eq(start, body.positions, 3 * sizeof *start * body.vertex_count);
    ck_assert_double_lt(largest_shift(start, soon) / MOMENT, 0.002);
    free(start);
    free(soon);
}
END_TEST

START_TEST(walk_repeats_for_ever)
{
    float *once = pose_at(BLEND + 0.3);
    float *later = pose_at(BLEND + 0.3 + 50.0 * STRIDE);
    float *half = pose_at(BLEND + 0.3 + 0.5 * STRIDE);
    ck_assert_double_lt(largest_shift(once, later), 1e-5);
    ck_assert_double_gt(largest_shift(once, half), 0.1);
    free(once);
    free(later);
    free(half);
}
END_TEST

START_TEST(walk_is_faster_than_1_m_per_s_and_never_jerks)
{
    const double frame = 1.0 / 60.0;
    double fastest = 0.0;
    float *before = pose_at(0.0);
    for (int i = 1; i <= 150; i++) {
        float *now = pose_at(i * frame);
        const double speed = largest_shift(before, now) / frame;
        ck_assert_double_lt(speed, 5.0);
        if (i * frame > BLEND) {
            fastest = fmax(fastest, speed);
        }
        free(before);
        before = now;
    }
    free(before);
    ck_assert_double_gt(fastest, 1.0);
}
END_TEST

START_TEST(jump_moves_everything_sideways_within_one_frame)
{
    PercaleMesh mesh;
    PercaleSceneError error;
    PercaleMannequin *leaping = percale_mannequin_make(0.25, 1.0, &mesh, &error);
    ck_assert_ptr_nonnull(leaping);
    float *jumped = malloc(3 * sizeof *jumped * mesh.vertex_count);
    ck_assert_ptr_nonnull(jumped);
    for (int frame = 59; frame <= 62; frame++) {
        float *plain = pose_at(frame / 60.0);
        percale_mannequin_pose(leaping, frame / 60.0, jumped);
        const double leap = frame <= 60 ? 0.0 : 0.25;
        for (uint32_t i = 0; i < mesh.vertex_count; i++) {
            ck_assert_double_eq_tol((double)jumped[3 * i] - (double)plain[3 * i], leap, 1e-6);
            ck_assert_mem_eq(jumped + 3 * i + 1, plain + 3 * i + 1, 2 * sizeof *plain);
        }
        free(plain);
    }
    free(jumped);
    percale_mannequin_free(leaping);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(walk_at_twice_the_speed_is_where_it_would_be_in_twice_the_time)
{
    PercaleMesh mesh;
    PercaleSceneError error;
    PercaleMannequin *fast = percale_mannequin_make(0.25, 2.0, &mesh, &error);
    ck_assert_ptr_nonnull(fast);
    float *positions = malloc(3 * sizeof *positions * mesh.vertex_count);
    ck_assert_ptr_nonnull(positions);
    for (int frame = 0; frame <= 60; frame += 15) { // the jump comes after frame 60 as ever
        float *later = pose_at(2 * frame / 60.0);
        percale_mannequin_pose(fast, frame / 60.0, positions);
        ck_assert_double_lt(largest_shift(positions, later), 1e-6);
        free(later);
    }
    free(positions);
    percale_mannequin_free(fast);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(skin_never_crosses_itself)
{
    const int per_stride = PERCALE_SANITIZED ? 3 : 6;
    for (int i = 0; i <= per_stride * 2; i++) { // falling into the stride, then a whole one
        float *positions = pose_at(i * STRIDE / per_stride);
        const PercaleAuditMesh skin = {.positions = positions,
                                       .vertex_count = body.vertex_count,
                                       .triangles = body.triangles,
                                       .triangle_count = body.triangle_count,
                                       .thickness = THICKNESS,
                                       .mask = 1};
        PercaleQuality quality;
        ck_assert_int_eq(percale_audit(&skin, 1, NULL, 0, &quality), PERCALE_OK);
        ck_assert_msg(quality.ef_cloth_cloth <= 0.0, "%g crossings at %g s", quality.ef_cloth_cloth,
                      i * STRIDE / per_stride);
        free(positions);
    }
}
END_TEST

START_TEST(limbs_keep_20_mm_from_each_other_and_from_the_trunk)
{
    static const double APART = 0.020; // m
    const int per_stride = PERCALE_SANITIZED ? 2 : 6;
    double legs = 1.0;
    double arms = 1.0;
    for (int i = 0; i <= per_stride; i++) {
        float *positions = pose_at(i == 0 ? 0.0 : STRIDE * (1.0 + (double)i / per_stride));
        legs = fmin(legs, part_distance(positions, is_left_leg, is_right_leg, 0.2));
        legs = fmin(legs, part_distance(positions, is_right_leg, is_left_leg, 0.2));
        arms = fmin(arms, part_distance(positions, is_arm, is_trunk_or_leg, 0.2));
        arms = fmin(arms, part_distance(positions, is_trunk_or_leg, is_arm, 0.2));
        free(positions);
    }
    ck_assert_double_gt(legs, APART);
    ck_assert_double_gt(arms, APART);
    (void)printf("limbs: legs %.1f mm, arms %.1f mm apart\n", 1e3 * legs, 1e3 * arms);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("mannequin");
    TCase *figure = tcase_create("mannequin");
    tcase_set_tags(figure, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_add_unchecked_fixture(figure, make_body, free_body);
    tcase_set_timeout(figure, 60);
    tcase_add_test(figure, body_is_one_closed_surface_without_handles);
    tcase_add_test(figure, body_has_no_slivers);
    tcase_add_test(figure, body_stands_on_the_floor_and_is_170_cm_tall);
    tcase_add_test(figure, walk_starts_from_the_mesh_and_from_rest);
    tcase_add_test(figure, walk_repeats_for_ever);
    tcase_add_test(figure, walk_is_faster_than_1_m_per_s_and_never_jerks);
    tcase_add_test(figure, jump_moves_everything_sideways_within_one_frame);
    tcase_add_test(figure, walk_at_twice_the_speed_is_where_it_would_be_in_twice_the_time);
    tcase_add_test(figure, skin_never_crosses_itself);
    tcase_add_test(figure, limbs_keep_20_mm_from_each_other_and_from_the_trunk);
    suite_add_tcase(suite, figure);
    return percale_test_run(suite);
}
