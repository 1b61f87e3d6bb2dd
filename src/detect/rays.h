// rays.h: vertex paths cast with Embree against the obstacles; the only engine file that includes Embree.
//
//   in   obstacle triangles, positions of the substep's end pose, paths in that pose's frame
//   out  one flag per path: it may pass through the surface
//
// A flag is only a hint: which triangle, where and from which side is decided by surface.h in double, so that
// results don't depend on Embree's tree. Static and rigid obstacles are built once, in their own space;
// deforming ones are refit before each substep's rays.

#ifndef PERCALE_RAYS_H
#define PERCALE_RAYS_H

#include "base/message.h"
#include "base/simd.h"
#include "base/team.h"
#include "model/object.h"

typedef struct PercaleRays PercaleRays;

/// Creates the device and one scene per obstacle. The objects' triangles are shared: they stay where they are
/// until percale_rays_destroy.
PercaleResult percale_rays_create(PercaleRays **rays, const PercaleObjects *objects, PercaleMemory *memory,
                                  PercaleMessage *message);
void percale_rays_destroy(PercaleRays *rays, PercaleMemory *memory); ///< NULL is allowed

/// Takes over the points of a deforming obstacle ([vertex_count]); the others need no update. False when
/// Embree reports an error.
bool percale_rays_refit(PercaleRays *rays, uint32_t obstacle, const f32x4 *points);

/// from, to: [count] path ends in the obstacle's scene space (own space for rigid ones); paths with a
/// non-finite end are not cast. flags: [count] 1 where Embree finds the surface on the path.
void percale_rays_cast(const PercaleRays *rays, uint32_t obstacle, const f32x4 *from, const f32x4 *to,
                       uint32_t count, uint8_t *flags, PercaleTeam *team);

#endif
