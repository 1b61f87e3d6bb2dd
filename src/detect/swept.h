// swept.h: what a vertex meets on its way through the substep when the obstacle moves, too.
//
//   in   start and end of the vertex and of the obstacle's points, boxes over both
//   out  the first triangle that it may have touched from the front
//
// All four points of a vertex and a triangle go straight from the start to the end, as the engine moves them;
// when they may touch is asked of impact_time.h. So nothing is missed, however the obstacle turns or deforms:
// on the ways of a closed surface's points the winding number of a vertex can't change without a touch.

#ifndef PERCALE_SWEPT_H
#define PERCALE_SWEPT_H

#include "detect/proximity.h"

/// Boxes over start and end of the running substep. Only with ccd=exact.
static inline const PercaleTree *swept_tree(const PercaleProximity *proximity)
{
    return proximity->motion > 0.0f ? &proximity->swept : &proximity->tree;
}

// Share by which a motion may be greater than float32 says, and a clearance smaller; generously.
static const float MOTION_ROUNDING = 1e-5f;

/// Whether the vertex may have come as far as the surface, by its clearance at the start.
static inline bool may_meet(const PercalePair *pair, const PercaleProximity *proximity, uint32_t slot)
{
    const PercaleModel *model = pair->model;
    float motion = length3(model->predicted[slot] - model->position[slot]) + proximity->motion;
    return !(proximity->clearance[slot] > motion * (1.0f + MOTION_ROUNDING));
}

/// The first touch from the front on the slot's way from its position to where it is predicted. Its weights
/// are those of the point of the triangle that was touched; ties go to the smaller triangle.
PercaleCrossing percale_swept_crossing(const PercalePair *pair, const PercaleProximity *proximity,
                                       uint32_t slot);

#endif
