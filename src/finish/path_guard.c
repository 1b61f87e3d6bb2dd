#include "finish/path_guard.h"

#include "base/parallel.h"
#include "base/wide.h"
#include "detect/swept.h"
#include "finish/guard.h"

#include <stdatomic.h>
#include <string.h>

/// How much of the way from where the obstacle would carry it to the point of its touch a vertex goes, by
/// attempt. Of a corner the first two find both walls.
static const double SHARES[] = {1.0, 1.0, 1.0, 0.5, 0.0};
enum { SHARE_COUNT = sizeof(SHARES) / sizeof(SHARES[0]) };

/// The earliest touch of all obstacles.
typedef struct Touch {
    uint32_t obstacle;
    PercaleCrossing crossing;
} Touch;

static PercalePair pair_with(const PercalePathGuardStage *stage, uint32_t obstacle)
{
    return (PercalePair){.model = stage->model, .obstacle = &stage->model->obstacles[obstacle]};
}

static Touch find_touch(const PercalePathGuardStage *stage, uint32_t slot)
{
    const PercaleModel *model = stage->model;
    Touch first = {0, NO_CROSSING};
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        PercalePair pair = pair_with(stage, o);
        const PercaleProximity *proximity = &stage->proximities[o];
        if ((model->cloths[model->cloth_of[slot]].mask & pair.obstacle->mask) == 0 ||
            (!stage->again && !may_meet(&pair, proximity, slot))) {
            continue;
        }
        PercaleCrossing crossing = percale_swept_crossing(&pair, proximity, slot);
        if (crossing.triangle != NO_TRIANGLE &&
            (first.crossing.triangle == NO_TRIANGLE || crossing.time < first.crossing.time)) {
            first = (Touch){o, crossing};
        }
    }
    return first;
}

/// What is known of its distances shrinks, where it isn't what they were at the start.
static void spend_clearances(const PercalePathGuardStage *stage, uint32_t slot, float way)
{
    for (uint32_t o = 0; o < stage->model->obstacle_count; o++) {
        PercaleProximity *proximity = &stage->proximities[o];
        proximity->clearance[slot] -= way;
        proximity->side[slot] = 0;
        proximity->nearest[slot] = NO_TRIANGLE;
    }
}

static void stop_before(const PercalePathGuardStage *stage, uint32_t slot, const Touch *touch, double share)
{
    PercaleModel *model = stage->model;
    PercalePair pair = pair_with(stage, touch->obstacle);
    PercaleSurface at_end = {pair.obstacle, NULL, model->predicted, NULL};
    const PercaleCrossing *crossing = &touch->crossing;
    Vec3 normal = percale_surface_face_normal(&at_end, crossing->triangle);
    Vec3 carried = percale_path_start(&pair, &stage->frames[touch->obstacle], slot, crossing->triangle);
    Vec3 before = vadd(percale_surface_point(&at_end, crossing->triangle, crossing->weights),
                       vscale(GAP * (double)pair_thickness(&pair, slot), normal));
    f32x4 was = model->predicted[slot];
    model->predicted[slot] = f32x4_of(vadd(carried, vscale(share, vsub(before, carried))), was[3]);
    percale_guard_stop_approach(&pair, slot, crossing, normal, stage->dt, model->next_velocity);
    if (stage->again) {
        spend_clearances(stage, slot, length3(with_w(model->predicted[slot] - was, 0.0f)));
    }
}

static void guard_way(const PercalePathGuardStage *stage, uint32_t slot, PercalePathGuardCounts *counts)
{
    Touch touch = find_touch(stage, slot);
    if (touch.crossing.triangle == NO_TRIANGLE) {
        return;
    }
    counts->truncated++;
    for (int i = 0; i < SHARE_COUNT; i++) {
        stop_before(stage, slot, &touch, SHARES[i]);
        touch = find_touch(stage, slot);
        if (touch.crossing.triangle == NO_TRIANGLE) {
            return;
        }
    }
    counts->left++;
}

static bool has_moved_since(const PercalePathGuardStage *stage, uint32_t slot)
{
    f32x4 by = with_w(stage->model->predicted[slot] - stage->proved[slot], 0.0f);
    return by[0] != 0.0f || by[1] != 0.0f || by[2] != 0.0f;
}

/// Whether none of eight slots may have come as far as any obstacle: the usual case.
static bool are_out_of_reach(const PercalePathGuardStage *stage, uint32_t slot)
{
    const PercaleModel *model = stage->model;
    f32x8 motion = distances8(model->predicted + slot, model->position + slot);
    uint32_t out = 0xff;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        f32x8 both = (motion + stage->proximities[o].motion) * (1.0f + MOTION_ROUNDING);
        out &= lane_bits(greater8(load8(stage->proximities[o].clearance + slot), both));
    }
    return out == 0xff;
}

static void guard_slots(const PercalePathGuardStage *stage, uint32_t first, uint32_t end,
                        PercalePathGuardCounts *counts)
{
    for (uint32_t slot = first; slot < end; slot++) {
        bool can_move = stage->model->predicted[slot][3] > 0.0f;
        if (can_move && (!stage->again || has_moved_since(stage, slot))) {
            guard_way(stage, slot, counts);
        }
    }
}

/// What the chunks share.
typedef struct Guard {
    const PercalePathGuardStage *stage;
    atomic_uint_fast64_t truncated, left;
} Guard;

static void guard_range(void *context, uint32_t first, uint32_t end)
{
    Guard *guard = context;
    const PercalePathGuardStage *stage = guard->stage;
    PercalePathGuardCounts counts = {0, 0};
    uint32_t slot = first;
    for (; slot + WIDE <= end; slot += WIDE) {
        if (stage->again || !are_out_of_reach(stage, slot)) {
            guard_slots(stage, slot, slot + WIDE, &counts);
        }
    }
    guard_slots(stage, slot, end, &counts);
    memcpy(stage->proved + first, stage->model->predicted + first, (end - first) * sizeof(f32x4));
    atomic_fetch_add_explicit(&guard->truncated, counts.truncated, memory_order_relaxed);
    atomic_fetch_add_explicit(&guard->left, counts.left, memory_order_relaxed);
}

PercalePathGuardCounts percale_path_guard_run(const PercalePathGuardStage *stage)
{
    enum { GRAIN_WAYS = 512 };
    Guard guard = {stage, 0, 0};
    percale_team_for(stage->team, stage->model->slot_count, GRAIN_WAYS, guard_range, &guard);
    return (PercalePathGuardCounts){guard.truncated, guard.left};
}
