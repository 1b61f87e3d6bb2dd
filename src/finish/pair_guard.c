#include "finish/pair_guard.h"

#include "finish/passing.h"
#include "finish/zones.h"

#include <string.h>

enum {
    // Rounds: of each the one after its last.
    PUSHES = 48,             // what has passed is pushed back
    HALVES = PUSHES + 4,     // it goes half as far
    ROUNDS = HALVES + 20,    // it goes together
    LAST_ROUND = ROUNDS + 32 // all the rest stands still
};

/// What the rounds work with.
typedef struct Work {
    const PercalePairGuardStage *stage;
    PercaleZones zones;
    uint8_t *touched; // [points] those that have passed when last looked for, or moved since
} Work;

/// Moves a point and gives it the velocity that it has so. What is known of its distances shrinks.
static void move_point(const Work *work, uint32_t slot, f32x4 to)
{
    const PercalePairGuardStage *stage = work->stage;
    PercaleModel *model = stage->model;
    work->touched[slot] = 1;
    f32x4 by = with_w(to - model->predicted[slot], 0.0f);
    model->predicted[slot] = with_w(to, model->predicted[slot][3]);
    model->next_velocity[slot] += by / stage->dt;
    for (uint32_t o = 0; stage->obstacles && o < model->obstacle_count; o++) {
        PercaleProximity *proximity = &stage->proximities[o];
        proximity->clearance[slot] -= length3(by);
        proximity->side[slot] = 0;
        proximity->nearest[slot] = NO_TRIANGLE;
    }
}

/// The projection of MATH.md, section 1.
static void push_back(const Work *work, const PercaleStencil *stencil)
{
    const f32x4 *x = work->stage->model->predicted;
    f32x4 offset = {0};
    float weight = 0.0f;
    for (int k = 1; k < 4; k++) {
        offset += (x[stencil->points[k]] - x[stencil->points[0]]) * stencil->weights[k];
    }
    float farthest = 0.0f;
    for (int k = 0; k < 4; k++) {
        float share = x[stencil->points[k]][3] * stencil->weights[k];
        weight += share * stencil->weights[k];
        farthest = fmaxf(farthest, fabsf(share));
    }
    weight = fmaxf(weight, farthest / LONGEST_LEVER);
    float depth = stencil->normal[3] - dot3(stencil->normal, offset);
    if (!(depth > 0.0f) || !(weight > 0.0f)) {
        return;
    }
    for (int k = 0; k < 4; k++) {
        float share = x[stencil->points[k]][3] * stencil->weights[k];
        if (share != 0.0f) {
            move_point(work, stencil->points[k],
                       x[stencil->points[k]] + stencil->normal * (share * depth / weight));
        }
    }
}

/// Those that still pass go half as far.
static void hold_back(const Work *work, const PercaleStencil *stencil)
{
    const PercaleModel *model = work->stage->model;
    for (int k = 0; k < 4; k++) {
        uint32_t point = stencil->points[k];
        if (model->predicted[point][3] > 0.0f) {
            f32x4 to = model->position[point] + (model->predicted[point] - model->position[point]) * 0.5f;
            move_point(work, point, to);
        }
    }
}

/// What still passes goes together; with `all` the rest stands still: then nothing passes but what pins and
/// obstacles force.
static void move_zones(Work *work, bool all)
{
    const PercaleModel *model = work->stage->model;
    PercaleZones *zones = &work->zones;
    for (size_t i = 0; i < work->stage->passing->count; i++) {
        percale_zones_add(zones, model, &work->stage->passing->items[i]);
    }
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        bool held = zones->parent[slot] != NO_ZONE;
        if (model->predicted[slot][3] > 0.0f && (held || all)) {
            f32x4 motion = held ? percale_zones_motion(zones, slot) : (f32x4){0};
            move_point(work, slot, model->position[slot] + motion);
        }
    }
}

/// What has passed, and so far nothing else, is touched.
static void touch_passing(const Work *work)
{
    const PercaleStencilList *passing = work->stage->passing;
    memset(work->touched, 0, work->stage->model->point_count);
    for (size_t i = 0; i < passing->count; i++) {
        for (int k = 0; k < 4; k++) {
            work->touched[passing->items[i].points[k]] = 1;
        }
    }
}

/// What of the guard's work is done in this round.
static bool put_back(Work *work, int round)
{
    const PercaleStencilList *passing = work->stage->passing;
    touch_passing(work);
    if (round == HALVES && !percale_zones_create(&work->zones, work->stage->model, work->stage->arena)) {
        return false;
    }
    if (round >= HALVES) {
        move_zones(work, round >= ROUNDS);
        return true;
    }
    for (size_t i = 0; i < passing->count; i++) { // few, and in a fixed order
        if (round < PUSHES) {
            push_back(work, &passing->items[i]);
        } else {
            hold_back(work, &passing->items[i]);
        }
    }
    return true;
}

bool percale_pair_guard_run(const PercalePairGuardStage *stage, PercalePairGuardCounts *counts)
{
    *counts = (PercalePairGuardCounts){0};
    Work work = {.stage = stage};
    bool complete = percale_passages_find(stage, NULL, counts);
    for (int round = 0; complete && round < LAST_ROUND && stage->passing->count > 0; round++) {
        counts->pushed += stage->passing->count;
        if (work.touched == NULL) {
            work.touched = percale_arena_new(stage->arena, stage->model->point_count, 1);
        }
        complete = work.touched != NULL && put_back(&work, round) &&
                   percale_passages_find(stage, work.touched, counts);
    }
    counts->left = stage->passing->count;
    return complete;
}
