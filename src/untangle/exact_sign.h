// exact_sign.h: on which side of a plane a point lies, never 0.
//
//   in   four different points with their numbers, float32 coordinates
//   out  +1 or -1: the sign of det(b - a, c - a, d - a)
//
// The sign is exact. Where the four lie in one plane each coordinate of each point counts as moved by an
// infinitesimal of its own, the larger the smaller the point's number (simulation of simplicity: Edelsbrunner
// and Muecke 1990). So there is no degenerate case, every answer fits every other, and no tie depends on the
// order of the arguments but for the sign of their permutation.

#ifndef PERCALE_EXACT_SIGN_H
#define PERCALE_EXACT_SIGN_H

#include "base/simd.h"

/// numbers: of the points, all different; they index x.
int percale_plane_side(const f32x4 *x, const uint32_t numbers[4]);

#endif
