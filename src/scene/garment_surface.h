// garment_surface.h: the surface that a garment lies on, as a field.
//
//   in   a cut, the distances to keep
//   out  points put onto the surface
//
// A bodice that follows trunk and upper arms closely, joined to a skirt that is a wide cone. The garments of
// two layers are levels of one field: the outer one is farther off by the difference of `outwards` at least.

#ifndef PERCALE_GARMENT_SURFACE_H
#define PERCALE_GARMENT_SURFACE_H

#include "garment_cut.h"

#define PERCALE_GARMENT_AXIS_Z  (-0.008) // m, of the trunk
#define PERCALE_GARMENT_EXACTLY 1e-7     // m off the surface at the end: a float's last digits

typedef struct PercaleGarmentSurface {
    const PercaleGarmentCut *cut;
    double clearance; ///< m between the skin and a garment that fits tightly, where it does
    double outwards;  ///< m from that garment to this one
} PercaleGarmentSurface;

/// Moves a point that is near onto the surface without its folds, to within `tolerance` m.
void percale_garment_settle(const PercaleGarmentSurface *surface, double tolerance, double point[3]);

/// The first point of a ray that starts inside which is on the surface.
void percale_garment_march_out(const PercaleGarmentSurface *surface, const double origin[3],
                               const double direction[3], double point[3]);

/// Moves a point of the plain skirt out onto its folds. `round`: 0..1 round the body.
void percale_garment_add_folds(const PercaleGarmentCut *cut, double round, double point[3]);

#endif
