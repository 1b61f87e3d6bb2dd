// impact_queries.h: pairs of features that move, in families that are hard in different ways.

#ifndef PERCALE_TESTS_IMPACT_QUERIES_H
#define PERCALE_TESTS_IMPACT_QUERIES_H

#include "impact_oracle.h"

typedef enum ImpactFamily {
    RANDOM_POINTS = 0, // start and end in a box
    GRAZING,           // 1e-12 to 1e-3 of the size apart, without closing speed, at some moment
    IN_A_PLANE,        // all of the motion in one plane, exactly
    THROUGH_FEATURES,  // exactly on the inside, an edge or a corner at some moment
    PARALLEL_MEETING,  // edges that are parallel, triangles that are a line, when they meet
    DEGENERATE,        // triangles and edges that are a line or a point throughout
    FAR_OFF,           // 1e4 from the origin, with small motions
    GRID,              // coordinates 0 to 3: ties everywhere
    SIZES_OF_MOTION,   // 1e-8 to 1e4 of the feature's size
    AT_REST,           // no motion, or all the same; touching or nearly so
    NOISE,             // touching up to the rounding of the coordinates
    TURNING,           // both turn together, 1e-9 to 1e-3 of the size apart
    NEARLY_EXACT,      // one of the exact ones, off by 1e-16 to 1e-3 of the size
    FAMILY_COUNT
} ImpactFamily;

const char *impact_family_name(ImpactFamily family);

/// All coordinates are below 1.1e4, and multiples of 2^-60 of the power of two above the largest: so the
/// oracle's integers stay short.
ImpactQuery impact_query(ImpactFamily family, bool edges, uint64_t *seed);

#endif
