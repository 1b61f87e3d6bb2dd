#include "cli/run_output.h"

#include "cli/destination.h"

#include <stdlib.h>
#include <string.h>

enum { FRAME_SUFFIX = 32 }; // bytes for "_%04u.obj" of any frame

static const float SAMPLE_RATE = 1.0f; // PC2: frames from one sample to the next

static bool out_of_memory(PercaleSceneError *error)
{
    (void)snprintf(error->text, sizeof error->text, "out of memory");
    return false;
}

bool percale_run_output_check(const PercaleScene *scene, PercaleSceneError *error)
{
    uint32_t count = percale_scene_cloth_count(scene);
    for (uint32_t index = 0; index < count; ++index) {
        const char *name = percale_scene_cloth(scene, index).name;
        if (*name == '\0' || *name == '.' || strchr(name, '/')) {
            (void)snprintf(error->text, sizeof error->text, "--out: cloth name '%s' can't name a file", name);
            return false;
        }
        for (uint32_t other = 0; other < index; ++other) {
            if (strcmp(name, percale_scene_cloth(scene, other).name) != 0)
                continue;
            (void)snprintf(error->text, sizeof error->text, "--out: two cloths are named '%s'", name);
            return false;
        }
    }
    return true;
}

/// folder/name + suffix in new memory.
static char *file_path(const PercaleRunOutput *output, const char *name, const char *suffix)
{
    size_t size = strlen(name) + strlen(suffix) + 1;
    char *file = malloc(size);
    if (!file)
        return NULL;
    (void)snprintf(file, size, "%s%s", name, suffix);
    char *path = percale_destination_join(output->folder, file);
    free(file);
    return path;
}

static bool open_writer(PercaleRunOutput *output, uint32_t index, uint32_t sample_count,
                        PercaleSceneError *error)
{
    PercaleSceneObject cloth = percale_scene_cloth(output->scene, index);
    char *path = file_path(output, cloth.name, ".pc2");
    if (!path)
        return out_of_memory(error);
    output->writers[index] = percale_pc2_open(path, cloth.vertex_count, sample_count, SAMPLE_RATE, error);
    free(path);
    return output->writers[index] != NULL;
}

static void release(PercaleRunOutput *output)
{
    PercaleSceneError ignored;
    for (uint32_t index = 0; output->writers && index < output->cloth_count; ++index)
        if (output->writers[index])
            (void)percale_pc2_close(output->writers[index],
                                    &ignored); // incomplete: removes the temporary file
    free(output->writers);
    free(output->positions);
    *output = (PercaleRunOutput){0};
}

bool percale_run_output_open(PercaleRunOutput *output, const PercaleScene *scene, const char *folder,
                             bool as_obj, uint32_t sample_count, PercaleSceneError *error)
{
    *output = (PercaleRunOutput){.scene = scene, .folder = folder, .as_obj = as_obj};
    output->cloth_count = percale_scene_cloth_count(scene);
    percale_scene_origin(scene, output->origin);
    size_t largest = 0;
    for (uint32_t index = 0; index < output->cloth_count; ++index) {
        uint32_t vertex_count = percale_scene_cloth(scene, index).vertex_count;
        largest = vertex_count > largest ? vertex_count : largest;
    }
    output->positions = malloc((3 * largest + 1) * sizeof *output->positions);
    output->writers = calloc((size_t)output->cloth_count + 1, sizeof(PercalePc2Writer *));
    bool opened = output->positions && output->writers;
    if (!opened)
        (void)out_of_memory(error);
    opened = opened && percale_destination_make(folder, error);
    for (uint32_t index = 0; opened && !as_obj && index < output->cloth_count; ++index)
        opened = open_writer(output, index, sample_count, error);
    if (!opened)
        release(output);
    return opened;
}

static bool write_mesh(const PercaleRunOutput *output, const PercaleSceneObject *cloth,
                       const float *positions, const char *suffix, PercaleSceneError *error)
{
    char *path = file_path(output, cloth->name, suffix);
    if (!path)
        return out_of_memory(error);
    bool written = percale_obj_write(path, positions, cloth->vertex_count, cloth->triangles,
                                     cloth->triangle_count, output->origin, error);
    free(path);
    return written;
}

static void add_origin(const PercaleRunOutput *output, uint32_t vertex_count)
{
    for (size_t k = 0; k < 3 * (size_t)vertex_count; ++k)
        output->positions[k] = (float)((double)output->positions[k] + output->origin[k % 3]);
}

bool percale_run_output_add(PercaleRunOutput *output, PercaleSolver *solver, uint32_t frame,
                            PercaleSceneError *error)
{
    bool added = true;
    for (uint32_t index = 0; added && index < output->cloth_count; ++index) {
        PercaleSceneObject cloth = percale_scene_cloth(output->scene, index);
        if (percale_cloth_get_positions(solver, cloth.cloth, output->positions, 0) != PERCALE_OK) {
            (void)snprintf(error->text, sizeof error->text, "%s", percale_solver_last_error(solver));
            return false;
        }
        if (output->as_obj) {
            char suffix[FRAME_SUFFIX];
            (void)snprintf(suffix, sizeof suffix, "_%04u.obj", (unsigned)frame);
            added = write_mesh(output, &cloth, output->positions, suffix, error);
        } else {
            add_origin(output, cloth.vertex_count);
            added = percale_pc2_append(output->writers[index], output->positions, error);
        }
    }
    return added;
}

bool percale_run_output_close(PercaleRunOutput *output, bool complete, PercaleSceneError *error)
{
    bool written = complete;
    for (uint32_t index = 0; written && !output->as_obj && index < output->cloth_count; ++index) {
        PercaleSceneObject cloth = percale_scene_cloth(output->scene, index);
        PercalePc2Writer *writer = output->writers[index];
        output->writers[index] = NULL;
        written =
            percale_pc2_close(writer, error) && write_mesh(output, &cloth, cloth.positions, ".obj", error);
    }
    release(output);
    return written || !complete;
}
