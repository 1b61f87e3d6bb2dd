// test_garment.c: the mannequin and the dress: closed, clear of themselves and of each other, well sewn.
//
// Sanitized builds leave out the large dresses and most frames of the walk.

#include "mesh_topology.h"
#include "percale/geometry.h"
#include "percale/scene.h"
#include "scene/garment.h"
#include "scene/mannequin.h"
#include "testing.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double STRIDE = 1.1; // s; after so long the walk repeats
static const double BLEND = 0.9;  // s; from then on at full stride
static const float THICKNESS = 0.002F;
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

// ---- measures ----

static void corner(const float *positions, uint32_t vertex, double point[3])
{
    for (size_t k = 0; k < 3; k++) {
        point[k] = (double)positions[3 * (size_t)vertex + k];
    }
}

static double distance_between(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

typedef struct Shape {
    double aspect;   ///< longest edge by smallest height
    double area;     ///< m^2
    double smallest; ///< cosine of the smallest angle
} Shape;

static Shape shape_of(const PercaleMesh *mesh, uint32_t triangle)
{
    double p[3][3];
    for (uint32_t k = 0; k < 3; k++) {
        corner(mesh->positions, mesh->triangles[3 * triangle + k], p[k]);
    }
    const double a = distance_between(p[0], p[1]);
    const double b = distance_between(p[1], p[2]);
    const double c = distance_between(p[2], p[0]);
    const double s = 0.5 * (a + b + c);
    const double area = sqrt(fmax(s * (s - a) * (s - b) * (s - c), 0.0));
    const double longest = fmax(a, fmax(b, c));
    const double shortest = fmin(a, fmin(b, c));
    const double middle = a + b + c - longest - shortest;
    return (Shape){.aspect = longest * longest / (2.0 * area),
                   .area = area,
                   .smallest = (longest * longest + middle * middle - shortest * shortest) /
                               (2.0 * longest * middle)};
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

static uint64_t digest(const PercaleMesh *mesh)
{
    uint64_t hash = 1469598103934665603ULL; // FNV-1a
    const unsigned char *bytes = (const unsigned char *)mesh->positions;
    for (size_t i = 0; i < 3 * sizeof(float) * mesh->vertex_count; i++) {
        hash = (hash ^ bytes[i]) * 1099511628211ULL;
    }
    return hash;
}

/// A part of the body, by where its vertices are in the rest pose.
typedef bool Part(double x, double y);

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

static bool is_part(Part *part, uint32_t vertex)
{
    return part((double)body.positions[3 * vertex], (double)body.positions[3 * vertex + 1]);
}

/// The triangles of a part in a pose, each with a ball around it, which spares most of the work.
typedef struct Ball {
    double corners[3][3]; // m
    double reach;         // m, around the first corner
} Ball;

typedef struct Balls {
    Ball *list;
    uint32_t count;
} Balls;

/// Of the triangles whose first corner belongs to the part; NULL: all.
static Balls balls_of(const float *positions, Part *part)
{
    Balls balls = {.list = calloc(body.triangle_count, sizeof(Ball))};
    ck_assert_ptr_nonnull(balls.list);
    for (uint32_t t = 0; t < body.triangle_count; t++) {
        const uint32_t *v = body.triangles + 3 * (size_t)t;
        if (part && !is_part(part, v[0])) {
            continue;
        }
        Ball *ball = &balls.list[balls.count++];
        for (int k = 0; k < 3; k++) {
            corner(positions, v[k], ball->corners[k]);
        }
        ball->reach = fmax(distance_between(ball->corners[0], ball->corners[1]),
                           distance_between(ball->corners[0], ball->corners[2]));
    }
    return balls;
}

/// Smallest distance of a point to the triangles, if it is less than `limit`.
static double distance_to_balls(const Balls *balls, const double point[3], double limit)
{
    double best = limit;
    for (uint32_t i = 0; i < balls->count; i++) {
        const Ball *ball = &balls->list[i];
        const double far = best + ball->reach;
        const double dx = point[0] - ball->corners[0][0];
        const double dy = point[1] - ball->corners[0][1];
        const double dz = point[2] - ball->corners[0][2];
        if (dx * dx + dy * dy + dz * dz < far * far) {
            double x[4][3];
            double weight[4];
            memcpy(x[0], point, sizeof x[0]);
            memcpy(x[1], ball->corners, sizeof ball->corners);
            best = fmin(best, percale_vertex_face_closest((const double(*)[3])x, weight));
        }
    }
    return best;
}

static double part_distance(const float *positions, Part *from, Part *to, double limit)
{
    double best = limit;
    const Balls balls = balls_of(positions, to);
    for (uint32_t i = 0; i < body.vertex_count; i++) {
        if (is_part(from, i)) {
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

// ---- the body ----

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

// ---- the dress ----

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
    const Balls balls = balls_of(body.positions, NULL);
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
    TCase *figure = tcase_create("mannequin");
    tcase_set_tags(figure, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_add_unchecked_fixture(figure, make_both, free_both);
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
