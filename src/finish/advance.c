#include "finish/advance.h"

#include "base/parallel.h"
#include "base/reduce.h"
#include "base/wide.h"

#include <string.h>

/// What the chunks of the stage share.
typedef struct Advance {
    PercaleModel *model;
    float dt; // s
    ReducedUint bad;
} Advance;

/// Names the vertices of a range whose new state isn't finite.
static void name_bad(Advance *advance, uint32_t first, uint32_t end)
{
    const PercaleModel *model = advance->model;
    for (uint32_t slot = first; slot < end; slot++) {
        if (!is_finite3(model->predicted[slot]) || !is_finite3(model->next_velocity[slot])) {
            reduce_min(&advance->bad, slot);
        }
    }
}

/// One or two vertices from `slot` on. Returns what of their new velocities is not finite (with x, v is not).
static inline i32x8 advance_vertices(const Advance *advance, uint32_t slot, uint32_t count)
{
    PercaleModel *model = advance->model;
    f32x8 v = load_two(model->next_velocity + slot, count);
    f32x8 x = load_two(model->predicted + slot, count);
    f32x8 unhindered = load_two(model->position + slot, count) + v * advance->dt;
    v = without_w(v + (x - unhindered) * (1.0f / advance->dt));
    store_two(model->next_velocity + slot, v, count);
    return not_finite8(v);
}

static void velocity_range(void *context, uint32_t first, uint32_t end)
{
    Advance *advance = context;
    i32x8 bad = {0};
    uint32_t slot = first;
    for (; slot + 2 <= end; slot += 2) {
        bad |= advance_vertices(advance, slot, 2);
    }
    if (slot < end) {
        bad |= advance_vertices(advance, slot, 1);
    }
    if (lane_bits(bad) != 0) {
        name_bad(advance, first, end);
    }
}

uint32_t percale_advance_velocities(PercaleModel *model, float dt, PercaleTeam *team)
{
    Advance advance = {model, dt, UINT32_MAX};
    percale_team_for(team, model->slot_count, GRAIN, velocity_range, &advance);
    return advance.bad;
}

static void check_range(void *context, uint32_t first, uint32_t end)
{
    name_bad(context, first, end);
}

uint32_t percale_advance_find_bad(PercaleModel *model, PercaleTeam *team)
{
    Advance advance = {model, 0.0f, UINT32_MAX};
    percale_team_for(team, model->slot_count, GRAIN, check_range, &advance);
    return advance.bad;
}

void percale_advance_commit(PercaleModel *model, bool obstacles_moved)
{
    f32x4 *position = model->position;
    f32x4 *velocity = model->velocity;
    model->position = model->predicted;
    model->velocity = model->next_velocity;
    model->predicted = position;
    model->next_velocity = velocity;
    if (obstacles_moved) {
        size_t obstacle_points = model->point_count - model->slot_count;
        memcpy(model->predicted + model->slot_count, model->position + model->slot_count,
               obstacle_points * sizeof(f32x4));
    }
}
