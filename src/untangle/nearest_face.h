// nearest_face.h: the nearest of some of the faces.
//
//   in   a tree over triangles, which of them count, a point
//   out  the nearest one and where

#ifndef PERCALE_NEAREST_FACE_H
#define PERCALE_NEAREST_FACE_H

#include "detect/distance.h"
#include "untangle/crossings.h"

/// Which faces count: those of an object, or those whose corners all have the label.
typedef struct PercaleFaceChoice {
    const uint32_t *labels; // [point_count]; NULL: any
    uint32_t label;
    uint32_t object; // NO_INDEX: any
} PercaleFaceChoice;

typedef struct PercaleNearestFace {
    uint32_t face; // NO_INDEX: none
    PercaleClosest closest;
    Vec3 foot;
} PercaleNearestFace;

/// first_face: of the tree's triangles among all. Ties go to the smaller face.
PercaleNearestFace percale_nearest_face(const PercaleCrossingSearch *search, bool obstacles, const f32x4 *x,
                                        Vec3 point, const PercaleFaceChoice *choice);

#endif
