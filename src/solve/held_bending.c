#include "solve/held_bending.h"

#include "base/parallel.h"

/// What the chunks share.
typedef struct Held {
    const PercaleHeldBending *held;
    f32x4 *ahead; // where the points will be, then bent
} Held;

static f32x4 look_ahead(const PercaleHeldBending *held, uint32_t slot)
{
    f32x4 x = held->plan.arrays.x[slot];
    f32x4 start = held->plan.arrays.start[slot];
    return with_w(start + (x - start) * (float)held->interval, x[3]);
}

static void look_ahead_range(void *context, uint32_t first, uint32_t end)
{
    const Held *all = context;
    for (uint32_t slot = first; slot < end; slot++) {
        all->ahead[slot] = look_ahead(all->held, slot);
    }
}

/// The weights are those of an impulse of all the substeps: each has its share of it.
static void push_range(void *context, uint32_t first, uint32_t end)
{
    const Held *all = context;
    const PercaleHeldBending *held = all->held;
    const PercaleSolveArrays *arrays = &held->plan.arrays;
    for (uint32_t slot = first; slot < end; slot++) {
        f32x4 bent = with_w(all->ahead[slot] - look_ahead(held, slot), 0.0f) / (float)held->interval;
        held->pushes[slot] = bent / arrays->dt;
        arrays->x[slot] += bent;
        arrays->velocity[slot] += held->pushes[slot];
    }
}

bool percale_held_bending_run(const PercaleHeldBending *held, PercaleTeam *team, PercaleArena *arena)
{
    uint32_t count = held->plan.arrays.model->slot_count;
    Held all = {held, percale_arena_new(arena, count, sizeof(f32x4))};
    if (all.ahead == NULL) {
        return false;
    }
    PercaleSweepPlan plan = held->plan;
    plan.arrays.x = all.ahead;
    percale_team_for(team, count, GRAIN, look_ahead_range, &all);
    if (!percale_sweep_hinges(&plan, team, arena)) {
        return false;
    }
    percale_team_for(team, count, GRAIN, push_range, &all);
    return true;
}
