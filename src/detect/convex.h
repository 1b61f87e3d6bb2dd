// convex.h: triangles of an obstacle that stands still above which nothing else of it can be near.
//
//   in   an obstacle that stands still, its tree
//   out  its triangles around which it is convex; of a vertex above such a one that this is all it is near to
//
// Where a closed or open surface is convex or plane, the space in front of it is parted into that above its
// faces, its edges and its vertices; a vertex above a face is nearest to this face, and no other feature of
// the surface sees it in front of itself. So one triangle is asked instead of all that are near. What a
// vertex gets are the same bits.

#ifndef PERCALE_CONVEX_H
#define PERCALE_CONVEX_H

#include "detect/surface.h"

/// A triangle's plane and the inner sides of its sides, as seen from its first corner; in float32, for the
/// margin is greater than what that rounds away.
typedef struct PercaleConvexFace {
    f32x4 normal; // unit; [3] by how much a point has to be inside of the sides, m: below zero, the triangle
                  // is not known to be the only one
    f32x4 sides[3]; // unit; [3] m, of the side along it
} PercaleConvexFace;

typedef struct PercaleConvex {
    PercaleConvexFace *faces; // [triangle_count] NULL: nothing is known
    Vec3 *normals;            // [triangle_count] percale_surface_face_normal
    double radius;            // m, within which it is convex around each of its faces
} PercaleConvex;

/// False without memory; to be freed even then.
bool percale_convex_find(PercaleConvex *convex, const PercaleSurface *surface, double radius,
                         PercaleMemory *memory);
void percale_convex_free(PercaleConvex *convex, PercaleMemory *memory);

/// Brings what will be asked of a triangle near the processor: vertices that lie together don't lie together
/// here.
static inline void percale_convex_prefetch(const PercaleConvex *convex, const PercaleModelSurface *mesh,
                                           uint32_t triangle)
{
    if (convex->faces != NULL && triangle != NO_TRIANGLE) {
        __builtin_prefetch(&convex->faces[triangle]);
        __builtin_prefetch(&convex->normals[triangle]);
        __builtin_prefetch(&mesh->triangles[3 * (size_t)triangle]);
    }
}

/// The triangle that alone has a feature within `reach` of the point, and is the nearest, if there is one to
/// be found from `seed` on. NO_TRIANGLE: it isn't known.
uint32_t percale_convex_face(const PercaleConvex *convex, const PercaleSurface *surface, Vec3 point,
                             double reach, uint32_t seed);

/// The nearest triangle, as percale_surface_nearest finds it, where there is one next to the `seed` (or none,
/// NO_TRIANGLE) above which nothing else is near. False: it has to be searched for.
bool percale_convex_nearest(const PercaleConvex *convex, const PercaleSurface *surface, Vec3 point,
                            double radius, uint32_t seed, PercaleNearest *nearest);

#endif
