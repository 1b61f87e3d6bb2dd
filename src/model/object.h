// object.h: what the caller added, in the caller's order: the source from which the model is assembled.

#ifndef PERCALE_OBJECT_H
#define PERCALE_OBJECT_H

#include "base/memory.h"
#include "base/message.h"

#include <stdbool.h>

enum { NAME_SIZE = 64 };

typedef struct PercaleClothObject {
    uint32_t id;
    char name[NAME_SIZE];
    uint32_t vertex_count, triangle_count;
    float *positions;    // [3 * vertex_count] m; of the last time when no model held them
    float *velocities;   // [3 * vertex_count] m/s
    uint32_t *triangles; // [3 * triangle_count]
    float *rest_lengths; // [3 * triangle_count] m; edge from corner k to corner k + 1
    double *rest_areas; // [triangle_count] m^2; from the shape itself: lengths in float32 lose thin triangles
    uint32_t *curve;    // [vertex_count] the vertices along a space-filling curve
    PercaleMaterial material; // thickness resolved
    int32_t layer;
    uint32_t mask;
} PercaleClothObject;

/// How an obstacle moves; decides the frame in which vertex paths are cast.
typedef enum PercaleMotion { MOTION_STATIC = 0, MOTION_RIGID, MOTION_DEFORMING } PercaleMotion;

/// x -> rotation * x + translation; rotation is a unit quaternion (x, y, z, w).
typedef struct PercalePose {
    double rotation[4];
    double translation[3];
} PercalePose;

typedef struct PercaleObstacleObject {
    uint32_t id;
    char name[NAME_SIZE];
    uint32_t vertex_count, triangle_count;
    float *base;                    // [3 * vertex_count] m; as added
    float *from;                    // [3 * vertex_count] m; where the next step starts (deforming)
    float *to;                      // [3 * vertex_count] m; where it ends (deforming)
    float *velocity_from;           // [3 * vertex_count] m/s, at `from`; NULL: as along the chord
    float *velocity_to;             // [3 * vertex_count] m/s, at `to`; NULL: it goes in a straight line
    PercalePose pose_from, pose_to; // (rigid)
    uint32_t *triangles;            // [3 * triangle_count]
    PercaleMotion motion;           // of the whole life so far
    bool moving;                    // in the next step
    float friction, thickness;
    uint32_t mask;
} PercaleObstacleObject;

typedef struct PercalePinObject {
    uint32_t id;
    PercaleCloth cloth;
    uint32_t vertex_count;
    uint32_t *vertices; // [vertex_count]
    float *to;          // [3 * vertex_count] m; targets at the end of the next step
} PercalePinObject;

typedef struct PercaleSeamObject {
    uint32_t id;
    PercaleCloth cloth_a, cloth_b;
    uint32_t pair_count;
    uint32_t *vertices_a, *vertices_b; // [pair_count]
    bool *welded;                      // [pair_count] once closed, a pair is one point
} PercaleSeamObject;

typedef struct PercaleObjects {
    PercaleClothObject *cloths;
    PercaleObstacleObject *obstacles;
    PercalePinObject *pins;
    PercaleSeamObject *seams;
    size_t cloth_count, cloth_capacity;
    size_t obstacle_count, obstacle_capacity;
    size_t pin_count, pin_capacity;
    size_t seam_count, seam_capacity;
} PercaleObjects;

/// Each frees what one object owns.
void percale_cloth_object_free(PercaleClothObject *cloth, PercaleMemory *memory);
void percale_obstacle_object_free(PercaleObstacleObject *obstacle, PercaleMemory *memory);
/// After a step: the velocity at its end is that at the start of the next, if it has got there.
void percale_obstacle_object_arrive(PercaleObstacleObject *obstacle, bool arrived, PercaleMemory *memory);
void percale_pin_object_free(PercalePinObject *pin, PercaleMemory *memory);
void percale_seam_object_free(PercaleSeamObject *seam, PercaleMemory *memory);
void percale_objects_free(PercaleObjects *objects, PercaleMemory *memory);

/// Index of the cloth or obstacle with this handle, SIZE_MAX for none.
size_t percale_find_cloth(const PercaleObjects *objects, PercaleCloth cloth);
size_t percale_find_obstacle(const PercaleObjects *objects, PercaleObstacle obstacle);

#endif
