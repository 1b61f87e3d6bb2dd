#include "render/picture.h"

#include "render/camera.h"
#include "render/color_scale.h"
#include "render/png_file.h"
#include "render/shading.h"
#include "scene/output_file.h"

#include <omp.h>
#include <stdlib.h>

enum {
    SAMPLES_ASIDE = 3,        // samples of a pixel, in each direction
    ROWS_PER_THREAD_MIN = 16, // below this a thread costs more than it brings
    PICTURE_SIDE_MAX = 16384  // pixels; 800 MB of PNG rows are no picture any more
};

static int threads_for(uint32_t row_count)
{
    uint32_t useful = 1u + row_count / ROWS_PER_THREAD_MIN;
    int available = omp_get_num_procs();
    return useful < (uint32_t)available ? (int)useful : available;
}

static void include_in_camera(void *user, PercaleVec3 point)
{
    percale_camera_include(user, point);
}

static void render_pixel(const PercaleStudio *studio, const PercaleCamera *camera, PercalePixels *pixels,
                         uint32_t row, uint32_t column)
{
    PercaleVec3 sum = vec3(0.0f, 0.0f, 0.0f);
    for (uint32_t index = 0; index < SAMPLES_ASIDE * SAMPLES_ASIDE; ++index) {
        uint32_t sample_row = index / SAMPLES_ASIDE;
        float aside = ((float)(index % SAMPLES_ASIDE) + 0.5f) / (float)SAMPLES_ASIDE;
        float below = ((float)sample_row + 0.5f) / (float)SAMPLES_ASIDE;
        float x = ((float)column + aside) / (float)pixels->width;
        float y = 1.0f - ((float)row + below) / (float)pixels->height;
        PercaleSample sample = {.start = camera->eye,
                                .direction =
                                    percale_camera_direction(camera, 2.0f * x - 1.0f, 2.0f * y - 1.0f),
                                .height = y,
                                .pixel = row * pixels->width + column,
                                .index = index};
        sum = vec3_add(sum, percale_studio_shade(studio, &sample));
    }
    PercaleVec3 mean = vec3_scale(sum, 1.0f / (float)(SAMPLES_ASIDE * SAMPLES_ASIDE));
    percale_color_to_srgb(mean, pixels->rgb + 3 * ((size_t)row * pixels->width + column));
}

static void render_rows(const PercaleStudio *studio, const PercaleCamera *camera, PercalePixels *pixels)
{
#pragma omp parallel for default(none) shared(studio, camera, pixels) schedule(dynamic, 4) \
    num_threads(threads_for(pixels->height))
    for (uint32_t row = 0; row < pixels->height; ++row)
        for (uint32_t column = 0; column < pixels->width; ++column)
            render_pixel(studio, camera, pixels, row, column);
}

static bool render(const PercalePictureMesh *meshes, uint32_t mesh_count, PercalePixels *pixels,
                   PercaleSceneError *error)
{
    PercaleRayScene *scene = percale_ray_scene_create(meshes, mesh_count, error);
    if (!scene)
        return false;
    PercaleCamera camera = percale_camera_start(pixels->width, pixels->height);
    percale_ray_scene_visit(scene, include_in_camera, &camera);
    percale_camera_frame(&camera);
    PercaleStudio studio = percale_studio_create(scene, camera.right, camera.forward);
    render_rows(&studio, &camera, pixels);
    percale_ray_scene_free(scene);
    return true;
}

static bool save(const char *path, const PercalePixels *pixels, const char *legend, PercaleSceneError *error)
{
    PercaleOutputFile file;
    if (!percale_output_open(&file, path, error))
        return false;
    if (percale_png_write(file.stream, pixels, legend))
        return percale_output_commit(&file, error);
    percale_output_discard(&file);
    (void)snprintf(error->text, sizeof error->text, "%s: could not write the PNG", path);
    return false;
}

bool percale_picture_write(const char *path, const PercalePictureMesh *meshes, uint32_t mesh_count,
                           PercalePictureDef def, PercaleSceneError *error)
{
    if (def.width < 1 || def.height < 1 || def.width > PICTURE_SIDE_MAX || def.height > PICTURE_SIDE_MAX) {
        (void)snprintf(error->text, sizeof error->text, "picture: %u x %u pixels is not within 1..%d",
                       (unsigned)def.width, (unsigned)def.height, PICTURE_SIDE_MAX);
        return false;
    }
    PercalePixels pixels = {.width = def.width, .height = def.height};
    pixels.rgb = malloc(3 * (size_t)def.width * def.height);
    if (!pixels.rgb) {
        (void)snprintf(error->text, sizeof error->text, "picture: out of memory");
        return false;
    }
    bool written = render(meshes, mesh_count, &pixels, error) && save(path, &pixels, def.legend, error);
    free(pixels.rgb);
    return written;
}
