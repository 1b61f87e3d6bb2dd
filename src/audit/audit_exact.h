// audit_exact.h: on which side, exactly. The sign is that of the real number for any float coordinates below
// 1e38 m; a filter in double answers nearly all, sums without rounding the rest.

#ifndef PERCALE_AUDIT_AUDIT_EXACT_H
#define PERCALE_AUDIT_AUDIT_EXACT_H

/// Sign (-1, 0, 1) of det(a - d, b - d, c - d): 1 where d is below the triangle, seen against its normal.
int percale_audit_orient(const float a[3], const float b[3], const float c[3], const float d[3]);

/// Sign of the area of (a, b, c) in the plane of y and z: 1 where they turn from y towards z.
int percale_audit_orient_yz(const float a[3], const float b[3], const float c[3]);

#endif
