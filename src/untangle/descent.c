#include "untangle/descent.h"

// |cosine| of edge and face normal below which they count as so steep: else a grazing edge has no direction
static const double GRAZING = 1e-3;

static Vec3 place_of(const PercaleTangleStage *stage, const PercaleContour *contour, uint32_t index)
{
    const PercaleContourStep *step = &stage->contours->steps[contour->first + index];
    return percale_crossing_point(stage->mesh, &stage->crossings->items[step->crossing], stage->x);
}

/// R: unit vectors to the crossing from those beside it.
static Vec3 pull_of(const PercaleTangleStage *stage, const PercaleContour *contour, uint32_t index)
{
    Vec3 place = place_of(stage, contour, index);
    Vec3 sum = vec3(0.0, 0.0, 0.0);
    for (int end = 0; end < 2; end++) {
        bool is_last = end == 0 ? index == 0 : index + 1 == contour->count;
        uint32_t beside = end == 0 ? index + contour->count - 1 : index + 1;
        if (!is_last || contour->is_closed) {
            Vec3 other = place_of(stage, contour, beside % contour->count);
            sum = vadd(sum, vunit(vsub(place, other)));
        } else if (contour->ends[0][end] == 'L') {
            uint32_t loop = percale_loop_vertex(stage->contours, stage->mesh, contour, (uint32_t)end);
            sum = vadd(sum, vunit(vsub(place, vec3_of(stage->x[loop]))));
        }
    }
    return sum;
}

Vec3 percale_descent_gradient(const PercaleTangleStage *stage, const PercaleContour *contour, uint32_t index)
{
    const PercaleContourStep *step = &stage->contours->steps[contour->first + index];
    const PercaleTangleCrossing *crossing = &stage->crossings->items[step->crossing];
    const uint32_t *ends = stage->mesh->edges.vertices[crossing->edge];
    Vec3 along = vunit(vsub(vec3_of(stage->x[ends[1]]), vec3_of(stage->x[ends[0]])));
    Vec3 normal = turned_normal(stage->mesh, stage->x, crossing->face);
    Vec3 pull = pull_of(stage, contour, index);
    double steep = vdot(along, normal);
    if (fabs(steep) < GRAZING) {
        steep = steep < 0.0 ? -GRAZING : GRAZING;
    }
    return vsub(pull, vscale(vdot(along, pull) / steep, normal));
}

bool percale_descend(PercaleTangleStage *stage, uint32_t contour_index, double step)
{
    const PercaleContour *contour = &stage->contours->items[contour_index];
    bool complete = true;
    for (uint32_t i = 0; complete && i < contour->count; i++) {
        const PercaleContourStep *here = &stage->contours->steps[contour->first + i];
        const PercaleTangleCrossing *crossing = &stage->crossings->items[here->crossing];
        const uint32_t *ends = stage->mesh->edges.vertices[crossing->edge];
        Vec3 gradient = percale_descent_gradient(stage, contour, i);
        double size = vlength(gradient);
        double length =
            fmin(vlength(vsub(vec3_of(stage->x[ends[1]]), vec3_of(stage->x[ends[0]]))),
                 (double)stage->edge_lengths[crossing->edge]); // what has been stretched grows no more
        double way = step * length * size / sqrt(size * size + 1.0);
        Vec3 direction = vscale(-1.0, vunit(gradient));
        Vec3 place = percale_crossing_point(stage->mesh, crossing, stage->x);
        double nearer = fmax(crossing->along, 1.0 - crossing->along);
        for (int k = 0; complete && size > 0.0 && k < 2; k++) {
            double share = (k == 0 ? 1.0 - crossing->along : crossing->along) / nearer;
            double from = vdot(direction, vsub(vec3_of(stage->x[ends[k]]), place));
            complete = percale_add_tangle_stencil(stage, ends[k], crossing->face, crossing->weights,
                                                  direction, from + share * way);
        }
    }
    return complete;
}
