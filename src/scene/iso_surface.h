// iso_surface.h: a closed triangle mesh of a field's zero level, with well-shaped triangles.
//
//   in   a signed distance field, a box that holds its zero level, the size of a lattice cell
//   out  triangles astride the zero level, counter-clockwise seen from where the field is positive
//
// Surface nets (Gibson 1998): one vertex per cell that the surface crosses, one quad per lattice edge that it
// crosses; then the vertices slide along the surface and edges flip, to even out the triangles.

#ifndef PERCALE_ISO_SURFACE_H
#define PERCALE_ISO_SURFACE_H

#include "percale/scene.h"

/// Distance at a point and its gradient; the length of the gradient is close to 1.
typedef double PercaleField(const double point[3], double gradient[3]);

/// Moves a point along the gradient to within `tolerance` (m) of the zero level; false if it does not get
/// there.
bool percale_field_project(PercaleField *field, double tolerance, double point[3]);

/// Fills mesh's positions and triangles (name and uvs are left NULL). False without memory, or where parts of
/// the surface are closer to each other than a cell.
bool percale_iso_surface(PercaleField *field, const double lower[3], const double upper[3], double cell,
                         PercaleMesh *mesh);

#endif
