#include "predict/look_ahead.h"

#include "base/parallel.h"

/// What the chunks of a look share.
typedef struct Look {
    const PercaleModel *model;
    const f32x4 *seen;
    float time; // s, or substeps
    f32x4 *to;
} Look;

static void coast_range(void *context, uint32_t first, uint32_t end)
{
    const Look *look = context;
    const PercaleModel *model = look->model;
    for (uint32_t i = first; i < end; i++) {
        f32x4 x = model->predicted[i];
        bool coasts = i < model->slot_count && x[3] > 0.0f;
        look->to[i] = coasts ? with_w(model->position[i] + model->velocity[i] * look->time, x[3]) : x;
    }
}

void percale_look_coasting(const PercaleModel *model, float dt, f32x4 *coasting, PercaleTeam *team)
{
    Look look = {model, NULL, dt, coasting};
    percale_team_for(team, model->point_count, GRAIN, coast_range, &look);
}

static void ahead_range(void *context, uint32_t first, uint32_t end)
{
    const Look *look = context;
    for (uint32_t i = first; i < end; i++) {
        f32x4 x = look->seen[i];
        look->to[i] = x + (x - look->model->position[i]) * look->time;
    }
}

void percale_look_ahead(const PercaleModel *model, const f32x4 *seen, float substeps, f32x4 *ahead,
                        PercaleTeam *team)
{
    Look look = {model, seen, substeps, ahead};
    percale_team_for(team, model->point_count, GRAIN, ahead_range, &look);
}
