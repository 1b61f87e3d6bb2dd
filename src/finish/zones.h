// zones.h: points of the cloth that no projection has brought past each other go together.
//
//   in   stencils that are violated still, start positions, predicted positions of what is led
//   out  zones, and where each goes
//
// A zone keeps its shape for a substep, so nothing in it passes anything (impact zones: Provot 1997; Harmon
// et al. 2008). It stands still, unless pins or obstacles push it: then it goes with them, since what is led
// can't be held back. Where both do, it goes with the pins.

#ifndef PERCALE_ZONES_H
#define PERCALE_ZONES_H

#include "base/arena.h"
#include "detect/stencil.h"
#include "model/model.h"

typedef struct PercaleZones {
    uint32_t *parent; // [slot_count] towards the zone's first slot; NO_ZONE: in none
    f32x4 *pins; // [slot_count] of first slots: sum of the motions of pinned points met, m; [3]: how many
    f32x4 *obstacles; // likewise
} PercaleZones;

static const uint32_t NO_ZONE = UINT32_MAX;

/// False without memory.
bool percale_zones_create(PercaleZones *zones, const PercaleModel *model, PercaleArena *arena);

/// The points of the stencil that can move are of one zone from now on.
void percale_zones_add(PercaleZones *zones, const PercaleModel *model, const PercaleStencil *stencil);

/// How far the slot's zone goes in the substep, m. It must be in one.
f32x4 percale_zones_motion(PercaleZones *zones, uint32_t slot);

#endif
