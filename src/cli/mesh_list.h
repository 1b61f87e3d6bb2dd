// mesh_list.h: the meshes of an option's OBJ files.

#ifndef PERCALE_MESH_LIST_H
#define PERCALE_MESH_LIST_H

#include "cli/options.h"

typedef struct PercaleMeshList {
    const char **paths; // [count]
    PercaleMesh *meshes;
    size_t count;
} PercaleMeshList;

/// `option` NULL: the words. Free it also after a failure; a zeroed list is allowed.
bool percale_mesh_list_read(const PercaleOptions *options, const char *option, PercaleMeshList *list,
                            PercaleSceneError *error);
void percale_mesh_list_free(PercaleMeshList *list);

uint64_t percale_mesh_list_triangles(const PercaleMeshList *list);
uint64_t percale_mesh_list_vertices(const PercaleMeshList *list);

#endif
