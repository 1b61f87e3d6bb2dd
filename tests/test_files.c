// Laws of the files: what is written comes back, what is bad is refused with its place, and nothing half
// written stands under a final name.

#include "percale/scene.h"
#include "scene/number_text.h"
#include "scene/output_file.h"
#include "scratch_folder.h"
#include "testing.h"

#include <math.h>
#include <signal.h>
#include <sys/wait.h>

// ---- OBJ ----

static PercaleMesh read_obj_text(const char *text)
{
    PercaleMesh mesh;
    PercaleSceneError error = {""};
    scratch_write("mesh.obj", text);
    ck_assert_msg(percale_obj_read(scratch_path("mesh.obj").text, NULL, &mesh, &error), "%s", error.text);
    return mesh;
}

static void expect_triangles(const PercaleMesh *mesh, const uint32_t *triangles, uint32_t count)
{
    ck_assert_uint_eq(mesh->triangle_count, count);
    ck_assert_mem_eq(mesh->triangles, triangles, 3 * count * sizeof *triangles);
}

// The error must hold both texts and no mesh may come back.
static void expect_bad_obj(const char *text, const char *place, const char *reason)
{
    PercaleMesh mesh;
    PercaleSceneError error = {""};
    scratch_write("bad.obj", text);
    ck_assert_msg(!percale_obj_read(scratch_path("bad.obj").text, NULL, &mesh, &error), "accepted: %s", text);
    ck_assert_msg(strstr(error.text, place) != NULL, "\"%s\" is not in: %s", place, error.text);
    ck_assert_msg(strstr(error.text, reason) != NULL, "\"%s\" is not in: %s", reason, error.text);
    ck_assert_ptr_null(strchr(error.text, '\n'));
    ck_assert_ptr_null(mesh.positions);
    ck_assert_uint_eq(mesh.vertex_count, 0);
}

START_TEST(obj_round_trip_keeps_every_bit)
{
    enum { SIDE = 20 };
    PercaleMesh mesh = percale_test_sheet(SIDE, 1.0F);
    PercaleSceneError error = {""};
    uint64_t seed = 7;
    for (size_t k = 0; k < (size_t)3 * SIDE * SIDE; ++k) {
        const double magnitude = pow(10.0, 12.0 * percale_test_random(&seed) - 8.0);
        mesh.positions[k] = (float)(magnitude * (2.0 * percale_test_random(&seed) - 1.0));
    }
    const ScratchPath path = scratch_path("out.obj");
    ck_assert_msg(percale_obj_write(path.text, mesh.positions, mesh.vertex_count, mesh.triangles,
                                    mesh.triangle_count, NULL, &error),
                  "%s", error.text);
    PercaleMesh back;
    ck_assert_msg(percale_obj_read(path.text, NULL, &back, &error), "%s", error.text);
    ck_assert_str_eq(back.name, "out");
    ck_assert_uint_eq(back.vertex_count, mesh.vertex_count);
    ck_assert_mem_eq(back.positions, mesh.positions, 3 * mesh.vertex_count * sizeof *mesh.positions);
    expect_triangles(&back, mesh.triangles, mesh.triangle_count);
    percale_mesh_free(&mesh);
    percale_mesh_free(&back);
}
END_TEST

START_TEST(obj_far_from_home_loses_nothing_against_its_origin)
{
    static const double FAR[3] = {10000.0, -250.0, 0.0};
    PercaleSceneError error = {""};
    PercaleMesh mesh;
    scratch_write("far.obj", "v 10000.0001 -250 0\nv 10001 -250 0\nv 10000 -249.5 0\nf 1 2 3\n");
    ck_assert(percale_obj_read(scratch_path("far.obj").text, FAR, &mesh, &error));
    ck_assert_double_eq_tol((double)mesh.positions[0], 1e-4, 1e-11);
    ck_assert_double_eq((double)mesh.positions[7], (double)0.5F);
    const ScratchPath path = scratch_path("back.obj");
    ck_assert(percale_obj_write(path.text, mesh.positions, 3, mesh.triangles, 1, FAR, &error));
    percale_mesh_free(&mesh);
    ck_assert(percale_obj_read(path.text, FAR, &mesh, &error));
    ck_assert_double_eq_tol((double)mesh.positions[0], 1e-4, 1e-11);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(polygons_become_fans)
{
    static const uint32_t EXPECTED[] = {0, 1, 2, 0, 2, 3, 0, 3, 4};
    PercaleMesh mesh = read_obj_text("v 0 0 0\nv 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1 0\nf 1 2 3 4 5\n");
    expect_triangles(&mesh, EXPECTED, 3);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(negative_indices_count_back_from_the_face)
{
    static const uint32_t EXPECTED[] = {0, 1, 2, 1, 2, 3};
    PercaleMesh mesh = read_obj_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\nv 1 1 0\nf -3 -2 -1\n");
    expect_triangles(&mesh, EXPECTED, 2);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(every_form_of_corner_and_number_is_read)
{
    static const uint32_t EXPECTED[] = {0, 1, 2, 0, 1, 3};
    PercaleMesh mesh = read_obj_text("# a comment ending in a backslash \\\n"
                                     "v +.5 1. -2.5e-1 # behind it\r\n"
                                     "mtllib some.mtl\r\n"
                                     "\tv 1E2 0 0 1.0\n"
                                     "v 0 1 0 0.1 0.2 0.3\n"
                                     "v 0 \\\n 0 \\\r\n 1\n"
                                     "vt 0.25 0.5\nvt 0.75 0.5 0\nvn 0 0 1\n"
                                     "o thing\ng part\ns off\nusemtl none\n"
                                     "f 1/1/1 2/2 3//1\nl 1 2\np 1\n"
                                     "f 1 2/2/1 \\\n4");
    expect_triangles(&mesh, EXPECTED, 2);
    ck_assert_uint_eq(mesh.vertex_count, 4);
    ck_assert_double_eq((double)mesh.positions[0], (double)0.5F);
    ck_assert_double_eq((double)mesh.positions[1], (double)1.0F);
    ck_assert_double_eq((double)mesh.positions[2], (double)-0.25F);
    ck_assert_double_eq((double)mesh.positions[3], (double)100.0F);
    ck_assert_double_eq((double)mesh.positions[11], (double)1.0F);
    ck_assert_double_eq((double)mesh.uvs[0], (double)0.25F);
    ck_assert_double_eq((double)mesh.uvs[2], (double)0.75F);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(a_vertex_keeps_its_first_texture_coordinates)
{
    PercaleMesh mesh = read_obj_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 9 9\n"
                                     "f 1/1 2/2 3/3\nf 2/4 4/4 3/4\n");
    ck_assert_double_eq((double)mesh.uvs[2], (double)1.0F);
    ck_assert_double_eq((double)mesh.uvs[5], (double)1.0F);
    ck_assert_double_eq((double)mesh.uvs[6], (double)9.0F);
    percale_mesh_free(&mesh);
}
END_TEST

START_TEST(a_bad_obj_is_refused_with_its_line)
{
    static const struct {
        const char *text, *place, *reason;
    } BAD[] = {
        {"v 0 0 0\nv 1 nan 0\nf 1 2 3\n", "bad.obj:2:", "nan"},
        {"v 0 0 0\nv 1 0 inf\n", "bad.obj:2:", "inf"},
        {"v 0 0 1e39\n", "bad.obj:1:", "1e39"},
        {"v 0 0 1e999\n", "bad.obj:1:", "1e999"},
        {"v 0 0\n", "bad.obj:1:", "3 coordinates"},
        {"v 0 0 1 2 3\n", "bad.obj:1:", "3 coordinates"},
        {"v 0 0 1 2 3 4 5 6\n", "bad.obj:1:", "numbers"},
        {"v 0 0 1x\n", "bad.obj:1:", "1x"},
        {"v 0 0 1,5\n", "bad.obj:1:", "1,5"},
        {"\n\nvt 1\n", "bad.obj:3:", "texture"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 \\\n 4\n", "bad.obj:5:", "vertex index 4"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "bad.obj:4:", "index 0"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf -4 1 2\n", "bad.obj:4:", "index -4"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1 2 3\n", "bad.obj:4:", "texture index 1"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//1 2 3\n", "bad.obj:4:", "normal index 1"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3.5\n", "bad.obj:4:", "3.5"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3/\n", "bad.obj:4:", "corner"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 x\n", "bad.obj:4:", "x"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 99999999999999999999 1 2\n", "bad.obj:4:", "out of range"},
        {"v 0 0 0\nv 1 0 0\r\nv 0 1 0\nf 1 2\n", "bad.obj:4:", "3 corners"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 1\n", "bad.obj:4:", "vertex 1 twice"},
        {"", "bad.obj:", "no vertices"},
        {"nothing of use\n", "bad.obj:", "no vertices"},
        {"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "bad.obj:", "no faces"},
    };
    for (size_t k = 0; k < sizeof BAD / sizeof BAD[0]; ++k) {
        expect_bad_obj(BAD[k].text, BAD[k].place, BAD[k].reason);
    }
}
END_TEST

START_TEST(a_vertex_repeated_in_a_large_face_is_found)
{
    enum { CORNERS = 50 };
    char text[4096] = "";
    size_t used = 0;
    for (int k = 0; k < CORNERS; ++k) {
        used += (size_t)snprintf(text + used, sizeof text - used, "v %d 0 0\n", k);
    }
    used += (size_t)snprintf(text + used, sizeof text - used, "f");
    for (int k = 1; k <= CORNERS; ++k) {
        used += (size_t)snprintf(text + used, sizeof text - used, " %d", k == CORNERS ? 7 : k);
    }
    expect_bad_obj(text, "bad.obj:51:", "vertex 7 twice");
}
END_TEST

START_TEST(a_missing_file_is_named)
{
    PercaleMesh mesh;
    PercalePointCache cache;
    PercaleSceneError error = {""};
    ck_assert(!percale_obj_read("no/such/mesh.obj", NULL, &mesh, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "no/such/mesh.obj"));
    ck_assert(!percale_pc2_read("no/such/cache.pc2", &cache, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "no/such/cache.pc2"));
}
END_TEST

// ---- numbers ----

START_TEST(written_numbers_read_back_as_the_same_float)
{
    uint64_t seed = 3;
    for (int k = 0; k < 20000; ++k) {
        const double magnitude = pow(10.0, 70.0 * percale_test_random(&seed) - 36.0);
        const float value = (float)(magnitude * (2.0 * percale_test_random(&seed) - 1.0));
        char text[PERCALE_NUMBER_TEXT_SIZE];
        const size_t length = percale_number_format(text, (double)value);
        const char *at = text;
        double back = 0.0;
        ck_assert(percale_number_parse(&at, text + length, &back));
        ck_assert_ptr_eq(at, text + length);
        ck_assert_double_eq((double)(float)back, (double)value);
    }
}
END_TEST

START_TEST(decimals_of_fifteen_digits_are_exact)
{
    static const struct {
        const char *text;
        double value;
    } EXACT[] = {{"0.1", 0.1},
                 {"0.3", 0.3},
                 {"0.7", 0.7},
                 {"-9.81", -9.81},
                 {"123456789012345", 123456789012345.0},
                 {"1.23456789012345e-7", 1.23456789012345e-7},
                 {"0.000001", 1e-6},
                 {"1e22", 1e22},
                 {"00012.50", 12.5},
                 {"-0", -0.0}};
    for (size_t k = 0; k < sizeof EXACT / sizeof EXACT[0]; ++k) {
        const char *at = EXACT[k].text;
        double value = 1.0;
        ck_assert(percale_number_parse(&at, at + strlen(at), &value));
        ck_assert_double_eq(value, EXACT[k].value);
        ck_assert_int_eq(signbit(value) != 0, signbit(EXACT[k].value) != 0);
    }
}
END_TEST

// ---- PC2 ----

enum {
    POINTS = 3,
    SAMPLES = 2,
    VALUES = 3 * POINTS,
    HEADER = 32,
    CACHE_BYTES = HEADER + 4 * VALUES * SAMPLES
};

static const float FIRST_SAMPLE[VALUES] = {1.0F, 2.0F, 3.0F, -4.0F, 5e-9F, 6.0F, 7.0F, 8.0F, 9.0F};

static bool write_cache(const char *name, uint32_t samples, PercaleSceneError *error)
{
    PercalePc2Writer *writer = percale_pc2_open(scratch_path(name).text, POINTS, SAMPLES, 48.0F, error);
    ck_assert_ptr_nonnull(writer);
    for (uint32_t sample = 0; sample < samples; ++sample) {
        float positions[VALUES];
        for (int k = 0; k < VALUES; ++k) {
            positions[k] = FIRST_SAMPLE[k] + (float)sample;
        }
        ck_assert(percale_pc2_append(writer, positions, error));
    }
    return percale_pc2_close(writer, error);
}

static void load_cache(unsigned char bytes[CACHE_BYTES])
{
    PercaleSceneError error = {""};
    ck_assert(write_cache("good.pc2", SAMPLES, &error));
    FILE *stream = fopen(scratch_path("good.pc2").text, "rb");
    ck_assert_ptr_nonnull(stream);
    ck_assert_uint_eq(fread(bytes, 1, CACHE_BYTES, stream), CACHE_BYTES);
    ck_assert_int_eq(fgetc(stream), EOF);
    ck_assert_int_eq(fclose(stream), 0);
}

static void expect_bad_cache(const unsigned char *bytes, size_t size, const char *reason)
{
    PercalePointCache cache;
    PercaleSceneError error = {""};
    scratch_write_bytes("bad.pc2", bytes, size);
    ck_assert_msg(!percale_pc2_read(scratch_path("bad.pc2").text, &cache, &error), "accepted: %s", reason);
    ck_assert_msg(strstr(error.text, reason) != NULL && strstr(error.text, "bad.pc2") != NULL,
                  "\"%s\" is not in: %s", reason, error.text);
    ck_assert_ptr_null(cache.samples);
}

START_TEST(pc2_round_trip_keeps_every_bit)
{
    PercaleSceneError error = {""};
    PercalePointCache cache;
    ck_assert(write_cache("walk.pc2", SAMPLES, &error));
    ck_assert_msg(percale_pc2_read(scratch_path("walk.pc2").text, &cache, &error), "%s", error.text);
    ck_assert_uint_eq(cache.vertex_count, POINTS);
    ck_assert_uint_eq(cache.sample_count, SAMPLES);
    ck_assert_mem_eq(cache.samples, FIRST_SAMPLE, sizeof FIRST_SAMPLE);
    ck_assert_double_eq((double)cache.samples[VALUES], (double)2.0F);
    percale_point_cache_free(&cache);
}
END_TEST

START_TEST(pc2_bytes_are_those_of_the_format)
{
    static const unsigned char EXPECTED[HEADER + 4] = {
        'P', 'O', 'I', 'N', 'T', 'C', 'A', 'C', 'H', 'E', '2',     0, 1, 0, 0, 0, POINTS, 0,
        0,   0,   0,   0,   0,   0,   0,   0,   64,  66,  SAMPLES, 0, 0, 0, 0, 0, 128,    63};
    unsigned char bytes[CACHE_BYTES];
    load_cache(bytes);
    ck_assert_mem_eq(bytes, EXPECTED, sizeof EXPECTED);
}
END_TEST

START_TEST(a_bad_pc2_is_refused_with_its_reason)
{
    unsigned char bytes[CACHE_BYTES + 1] = {0};
    load_cache(bytes);
    expect_bad_cache(bytes, CACHE_BYTES - 1, "bytes");
    expect_bad_cache(bytes, CACHE_BYTES + 1, "bytes");
    expect_bad_cache(bytes, HEADER - 1, "not a PC2");
    expect_bad_cache(bytes, 0, "not a PC2");
    bytes[12] = 2;
    expect_bad_cache(bytes, CACHE_BYTES, "version 2");
    bytes[12] = 1;
    bytes[0] = 'Q';
    expect_bad_cache(bytes, CACHE_BYTES, "not a PC2");
    bytes[0] = 'P';
    bytes[16] = 0;
    expect_bad_cache(bytes, CACHE_BYTES, "0 points");
    bytes[16] = POINTS;
    bytes[31] = 0xff;
    expect_bad_cache(bytes, CACHE_BYTES, "samples");
    bytes[31] = 0;
    memset(bytes + HEADER + 4 * (VALUES + 3), 0xff, 4);
    expect_bad_cache(bytes, CACHE_BYTES, "sample 1, point 1");
}
END_TEST

START_TEST(a_pc2_without_all_its_samples_leaves_nothing)
{
    PercaleSceneError error = {""};
    ck_assert(!write_cache("short.pc2", SAMPLES - 1, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "1 of 2"));
    ck_assert_int_eq(scratch_count(false), 0);
}
END_TEST

START_TEST(a_pc2_takes_no_more_samples_than_announced)
{
    PercaleSceneError error = {""};
    PercalePc2Writer *writer = percale_pc2_open(scratch_path("full.pc2").text, POINTS, 1, 1.0F, &error);
    ck_assert(percale_pc2_append(writer, FIRST_SAMPLE, &error));
    ck_assert(!percale_pc2_append(writer, FIRST_SAMPLE, &error));
    ck_assert(percale_pc2_close(writer, &error));
}
END_TEST

// ---- output files ----

START_TEST(a_killed_writer_leaves_no_final_file)
{
    const pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0) {
        PercaleSceneError error;
        PercalePc2Writer *writer = percale_pc2_open(scratch_path("killed.pc2").text, POINTS, 1, 1.0F, &error);
        if (writer != NULL && percale_pc2_append(writer, FIRST_SAMPLE, &error)) {
            (void)kill(getpid(), SIGKILL);
        }
        _exit(EXIT_FAILURE);
    }
    int status = 0;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert(WIFSIGNALED(status));
    ck_assert(!scratch_exists("killed.pc2"));
    // The leftover is in nobody's way.
    PercaleSceneError error = {""};
    ck_assert_msg(write_cache("killed.pc2", SAMPLES, &error), "%s", error.text);
}
END_TEST

START_TEST(until_it_is_committed_the_old_file_stands)
{
    PercaleOutputFile file;
    PercaleSceneError error = {""};
    char text[8] = "";
    scratch_write("kept.txt", "old");
    const ScratchPath path = scratch_path("kept.txt");
    ck_assert(percale_output_open(&file, path.text, &error));
    ck_assert_int_ge(fputs("newer", file.stream), 0);
    percale_output_discard(&file);
    ck_assert_int_eq(scratch_count(false), 1);
    FILE *stream = fopen(path.text, "rb");
    ck_assert_ptr_nonnull(stream);
    ck_assert_uint_eq(fread(text, 1, sizeof text - 1, stream), 3);
    ck_assert_int_eq(fclose(stream), 0);
    ck_assert_str_eq(text, "old");
}
END_TEST

START_TEST(two_writers_of_one_name_do_not_mix)
{
    PercaleOutputFile first;
    PercaleOutputFile second;
    PercaleSceneError error = {""};
    char text[8] = "";
    const ScratchPath path = scratch_path("shared.txt");
    ck_assert(percale_output_open(&first, path.text, &error));
    ck_assert(percale_output_open(&second, path.text, &error));
    ck_assert_int_ge(fputs("one", first.stream), 0);
    ck_assert_int_ge(fputs("two", second.stream), 0);
    ck_assert(percale_output_commit(&second, &error));
    ck_assert(percale_output_commit(&first, &error));
    FILE *stream = fopen(path.text, "rb");
    ck_assert_ptr_nonnull(stream);
    ck_assert_uint_eq(fread(text, 1, sizeof text - 1, stream), 3);
    ck_assert_int_eq(fclose(stream), 0);
    ck_assert_str_eq(text, "one");
    ck_assert_int_eq(scratch_count(false), 1);
}
END_TEST

// Through a link of its own: whatever goes wrong here replaces the link and not the machine's device.
START_TEST(a_full_disk_is_an_error_at_commit)
{
    PercaleOutputFile file;
    PercaleSceneError error = {""};
    const ScratchPath path = scratch_path("full.txt");
    ck_assert_int_eq(symlink("/dev/full", path.text), 0);
    ck_assert(percale_output_open(&file, path.text, &error)); // not a regular file: written in place
    ck_assert_int_ge(fputs("text", file.stream), 0);
    ck_assert(!percale_output_commit(&file, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "full.txt"));
    ck_assert_ptr_null(file.stream);
    ck_assert_int_eq(scratch_count(false), 1);
}
END_TEST

START_TEST(an_unwritable_path_is_named)
{
    PercaleOutputFile file;
    PercaleSceneError error = {""};
    ck_assert(!percale_output_open(&file, "no/such/folder/x.txt", &error));
    ck_assert_ptr_nonnull(strstr(error.text, "no/such/folder/x.txt"));
    ck_assert(!percale_output_open(&file, scratch_folder, &error)); // a folder is no file
    ck_assert_ptr_nonnull(strstr(error.text, scratch_folder));
    ck_assert_int_eq(scratch_count(false), 0);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("files");
    TCase *laws = tcase_create("laws");
    tcase_add_checked_fixture(laws, make_scratch, remove_scratch);
    tcase_add_test(laws, obj_round_trip_keeps_every_bit);
    tcase_add_test(laws, obj_far_from_home_loses_nothing_against_its_origin);
    tcase_add_test(laws, polygons_become_fans);
    tcase_add_test(laws, negative_indices_count_back_from_the_face);
    tcase_add_test(laws, every_form_of_corner_and_number_is_read);
    tcase_add_test(laws, a_vertex_keeps_its_first_texture_coordinates);
    tcase_add_test(laws, a_bad_obj_is_refused_with_its_line);
    tcase_add_test(laws, a_vertex_repeated_in_a_large_face_is_found);
    tcase_add_test(laws, a_missing_file_is_named);
    tcase_add_test(laws, written_numbers_read_back_as_the_same_float);
    tcase_add_test(laws, decimals_of_fifteen_digits_are_exact);
    tcase_add_test(laws, pc2_round_trip_keeps_every_bit);
    tcase_add_test(laws, pc2_bytes_are_those_of_the_format);
    tcase_add_test(laws, a_bad_pc2_is_refused_with_its_reason);
    tcase_add_test(laws, a_pc2_without_all_its_samples_leaves_nothing);
    tcase_add_test(laws, a_pc2_takes_no_more_samples_than_announced);
    tcase_add_test(laws, a_killed_writer_leaves_no_final_file);
    tcase_add_test(laws, until_it_is_committed_the_old_file_stands);
    tcase_add_test(laws, two_writers_of_one_name_do_not_mix);
    tcase_add_test(laws, a_full_disk_is_an_error_at_commit);
    tcase_add_test(laws, an_unwritable_path_is_named);
    suite_add_tcase(suite, laws);
    return percale_test_run(suite);
}
