// near.h: which cloth vertices are near each other on the rest shape.
//
//   in   edges with their rest lengths, a radius
//   out  for each slot the slots within the radius along edges, with the length of the way
//
// Parts of a cloth that lie nearer than its thickness at rest can't keep that thickness; everything else can
// (MATH.md, section 6).

#ifndef PERCALE_NEAR_H
#define PERCALE_NEAR_H

#include "base/memory.h"

#include <math.h>

typedef struct PercaleNear {
    uint32_t *first;  // [slot_count + 1] into slots and distances
    uint32_t *slots;  // ascending for each slot, itself left out
    float *distances; // m along edges
    float *radius;    // [slot_count] m; all slots within it are listed
} PercaleNear;

/// edges: [edge_count][2] slots. At most NEAR_MOST are listed for a slot, its radius is smaller then. False
/// without memory.
enum { NEAR_MOST = 256 };
bool percale_near_build(PercaleNear *near, uint32_t slot_count, const uint32_t (*edges)[2],
                        const float *edge_lengths, uint32_t edge_count, float radius, PercaleMemory *memory);
void percale_near_free(PercaleNear *near, PercaleMemory *memory);

/// Length of the way between two slots, or the radius where they are farther apart: a lower bound, m.
static inline float near_distance(const PercaleNear *near, uint32_t a, uint32_t b)
{
    uint32_t low = near->first[a];
    uint32_t high = near->first[a + 1];
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (near->slots[middle] == b) {
            return near->distances[middle];
        }
        if (near->slots[middle] < b) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return near->radius[a];
}

/// Shortest way between the vertices of two features, m; a lower bound.
static inline float near_features(const PercaleNear *near, const uint32_t *a, uint32_t a_count,
                                  const uint32_t *b, uint32_t b_count)
{
    float nearest = INFINITY;
    for (uint32_t i = 0; i < a_count; i++) {
        for (uint32_t k = 0; k < b_count; k++) {
            float distance = near_distance(near, a[i], b[k]);
            nearest = distance < nearest ? distance : nearest;
        }
    }
    return nearest;
}

/// The thickness that two features with this way between them can keep, m: half of it at most.
static inline float allowed_thickness(float thickness, float way)
{
    float most = 0.5f * way;
    return most < thickness ? most : thickness;
}

#endif
