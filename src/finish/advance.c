#include "finish/advance.h"

#include "base/parallel.h"

static bool is_finite3(f32x4 x)
{
    return isfinite(x[0]) && isfinite(x[1]) && isfinite(x[2]);
}

uint32_t percale_advance_find_bad(const PercaleModel *model, int thread_count)
{
    uint32_t first = UINT32_MAX;
#pragma omp parallel for default(none) shared(model) reduction(min      \
                                                               : first) \
    num_threads(threads_for(model->slot_count, thread_count)) schedule(static)
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        if (!is_finite3(model->predicted[slot]) && slot < first) {
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
                f32x4 v = model->free_velocity[point];
                f32x4 pushed = model->predicted[point] - (model->start[point] + v * dt);
                model->velocity[point] = with_w(v + pushed / dt, 0.0f);
            }
            model->position[point] = model->predicted[point];
            model->start[point] = model->predicted[point];
        }
        float_mode_leave(mode);
    }
}
