#include "finish/advance.h"

#include "base/parallel.h"

static bool is_finite3(f32x4 x)
{
    return isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2]);
}

/// v* + (x - (x0 + dt v*)) / dt; see advance.h.
static f32x4 velocity_of(const PercaleModel *model, uint32_t slot, float dt)
{
    f32x4 v = model->free_velocity[slot];
    f32x4 pushed = model->predicted[slot] - (model->start[slot] + v * dt);
    return with_w(v + pushed / dt, 0.0f);
}

uint32_t percale_advance_find_bad(const PercaleModel *model, float dt, int thread_count)
{
    uint32_t first = UINT32_MAX;
#pragma omp parallel for default(none) shared(model, dt) reduction(min      \
                                                                   : first) \
    num_threads(threads_for(model->slot_count, thread_count)) schedule(static)
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        bool good = is_finite3(model->predicted[slot]) && is_finite3(velocity_of(model, slot, dt));
        if (!good && slot < first) {
            first = slot;
        }
    }
    return first;
}

void percale_advance_commit(PercaleModel *model, float dt, int thread_count)
{
#pragma omp parallel default(none) shared(model, dt) \
    num_threads(threads_for(model->point_count, thread_count))
    {
        uint32_t mode = float_mode_enter();
#pragma omp for schedule(static)
        for (uint32_t point = 0; point < model->point_count; point++) {
            if (point < model->slot_count) {
                model->velocity[point] = velocity_of(model, point, dt);
            }
            model->position[point] = model->predicted[point];
            model->start[point] = model->predicted[point];
        }
        float_mode_leave(mode);
    }
}
