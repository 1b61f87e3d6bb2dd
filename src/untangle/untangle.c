#include "untangle/untangle.h"

#include "untangle/descent.h"
#include "untangle/push.h"

enum {
    IN_ONE_NOW = 0x80, // a mark among the rounds
    TURN_ROUNDS = 4,   // after so many a contour is treated the other way
    FAILS_MOST = 6     // one that was put back more often is left
};

static const double DESCENT_STEP = 0.5; // lengths of an edge

void percale_tangle_ages_count(PercaleTangleAges *ages, const PercaleTangleStage *stage)
{
    const PercaleContours *contours = stage->contours;
    uint8_t *rounds = ages->rounds;
    for (size_t i = 0; i < contours->piece_count; i++) {
        rounds[contours->pieces[i].triangles[0]] |= IN_ONE_NOW;
        rounds[contours->pieces[i].triangles[1]] |= IN_ONE_NOW;
    }
    for (uint32_t t = 0; t < stage->mesh->triangle_count; t++) {
        uint8_t before = rounds[t] & (IN_ONE_NOW - 1);
        uint8_t after = (uint8_t)(before + (before + 1 < IN_ONE_NOW));
        rounds[t] = rounds[t] != before ? after : 0;
    }
}

/// The mean of the triangles of a contour.
static uint32_t mean_of(const PercaleTangleStage *stage, const uint8_t *values, const PercaleContour *contour)
{
    uint32_t sum = 0;
    for (uint32_t i = 0; i < contour->count; i++) {
        const PercaleContourStep *step = &stage->contours->steps[contour->first + i];
        sum += values[stage->crossings->items[step->crossing].face];
    }
    return contour->count > 0 ? (sum + contour->count / 2) / contour->count : 0;
}

static bool is_pushed_out(const PercaleTangleStage *stage, const PercaleContour *contour)
{
    return object_of_triangle(stage->mesh, contour->triangles[0])->is_closed ||
           object_of_triangle(stage->mesh, contour->triangles[1])->is_closed;
}

/// The stencils of one contour.
static bool treat(PercaleTangleStage *stage, const PercaleTangleAges *ages, uint32_t index)
{
    const PercaleContour *contour = &stage->contours->items[index];
    uint32_t age = mean_of(stage, ages->rounds, contour);
    uint32_t fails = mean_of(stage, ages->fails, contour);
    bool is_left = age > ages->patience || fails > FAILS_MOST;
    // Two triangles that share a point may cross for a while: cloth that gives way straightens them.
    if (is_left || is_pushed_out(stage, contour) || contour->pair_count == 0) {
        return true;
    }
    bool pushed = false;
    if ((age / TURN_ROUNDS + ages->turns + fails) % 2 == 0 && !percale_push_region(stage, index, &pushed)) {
        return false;
    }
    return pushed || percale_descend(stage, index, DESCENT_STEP);
}

bool percale_tangle_find_stencils(PercaleTangleStage *stage, const PercaleTangleAges *ages)
{
    percale_begin_tangle_stencils(stage);
    bool complete = percale_push_out(stage);
    for (uint32_t i = 0; complete && i < stage->contours->count; i++) {
        complete = treat(stage, ages, i);
    }
    percale_end_tangle_stencils(stage);
    return complete;
}
