#include "predict/predict.h"

#include "base/parallel.h"
#include "base/reduce.h"
#include "base/wide.h"

static const float AIR_DENSITY = 1.2f;       // kg/m^3, at 20 C
static const float PLATE_COEFFICIENT = 1.2f; // drag of a flat plate across the flow

/// Change of a vertex's velocity by the pressure of the wind on a third of each triangle around it. The
/// quotient with 1 + strength keeps a light cloth in a large step from overshooting the speed of the air.
static f32x4 wind_push(const PercalePredictStage *stage, uint32_t slot)
{
    const PercaleModel *model = stage->model;
    f32x4 push = {0};
    const PercaleModelSurface *cloth = &model->cloth;
    for (uint32_t i = cloth->vertex_first_face[slot]; i < cloth->vertex_first_face[slot + 1]; i++) {
        const uint32_t *corners = cloth->triangles + 3 * (size_t)cloth->vertex_faces[i];
        f32x4 a = model->position[corners[0]];
        f32x4 u = model->position[corners[1]] - a;
        f32x4 v = model->position[corners[2]] - a;
        f32x4 normal = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
                        0.0f};
        float length = length3(normal);
        if (length <= 0.0f) {
            continue;
        }
        normal /= length;
        f32x4 mean =
            (model->velocity[corners[0]] + model->velocity[corners[1]] + model->velocity[corners[2]]) / 3.0f;
        float across = dot3(stage->wind - mean, normal);
        float strength = 0.5f * AIR_DENSITY * PLATE_COEFFICIENT * (0.5f * length / 3.0f) * fabsf(across) *
                         model->position[slot][3] * stage->dt;
        push += normal * (across * strength / (1.0f + strength));
    }
    return push;
}

/// What the chunks of the stage share.
typedef struct Predict {
    const PercalePredictStage *stage;
    bool windy;
    ReducedUint bad;
} Predict;

static f32x8 limit_speed(f32x8 velocity, float speed_max)
{
    f32x8 speed2 = dot3_pairs(velocity, velocity);
    if (lane_bits(greater8(speed2, all8(speed_max * speed_max))) == 0) {
        return velocity;
    }
    f32x8 speed = sqrt8(speed2);
    return select8(greater8(speed, all8(speed_max)), velocity * (all8(speed_max) / speed), velocity);
}

/// One or two vertices from `slot` on. Returns what of them is not finite.
static inline i32x8 predict_vertices(const Predict *predict, uint32_t slot, uint32_t count)
{
    const PercalePredictStage *stage = predict->stage;
    PercaleModel *model = stage->model;
    f32x8 x = load_two(model->position + slot, count);
    f32x8 pull = pair_of_points(stage->gravity, stage->gravity) * stage->dt;
    f32x8 velocity = load_two(model->velocity + slot, count) + pull;
    if (stage->pushes != NULL) {
        velocity += load_two(stage->pushes + slot, count);
    }
    if (predict->windy) {
        velocity += pair_of_points(wind_push(stage, slot), wind_push(stage, slot + count - 1));
    }
    velocity = limit_speed(without_w(velocity * stage->damping), stage->speed_max);
    velocity = where8(greater8(SPREAD(x, 3), all8(0.0f)), velocity);
    f32x8 to = x + velocity * stage->dt;
    store_two(model->next_velocity + slot, velocity, count);
    store_two(model->predicted + slot, to, count);
    if (stage->ahead != NULL) {
        store_two(stage->ahead + slot, x + (to - x) * stage->ahead_count, count);
    }
    return not_finite8(to);
}

static void predict_range(void *context, uint32_t first, uint32_t end)
{
    Predict *predict = context;
    i32x8 bad = {0};
    uint32_t slot = first;
    for (; slot + 2 <= end; slot += 2) {
        bad |= predict_vertices(predict, slot, 2);
    }
    if (slot < end) {
        bad |= predict_vertices(predict, slot, 1);
    }
    for (slot = first; lane_bits(bad) != 0 && slot < end; slot++) {
        if (!is_finite3(predict->stage->model->predicted[slot])) {
            reduce_min(&predict->bad, slot);
        }
    }
}

uint32_t percale_predict_cloth(const PercalePredictStage *stage, PercaleTeam *team)
{
    Predict predict = {stage, dot3(stage->wind, stage->wind) > 0.0f, UINT32_MAX};
    percale_team_for(team, stage->model->slot_count, GRAIN, predict_range, &predict);
    return predict.bad;
}

void percale_predict_pins(const PercalePredictStage *stage, const f32x4 *from, const f32x4 *to,
                          float fraction)
{
    PercaleModel *model = stage->model;
    for (uint32_t i = 0; i < model->pinned_count; i++) {
        uint32_t slot = model->pinned_slots[i];
        f32x4 target = fraction < 1.0f ? from[i] + (to[i] - from[i]) * fraction : to[i];
        model->predicted[slot] = with_w(target, 0.0f);
        if (stage->ahead != NULL) {
            f32x4 x = model->position[slot];
            stage->ahead[slot] = x + (model->predicted[slot] - x) * stage->ahead_count;
        }
    }
}
