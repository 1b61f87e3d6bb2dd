// regions.h: what a contour cuts off.
//
//   in   a contour, one of its traces
//   out  the points of the smaller of the two parts into which the trace divides the surface, with its area
//
// Flood fill from both sides of the trace at once, along edges that it does not cross, always on the side
// that has covered less; so the work is that of the smaller part. Where the two floods meet, the trace
// divides nothing.

#ifndef PERCALE_REGIONS_H
#define PERCALE_REGIONS_H

#include "untangle/contours.h"

enum { SIDE_LEFT = 0, SIDE_RIGHT = 1, SIDE_SMALLER = 2 };

/// Scratch and result of a flood.
typedef struct PercaleRegionFlood {
    const PercaleTangleMesh *mesh;
    const PercaleTangleCrossings *crossings;
    const PercaleContours *contours;
    double *areas;      // [point_count] m^2, a third of the triangles around
    uint32_t *sides;    // [point_count] 2 * epoch + side
    uint32_t *cut;      // [edge_count] epoch
    uint32_t *wall;     // [point_count] wall_epoch; points through which the curve goes
    uint32_t *queue[2]; // [point_count] points of either side
    uint32_t epoch, wall_epoch;
    void *sorting;
    size_t sorting_capacity;
} PercaleRegionFlood;

typedef struct PercaleTangleRegion {
    bool is_cut_off; // else the trace divides nothing, or cuts off no point
    uint32_t side;   // of the trace
    uint32_t count;
    const uint32_t *points; // valid until the next flood
    double area;            // m^2
} PercaleTangleRegion;

/// False without memory; then there is nothing to free.
bool percale_region_flood_open(PercaleRegionFlood *flood, const PercaleTangleMesh *mesh, const f32x4 *x,
                               PercaleMemory *memory);
void percale_region_flood_close(PercaleRegionFlood *flood, PercaleMemory *memory);

/// `side`: SIDE_SMALLER, or the one that is wanted whatever its size. False without memory.
bool percale_region_find(PercaleRegionFlood *flood, uint32_t contour, uint32_t trace, uint32_t side,
                         PercaleMemory *memory, PercaleTangleRegion *region);

/// Whether the last flood has found the point on the region's side.
static inline bool is_in_region(const PercaleRegionFlood *flood, const PercaleTangleRegion *region,
                                uint32_t point)
{
    return flood->sides[point] == 2 * flood->epoch + region->side;
}

#endif
