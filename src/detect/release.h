// release.h: what untangling has in hand: pairs of features that neither contact nor the guard may hold.
//
// A part of the cloth that is on the wrong side of another has to come through it. Its sides are those of the
// tangle, so what is known of them from before is forgotten.

#ifndef PERCALE_RELEASE_H
#define PERCALE_RELEASE_H

#include <stdbool.h>
#include <stdint.h>

enum { RELEASE_BITS = 32 };

typedef struct PercaleReleases {
    uint32_t *wrong;  // [point_count] a bit for each part that is on the wrong side
    uint32_t *others; // [point_count] the same bit where the surface is that it has to come through
} PercaleReleases;

static inline uint32_t bits_of_points(const uint32_t *bits, const uint32_t *points, uint32_t count)
{
    uint32_t all = 0;
    for (uint32_t k = 0; k < count; k++) {
        all |= bits[points[k]];
    }
    return all;
}

/// Whether one of two features is to come through the other.
static inline bool are_released(const PercaleReleases *releases, const uint32_t *a, uint32_t a_count,
                                const uint32_t *b, uint32_t b_count)
{
    return ((bits_of_points(releases->wrong, a, a_count) & bits_of_points(releases->others, b, b_count)) |
            (bits_of_points(releases->wrong, b, b_count) & bits_of_points(releases->others, a, a_count))) !=
           0;
}

#endif
