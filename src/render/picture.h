// picture.h: renders one frame with Embree into a PNG: shaded, shadowed, on a floor.
//
//   in   meshes (the caller's arrays), per-vertex colours by stretch or penetration on request
//   out  a PNG file, written under a temporary name and renamed
//
// A small library of its own on the public headers; the engine does not know it.

#ifndef PERCALE_PICTURE_H
#define PERCALE_PICTURE_H

#include "percale/scene.h"

typedef struct PercalePictureMesh {
    const float *positions; ///< [3 * vertex_count] m
    uint32_t vertex_count;
    const uint32_t *triangles; ///< [3 * triangle_count]
    uint32_t triangle_count;
    const float *heat; ///< [vertex_count] in 0..1, drawn as a colour scale; NULL: the object's own colour
    bool cloth;        ///< cloth is drawn two-sided in a garment colour, obstacles in a skin-like clay
    uint32_t index;    ///< picks among a few colours
} PercalePictureMesh;

typedef struct PercalePictureDef {
    uint32_t width, height; ///< pixels
    const char *legend;     ///< what the heat means, for the PNG's text chunk; NULL: none
} PercalePictureDef;

/// Frames all meshes (camera in front, +z, slightly above and aside) and writes `path`.
bool percale_picture_write(const char *path, const PercalePictureMesh *meshes, uint32_t mesh_count,
                           PercalePictureDef def, PercaleSceneError *error);

#endif
