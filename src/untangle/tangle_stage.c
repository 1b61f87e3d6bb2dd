#include "untangle/tangle_stage.h"

bool percale_add_tangle_stencil(PercaleTangleStage *stage, uint32_t point, uint32_t face,
                                const double weights[3], Vec3 normal, double distance)
{
    const uint32_t *corners = corners_of_triangle(stage->mesh, face);
    PercaleStencilList *list = stage->stencils;
    if (!percale_memory_reserve(stage->memory, &list->items, &list->capacity, list->count + 1,
                                sizeof(list->items[0]))) {
        return false;
    }
    const double signed_weights[4] = {1.0, -weights[0], -weights[1], -weights[2]};
    PercaleStencil stencil = {.points = {point, corners[0], corners[1], corners[2]},
                              .normal = f32x4_of(normal, (float)distance)};
    percale_stencil_weigh(&stencil, signed_weights, false);
    for (int k = 1; k < 4; k++) {
        if (stencil.weights[k] == 0.0f) { // the kernel must not read what another of its colour may move
            stencil.points[k] = point;
        }
    }
    list->items[list->count++] = stencil;
    return true;
}
