// audit_vector.h: points and directions of the audit, in double.

#ifndef PERCALE_AUDIT_AUDIT_VECTOR_H
#define PERCALE_AUDIT_AUDIT_VECTOR_H

#include <stddef.h>
#include <stdint.h>

static inline void load_point(const float *positions, size_t vertex, double point[3])
{
    for (size_t axis = 0; axis < 3; axis++)
        point[axis] = (double)positions[3 * vertex + axis];
}

static inline void subtract(const double a[3], const double b[3], double difference[3])
{
    for (size_t axis = 0; axis < 3; axis++)
        difference[axis] = a[axis] - b[axis];
}

static inline double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const double a[3], const double b[3], double product[3])
{
    product[0] = a[1] * b[2] - a[2] * b[1];
    product[1] = a[2] * b[0] - a[0] * b[2];
    product[2] = a[0] * b[1] - a[1] * b[0];
}

#endif
