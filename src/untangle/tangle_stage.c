#include "untangle/tangle_stage.h"

enum { HOLD_ROUNDS = 12 };

static bool add(PercaleTangleStage *stage, uint32_t point, uint32_t face, const double weights[3],
                f32x4 normal, uint64_t until)
{
    const uint32_t *corners = corners_of_triangle(stage->mesh, face);
    PercaleStencilList *list = stage->stencils;
    if (!percale_memory_reserve(stage->memory, &list->items, &list->capacity, list->count + 1,
                                sizeof(list->items[0]))) {
        return false;
    }
    const double signed_weights[4] = {1.0, -weights[0], -weights[1], -weights[2]};
    PercaleStencil stencil = {
        .points = {point, corners[0], corners[1], corners[2]}, .normal = normal, .source = until};
    percale_stencil_weigh(&stencil, signed_weights, false);
    for (int k = 1; k < 4; k++) {
        if (stencil.weights[k] == 0.0f) { // the kernel must not read what another of its colour may move
            stencil.points[k] = point;
        }
    }
    list->items[list->count++] = stencil;
    return true;
}

bool percale_add_tangle_stencil(PercaleTangleStage *stage, uint32_t point, uint32_t face,
                                const double weights[3], Vec3 normal, double distance)
{
    return add(stage, point, face, weights, f32x4_of(normal, (float)distance), stage->round);
}

bool percale_add_tangle_hold(PercaleTangleStage *stage, uint32_t point, uint32_t face,
                             const double weights[3], Vec3 normal, double distance)
{
    stage->held_in[point] = stage->round;
    return add(stage, point, face, weights, f32x4_of(normal, (float)distance), stage->round + HOLD_ROUNDS);
}

void percale_begin_tangle_stencils(PercaleTangleStage *stage)
{
    PercaleStencilList *list = stage->stencils;
    size_t kept = 0;
    stage->round++;
    for (size_t i = 0; i < list->count; i++) {
        if (list->items[i].source >= stage->round) {
            list->items[kept] = list->items[i];
            list->items[kept++].multiplier = (f32x4){0};
        }
    }
    list->count = stage->held_count = kept;
}

void percale_end_tangle_stencils(PercaleTangleStage *stage)
{
    PercaleStencilList *list = stage->stencils;
    size_t kept = 0;
    for (size_t i = 0; i < list->count; i++) {
        bool is_superseded =
            i < stage->held_count && stage->held_in[list->items[i].points[0]] == stage->round;
        if (!is_superseded) {
            list->items[kept++] = list->items[i];
        }
    }
    list->count = kept;
}
