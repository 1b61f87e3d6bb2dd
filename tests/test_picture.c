// Laws of the picture renderer: what is drawn, what is left out, and what a failure leaves behind.

#include "render/picture.h"
#include "testing.h"

#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 60, HEIGHT = 80, PATH_SIZE = 256 };

static const float SQUARE[] = {-1, 0, 0, 1, 0, 0, 1, 2, 0, -1, 2, 0};
static const uint32_t SQUARE_TRIANGLES[] = {0, 1, 2, 0, 2, 3};

static char folder[64];

static void make_folder(void)
{
    strcpy(folder, "picture_XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(folder));
}

static void remove_folder(void)
{
    char path[PATH_SIZE];
    (void)snprintf(path, sizeof path, "%s/picture.png", folder);
    (void)unlink(path);
    ck_assert_int_eq(rmdir(folder), 0); // nothing else is left, temporary files least of all
}

static PercalePictureMesh square(void)
{
    return (PercalePictureMesh){.positions = SQUARE,
                                .vertex_count = 4,
                                .triangles = SQUARE_TRIANGLES,
                                .triangle_count = 2,
                                .cloth = true};
}

typedef struct Image {
    uint32_t width, height;
    uint8_t *rgb; // [3 * width * height]
} Image;

static bool write_picture(const char *name, const PercalePictureMesh *meshes, uint32_t count,
                          const char *legend, PercaleSceneError *error)
{
    char path[PATH_SIZE];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    PercalePictureDef def = {.width = WIDTH, .height = HEIGHT, .legend = legend};
    return percale_picture_write(path, meshes, count, def, error);
}

static Image read_picture(const char *name)
{
    char path[PATH_SIZE];
    (void)snprintf(path, sizeof path, "%s/%s", folder, name);
    png_image image = {.version = PNG_IMAGE_VERSION};
    ck_assert_msg(png_image_begin_read_from_file(&image, path) != 0, "%s: %s", path, image.message);
    image.format = PNG_FORMAT_RGB;
    Image result = {image.width, image.height, malloc(PNG_IMAGE_SIZE(image))};
    ck_assert_ptr_nonnull(result.rgb);
    ck_assert_int_ne(png_image_finish_read(&image, NULL, result.rgb, 0, NULL), 0);
    return result;
}

static const uint8_t *pixel(const Image *image, uint32_t column, uint32_t row)
{
    return image->rgb + 3 * ((size_t)row * image->width + column);
}

static int difference(const uint8_t *a, const uint8_t *b)
{
    return abs(a[0] - b[0]) + abs(a[1] - b[1]) + abs(a[2] - b[2]);
}

static Image draw(const PercalePictureMesh *meshes, uint32_t count)
{
    PercaleSceneError error = {""};
    ck_assert_msg(write_picture("picture.png", meshes, count, NULL, &error), "%s", error.text);
    return read_picture("picture.png");
}

START_TEST(an_object_in_the_middle_differs_from_the_background)
{
    PercalePictureMesh mesh = square();
    Image image = draw(&mesh, 1);
    ck_assert_uint_eq(image.width, WIDTH);
    ck_assert_uint_eq(image.height, HEIGHT);
    const uint8_t *middle = pixel(&image, WIDTH / 2, HEIGHT / 2);
    const uint8_t *beside = pixel(&image, 1, HEIGHT / 2);
    ck_assert_int_gt(difference(middle, beside), 100);
    ck_assert_int_gt(middle[2], middle[0]); // the first garment is blue
    free(image.rgb);
}
END_TEST

START_TEST(the_scene_fills_the_frame_wherever_and_however_large_it_is)
{
    const float scales[] = {0.01f, 1.0f, 500.0f};
    for (size_t index = 0; index < 3; ++index) {
        float positions[12];
        for (int k = 0; k < 12; ++k)
            positions[k] = scales[index] * (SQUARE[k] + 3.0f);
        PercalePictureMesh mesh = square();
        mesh.positions = positions;
        Image image = draw(&mesh, 1);
        uint32_t blue = 0;
        for (uint32_t place = 0; place < WIDTH * HEIGHT; ++place)
            blue += image.rgb[3 * place + 2] > image.rgb[3 * place] + 40;
        ck_assert_uint_gt(blue, WIDTH * HEIGHT / 3);
        ck_assert_uint_lt(blue, WIDTH * HEIGHT * 3 / 4);
        for (uint32_t column = 0; column < WIDTH; ++column) {
            ck_assert_uint_le(pixel(&image, column, 0)[2], pixel(&image, column, 0)[0] + 40);
            ck_assert_uint_le(pixel(&image, column, HEIGHT - 1)[2],
                              pixel(&image, column, HEIGHT - 1)[0] + 40);
        }
        free(image.rgb);
    }
}
END_TEST

START_TEST(the_floor_shows_a_shadow)
{
    PercalePictureMesh mesh = square();
    Image image = draw(&mesh, 1);
    uint32_t shadow = 0; // pixels that are grey and clearly darker than the floor at the picture's edge
    for (uint32_t row = HEIGHT / 2; row < HEIGHT; ++row)
        for (uint32_t column = 0; column < WIDTH; ++column) {
            const uint8_t *here = pixel(&image, column, row);
            shadow += abs(here[2] - here[0]) < 20 && here[0] + 60 < pixel(&image, 0, row)[0];
        }
    ck_assert_uint_gt(shadow, 30);
    free(image.rgb);
}
END_TEST

START_TEST(heat_colours_the_cloth_from_violet_to_yellow)
{
    const float cold[4] = {0, 0, 0, 0};
    const float hot[4] = {1, 1, 1, 1};
    PercalePictureMesh mesh = square();
    mesh.heat = cold;
    Image image = draw(&mesh, 1);
    const uint8_t *violet = pixel(&image, WIDTH / 2, HEIGHT / 2);
    ck_assert_int_gt(violet[2], violet[1] + 30);
    free(image.rgb);
    mesh.heat = hot;
    image = draw(&mesh, 1);
    const uint8_t *yellow = pixel(&image, WIDTH / 2, HEIGHT / 2);
    ck_assert_int_gt(yellow[1], yellow[2] + 60);
    free(image.rgb);
}
END_TEST

START_TEST(triangles_with_a_vertex_that_is_not_finite_are_left_out)
{
    const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f};
    Image images[4];
    for (int index = 0; index < 4; ++index) {
        float positions[12];
        memcpy(positions, SQUARE, sizeof positions);
        positions[9] = bad[index]; // vertex 3: of the second triangle
        PercalePictureMesh mesh = square();
        mesh.positions = positions;
        images[index] = draw(&mesh, 1);
    }
    PercalePictureMesh alone = square();
    alone.triangle_count = 1;
    Image expected = draw(&alone, 1);
    for (int index = 0; index < 4; ++index) {
        ck_assert_mem_eq(images[index].rgb, expected.rgb, 3 * WIDTH * HEIGHT);
        free(images[index].rgb);
    }
    free(expected.rgb);
}
END_TEST

START_TEST(heat_beyond_the_scale_is_drawn_as_its_end)
{
    const float given[3] = {7.0f, -3.0f, NAN};
    const float ends[3] = {1.0f, 0.0f, 0.0f};
    for (int index = 0; index < 3; ++index) {
        const float heat[4] = {given[index], given[index], given[index], given[index]};
        const float end[4] = {ends[index], ends[index], ends[index], ends[index]};
        PercalePictureMesh mesh = square();
        mesh.heat = heat;
        Image image = draw(&mesh, 1);
        mesh.heat = end;
        Image expected = draw(&mesh, 1);
        ck_assert_mem_eq(image.rgb, expected.rgb, 3 * WIDTH * HEIGHT);
        free(image.rgb);
        free(expected.rgb);
    }
}
END_TEST

START_TEST(nothing_finite_is_an_error_and_no_file)
{
    const float positions[12] = {NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    PercalePictureMesh mesh = square();
    mesh.positions = positions;
    PercaleSceneError error = {""};
    ck_assert(!write_picture("none.png", &mesh, 1, NULL, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "nothing to draw"));
    ck_assert(!write_picture("none.png", NULL, 0, NULL, &error)); // remove_folder finds no file
}
END_TEST

START_TEST(an_unwritable_path_is_named_and_leaves_nothing)
{
    PercalePictureMesh mesh = square();
    PercaleSceneError error = {""};
    ck_assert(!write_picture("missing/picture.png", &mesh, 1, NULL, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "missing/picture.png"));
    ck_assert(!write_picture(".", &mesh, 1, NULL, &error)); // a folder
    PercalePictureDef none = {.width = 0, .height = HEIGHT};
    ck_assert(!percale_picture_write("none.png", &mesh, 1, none, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "0 x 80 pixels"));
}
END_TEST

START_TEST(the_legend_is_in_the_file)
{
    PercalePictureMesh mesh = square();
    PercaleSceneError error = {""};
    ck_assert(write_picture("picture.png", &mesh, 1, "dark is good", &error));
    char path[PATH_SIZE];
    (void)snprintf(path, sizeof path, "%s/picture.png", folder);
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    char bytes[512] = "";
    size_t count = fread(bytes, 1, sizeof bytes, file);
    (void)fclose(file);
    static const char CHUNK[] = "tEXtDescription\0dark is good";
    bool found = false;
    for (size_t start = 0; start + sizeof CHUNK <= count; ++start)
        found = found || memcmp(bytes + start, CHUNK, sizeof CHUNK - 1) == 0;
    ck_assert(found);
}
END_TEST

START_TEST(the_same_scene_gives_the_same_bytes)
{
    PercalePictureMesh meshes[2] = {square(), square()};
    const float behind[12] = {-2, 0, -1, 2, 0, -1, 2, 1, -1, -2, 1, -1};
    meshes[1].positions = behind;
    meshes[1].cloth = false;
    Image first = draw(meshes, 2);
    Image second = draw(meshes, 2);
    ck_assert_mem_eq(first.rgb, second.rgb, 3 * WIDTH * HEIGHT);
    free(first.rgb);
    free(second.rgb);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("picture");
    TCase *laws = tcase_create("laws");
    tcase_add_checked_fixture(laws, make_folder, remove_folder);
    tcase_add_test(laws, an_object_in_the_middle_differs_from_the_background);
    tcase_add_test(laws, the_scene_fills_the_frame_wherever_and_however_large_it_is);
    tcase_add_test(laws, the_floor_shows_a_shadow);
    tcase_add_test(laws, heat_colours_the_cloth_from_violet_to_yellow);
    tcase_add_test(laws, triangles_with_a_vertex_that_is_not_finite_are_left_out);
    tcase_add_test(laws, heat_beyond_the_scale_is_drawn_as_its_end);
    tcase_add_test(laws, nothing_finite_is_an_error_and_no_file);
    tcase_add_test(laws, an_unwritable_path_is_named_and_leaves_nothing);
    tcase_add_test(laws, the_legend_is_in_the_file);
    tcase_add_test(laws, the_same_scene_gives_the_same_bytes);
    suite_add_tcase(suite, laws);
    return percale_test_run(suite);
}
