// stencil.h: the one contact type: four points, four signed weights, a unit normal and a distance to keep.
//
//     C(x) = n . (a0 x0 + a1 x1 + a2 x2 + a3 x3) - h >= 0          (MATH.md, section 1)
//
// An obstacle's vertex is a point with inverse mass 0, so one kernel serves every pair.

#ifndef PERCALE_STENCIL_H
#define PERCALE_STENCIL_H

#include "base/simd.h"

#include <stdbool.h>

// No point is moved farther than this many times the violation: where only points of small weight can move
// (the others are held), the lever would be as long as one likes.
static const float LONGEST_LEVER = 4.0f;

typedef struct PercaleStencil {
    uint32_t points[4];
    float weights[4]; // multiples of 2^-24 with the exact sum 0
    f32x4 normal;     // unit; [3] is the target distance h, m
    f32x4 multiplier; // accumulated over a substep, kg m: friction vector and, in [3], the normal multiplier
    f32x4 seen;       // m; sum a_k x_k when it was found; [3]: slip beyond which it is found anew, 0: none
    f32x4 owed;       // m; slip of earlier substeps that friction has still to undo, along the surface
    float friction;   // Coulomb coefficient of the pair
    float held;       // share of the friction wanted that the cone allowed last: 1 sticks, less slides
    uint64_t source;  // group and item that it was found for, ascending along a pass (see carry.h)
} PercaleStencil;

/// Rounds barycentric coordinates to multiples of 2^-24 that sum to exactly 1: else momentum leaks 6e-8 a
/// contact.
static inline void quantize_weights(const double weights[3], float quantized[3])
{
    const double UNIT = 16777216.0; // 2^24
    double first = floor(weights[0] * UNIT + 0.5) / UNIT;
    double second = floor(weights[1] * UNIT + 0.5) / UNIT;
    quantized[0] = (float)first;
    quantized[1] = (float)second;
    quantized[2] = (float)(1.0 - first - second);
}

/// sum a_k x_k, from differences to the first point (the weights sum to 0); [3] is 0.
static inline f32x4 stencil_offset(const PercaleStencil *stencil, const f32x4 *x)
{
    f32x4 first = x[stencil->points[0]];
    f32x4 offset = {0};
    for (int k = 1; k < 4; k++) {
        offset += (x[stencil->points[k]] - first) * stencil->weights[k];
    }
    return with_w(offset, 0.0f);
}

/// Sets the weights of a vertex and a face (1, -b1, -b2, -b3) or of two edges, so that those of each sign sum
/// to exactly 1.
static inline void percale_stencil_weigh(PercaleStencil *stencil, const double weights[4], bool edges)
{
    const double first[3] = {weights[0], weights[1], 0.0};
    const double second[3] = {-weights[edges ? 2 : 1], -weights[edges ? 3 : 2], edges ? 0.0 : -weights[3]};
    float a[3] = {0.0f, 0.0f, 0.0f};
    float b[3];
    if (edges) {
        quantize_weights(first, a);
    }
    quantize_weights(second, b);
    stencil->weights[0] = 1.0f - a[1];
    stencil->weights[1] = edges ? a[1] : -b[0];
    stencil->weights[2] = edges ? -(1.0f - b[1]) : -b[1];
    stencil->weights[3] = edges ? -b[1] : -b[2];
}

#endif
