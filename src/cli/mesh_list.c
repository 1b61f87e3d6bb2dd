#include "cli/mesh_list.h"

#include <stdlib.h>

bool percale_mesh_list_read(const PercaleOptions *options, const char *option, PercaleMeshList *list,
                            PercaleSceneError *error)
{
    list->count = percale_options_values(options, option, NULL);
    list->paths = calloc(list->count + 1, sizeof *list->paths);
    list->meshes = calloc(list->count + 1, sizeof *list->meshes);
    if (!list->paths || !list->meshes) {
        (void)snprintf(error->text, sizeof error->text, "out of memory");
        return false;
    }
    (void)percale_options_values(options, option, list->paths);
    for (size_t index = 0; index < list->count; ++index)
        if (!percale_obj_read(list->paths[index], NULL, &list->meshes[index], error))
            return false;
    return true;
}

void percale_mesh_list_free(PercaleMeshList *list)
{
    for (size_t index = 0; list->meshes && index < list->count; ++index)
        percale_mesh_free(&list->meshes[index]);
    free(list->paths);
    free(list->meshes);
    *list = (PercaleMeshList){0};
}

uint64_t percale_mesh_list_triangles(const PercaleMeshList *list)
{
    uint64_t sum = 0;
    for (size_t index = 0; index < list->count; ++index)
        sum += list->meshes[index].triangle_count;
    return sum;
}

uint64_t percale_mesh_list_vertices(const PercaleMeshList *list)
{
    uint64_t sum = 0;
    for (size_t index = 0; index < list->count; ++index)
        sum += list->meshes[index].vertex_count;
    return sum;
}
