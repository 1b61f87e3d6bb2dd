// vec3.h: three floats, for points (m), directions and linear RGB colours of the renderer.

#ifndef PERCALE_VEC3_H
#define PERCALE_VEC3_H

#include <math.h>

typedef struct PercaleVec3 {
    float x, y, z;
} PercaleVec3;

static inline PercaleVec3 vec3(float x, float y, float z)
{
    return (PercaleVec3){x, y, z};
}

static inline PercaleVec3 vec3_add(PercaleVec3 a, PercaleVec3 b)
{
    return vec3(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline PercaleVec3 vec3_subtract(PercaleVec3 a, PercaleVec3 b)
{
    return vec3(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline PercaleVec3 vec3_scale(PercaleVec3 a, float s)
{
    return vec3(a.x * s, a.y * s, a.z * s);
}

static inline PercaleVec3 vec3_multiply(PercaleVec3 a, PercaleVec3 b)
{
    return vec3(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline PercaleVec3 vec3_mix(PercaleVec3 a, PercaleVec3 b, float t)
{
    return vec3_add(vec3_scale(a, 1.0f - t), vec3_scale(b, t));
}

static inline float vec3_dot(PercaleVec3 a, PercaleVec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline PercaleVec3 vec3_cross(PercaleVec3 a, PercaleVec3 b)
{
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline float vec3_length(PercaleVec3 a)
{
    return sqrtf(vec3_dot(a, a));
}

/// Unit vector along a; `otherwise` where a has no direction.
static inline PercaleVec3 vec3_normalize(PercaleVec3 a, PercaleVec3 otherwise)
{
    float length = vec3_length(a);
    return length > 0.0f ? vec3_scale(a, 1.0f / length) : otherwise;
}

#endif
