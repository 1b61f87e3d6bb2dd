// advance.h: makes the committed state out of the solved one; the only writer of position and velocity.
//
//   in   position, predicted, v* (next_velocity)
//   out  next_velocity, then: position, velocity
//
//     v = v* + (predicted - (position + dt v*)) / dt
//
// which in exact arithmetic is (predicted - position) / dt. In float32 the difference of two positions has an
// error of ulp(x) / dt; this form has it only in what the constraints have changed: a free fall of 5 m in
// 1,200 substeps is off by 0.04 mm instead of 4.7 mm.

#ifndef PERCALE_ADVANCE_H
#define PERCALE_ADVANCE_H

#include "base/team.h"
#include "model/model.h"

#include <stdbool.h>

/// Computes next_velocity. Returns the slot of the first vertex whose predicted position or new velocity is
/// NaN or infinite, UINT32_MAX for none. The committed state is as before.
uint32_t percale_advance_velocities(PercaleModel *model, float dt, PercaleTeam *team);

/// The first vertex that is NaN or infinite now: for what has been corrected since.
uint32_t percale_advance_find_bad(PercaleModel *model, PercaleTeam *team);

/// The solved state becomes the committed one, at once: the arrays change places. Obstacles stand where they
/// are in both of them; only when one has moved is there anything to do for that.
void percale_advance_commit(PercaleModel *model, bool obstacles_moved);

#endif
