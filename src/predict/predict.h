// predict.h: moves every cloth vertex to where it would go if nothing were in its way.
//
//   in   position, velocity; triangles for the wind
//   out  next velocity, predicted; where asked for, the points some substeps on
//
//     v = clamp((v + dt (g + wind) + push) * exp(-damping dt)),   x* = x + dt v   (symplectic Euler)

#ifndef PERCALE_PREDICT_H
#define PERCALE_PREDICT_H

#include "base/team.h"
#include "model/model.h"

typedef struct PercalePredictStage {
    PercaleModel *model;
    f32x4 gravity;       // m/s^2
    f32x4 wind;          // m/s, velocity of the air
    float damping;       // share of the velocity that is left after a substep
    float speed_max;     // m/s
    float dt;            // s
    const f32x4 *pushes; // [slot_count] m/s, velocity that a force gives in the substep; NULL: none
    f32x4 *ahead; // [slot_count] where the vertices will be, did they go on like that; NULL: not asked for
    float ahead_count; // substeps until then
} PercalePredictStage;

/// Returns the slot of the first vertex that would become NaN or infinite, UINT32_MAX for none.
uint32_t percale_predict_cloth(const PercalePredictStage *stage, PercaleTeam *team);

/// Puts pinned vertices on the line from where the step began to their targets. fraction: of the step, at the
/// end of this substep; from, to: [pinned_count] points.
void percale_predict_pins(const PercalePredictStage *stage, const f32x4 *from, const f32x4 *to,
                          float fraction);

#endif
