// obj_file.h: Wavefront OBJ files as they are: positions in double, texture coordinates beside them.
//
//   in   a path
//   out  vertices in the file's order, polygons as fans
//
// Understood are v, vt and f (v, v/vt, v/vt/vn, v//vn, negative indices); every other statement is skipped.
// percale.h's own functions for OBJ files (scene.h) stand on this one.

#ifndef PERCALE_OBJ_FILE_H
#define PERCALE_OBJ_FILE_H

#include "percale/scene.h"

typedef struct PercaleObj {
    char *name;
    double *positions; ///< [3 * vertex_count] as written in the file
    float *uvs;        ///< [2 * vertex_count]; NULL: no corner has texture coordinates
    uint32_t vertex_count;
    uint32_t *triangles; ///< [3 * triangle_count]
    uint32_t triangle_count;
    uint32_t uv_split_vertex;   ///< the first with two different texture coordinates; vertex_count: none
    uint32_t uv_missing_vertex; ///< the first without texture coordinates; vertex_count: none
} PercaleObj;

/// `surface`: faces must be there; else a file of points will do.
bool percale_obj_load(const char *path, bool surface, PercaleObj *obj, PercaleSceneError *error);
void percale_obj_free(PercaleObj *obj); ///< leaves it zeroed; a zeroed one is allowed

#endif
