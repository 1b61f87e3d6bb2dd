// stencil.h: the one contact type: four points, four signed weights, a unit normal and a distance to keep.
//
//     C(x) = n . (a0 x0 + a1 x1 + a2 x2 + a3 x3) - h >= 0          (MATH.md, section 1)
//
// An obstacle's vertex is a point with inverse mass 0, so one kernel serves every pair.

#ifndef PERCALE_STENCIL_H
#define PERCALE_STENCIL_H

#include "base/simd.h"

typedef struct PercaleStencil {
    uint32_t points[4];
    float weights[4]; // multiples of 2^-24 with the exact sum 0
    f32x4 normal;     // unit; [3] is the target distance h, m
    f32x4 multiplier; // accumulated over a substep, kg m: friction vector and, in [3], the normal multiplier
    float friction;   // Coulomb coefficient of the pair
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

#endif
