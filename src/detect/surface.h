// surface.h: what a point sees of an obstacle's oriented surface: the nearest feature, its side, all features
// near.
//
//   in   the obstacle's mesh and tree, positions of one pose, a point
//   out  nearest triangle and region, signed side, feature list, first crossing of a path
//
// The side of a point is the sign of its offset along the nearest feature's normal; edges and vertices take
// the angle-weighted pseudonormal (Baerentzen and Aanaes 2005), with which the sign is right for closed
// meshes.

#ifndef PERCALE_SURFACE_H
#define PERCALE_SURFACE_H

#include "detect/distance.h"
#include "detect/tree.h"
#include "model/model.h"

static const uint32_t NO_TRIANGLE = UINT32_MAX;

/// One obstacle at one pose.
typedef struct PercaleSurface {
    const PercaleModelSurface *mesh;
    const PercaleTree *tree; // boxes of this pose
    const f32x4 *points;     // all points of the solver, at this pose
    const Vec3 *normals;     // [triangle_count] of the faces, unit, at this pose; NULL: not kept
} PercaleSurface;

typedef struct PercaleNearest {
    uint32_t triangle;      // NO_TRIANGLE: nothing within the radius; then
    PercaleClosest closest; // its distance is a bound, often far beyond the radius: nothing is nearer
    Vec3 foot;              // the closest point
} PercaleNearest;

/// The contact features that a triangle and a region name: a face, an edge or a vertex, each numbered on its
/// own.
typedef struct PercaleFeature {
    uint32_t triangle;
    PercaleClosest closest;
} PercaleFeature;

/// A growing list of features.
typedef struct PercaleFeatureList {
    PercaleFeature *items;
    size_t count, capacity;
} PercaleFeatureList;

/// Nearest point of the surface within `radius`; ties go to the smaller triangle. `seed` is a triangle to try
/// first (NO_TRIANGLE: none): it only makes the search shorter.
PercaleNearest percale_surface_nearest(const PercaleSurface *surface, Vec3 point, double radius,
                                       uint32_t seed);

/// All triangles within `radius`, in a fixed order, appended to the emptied list. False without memory.
bool percale_surface_gather(const PercaleSurface *surface, Vec3 point, double radius, PercaleMemory *memory,
                            PercaleFeatureList *list);

/// The same among these triangles alone.
PercaleNearest percale_surface_nearest_of(const PercaleSurface *surface, Vec3 point, double radius,
                                          const uint32_t *triangles, uint32_t count);
bool percale_surface_gather_of(const PercaleSurface *surface, Vec3 point, double radius,
                               const uint32_t *triangles, uint32_t count, PercaleMemory *memory,
                               PercaleFeatureList *list);

/// Unit normal of a triangle; zero when it has no area.
Vec3 percale_surface_face_normal(const PercaleSurface *surface, uint32_t triangle);

/// Unit (pseudo)normal of the feature that `region` names on `triangle`.
Vec3 percale_surface_normal(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region);

/// +1 when the point is on the outer side of its nearest feature or on it, else -1.
int percale_surface_side(const PercaleSurface *surface, Vec3 point, const PercaleNearest *nearest);

/// True when the feature lies on the rim of an open surface.
bool percale_surface_on_rim(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region);

/// Number of triangles around the feature.
uint32_t percale_surface_face_count(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region);

/// A number for the feature: kind in the top bits, then face, edge or vertex index.
uint64_t percale_surface_feature_key(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region);

/// Orders the list by feature, then by triangle.
void percale_surface_sort(const PercaleSurface *surface, PercaleFeatureList *list);

/// Earliest passage of the path from a to b through the surface from its front; exact up to rounding in
/// double, and without gaps between neighbouring triangles. Ties go to the smaller triangle.
typedef struct PercaleCrossing {
    uint32_t triangle; // NO_TRIANGLE: none
    double time;       // in [0, 1]
    double weights[3];
} PercaleCrossing;
static const PercaleCrossing NO_CROSSING = {UINT32_MAX, 1.0, {0.0, 0.0, 0.0}};
PercaleCrossing percale_surface_first_crossing(const PercaleSurface *surface, Vec3 a, Vec3 b);

/// The point with these barycentric coordinates.
Vec3 percale_surface_point(const PercaleSurface *surface, uint32_t triangle, const double weights[3]);

#endif
