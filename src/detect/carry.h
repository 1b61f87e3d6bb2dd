// carry.h: what stencils hand on to those that are found anew: the anchors of friction.
//
//   in   stencils of the last collision pass and of this one, each ascending by source
//   out  in those of this pass: the slip that friction still owes, and within a substep the multipliers
//
// A stencil is found again by its four points. When the closest point has moved to a neighbouring feature,
// what the same vertex or edge owed along nearly the same surface is taken over (MATH.md, section 6, rule
// 13).

#ifndef PERCALE_CARRY_H
#define PERCALE_CARRY_H

#include "base/team.h"
#include "detect/collect.h"

typedef struct PercaleCarryStage {
    const PercaleStencilList *known; // of the last pass
    PercaleStencilList *found;       // of this one
    bool same_substep;               // multipliers go on
    PercaleTeam *team;
} PercaleCarryStage;

void percale_carry_run(PercaleCarryStage *stage);

#endif
