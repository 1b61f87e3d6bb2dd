// Laws of the scene layers: three garments that start one outside the other, apart from each other and from
// the body, unless the jacket is pushed into the dress.

#include "percale/geometry.h"
#include "scene_play.h"

#include <math.h>
#include <string.h>

static const double THICKNESS = 0.002; // m
static const double APART = 1.5;       // thicknesses
static const double FAR = 0.02;        // m: what is farther off than this is not looked at
enum { DRESS, JACKET, COAT, GARMENT_COUNT, SMALL = 3000 };

// ---- measures ----

typedef struct Corners {
    double point[3][3];
    double lower[3], upper[3];
} Corners;

static Corners corners_of(PercaleSceneObject object, size_t triangle)
{
    Corners corners;
    for (size_t axis = 0; axis < 3; ++axis) {
        corners.lower[axis] = HUGE_VAL;
        corners.upper[axis] = -HUGE_VAL;
        for (size_t k = 0; k < 3; ++k) {
            const double x = (double)object.positions[3 * (size_t)object.triangles[3 * triangle + k] + axis];
            corners.point[k][axis] = x;
            corners.lower[axis] = fmin(corners.lower[axis], x);
            corners.upper[axis] = fmax(corners.upper[axis], x);
        }
    }
    return corners;
}

static bool may_be_nearer(const Corners *a, const Corners *b, double distance)
{
    for (int axis = 0; axis < 3; ++axis) {
        if (a->lower[axis] > b->upper[axis] + distance || b->lower[axis] > a->upper[axis] + distance) {
            return false;
        }
    }
    return true;
}

/// Of two triangles that do not cross.
static double triangle_distance(const Corners *a, const Corners *b)
{
    double nearest = HUGE_VAL;
    double weight[4];
    double x[4][3];
    for (size_t k = 0; k < 3; ++k) {
        memcpy(x[0], a->point[k], sizeof x[0]);
        memcpy(x[1], b->point, sizeof b->point);
        nearest = fmin(nearest, percale_vertex_face_closest((const double(*)[3])x, weight));
        memcpy(x[0], b->point[k], sizeof x[0]);
        memcpy(x[1], a->point, sizeof a->point);
        nearest = fmin(nearest, percale_vertex_face_closest((const double(*)[3])x, weight));
    }
    for (size_t k = 0; k < 9; ++k) {
        memcpy(x[0], a->point[k / 3], sizeof x[0]);
        memcpy(x[1], a->point[(k / 3 + 1) % 3], sizeof x[0]);
        memcpy(x[2], b->point[k % 3], sizeof x[0]);
        memcpy(x[3], b->point[(k % 3 + 1) % 3], sizeof x[0]);
        nearest = fmin(nearest, percale_edge_edge_closest((const double(*)[3])x, weight));
    }
    return nearest;
}

static double distance_between(PercaleSceneObject a, PercaleSceneObject b)
{
    double nearest = FAR;
    Corners *others = calloc(b.triangle_count, sizeof *others);
    ck_assert_ptr_nonnull(others);
    for (size_t t = 0; t < b.triangle_count; ++t) {
        others[t] = corners_of(b, t);
    }
    for (size_t t = 0; t < a.triangle_count; ++t) {
        const Corners corners = corners_of(a, t);
        for (size_t u = 0; u < b.triangle_count; ++u) {
            if (may_be_nearer(&corners, &others[u], nearest)) {
                nearest = fmin(nearest, triangle_distance(&corners, &others[u]));
            }
        }
    }
    free(others);
    return nearest;
}

/// How far a point is in front of a mesh's nearest triangle's plane, or behind it (negative).
static double height_over(const float *position, PercaleSceneObject mesh)
{
    double nearest = HUGE_VAL;
    double height = 0.0;
    for (size_t t = 0; t < mesh.triangle_count; ++t) {
        const Corners face = corners_of(mesh, t);
        double weight[4];
        double x[4][3];
        double side[3];
        double up[3];
        memcpy(x[1], face.point, sizeof face.point);
        for (int k = 0; k < 3; ++k) {
            x[0][k] = (double)position[k];
            side[k] = x[2][k] - x[1][k];
            up[k] = x[3][k] - x[1][k];
        }
        const double distance = percale_vertex_face_closest((const double(*)[3])x, weight);
        if (distance < nearest) {
            const double normal[3] = {side[1] * up[2] - side[2] * up[1], side[2] * up[0] - side[0] * up[2],
                                      side[0] * up[1] - side[1] * up[0]};
            const double over = normal[0] * (x[0][0] - x[1][0]) + normal[1] * (x[0][1] - x[1][1]) +
                                normal[2] * (x[0][2] - x[1][2]);
            nearest = distance;
            height = copysign(distance, over);
        }
    }
    return height;
}

/// The lowest of every `step`-th vertex.
static double lowest_over(PercaleSceneObject upper, PercaleSceneObject lower, size_t step)
{
    double lowest = HUGE_VAL;
    for (size_t vertex = 0; vertex < upper.vertex_count; vertex += step) {
        lowest = fmin(lowest, height_over(&upper.positions[3 * vertex], lower));
    }
    return lowest;
}

static Play start(uint64_t size, const char *push)
{
    Play play = open_play("layers", size);
    set(&play, "push", push);
    build(&play, 1);
    return play;
}

// Built once, for it takes a second or two; the tests only look at them.
static Play plain, tucked;

static void open_both(void)
{
    plain = start(SMALL, "0");
    tucked = start(SMALL, "0.03");
}

static void close_both(void)
{
    close_play(&plain);
    close_play(&tucked);
}

// ---- the start ----

START_TEST(a_dress_a_jacket_and_a_coat_start_without_a_crossing)
{
    static const char *const NAMES[GARMENT_COUNT] = {"dress", "jacket", "coat"};
    static const uint64_t SIZES[] = {SMALL, 10000};
    for (size_t k = 0; k < (PERCALE_SANITIZED ? 1 : 2); ++k) {
        Play play = k == 0 ? plain : start(SIZES[k], "0");
        ck_assert_uint_eq(percale_scene_cloth_count(play.scene), GARMENT_COUNT);
        for (uint32_t layer = 0; layer < GARMENT_COUNT; ++layer) {
            ck_assert_str_eq(percale_scene_cloth(play.scene, layer).name, NAMES[layer]);
            ck_assert_int_eq(play.scene->cloths[layer].layer, (int)layer);
            ck_assert_uint_gt(play.scene->cloths[layer].seam_count, 0);
            ck_assert_uint_eq(play.scene->cloths[layer].pin_count, 0);
        }
        ck_assert_double_eq_tol(count_vertices(&play), (double)SIZES[k], 0.03 * (double)SIZES[k]);
        const PercaleQuality quality = judge(&play);
        ck_assert_double_eq(quality.ef_cloth_cloth + quality.ef_cloth_obstacle + quality.ef_seam, 0.0);
        ck_assert_double_eq(quality.vertices_inside, 0.0);
        ck_assert_double_eq_tol(quality.stretch_max, 0.0, 1e-5);
        if (k > 0) {
            close_play(&play);
        }
    }
}
END_TEST

START_TEST(they_start_apart_from_each_other_and_from_the_body)
{
    static const uint64_t SIZES[] = {SMALL, 7000};
    for (size_t k = 0; k < (PERCALE_SANITIZED ? 1 : 2); ++k) {
        Play play = k == 0 ? plain : start(SIZES[k], "0");
        PercaleSceneObject beneath = percale_scene_obstacle(play.scene, 0);
        for (uint32_t layer = 0; layer < GARMENT_COUNT; ++layer) {
            const PercaleSceneObject garment = percale_scene_cloth(play.scene, layer);
            ck_assert_double_ge(distance_between(garment, beneath), APART * THICKNESS);
            beneath = garment;
        }
        if (k > 0) {
            close_play(&play);
        }
    }
}
END_TEST

START_TEST(each_starts_outside_the_one_beneath)
{
    for (uint32_t layer = JACKET; layer < GARMENT_COUNT; ++layer) {
        const PercaleSceneObject garment = percale_scene_cloth(plain.scene, layer);
        const PercaleSceneObject beneath = percale_scene_cloth(plain.scene, layer - 1);
        ck_assert_double_ge(lowest_over(garment, beneath, PERCALE_SANITIZED ? 7 : 1), APART * THICKNESS);
    }
}
END_TEST

START_TEST(too_few_vertices_are_refused_by_name)
{
    PercaleSceneError error = {""};
    Play play = open_play("layers", SMALL - 1);
    ck_assert_ptr_null(percale_scene_build(play.scene, 1, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "layers: size 2999 "));
    percale_scene_close(play.scene);
}
END_TEST

// ---- push ----

START_TEST(push_tucks_the_jacket_into_the_dress_but_not_into_the_body)
{
    static const double PUSH = 0.03; // m
    const PercaleSceneObject dress = percale_scene_cloth(tucked.scene, DRESS);
    const PercaleSceneObject jacket = percale_scene_cloth(tucked.scene, JACKET);
    const double lowest = lowest_over(jacket, dress, PERCALE_SANITIZED ? 3 : 1);
    ck_assert_double_lt(lowest, -0.5 * PUSH);
    ck_assert_double_gt(lowest, -PUSH);
    const PercaleQuality quality = judge(&tucked);
    ck_assert_double_gt(quality.ef_cloth_cloth, 50.0);
    ck_assert_double_eq(quality.ef_cloth_obstacle, 0.0);
    ck_assert_double_eq(quality.vertices_inside, 0.0);
    ck_assert_double_eq(quality.penetration_obstacle_mm, 0.0);
}
END_TEST

START_TEST(push_leaves_the_rest_shape_and_what_is_above_the_hips)
{
    static const float HIPS = 0.95F; // m
    Play pushed = open_play("layers", SMALL);
    set(&pushed, "push", "0.03");
    set(&pushed, "origin", "10000,0,0"); // far away a float holds no millimetre
    build(&pushed, 1);
    for (uint32_t layer = 0; layer < GARMENT_COUNT; ++layer) {
        const PercaleSceneObject a = percale_scene_cloth(plain.scene, layer);
        const PercaleSceneObject b = percale_scene_cloth(pushed.scene, layer);
        uint32_t moved = 0;
        ck_assert_uint_eq(a.vertex_count, b.vertex_count);
        for (size_t k = 0; k < 3 * (size_t)a.triangle_count; ++k) {
            ck_assert_double_eq_tol((double)a.rest_lengths[k], (double)b.rest_lengths[k], 1e-6);
        }
        for (size_t k = 0; k < 3 * (size_t)a.vertex_count; k += 3) {
            const double shift = fabs((double)a.positions[k] - (double)b.positions[k]) +
                                 fabs((double)a.positions[k + 1] - (double)b.positions[k + 1]) +
                                 fabs((double)a.positions[k + 2] - (double)b.positions[k + 2]);
            const bool same = !(shift > 0.0);
            ck_assert(same || (layer == JACKET && a.positions[k + 1] < HIPS));
            moved += !same;
        }
        ck_assert(layer == JACKET ? 10 * moved > a.vertex_count : moved == 0);
    }
    close_play(&pushed);
}
END_TEST

// ---- the walk ----

START_TEST(only_a_pushed_jacket_is_born_crossed)
{
    static const char *const PUSHES[] = {"0", "0.03"};
    for (int pushed = 0; pushed < 2; ++pushed) {
        Play play = open_play("layers", SMALL);
        set(&play, "push", PUSHES[pushed]);
        set(&play, "substeps", "2");
        build(&play, 2);
        run_frames(&play, 2);
        ck_assert_int_eq(percale_solver_counters(play.solver).born_crossed > 0, pushed);
        ck_assert_int_eq(judge(&play).ef_cloth_cloth > 0.0, pushed);
        ck_assert_double_eq(judge(&play).nonfinite, 0.0);
        close_play(&play);
    }
}
END_TEST

static uint64_t hash_after_a_frame(int thread_count)
{
    Play play = open_play("layers", SMALL);
    set(&play, "substeps", "2");
    build(&play, thread_count);
    run_frame(&play);
    const uint64_t hash = percale_solver_hash(play.solver);
    close_play(&play);
    return hash;
}

START_TEST(they_end_the_same_for_any_number_of_threads)
{
    static const int THREADS[] = {3, 2, 7};
    const uint64_t expected = hash_after_a_frame(1);
    for (size_t k = 0; k < (PERCALE_SANITIZED ? 1 : 3); ++k) {
        ck_assert_uint_eq(hash_after_a_frame(THREADS[k]), expected);
    }
}
END_TEST

/// The body of a scene built anew, at a frame.
static Play body_at(const char *name, const char *speed, uint32_t frame)
{
    PercaleSceneError error = {""};
    Play play = open_play(name, SMALL);
    set(&play, "speed", speed);
    build(&play, 1);
    ck_assert_msg(percale_scene_move(play.scene, play.solver, frame, &error), "%s", error.text);
    return play;
}

START_TEST(at_twice_the_speed_she_is_there_in_half_the_frames)
{
    static const char *const NAMES[] = {"dress", "layers"};
    Play slow = body_at("dress", "1", 50);
    const PercaleSceneObject expected = percale_scene_obstacle(slow.scene, 0);
    for (size_t k = 0; k < 2; ++k) {
        Play fast = body_at(NAMES[k], "2", 25);
        const PercaleSceneObject body = percale_scene_obstacle(fast.scene, 0);
        ck_assert_uint_eq(body.vertex_count, expected.vertex_count);
        for (size_t i = 0; i < 3 * (size_t)body.vertex_count; ++i) {
            ck_assert_double_eq_tol((double)body.positions[i], (double)expected.positions[i], 1e-6);
        }
        close_play(&fast);
    }
    close_play(&slow);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("layered garments");
    TCase *begin = tcase_create("start");
    tcase_set_tags(begin, PERCALE_ONE_THREAD " " PERCALE_ANY_ENGINE);
    tcase_set_timeout(begin, 0.0);
    tcase_add_test(begin, a_dress_a_jacket_and_a_coat_start_without_a_crossing);
    tcase_add_test(begin, they_start_apart_from_each_other_and_from_the_body);
    tcase_add_test(begin, each_starts_outside_the_one_beneath);
    tcase_add_test(begin, too_few_vertices_are_refused_by_name);
    tcase_add_test(begin, push_tucks_the_jacket_into_the_dress_but_not_into_the_body);
    tcase_add_test(begin, push_leaves_the_rest_shape_and_what_is_above_the_hips);
    TCase *walk = tcase_create("walk");
    tcase_set_tags(walk, PERCALE_ANY_ENGINE);
    tcase_set_timeout(walk, 0.0);
    tcase_add_test(walk, only_a_pushed_jacket_is_born_crossed);
    tcase_add_test(walk, they_end_the_same_for_any_number_of_threads);
    if (!PERCALE_SANITIZED) { // no code of its own
        tcase_add_test(walk, at_twice_the_speed_she_is_there_in_half_the_frames);
    }
    suite_add_tcase(suite, begin);
    suite_add_tcase(suite, walk);
    tcase_add_unchecked_fixture(begin, open_both, close_both);
    return percale_test_run(suite);
}
