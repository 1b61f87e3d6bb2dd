// garment_shape.h: the surface that a garment is cut from, the same at every resolution.
//
//   in   a cut, the distances to keep
//   out  points of a trunk tube with two armholes and of two sleeves, by grid coordinates

#ifndef PERCALE_GARMENT_SHAPE_H
#define PERCALE_GARMENT_SHAPE_H

#include "garment_surface.h"

typedef struct PercaleGarmentShape PercaleGarmentShape;

PercaleGarmentShape *
percale_garment_shape_make(const PercaleGarmentSurface *surface); ///< NULL without memory
void percale_garment_shape_free(PercaleGarmentShape *shape);      ///< NULL is allowed

/// A grid point of the trunk, or of a sleeve (side: 0 left, 1 right), of a grid of any fineness, m.
void percale_garment_trunk_point(const PercaleGarmentShape *shape, PercaleGarmentGrid grid, uint32_t row,
                                 uint32_t column, double point[3]);
void percale_garment_sleeve_point(const PercaleGarmentShape *shape, PercaleGarmentGrid grid, int side,
                                  uint32_t row, uint32_t step, double point[3]);

#endif
