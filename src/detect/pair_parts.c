#include "detect/pair_parts.h"

#include <string.h>

double percale_pair_reach(const PercalePairStage *stage, const Keep *keep, const uint32_t points[4],
                          const double weights[4])
{
    double reach = (double)(CONTACT_REACH * keep->thickness);
    if (stage->later_substeps > 0.0f) {
        Vec3 moved = vsub(combine(stage, points, weights, false), combine(stage, points, weights, true));
        reach += (double)stage->later_substeps * vlength(moved);
    }
    return reach;
}

/// Slip beyond which weights and normal of a stencil no longer fit.
static float most_slip(const PercalePairStage *stage, const uint32_t points[4], const Push *push)
{
    const float SHARE_OF_EDGE = 0.2f;
    const float SHARE_OF_THICKNESS = 0.1f; // it turns the normal of a rim by as many radians
    bool rim = !push->edges && !(push->weights[1] < 0.0 && push->weights[2] < 0.0 && push->weights[3] < 0.0);
    double edge = vlength(vsub(end_of(stage, points[2]), end_of(stage, points[3])));
    double other = push->edges ? vlength(vsub(end_of(stage, points[0]), end_of(stage, points[1]))) : edge;
    return rim ? SHARE_OF_THICKNESS * push->thickness : SHARE_OF_EDGE * (float)fmin(edge, other);
}

void percale_pair_add(const PercalePairStage *stage, PercaleCollector *collector, const uint32_t points[4],
                      const Push *push)
{
    float risen = (float)push->start_gap + EXIT_SPEED * stage->dt;
    PercaleStencil stencil = {.normal =
                                  f32x4_of(push->normal, risen < push->thickness ? risen : push->thickness),
                              .friction = push->friction};
    memcpy(stencil.points, points, sizeof(stencil.points));
    percale_stencil_weigh(&stencil, push->weights, push->edges);
    stencil.seen = with_w(stencil_offset(&stencil, stage->end), most_slip(stage, points, push));
    percale_collect_stencil(collector, &stencil);
}

const PercalePairNote *percale_pair_find_note(const PercaleNoteList *known, uint64_t key)
{
    size_t low = 0;
    size_t high = known->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (known->items[middle].key < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < known->count && known->items[low].key == key ? &known->items[low] : NULL;
}

Vec3 percale_pair_outward(const PercalePairStage *stage, const PercaleModelSurface *obstacle,
                          const uint32_t *faces, uint32_t count, uint32_t divisor)
{
    PercaleSurface surface = {obstacle, NULL, stage->end, NULL};
    Vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < count; i++) {
        sum = vadd(sum, percale_surface_face_normal(&surface, faces[i] / divisor));
    }
    return vunit(sum);
}
