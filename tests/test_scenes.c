// Laws of scenes: built-in ones have the sizes they promise, files are read strictly, and things move when
// they should and only then.

#include "percale/scene.h"
#include "scene/scene_model.h"
#include "scratch_folder.h"
#include "testing.h"

#include <math.h>

static const char SQUARE_OBJ[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

static PercaleScene *open_scene(const char *name, uint64_t size)
{
    PercaleSceneError error = {""};
    PercaleScene *scene = percale_scene_open(name, size, &error);
    ck_assert_msg(scene != NULL, "%s", error.text);
    return scene;
}

static PercaleSolver *build_scene(PercaleScene *scene)
{
    PercaleSceneError error = {""};
    PercaleSolver *solver = percale_scene_build(scene, 1, &error);
    ck_assert_msg(solver != NULL, "%s", error.text);
    return solver;
}

static void set(PercaleScene *scene, const char *key, const char *value)
{
    PercaleSceneError error = {""};
    ck_assert_msg(percale_scene_set(scene, key, value, &error), "%s", error.text);
}

static void finish(PercaleScene *scene, PercaleSolver *solver)
{
    percale_solver_destroy(solver);
    percale_scene_close(scene);
}

static void expect_float(float value, double expected)
{
    ck_assert_double_eq_tol((double)value, expected, 1e-6);
}

// ---- built-in scenes ----

START_TEST(drape_has_exactly_the_vertices_asked_for)
{
    static const struct {
        uint64_t size;
        uint32_t per_side;
    } SIZES[] = {{0, 128}, {16384, 128}, {4096, 64}, {4000, 63}, {4050, 64},
                 {4, 2},   {1, 2},       {12, 3},    {13, 4}};
    for (size_t k = 0; k < sizeof SIZES / sizeof SIZES[0]; ++k) {
        PercaleScene *scene = open_scene("drape", SIZES[k].size);
        PercaleSolver *solver = build_scene(scene);
        const uint32_t n = SIZES[k].per_side;
        ck_assert_uint_eq(percale_scene_cloth_count(scene), 1);
        ck_assert_uint_eq(percale_scene_cloth(scene, 0).vertex_count, n * n);
        ck_assert_uint_eq(percale_scene_cloth(scene, 0).triangle_count, 2 * (n - 1) * (n - 1));
        finish(scene, solver);
    }
}
END_TEST

START_TEST(drape_starts_level_and_square_above_a_sphere)
{
    PercaleScene *scene = open_scene("drape", 256);
    PercaleSolver *solver = build_scene(scene);
    const PercaleSceneObject sheet = percale_scene_cloth(scene, 0);
    double low[3] = {1e9, 1e9, 1e9};
    double high[3] = {-1e9, -1e9, -1e9};
    for (size_t k = 0; k < (size_t)3 * sheet.vertex_count; ++k) {
        low[k % 3] = fmin(low[k % 3], (double)sheet.positions[k]);
        high[k % 3] = fmax(high[k % 3], (double)sheet.positions[k]);
    }
    ck_assert_double_eq(low[0], -1.0);
    ck_assert_double_eq(high[0], 1.0);
    ck_assert_double_eq(low[1], high[1]);
    ck_assert_double_eq_tol(low[1], 1.2, 1e-7);
    ck_assert_double_eq(low[2], -1.0);
    ck_assert_double_eq(high[2], 1.0);
    const PercaleSceneObject sphere = percale_scene_obstacle(scene, 0);
    ck_assert_uint_eq(percale_scene_obstacle_count(scene), 1);
    ck_assert_uint_eq(sphere.triangle_count, 20480);
    ck_assert_uint_eq(sphere.vertex_count, 10242);
    for (size_t k = 0; k < sphere.vertex_count; ++k) {
        const float *point = &sphere.positions[3 * k];
        const double r =
            sqrt((double)point[0] * (double)point[0] + ((double)point[1] - 0.5) * ((double)point[1] - 0.5) +
                 (double)point[2] * (double)point[2]);
        ck_assert_double_eq_tol(r, 0.5, 1e-7);
    }
    finish(scene, solver);
}
END_TEST

// Six times the volume that the triangles enclose, seen from a point.
static double signed_volume(PercaleSceneObject object, const double from[3])
{
    double sum = 0.0;
    for (size_t t = 0; t < object.triangle_count; ++t) {
        double corner[3][3];
        for (size_t k = 0; k < 9; ++k) {
            const size_t vertex = object.triangles[3 * t + k / 3];
            corner[k / 3][k % 3] = (double)object.positions[3 * vertex + k % 3] - from[k % 3];
        }
        const double *a = corner[0];
        const double *b = corner[1];
        const double *c = corner[2];
        sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
               a[2] * (b[0] * c[1] - b[1] * c[0]);
    }
    return sum;
}

START_TEST(the_sheet_faces_up_and_the_sphere_faces_out)
{
    static const double BELOW[3] = {0.0, 0.0, 0.0};
    PercaleScene *scene = open_scene("drape", 100);
    PercaleSolver *solver = build_scene(scene);
    ck_assert_double_eq_tol(signed_volume(percale_scene_cloth(scene, 0), BELOW) / 6.0, 4.0 * 1.2 / 3.0, 1e-5);
    ck_assert_double_eq_tol(signed_volume(percale_scene_obstacle(scene, 0), BELOW) / 6.0, 0.5236, 1e-3);
    finish(scene, solver);
}
END_TEST

// The first two pins are the ends of one side.
static void expect_corners(const PercaleSceneItem *cloth, uint32_t count)
{
    const PercalePinGroup *group = &cloth->pins[0];
    double sides[4] = {0.0, 0.0, 0.0, 0.0};
    ck_assert_uint_eq(group->count, count);
    for (uint32_t k = 0; k < count; ++k) {
        const float *point = &cloth->mesh.positions[3 * (size_t)group->vertices[k]];
        ck_assert_double_eq(fabs((double)point[0]), 1.0);
        ck_assert_double_eq(fabs((double)point[2]), 1.0);
        sides[k] = (double)point[2];
        for (uint32_t other = 0; other < k; ++other) {
            ck_assert_uint_ne(group->vertices[other], group->vertices[k]);
        }
    }
    ck_assert_double_eq(sides[0], sides[1]);
}

START_TEST(drape_hangs_from_as_many_corners_as_asked)
{
    static const struct {
        const char *hang;
        uint32_t count;
    } HANGS[] = {{"0", 0}, {"2", 2}, {"4", 4}};
    for (size_t k = 0; k < sizeof HANGS / sizeof HANGS[0]; ++k) {
        PercaleScene *scene = open_scene("drape", 81);
        set(scene, "hang", HANGS[k].hang);
        set(scene, "obstacle", "off");
        PercaleSolver *solver = build_scene(scene);
        ck_assert_uint_eq(percale_scene_obstacle_count(scene), 0);
        ck_assert_uint_eq(scene->cloths[0].pin_count, HANGS[k].count > 0);
        if (HANGS[k].count > 0) {
            expect_corners(&scene->cloths[0], HANGS[k].count);
        }
        finish(scene, solver);
    }
}
END_TEST

START_TEST(a_seed_moves_the_start_a_little_and_the_rest_shape_not_at_all)
{
    PercaleScene *plain = open_scene("drape", 64);
    PercaleScene *seeded = open_scene("drape", 64);
    PercaleSolver *plain_solver = build_scene(plain);
    set(seeded, "seed", "5");
    set(seeded, "hang", "2");
    PercaleSolver *seeded_solver = build_scene(seeded);
    const PercaleSceneObject before = percale_scene_cloth(plain, 0);
    const PercaleSceneObject after = percale_scene_cloth(seeded, 0);
    double largest = 0.0;
    for (size_t k = 0; k < (size_t)3 * before.vertex_count; ++k) {
        largest = fmax(largest, fabs((double)after.positions[k] - (double)before.positions[k]));
    }
    ck_assert_double_gt(largest, 5e-5);
    ck_assert_double_le(largest, 1.01e-4);
    ck_assert_mem_eq(before.positions, after.positions, 3 * sizeof(float)); // a pinned corner
    ck_assert_mem_eq(before.rest_lengths, after.rest_lengths,
                     3 * before.triangle_count * sizeof *before.rest_lengths);
    finish(plain, plain_solver);
    finish(seeded, seeded_solver);
}
END_TEST

START_TEST(the_flag_hangs_on_one_edge_in_the_wind)
{
    PercaleScene *scene = open_scene("flag", 600);
    PercaleSolver *solver = build_scene(scene);
    const PercalePinGroup *mast = &scene->cloths[0].pins[0];
    ck_assert_uint_eq(percale_scene_cloth(scene, 0).vertex_count, 600);
    ck_assert_uint_eq(percale_scene_obstacle_count(scene), 0);
    ck_assert_uint_eq(mast->count, 20);
    for (uint32_t k = 0; k < mast->count; ++k) {
        ck_assert_double_eq((double)scene->cloths[0].mesh.positions[3 * (size_t)mast->vertices[k]], 0.0);
    }
    ck_assert_double_gt(scene->settings.items[PERCALE_SET_WIND].value[0], 0.0);
    finish(scene, solver);
}
END_TEST

START_TEST(scenes_that_are_not_there_are_refused)
{
    static const struct {
        const char *name;
        uint64_t size;
        const char *reason;
    } BAD[] = {{"drap", 0, "\"drape\""},
               {"layer", 0, "\"layers\""},
               {"cantilever", 0, "not in this version"},
               {"no/such/scene.json", 0, "no/such/scene.json"},
               {"drape", 200000000, "too large"}};
    for (size_t k = 0; k < sizeof BAD / sizeof BAD[0]; ++k) {
        PercaleSceneError error = {""};
        ck_assert_ptr_null(percale_scene_open(BAD[k].name, BAD[k].size, &error));
        ck_assert_msg(strstr(error.text, BAD[k].reason) != NULL, "%s", error.text);
    }
}
END_TEST

START_TEST(every_listed_scene_opens_and_says_what_it_is)
{
    uint32_t count = 0;
    for (; percale_scene_name(count) != NULL; ++count) {
        PercaleScene *scene = open_scene(percale_scene_name(count), 0);
        uint32_t setting_count = 0;
        ck_assert_ptr_nonnull(percale_scene_summary(count));
        ck_assert_ptr_nonnull(percale_scene_settings(scene, &setting_count));
        ck_assert_uint_ge(setting_count, PERCALE_SET_COUNT);
        ck_assert_uint_gt(percale_scene_default_frames(scene), 0);
        percale_scene_close(scene);
    }
    ck_assert_uint_ge(count, 7);
    ck_assert_ptr_null(percale_scene_summary(count));
}
END_TEST

START_TEST(more_passes_than_sweeps_do_not_build)
{
    PercaleScene *scene = open_scene("drape", 16);
    PercaleSceneError error = {""};
    set(scene, "passes", "21");
    ck_assert_ptr_null(percale_scene_build(scene, 1, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "passes=21"));
    set(scene, "substeps", "21");
    PercaleSolver *solver = build_scene(scene);
    finish(scene, solver);
}
END_TEST

// ---- scene files ----

static PercaleScene *open_text(const char *text)
{
    scratch_write("square.obj", SQUARE_OBJ);
    scratch_write("scene.json", text);
    return open_scene(scratch_path("scene.json").text, 0);
}

START_TEST(a_bad_scene_file_is_refused_with_line_and_column)
{
    static const struct {
        const char *text, *place, *reason;
    } BAD[] = {
        {"{ \"cloths\": [ { \"obj\": \"square.obj\",\n \"thikness\": 1 } ] }", ":2:2:", "\"thickness\""},
        {"{ \"cloth\": [] }", ":1:3:", "\"cloths\""},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\" } ],\n\n  \"settings\": { \"grafity\": [0, 0, 0] } }",
         ":3:17:", "\"gravity\""},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"pins\": [0,\n 4] } ] }", ":2:2:", "pin 4"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"pins\": [-1] } ] }", ":1:47:", "pin -1"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"pins\": [0, 1.5] } ] }", ":1:50:", "whole"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"pins\": [2, 2] } ] }", ":1:50:", "twice"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"pins\": {\"vertexes\": [1]} } ] }",
         ":1:47:", "\"vertices\""},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"seams\": [[0, 1], [2, 9]] } ] }",
         ":1:60:", "seam vertex 9"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"seams\": [[3, 3]] } ] }", ":1:48:", "itself"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"seams\": [[3]] } ] }", ":1:48:", "[vertex, vertex]"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"rest\": \"uv\" } ] }", ":1:46:", "vertex 0"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"friction\": \"high\" } ] }", ":1:50:", "number"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"friction\": -1 } ] }", ":1:50:", "out of range"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"mask\": -1 } ] }", ":1:46:", "out of range"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"scale\": 0 } ] }", ":1:47:", "out of range"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"translate\": [1, 2] } ] }", ":1:51:", "three numbers"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"name\": \"a/b\" } ] }", ":1:46:", "a/b"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\" }, { \"obj\": \"square.obj\" } ] }",
         ":1:40:", "two cloths"},
        {"{ \"cloths\": [ { \"name\": \"a\" } ] }", ":1:15:", "\"obj\" is missing"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\", \"obj\": \"square.obj\" } ] }", ":1:", "duplicate"},
        {"{ \"cloths\": [ { \"obj\": \"square.obj\" } ], \"settings\": { \"reuse\": 1 } }",
         ":1:65:", "auto|always"},
        {"{ \"\xc3\xa9\": {\"a\": [\"]\\\"\", 1]}, \"cloths\": [] }", ":1:3:", "unknown key"},
        {"{ \"settings\": {\"\xc3\xa9\xc3\xa9\": [\"]\\\"\"], \"passes\": 1} }", ":1:16:", "unknown setting"},
        {"{ \"frames\": 0, \"cloths\": [ { \"obj\": \"square.obj\" } ] }", ":1:13:", "out of range"},
        {"{ \"frame_rate\": \"fast\", \"cloths\": [ { \"obj\": \"square.obj\" } ] }",
         ":1:17:", "frame_rate must be a number"},
        {"{ \"cloths\": [] }", ":1:1:", "no cloths"},
        {"[]", ":1:1:", "object"},
        {"{ \"cloths\": [ }", ":1:", "scene.json"},
        {"", "scene.json:", "expected"},
    };
    scratch_write("square.obj", SQUARE_OBJ);
    for (size_t k = 0; k < sizeof BAD / sizeof BAD[0]; ++k) {
        PercaleSceneError error = {""};
        scratch_write("scene.json", BAD[k].text);
        PercaleScene *scene = percale_scene_open(scratch_path("scene.json").text, 0, &error);
        ck_assert_msg(scene == NULL, "accepted: %s", BAD[k].text);
        ck_assert_msg(strstr(error.text, BAD[k].place) != NULL && strstr(error.text, BAD[k].reason) != NULL,
                      "\"%s\" or \"%s\" is not in: %s", BAD[k].place, BAD[k].reason, error.text);
    }
}
END_TEST

START_TEST(a_bad_mesh_of_a_scene_is_named_with_its_own_line)
{
    PercaleSceneError error = {""};
    scratch_write("broken.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 8\n");
    scratch_write("scene.json", "{ \"cloths\": [ { \"obj\": \"broken.obj\" } ] }");
    ck_assert_ptr_null(percale_scene_open(scratch_path("scene.json").text, 0, &error));
    ck_assert_msg(strstr(error.text, "broken.obj:4:") != NULL, "%s", error.text);
}
END_TEST

START_TEST(a_scene_file_has_no_size)
{
    PercaleSceneError error = {""};
    scratch_write("square.obj", SQUARE_OBJ);
    scratch_write("scene.json", "{ \"cloths\": [ { \"obj\": \"square.obj\" } ] }");
    ck_assert_ptr_null(percale_scene_open(scratch_path("scene.json").text, 100, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "size"));
}
END_TEST

START_TEST(own_values_beat_the_settings)
{
    PercaleScene *scene = open_text(
        "{ \"frame_rate\": 48, \"frames\": 9, \"cloths\": [ { \"name\": \"a\", \"obj\": \"square.obj\", "
        "\"thickness\": 0.004, \"mask\": 6, \"layer\": -2 }, { \"name\": \"b\", \"obj\": "
        "\"square.obj\", \"translate\": [0, 0, 1] } ], \"obstacles\": [ { \"obj\": \"square.obj\", "
        "\"translate\": [0, 0, -1] } ], \"settings\": { \"thickness\": 0.003, \"ee\": \"off\", "
        "\"reuse\": \"auto\", \"bending\": false, \"gravity\": [0, -1, 0] } }");
    set(scene, "thickness", "0.005");
    PercaleSolver *solver = build_scene(scene);
    expect_float(percale_scene_cloth(scene, 0).thickness, 0.004);
    expect_float(percale_scene_cloth(scene, 1).thickness, 0.005);
    expect_float(percale_scene_obstacle(scene, 0).thickness, 0.005);
    ck_assert_uint_eq(percale_scene_cloth(scene, 0).mask, 6);
    ck_assert_int_eq(scene->cloths[0].layer, -2);
    ck_assert_double_eq(percale_scene_frame_rate(scene), 48.0);
    ck_assert_uint_eq(percale_scene_default_frames(scene), 9);
    ck_assert_str_eq(percale_scene_obstacle(scene, 0).name, "square");
    finish(scene, solver);
}
END_TEST

START_TEST(a_mesh_is_scaled_then_turned_about_x_y_z_then_moved)
{
    PercaleScene *scene = open_text("{ \"cloths\": [ { \"obj\": \"square.obj\", \"scale\": 2, "
                                    "\"rotate\": [90, 0, 90], \"translate\": [1, 2, 3] } ] }");
    PercaleSolver *solver = build_scene(scene);
    // (1, 1, 0) -> scale (2, 2, 0) -> about x (2, 0, 2) -> about z (0, 2, 2) -> (1, 4, 5)
    const float *point = &percale_scene_cloth(scene, 0).positions[6];
    ck_assert_double_eq((double)point[0], 1.0);
    ck_assert_double_eq((double)point[1], 4.0);
    ck_assert_double_eq((double)point[2], 5.0);
    expect_float(percale_scene_cloth(scene, 0).rest_lengths[0], 2.0);
    finish(scene, solver);
}
END_TEST

START_TEST(the_origin_is_taken_off_before_anything_is_rounded)
{
    scratch_write("far.obj", "v 10000.0001 0 0\nv 10001 0 0\nv 10000 1 0\nf 1 2 3\n");
    scratch_write("scene.json", "{ \"cloths\": [ { \"obj\": \"far.obj\" } ] }");
    PercaleScene *scene = open_scene(scratch_path("scene.json").text, 0);
    set(scene, "origin", "10000,0,0");
    PercaleSolver *solver = build_scene(scene);
    ck_assert_double_eq_tol((double)percale_scene_cloth(scene, 0).positions[0], 1e-4, 1e-11);
    finish(scene, solver);
}
END_TEST

START_TEST(the_rest_shape_may_be_a_pattern_or_another_mesh)
{
    scratch_write("pattern.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 3 0\nvt 0 4\nf 1/1 2/2 3/3\n");
    scratch_write("small.obj", "v 0 0 0\nv 0.5 0 0\nv 0 0.5 0\nf 1 2 3\n");
    scratch_write("scene.json",
                  "{ \"cloths\": [ { \"obj\": \"pattern.obj\", \"rest\": \"uv\" }, { \"name\": "
                  "\"b\", \"obj\": \"pattern.obj\", \"rest\": \"small.obj\", \"translate\": [0, "
                  "0, 1] } ] }");
    PercaleScene *scene = open_scene(scratch_path("scene.json").text, 0);
    PercaleSolver *solver = build_scene(scene);
    const float *flat = percale_scene_cloth(scene, 0).rest_lengths;
    expect_float(flat[0], 3.0);
    expect_float(flat[1], 5.0);
    expect_float(flat[2], 4.0);
    const float *small = percale_scene_cloth(scene, 1).rest_lengths;
    expect_float(small[0], 0.5);
    expect_float(small[1], sqrt(0.5));
    finish(scene, solver);
}
END_TEST

START_TEST(a_pattern_with_a_torn_vertex_is_refused)
{
    PercaleSceneError error = {""};
    scratch_write("atlas.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 5 5\n"
                               "f 1/1 2/2 3/3\nf 1/1 3/5 4/4\n");
    scratch_write("scene.json", "{ \"cloths\": [ { \"obj\": \"atlas.obj\", \"rest\": \"uv\" } ] }");
    ck_assert_ptr_null(percale_scene_open(scratch_path("scene.json").text, 0, &error));
    ck_assert_msg(strstr(error.text, "vertex 2") != NULL, "%s", error.text);
}
END_TEST

START_TEST(a_thickness_of_zero_is_a_fifth_of_the_median_edge)
{
    PercaleScene *scene = open_scene("drape", 121);
    set(scene, "thickness", "0");
    PercaleSolver *solver = build_scene(scene);
    expect_float(percale_scene_cloth(scene, 0).thickness, 0.04); // sides of 0.2 m, a third are diagonals
    expect_float(percale_scene_obstacle(scene, 0).thickness, 0.04);
    finish(scene, solver);
}
END_TEST

START_TEST(sewn_vertices_share_a_number_and_others_do_not)
{
    scratch_write("two.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 4 6 5\n");
    scratch_write("scene.json",
                  "{ \"cloths\": [ { \"name\": \"a\", \"obj\": \"two.obj\" }, { \"name\": \"b\", "
                  "\"obj\": \"two.obj\", \"translate\": [0, 0, 1], \"seams\": [[4, 2], [3, 1]] } "
                  "] }");
    PercaleScene *scene = open_scene(scratch_path("scene.json").text, 0);
    PercaleSolver *solver = build_scene(scene);
    const uint32_t *weld = percale_scene_cloth(scene, 1).weld;
    ck_assert_ptr_null(percale_scene_cloth(scene, 0).weld);
    ck_assert_uint_eq(weld[3], weld[1]);
    ck_assert_uint_eq(weld[4], weld[2]);
    for (size_t a = 0; a < 6; ++a) {
        ck_assert_uint_ge(weld[a], 6); // the numbers of the other cloth are apart
        for (size_t b = 0; b < a; ++b) {
            const bool sewn = (a == 3 && b == 1) || (a == 4 && b == 2);
            ck_assert_int_eq(weld[a] == weld[b], sewn);
        }
    }
    finish(scene, solver);
}
END_TEST

// ---- motion ----

static void write_walk(const char *name, uint32_t samples)
{
    PercaleSceneError error = {""};
    PercalePc2Writer *writer = percale_pc2_open(scratch_path(name).text, 4, samples, 99.0F, &error);
    ck_assert_ptr_nonnull(writer);
    for (uint32_t sample = 0; sample < samples; ++sample) {
        const float z = -0.5F - 0.25F * (float)sample;
        const float positions[12] = {0.0F, 0.0F, z, 1.0F, 0.0F, z, 1.0F, 1.0F, z, 0.0F, 1.0F, z};
        ck_assert(percale_pc2_append(writer, positions, &error));
    }
    ck_assert_msg(percale_pc2_close(writer, &error), "%s", error.text);
}

static const char WALKING[] = "{ \"cloths\": [ { \"obj\": \"square.obj\" } ], \"obstacles\": [ { \"name\": "
                              "\"wall\", \"obj\": \"square.obj\", \"animation\": \"walk.pc2\" } ] }";

START_TEST(an_obstacle_is_at_sample_k_at_frame_k_and_stays_at_the_last)
{
    static const double EXPECTED[] = {-0.5, -0.75, -1.0, -1.0, -1.0};
    PercaleSceneError error = {""};
    write_walk("walk.pc2", 3);
    PercaleScene *scene = open_text(WALKING);
    PercaleSolver *solver = build_scene(scene);
    ck_assert_uint_eq(percale_scene_default_frames(scene), 2);
    expect_float(percale_scene_obstacle(scene, 0).positions[2], EXPECTED[0]);
    for (uint32_t frame = 1; frame <= 4; ++frame) {
        ck_assert_int_eq(percale_motion_changes(&scene->obstacles[0].motion, frame), frame <= 2);
        ck_assert_msg(percale_scene_move(scene, solver, frame, &error), "%s", error.text);
        expect_float(percale_scene_obstacle(scene, 0).positions[2], EXPECTED[frame]);
    }
    percale_solver_destroy(solver);
    solver = build_scene(scene); // a scene that is built again starts again
    expect_float(percale_scene_obstacle(scene, 0).positions[2], EXPECTED[0]);
    finish(scene, solver);
}
END_TEST

START_TEST(an_animation_of_other_points_is_refused)
{
    PercaleSceneError error = {""};
    write_walk("walk.pc2", 1);
    scratch_write("square.obj", SQUARE_OBJ);
    scratch_write("five.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 2 0\nf 1 2 3 4 5\n");
    scratch_write("scene.json", "{ \"cloths\": [ { \"obj\": \"square.obj\" } ], \"obstacles\": [ { \"obj\": "
                                "\"five.obj\", \"animation\": \"walk.pc2\" } ] }");
    ck_assert_ptr_null(percale_scene_open(scratch_path("scene.json").text, 0, &error));
    ck_assert_msg(strstr(error.text, "walk.pc2: 4 points, but 5") != NULL, "%s", error.text);
}
END_TEST

START_TEST(pc2_and_obj_animations_get_the_same_transform_as_the_mesh)
{
    scratch_write("move_0000.obj", SQUARE_OBJ);
    scratch_write("move_0001.obj", "v 0 0 5\nv 1 0 5\nv 1 1 5\nv 0 1 5\n");
    write_walk("walk.pc2", 2);
    PercaleScene *scene = open_text(
        "{ \"cloths\": [ { \"obj\": \"square.obj\" } ], \"obstacles\": [ { \"obj\": \"square.obj\", "
        "\"animation\": \"move_%04d.obj\", \"scale\": 2, \"translate\": [0, 0, -20] }, { \"obj\": "
        "\"square.obj\", \"animation\": \"walk.pc2\", \"scale\": 2, \"translate\": [0, 0, -30] } ] }");
    PercaleSceneError error = {""};
    PercaleSolver *solver = build_scene(scene);
    expect_float(percale_scene_obstacle(scene, 0).positions[2], -20.0);
    expect_float(percale_scene_obstacle(scene, 1).positions[2], -31.0);
    ck_assert_msg(percale_scene_move(scene, solver, 1, &error), "%s", error.text);
    expect_float(percale_scene_obstacle(scene, 0).positions[2], -10.0);
    expect_float(percale_scene_obstacle(scene, 0).positions[3], 2.0);
    expect_float(percale_scene_obstacle(scene, 1).positions[2], -31.5);
    finish(scene, solver);
}
END_TEST

START_TEST(pc2_coordinates_are_relative_to_the_origin)
{
    write_walk("walk.pc2", 2);
    PercaleScene *scene = open_text(WALKING);
    set(scene, "origin", "100,200,300");
    PercaleSolver *solver = build_scene(scene);
    ck_assert_double_eq((double)percale_scene_obstacle(scene, 0).positions[0], 0.0);
    ck_assert_double_eq((double)percale_scene_obstacle(scene, 0).positions[2], -0.5);
    ck_assert_double_eq((double)percale_scene_cloth(scene, 0).positions[1], -200.0);
    finish(scene, solver);
}
END_TEST

START_TEST(groups_of_pins_follow_their_animations)
{
    scratch_write("pins_0.obj", "v 1 1 0\nv 0 0 0\n");
    scratch_write("pins_1.obj", "v 1 2 0\nv 0 0.5 0\n");
    PercaleScene *scene =
        open_text("{ \"cloths\": [ { \"obj\": \"square.obj\", \"pins\": [ { \"vertices\": [2, 0], "
                  "\"animation\": \"pins_%d.obj\" }, { \"vertices\": [3] } ] } ] }");
    PercaleSceneError error = {""};
    PercaleSolver *solver = build_scene(scene);
    ck_assert_uint_eq(scene->cloths[0].pin_count, 2);
    ck_assert_msg(percale_scene_move(scene, solver, 1, &error), "%s", error.text);
    expect_float(scene->cloths[0].pins[0].targets[1], 2.0);
    expect_float(scene->cloths[0].pins[0].targets[4], 0.5);
    ck_assert_ptr_null(scene->cloths[0].pins[1].targets);
    finish(scene, solver);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("scenes");
    TCase *built_in = tcase_create("built-in");
    tcase_add_test(built_in, drape_has_exactly_the_vertices_asked_for);
    tcase_add_test(built_in, drape_starts_level_and_square_above_a_sphere);
    tcase_add_test(built_in, the_sheet_faces_up_and_the_sphere_faces_out);
    tcase_add_test(built_in, drape_hangs_from_as_many_corners_as_asked);
    tcase_add_test(built_in, a_seed_moves_the_start_a_little_and_the_rest_shape_not_at_all);
    tcase_add_test(built_in, the_flag_hangs_on_one_edge_in_the_wind);
    tcase_add_test(built_in, scenes_that_are_not_there_are_refused);
    tcase_add_test(built_in, every_listed_scene_opens_and_says_what_it_is);
    tcase_add_test(built_in, more_passes_than_sweeps_do_not_build);
    TCase *files = tcase_create("files");
    tcase_add_checked_fixture(files, make_scratch, remove_scratch);
    tcase_add_test(files, a_bad_scene_file_is_refused_with_line_and_column);
    tcase_add_test(files, a_bad_mesh_of_a_scene_is_named_with_its_own_line);
    tcase_add_test(files, a_scene_file_has_no_size);
    tcase_add_test(files, own_values_beat_the_settings);
    tcase_add_test(files, a_mesh_is_scaled_then_turned_about_x_y_z_then_moved);
    tcase_add_test(files, the_origin_is_taken_off_before_anything_is_rounded);
    tcase_add_test(files, the_rest_shape_may_be_a_pattern_or_another_mesh);
    tcase_add_test(files, a_pattern_with_a_torn_vertex_is_refused);
    tcase_add_test(files, a_thickness_of_zero_is_a_fifth_of_the_median_edge);
    tcase_add_test(files, sewn_vertices_share_a_number_and_others_do_not);
    tcase_add_test(files, an_obstacle_is_at_sample_k_at_frame_k_and_stays_at_the_last);
    tcase_add_test(files, an_animation_of_other_points_is_refused);
    tcase_add_test(files, pc2_and_obj_animations_get_the_same_transform_as_the_mesh);
    tcase_add_test(files, pc2_coordinates_are_relative_to_the_origin);
    tcase_add_test(files, groups_of_pins_follow_their_animations);
    suite_add_tcase(suite, built_in);
    suite_add_tcase(suite, files);
    return percale_test_run(suite);
}
