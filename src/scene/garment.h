// garment.h: a garment with sleeves, sewn from four panels.
//
//   in   the cut, how many vertices it should have, how far out it is to lie
//   out  one mesh of four separate panels (front, back, left sleeve, right sleeve) around the mannequin's
//   rest pose, and the pairs of vertices to sew together: side seams, shoulders, armholes, underarms
//
// Sewn vertices coincide bit for bit. The start is tight on shoulders, chest and waist and falls in folds
// from the hips; it is meant as the rest shape too. The shape is the same at every size from 5,000 vertices
// on, fewer stay a little farther from the skin.

#ifndef PERCALE_GARMENT_H
#define PERCALE_GARMENT_H

#include "garment_cut.h"
#include "percale/scene.h"

/// size: about how many vertices, the cut's smallest to 4,000,000 (off by less than 5 %). thickness: m,
/// 0.0005 to 0.01; the distance that the solver keeps. outwards: m by which the garment lies farther out than
/// one that fits tightly. Everything handed out is malloc'ed: mesh for percale_mesh_free, *seams
/// ([*seam_count] pairs of vertices of this mesh, no pair twice, no pair that the others imply) for free.
bool percale_garment_make(const PercaleGarmentCut *cut, uint64_t size, float thickness, double outwards,
                          PercaleMesh *mesh, uint32_t (**seams)[2], uint32_t *seam_count,
                          PercaleSceneError *error);

/// m by which a garment of this size cuts the corners of the body deeper than a fine one does.
double percale_garment_sag(const PercaleGarmentCut *cut, uint64_t size);

/// Vertices of the grid that the shape is made on: garments with sizes in this proportion are equally fine.
uint64_t percale_garment_vertices(const PercaleGarmentCut *cut);

#endif
