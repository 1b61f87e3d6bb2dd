// coplanar.h: when four points that move on straight lines lie in a plane.

#ifndef PERCALE_COPLANAR_H
#define PERCALE_COPLANAR_H

#include "base/simd.h"

/// from, to: [4]. Times in [0, 1], ascending, at which the points lie in a plane, where they pass through it;
/// at most three (a cubic, Provot 1997). Double, not conservative: points that stay in a plane have none, and
/// neither those that begin or end in it.
int percale_coplanar_times(const Vec3 *from, const Vec3 *to, double times[3]);

#endif
