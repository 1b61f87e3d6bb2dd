// obstacle_motion.h: where obstacles are at the end of a substep.
//
//   in   poses or positions at both ends of the step
//   out  predicted positions of the obstacle's points
//
// Deforming obstacles go in straight lines, or along cubics with given velocities at both ends (Hermite);
// rigid ones turn at a constant rate.

#ifndef PERCALE_OBSTACLE_MOTION_H
#define PERCALE_OBSTACLE_MOTION_H

#include "base/team.h"
#include "model/model.h"

/// Rigid pose between two others; exact at fractions 0 and 1.
PercalePose percale_motion_between(const PercalePose *from, const PercalePose *to, double fraction);

/// Writes model->predicted for the obstacle's points at `fraction` of the step (the end of the substep) and
/// returns how far the farthest of them moves from model->position, m. `seconds`: of the step.
float percale_motion_apply(PercaleModel *model, uint32_t obstacle, const PercaleObstacleObject *object,
                           double fraction, double seconds, PercaleTeam *team);

#endif
