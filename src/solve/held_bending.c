#include "solve/held_bending.h"

#include "base/parallel.h"
#include "base/wide.h"

/// One or two points from `slot` on. The weights are those of an impulse of all the substeps: each has its
/// share of it.
static inline void push_points(const PercaleHeldBending *held, uint32_t slot, uint32_t count)
{
    const PercaleSolveArrays *arrays = &held->plan.arrays;
    f32x8 start = load_two(arrays->start + slot, count);
    f32x8 x = load_two(arrays->x + slot, count);
    f32x8 straight = start + (x - start) * (float)held->interval;
    f32x8 bent = without_w(load_two(held->pushes + slot, count) - straight) * (1.0f / (float)held->interval);
    f32x8 push = bent * (1.0f / arrays->dt);
    store_two(held->pushes + slot, push, count);
    store_two(arrays->x + slot, x + bent, count);
    store_two(arrays->velocity + slot, load_two(arrays->velocity + slot, count) + push, count);
}

static void push_range(void *context, uint32_t first, uint32_t end)
{
    const PercaleHeldBending *held = context;
    uint32_t slot = first;
    for (; slot + 2 <= end; slot += 2) {
        push_points(held, slot, 2);
    }
    if (slot < end) {
        push_points(held, slot, 1);
    }
}

bool percale_held_bending_run(const PercaleHeldBending *held, PercaleTeam *team, PercaleArena *arena)
{
    const PercaleModel *model = held->plan.arrays.model;
    PercaleSweepPlan plan = held->plan;
    plan.arrays.x = held->pushes;
    if (!percale_sweep_hinges(&plan, team, arena)) {
        return false;
    }
    PercaleHeldBending shared = *held;
    percale_team_for(team, model->slot_count, GRAIN, push_range, &shared);
    return true;
}
