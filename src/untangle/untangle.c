#include "untangle/untangle.h"

#include "untangle/descent.h"
#include "untangle/push.h"

static const double DESCENT_STEP = 0.5; // lengths of an edge

static bool is_pushed_out(const PercaleTangleStage *stage, const PercaleContour *contour)
{
    return object_of_triangle(stage->mesh, contour->triangles[0])->is_closed ||
           object_of_triangle(stage->mesh, contour->triangles[1])->is_closed;
}

/// What crosses along the contour isn't held by what is known of it from before.
static void release_crossings(PercaleTangleStage *stage, uint32_t index)
{
    const PercaleContour *contour = &stage->contours->items[index];
    uint32_t bit = 1U << index % RELEASE_BITS;
    for (uint32_t i = 0; i < contour->count; i++) {
        const PercaleContourStep *step = &stage->contours->steps[contour->first + i];
        const PercaleTangleCrossing *crossing = &stage->crossings->items[step->crossing];
        for (uint32_t k = 0; k < 2; k++) {
            stage->releases.wrong[stage->mesh->edges.vertices[crossing->edge][k]] |= bit;
        }
        for (uint32_t k = 0; k < 3; k++) {
            stage->releases.others[corners_of_triangle(stage->mesh, crossing->face)[k]] |= bit;
        }
    }
}

/// The stencils of one contour.
static bool treat(PercaleTangleStage *stage, uint32_t index)
{
    const PercaleContour *contour = &stage->contours->items[index];
    // Two triangles that share a point may cross for a while: cloth that gives way straightens them.
    if (is_pushed_out(stage, contour) || contour->pair_count == 0) {
        return true;
    }
    bool pushed = false;
    if (!percale_push_region(stage, index, &pushed)) {
        return false;
    }
    if (pushed) {
        return true;
    }
    if (stage->frees_crossings) {
        release_crossings(stage, index);
    }
    return percale_descend(stage, index, DESCENT_STEP);
}

bool percale_tangle_find_stencils(PercaleTangleStage *stage)
{
    stage->stencils->count = 0;
    bool complete = percale_push_out(stage);
    for (uint32_t i = 0; complete && i < stage->contours->count; i++) {
        complete = treat(stage, i);
    }
    return complete;
}
