// look_ahead.h: where the points will be, for those who look for pairs.
//
//   in   positions, velocities, predicted positions
//   out  positions, one for each point

#ifndef PERCALE_LOOK_AHEAD_H
#define PERCALE_LOOK_AHEAD_H

#include "base/team.h"
#include "model/model.h"

/// Where the velocities alone take the cloth in a substep of dt seconds, without gravity and wind: what lies
/// on something stays on it, where the predicted positions have fallen g dt^2 into it (2.7 mm in 1/60 s).
/// What can't move and obstacles are where they are predicted.
void percale_look_coasting(const PercaleModel *model, float dt, f32x4 *coasting, PercaleTeam *team);

/// Where the points would be, did they go on as from `position` to `seen`, this many substeps later.
void percale_look_ahead(const PercaleModel *model, const f32x4 *seen, float substeps, f32x4 *ahead,
                        PercaleTeam *team);

#endif
