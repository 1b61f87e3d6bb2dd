#include "predict/predict.h"

#include "base/parallel.h"

static const float AIR_DENSITY = 1.2f;       // kg/m^3, at 20 C
static const float PLATE_COEFFICIENT = 1.2f; // drag of a flat plate across the flow

/// Change of a vertex's velocity by the pressure of the wind on a third of each triangle around it. The
/// quotient with 1 + strength keeps a light cloth in a large step from overshooting the speed of the air.
static f32x4 wind_push(const PercalePredictStage *stage, uint32_t slot)
{
    const PercaleModel *model = stage->model;
    f32x4 push = {0};
    for (uint32_t i = model->slot_first_triangle[slot]; i < model->slot_first_triangle[slot + 1]; i++) {
        const uint32_t *corners = model->triangles[model->slot_triangles[i]];
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

static f32x4 predicted_velocity(const PercalePredictStage *stage, uint32_t slot, bool windy)
{
    f32x4 velocity = stage->model->velocity[slot] + stage->gravity * stage->dt;
    if (windy) {
        velocity += wind_push(stage, slot);
    }
    velocity *= stage->damping;
    float speed = length3(velocity);
    return speed > stage->speed_max ? velocity * (stage->speed_max / speed) : velocity;
}

void percale_predict_cloth(const PercalePredictStage *stage)
{
    PercaleModel *model = stage->model;
    bool windy = dot3(stage->wind, stage->wind) > 0.0f;
#pragma omp parallel default(none) shared(stage, model, windy) \
    num_threads(threads_for(model->slot_count, stage->thread_count))
    {
        uint32_t mode = float_mode_enter();
#pragma omp for schedule(static)
        for (uint32_t slot = 0; slot < model->slot_count; slot++) {
            f32x4 x = model->position[slot];
            model->start[slot] = x;
            model->free_velocity[slot] =
                x[3] > 0.0f ? with_w(predicted_velocity(stage, slot, windy), 0.0f) : (f32x4){0};
            model->predicted[slot] = x + model->free_velocity[slot] * stage->dt;
        }
        float_mode_leave(mode);
    }
}

void percale_predict_pins(PercaleModel *model, const f32x4 *from, const f32x4 *to, float fraction)
{
    for (uint32_t i = 0; i < model->pinned_count; i++) {
        f32x4 target = fraction < 1.0f ? from[i] + (to[i] - from[i]) * fraction : to[i];
        model->predicted[model->pinned_slots[i]] = with_w(target, 0.0f);
    }
}
