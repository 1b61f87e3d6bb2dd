// Laws of the built-in scenes with dense contact (funnel, twist, cards) and of incline: they start as they
// should, and what their names promise happens.

#include "scene_play.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const NAMES[] = {"funnel", "twist", "cards", "incline"};
enum { NAME_COUNT = sizeof NAMES / sizeof NAMES[0] };

static const double PI = 3.14159265358979323846;

// ---- all of them ----

START_TEST(scenes_have_about_the_vertices_asked_for)
{
    static const uint64_t SIZES[] = {10000, 2700};
    static const double OFF = 0.03; // share of the size
    for (size_t k = 0; k < 2 * (size_t)NAME_COUNT; ++k) {
        Play play = open_play(NAMES[k / 2], SIZES[k % 2]);
        build(&play, 1);
        ck_assert_double_eq_tol((double)count_vertices(&play), (double)SIZES[k % 2],
                                OFF * (double)SIZES[k % 2]);
        close_play(&play);
    }
}
END_TEST

START_TEST(cells_of_ten_thousand_vertices_are_well_above_the_thickness)
{
    for (size_t k = 0; k < NAME_COUNT - 1; ++k) { // incline has a few hundred
        Play play = open_play(NAMES[k], 0);
        build(&play, 1);
        ck_assert_uint_ge(count_vertices(&play), 9700);
        const PercaleSceneObject cloth = percale_scene_cloth(play.scene, 0);
        for (size_t corner = 0; corner < 3 * (size_t)cloth.triangle_count; ++corner) {
            ck_assert(cloth.rest_lengths[corner] >= 4.0f * cloth.thickness);
        }
        close_play(&play);
    }
}
END_TEST

START_TEST(scenes_start_free_of_crossings_and_of_penetration)
{
    for (size_t k = 0; k < NAME_COUNT; ++k) {
        Play play = open_play(NAMES[k], PERCALE_SANITIZED ? 300 : 1500);
        if (strcmp(NAMES[k], "incline") == 0) {
            set(&play, "layers", "3");
        }
        build(&play, 1);
        const PercaleQuality quality = judge(&play);
        ck_assert_double_eq(quality.ef_cloth_cloth, 0.0);
        ck_assert_double_eq(quality.ef_cloth_obstacle, 0.0);
        ck_assert_double_eq(quality.penetration_max_mm, 0.0);
        ck_assert_double_eq(quality.penetration_obstacle_mm, 0.0);
        ck_assert_double_eq(quality.vertices_inside, 0.0);
        ck_assert_double_eq_tol(quality.stretch_max, 0.0, 1e-4);
        close_play(&play);
    }
}
END_TEST

static uint64_t hash_after(const char *name, int thread_count, uint32_t frames)
{
    const bool is_dense_at_once = strcmp(name, "cards") == 0;
    Play play = open_play(name, PERCALE_SANITIZED || is_dense_at_once ? 600 : 1800); // for 3 and 7 threads
    set(&play, "substeps", "3");
    if (strcmp(name, "incline") == 0) {
        set(&play, "layers", "2");
    }
    build(&play, thread_count);
    run_frames(&play, frames);
    const uint64_t hash = percale_solver_hash(play.solver);
    close_play(&play);
    return hash;
}

START_TEST(scenes_end_the_same_for_any_number_of_threads)
{
    static const int THREADS[] = {2, 3, 7};
    const char *name = NAMES[_i];
    const uint64_t expected = hash_after(name, 1, 2);
    ck_assert_uint_ne(hash_after(name, 1, 1), expected); // it does move
    for (size_t k = 0; k < sizeof THREADS / sizeof THREADS[0]; ++k) {
        ck_assert_msg(hash_after(name, THREADS[k], 2) == expected, "%s: %d threads", name, THREADS[k]);
    }
}
END_TEST

// ---- obstacles ----

static double volume_of(PercaleSceneObject object)
{
    double sum = 0.0; // six times the volume
    for (size_t t = 0; t < object.triangle_count; ++t) {
        double corner[9];
        for (size_t k = 0; k < 9; ++k) {
            corner[k] = (double)object.positions[3 * (size_t)object.triangles[3 * t + k / 3] + k % 3];
        }
        const double *a = corner;
        const double *b = corner + 3;
        const double *c = corner + 6;
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum / 6.0;
}

static int compare_edges(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a;
    const uint64_t right = *(const uint64_t *)b;
    return (left > right) - (left < right);
}

/// Each edge runs once in each direction.
static void expect_closed(PercaleSceneObject object)
{
    const size_t count = 3 * (size_t)object.triangle_count;
    uint64_t *edges = calloc(2 * count, sizeof *edges);
    ck_assert_ptr_nonnull(edges);
    for (size_t corner = 0; corner < count; ++corner) {
        const uint64_t a = object.triangles[corner];
        const uint64_t b = object.triangles[corner % 3 == 2 ? corner - 2 : corner + 1];
        edges[corner] = a << 32 | b;
        edges[count + corner] = b << 32 | a;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    qsort(edges + count, count, sizeof *edges, compare_edges);
    ck_assert_mem_eq(edges, edges + count, count * sizeof *edges);
    for (size_t k = 1; k < count; ++k) {
        ck_assert_uint_ne(edges[k], edges[k - 1]);
    }
    free(edges);
}

static double throat_of(PercaleSceneObject funnel)
{
    double narrowest = HUGE_VAL;
    for (size_t k = 0; k < funnel.vertex_count; ++k) {
        const float *point = &funnel.positions[3 * k];
        narrowest = fmin(narrowest, hypot((double)point[0], (double)point[2]));
    }
    return narrowest;
}

START_TEST(obstacles_are_closed_and_face_out)
{
    static const double WALL = 0.05; // m
    Play funnel = open_play("funnel", 400);
    build(&funnel, 1);
    const PercaleSceneObject ring = percale_scene_obstacle(funnel.scene, 0);
    // A wall of 0.05 m around a throat of 0.12 m and a cone of 0.6 m that opens to 0.75 m; that the edge
    // between them is rounded changes little.
    const double throat = throat_of(ring);
    const double volume = PI * WALL * (0.12 * (2.0 * throat + WALL) + 0.6 * (throat + 0.75 + WALL));
    expect_closed(ring);
    ck_assert_double_eq_tol(volume_of(ring), volume, 0.02 * volume);
    close_play(&funnel);
    Play cards = open_play("cards", 120);
    build(&cards, 1);
    expect_closed(percale_scene_obstacle(cards.scene, 0));
    ck_assert_double_eq_tol(volume_of(percale_scene_obstacle(cards.scene, 0)), 0.036, 1e-6);
    close_play(&cards);
    Play incline = open_play("incline", 4);
    build(&incline, 1);
    expect_closed(percale_scene_obstacle(incline.scene, 0));
    ck_assert_double_eq_tol(volume_of(percale_scene_obstacle(incline.scene, 0)), 0.4, 1e-6);
    close_play(&incline);
}
END_TEST

// ---- funnel ----

START_TEST(the_throat_has_room_for_the_cloth_of_any_thickness)
{
    static const char *const THICKNESSES[] = {"0", "0.002", "0.005", "0.02"};
    for (size_t k = 0; k < sizeof THICKNESSES / sizeof THICKNESSES[0]; ++k) {
        Play play = open_play("funnel", 2500);
        set(&play, "thickness", THICKNESSES[k]);
        build(&play, 1);
        const PercaleSceneObject funnel = percale_scene_obstacle(play.scene, 0);
        const PercaleSceneObject sheet = percale_scene_cloth(play.scene, 0);
        const double throat = throat_of(funnel) - (double)sheet.thickness;
        const double cloth = PI * (double)sheet.thickness; // of a circle of 1 m, where it passes
        ck_assert_double_le(cloth / (PI * throat * throat), 0.4);
        ck_assert_double_lt(throat_of(funnel), 0.5); // it is no hole that the sheet falls through
        close_play(&play);
    }
}
END_TEST

START_TEST(the_throat_has_room_for_the_folds_of_a_coarse_sheet)
{
    Play play = open_play("funnel", 400);
    build(&play, 1);
    const double cell = 1.0 / 19.0; // m, of 20 x 20 vertices
    ck_assert_double_ge(throat_of(percale_scene_obstacle(play.scene, 0)), 3.0 * cell - 1e-6);
    close_play(&play);
}
END_TEST

START_TEST(the_sheet_is_pulled_through_the_funnel)
{
    static const uint32_t FRAMES = 120; // of 1/30 s: the pull takes 4 s
    Play play = open_play("funnel", PERCALE_SANITIZED ? 49 : 64);
    set(&play, "frame_rate", "30");
    set(&play, "substeps", "8");
    set(&play, "passes", "4");
    build(&play, 1);
    const double above = 0.6;   // m, where the sheet starts: the rim
    const double below = -0.12; // m, where the throat ends
    float *before = positions_of(&play, 0);
    run_frames(&play, FRAMES);
    float *after = positions_of(&play, 0);
    for (size_t k = 0; k < count_vertices(&play); ++k) {
        ck_assert_double_gt((double)before[3 * k + 1], above);
        ck_assert_double_lt((double)after[3 * k + 1], below);
    }
    const PercalePinGroup *grip = &play.scene->cloths[0].pins[0];
    for (size_t k = 0; k < grip->count; ++k) {
        ck_assert_double_eq_tol((double)after[3 * (size_t)grip->vertices[k] + 1], -1.0, 1e-6);
    }
    ck_assert_double_eq(judge(&play).nonfinite, 0.0);
    ck_assert_double_eq(judge(&play).vertices_inside, 0.0);
    free(before);
    free(after);
    close_play(&play);
}
END_TEST

// ---- twist ----

/// Ends of the strip, as pins hold them.
typedef struct Ends {
    double angle[2];  // rad, counted through
    double height[2]; // m
} Ends;

/// Directions and heights of the two ends; angles go on from `before`.
static Ends look_at_ends(const Play *play, const Ends *before)
{
    Ends ends;
    float *positions = positions_of(play, 0);
    for (size_t end = 0; end < 2; ++end) {
        const PercalePinGroup *group = &play->scene->cloths[0].pins[end];
        const float *first = &positions[3 * (size_t)group->vertices[0]];
        const float *last = &positions[3 * (size_t)group->vertices[group->count - 1]];
        const double angle = atan2(-(double)(last[2] - first[2]), (double)(last[0] - first[0]));
        const double rounds = nearbyint((before->angle[end] - angle) / (2.0 * PI));
        ends.angle[end] = angle + 2.0 * PI * rounds;
        ends.height[end] = (double)first[1];
    }
    free(positions);
    return ends;
}

static const Ends AT_REST = {{0.0, 0.0}, {2.0, 0.0}};

START_TEST(the_ends_turn_four_times_against_each_other)
{
    Play play = open_play("twist", PERCALE_SANITIZED ? 36 : 100);
    set(&play, "self", "off");
    set(&play, "substeps", "4");
    build(&play, 1);
    Ends ends = look_at_ends(&play, &AT_REST);
    ck_assert_double_eq_tol(ends.angle[0], 0.0, 1e-6);
    ck_assert_double_eq_tol(ends.angle[1], 0.0, 1e-6);
    for (uint32_t frame = 0; frame < percale_scene_default_frames(play.scene); ++frame) {
        run_frame(&play);
        ends = look_at_ends(&play, &ends);
    }
    ck_assert_double_eq_tol(ends.angle[0], 4.0 * PI, 1e-5);
    ck_assert_double_eq_tol(ends.angle[1], -4.0 * PI, 1e-5);
    ck_assert_double_eq_tol(ends.height[0], 2.0, 1e-6); // the upper end stays
    ck_assert_double_eq(judge(&play).nonfinite, 0.0);
    close_play(&play);
}
END_TEST

START_TEST(the_free_end_comes_up_no_faster_than_a_hand_as_the_strip_winds_up)
{
    static const double FASTEST = 0.5; // m/s
    Play play = open_play("twist", PERCALE_SANITIZED ? 36 : 100);
    set(&play, "self", "off");
    set(&play, "substeps", "4");
    build(&play, 1);
    Ends ends = AT_REST;
    for (uint32_t frame = 0; frame < percale_scene_default_frames(play.scene); ++frame) {
        run_frame(&play);
        const Ends next = look_at_ends(&play, &ends);
        ck_assert_double_le(fabs(next.height[1] - ends.height[1]), FASTEST / 60.0 + 1e-6);
        ck_assert_double_ge(next.height[1], -1e-6);
        ends = next;
    }
    ck_assert_double_ge(ends.height[1], 0.2);
    ck_assert_double_le(ends.height[1], 1.5);
    ck_assert_double_le(judge(&play).stretch_p99, 0.2); // so it is not torn
    close_play(&play);
}
END_TEST

START_TEST(a_strip_that_nobody_turns_hardly_moves)
{
    Play play = open_play("twist", 100);
    set(&play, "turns", "0");
    set(&play, "substeps", "4");
    build(&play, 1);
    run_frames(&play, 30);
    const Ends ends = look_at_ends(&play, &AT_REST);
    ck_assert_double_eq_tol(ends.angle[1], 0.0, 1e-6);
    ck_assert_double_eq_tol(ends.height[1], 0.0, 1e-3);
    close_play(&play);
}
END_TEST

// ---- cards ----

static double mean_height(const Play *play, uint32_t cloth, double *lowest)
{
    const uint32_t count = percale_scene_cloth(play->scene, cloth).vertex_count;
    float *positions = positions_of(play, cloth);
    double sum = 0.0;
    for (size_t k = 0; k < count; ++k) {
        sum += (double)positions[3 * k + 1];
        *lowest = fmin(*lowest, (double)positions[3 * k + 1]);
    }
    free(positions);
    return sum / count;
}

START_TEST(cards_come_to_rest_in_their_order_on_the_ground)
{
    static const double THICKNESS = 0.002; // m
    Play play = open_play("cards", PERCALE_SANITIZED ? 120 : 180);
    set(&play, "substeps", "8");
    set(&play, "passes", "4");
    build(&play, 1);
    ck_assert_uint_eq(percale_scene_cloth_count(play.scene), 30);
    ck_assert_str_eq(percale_scene_cloth(play.scene, 0).name, "card_00");
    ck_assert_str_eq(percale_scene_cloth(play.scene, 29).name, "card_29");
    double lowest = HUGE_VAL;
    const double dropped_from = mean_height(&play, 29, &lowest);
    run_frames(&play, PERCALE_SANITIZED ? 10 : 15);
    double below = 0.0;
    lowest = HUGE_VAL;
    for (uint32_t card = 0; card < 30; ++card) {
        const double height = mean_height(&play, card, &lowest);
        ck_assert_double_gt(height, below); // above the one below, or the ground
        below = height;
    }
    ck_assert_double_lt(below, dropped_from - 5.0 * THICKNESS); // they have fallen
    ck_assert_double_gt(lowest, 0.0);
    ck_assert_double_eq(judge(&play).vertices_inside, 0.0);
    close_play(&play);
}
END_TEST

// ---- incline ----

/// How far the middle of each layer has gone down the slope, m; negative: up.
static void slide(const char *angle, const char *layers, uint32_t frames, double down[3])
{
    Play play = open_play("incline", PERCALE_SANITIZED ? 48 : 108);
    set(&play, "angle", angle);
    set(&play, "layers", layers);
    build(&play, 1);
    const uint32_t count = percale_scene_cloth_count(play.scene);
    const double slope = strtod(angle, NULL) * PI / 180.0;
    memset(down, 0, 3 * sizeof *down);
    for (int end = 0; end < 2; ++end) {
        for (uint32_t layer = 0; layer < count; ++layer) {
            const uint32_t vertex_count = percale_scene_cloth(play.scene, layer).vertex_count;
            float *positions = positions_of(&play, layer);
            double sum = 0.0;
            for (size_t k = 0; k < vertex_count; ++k) {
                sum += (double)positions[3 * k] * cos(slope) - (double)positions[3 * k + 1] * sin(slope);
            }
            down[layer] = sum / vertex_count - down[layer];
            free(positions);
        }
        run_frames(&play, end == 0 ? frames : 0);
    }
    close_play(&play);
}

START_TEST(a_sheet_holds_below_the_angle_of_friction)
{
    double down[3];
    slide("10", "1", 30, down);
    ck_assert_double_eq_tol(down[0], 0.0, 1e-3);
    slide("16", "1", 30, down); // the tangent of 16.7 degrees is 0.3
    ck_assert_double_eq_tol(down[0], 0.0, 1e-3);
}
END_TEST

START_TEST(a_sheet_slides_above_it_as_coulomb_says)
{
    double down[3];
    slide("25", "1", 30, down);
    const double slope = 25.0 * PI / 180.0;
    const double expected = 0.5 * 9.81 * (sin(slope) - 0.3 * cos(slope)) * 0.25; // 30 frames are 0.5 s
    ck_assert_double_eq_tol(down[0], expected, 0.05 * expected);
}
END_TEST

START_TEST(layers_lie_on_each_other)
{
    double down[3];
    slide("10", "3", 10, down);
    for (int layer = 0; layer < 3; ++layer) {
        ck_assert_double_eq_tol(down[layer], 0.0, 5e-3);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("built-in scenes");
    TCase *all = tcase_create("all");
    tcase_set_timeout(all, 60.0);
    tcase_add_test(all, scenes_have_about_the_vertices_asked_for);
    tcase_add_test(all, cells_of_ten_thousand_vertices_are_well_above_the_thickness);
    tcase_add_test(all, scenes_start_free_of_crossings_and_of_penetration);
    tcase_add_loop_test(all, scenes_end_the_same_for_any_number_of_threads, 0, NAME_COUNT);
    tcase_add_test(all, obstacles_are_closed_and_face_out);
    TCase *each = tcase_create("each");
    tcase_set_timeout(each, 60.0);
    tcase_add_test(each, the_throat_has_room_for_the_cloth_of_any_thickness);
    tcase_add_test(each, the_throat_has_room_for_the_folds_of_a_coarse_sheet);
    tcase_add_test(each, the_sheet_is_pulled_through_the_funnel);
    tcase_add_test(each, the_ends_turn_four_times_against_each_other);
    tcase_add_test(each, the_free_end_comes_up_no_faster_than_a_hand_as_the_strip_winds_up);
    tcase_add_test(each, a_strip_that_nobody_turns_hardly_moves);
    tcase_add_test(each, cards_come_to_rest_in_their_order_on_the_ground);
    tcase_add_test(each, a_sheet_holds_below_the_angle_of_friction);
    tcase_add_test(each, a_sheet_slides_above_it_as_coulomb_says);
    tcase_add_test(each, layers_lie_on_each_other);
    suite_add_tcase(suite, all);
    suite_add_tcase(suite, each);
    return percale_test_run(suite);
}
