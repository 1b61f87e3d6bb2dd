// tangle_stage.h: what the makers of stencils share: a tangle at one moment, and the list that they fill.
//
//   in   contours of the positions x
//   out  stencils: which point or edge has to move how far against which face
//
// The side of these stencils is GLOBAL: it comes from the contour, not from history.

#ifndef PERCALE_TANGLE_STAGE_H
#define PERCALE_TANGLE_STAGE_H

#include "detect/collect.h"
#include "detect/release.h"
#include "untangle/nearest_face.h"
#include "untangle/regions.h"

typedef struct PercaleTangleStage {
    const PercaleTangleMesh *mesh;
    const PercaleCrossingSearch *search;
    const PercaleTangleCrossings *crossings;
    const PercaleContours *contours;
    const f32x4 *x;
    PercaleRegionFlood *flood;
    const float *edge_lengths; // [edge_count] m, when the untangling began
    uint32_t *labels;          // [point_count] scratch of the patches
    uint32_t epoch;            // of the labels
    uint32_t *queue;           // [point_count] scratch
    uint8_t *is_inside; // [point_count] points behind the surface of a closed obstacle, found anew each time
    PercaleStencilList *stencils;
    PercaleReleases releases; // filled in with the stencils
    bool frees_crossings;     // also where a contour is only made shorter
    PercaleMemory *memory;
} PercaleTangleStage;

/// A point that has to get to h, or farther, from a face along n, seen from the face's point with these
/// weights. False without memory.
bool percale_add_tangle_stencil(PercaleTangleStage *stage, uint32_t point, uint32_t face,
                                const double weights[3], Vec3 normal, double distance);

/// Distance to keep between two objects, m.
static inline double distance_between(const PercaleTangleMesh *mesh, uint32_t face_a, uint32_t face_b)
{
    double sum = (double)object_of_triangle(mesh, face_a)->thickness +
                 (double)object_of_triangle(mesh, face_b)->thickness;
    return 0.5 * sum;
}

/// Normal of a face, as all of its piece of cloth are turned; unit.
static inline Vec3 turned_normal(const PercaleTangleMesh *mesh, const f32x4 *x, uint32_t face)
{
    const uint32_t *corners = corners_of_triangle(mesh, face);
    Vec3 a = vec3_of(x[corners[0]]);
    Vec3 normal = vcross(vsub(vec3_of(x[corners[1]]), a), vsub(vec3_of(x[corners[2]]), a));
    return vscale((double)mesh->turns[face], vunit(normal));
}

#endif
