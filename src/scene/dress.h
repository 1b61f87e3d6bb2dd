// dress.h: a knee-length dress with short sleeves, sewn from four panels.
//
//   in   how many vertices it should have, how far it is to stay from the skin
//   out  one mesh of four separate panels (front, back, left sleeve, right sleeve) around the mannequin's
//   rest
//        pose, and the pairs of vertices to sew together: side seams, shoulders, armholes, underarms
//
// Sewn vertices coincide bit for bit. The start is tight on shoulders, chest and waist and falls in folds
// from the hips; it is meant as the rest shape too. The shape is the same at every size from 5,000 vertices
// on, fewer stay a little farther from the skin.

#ifndef PERCALE_DRESS_H
#define PERCALE_DRESS_H

#include "percale/scene.h"

/// size: about how many vertices, 1,000 to 4,000,000 (off by less than 5 %). thickness: m, 0.0005 to 0.01;
/// the distance that the solver keeps. Everything handed out is malloc'ed: mesh for percale_mesh_free, *seams
/// ([*seam_count] pairs of vertices of this mesh, no pair twice, no pair that the others imply) for free.
bool percale_dress_make(uint64_t size, float thickness, PercaleMesh *mesh, uint32_t (**seams)[2],
                        uint32_t *seam_count, PercaleSceneError *error);

#endif
