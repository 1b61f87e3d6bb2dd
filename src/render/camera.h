// camera.h: a perspective camera in front (+z) of the scene, slightly above and aside, that just frames it.
//
//   in   every drawable point of the scene, in calls; the picture's size
//   out  the ray through a place of the picture

#ifndef PERCALE_CAMERA_H
#define PERCALE_CAMERA_H

#include "render/vec3.h"

#include <stdint.h>

typedef struct PercaleCamera {
    PercaleVec3 right, up, forward;  ///< orthonormal
    float tangent_right, tangent_up; ///< half the picture's width and height at distance 1
    float extent_right, extent_left; ///< m; largest r - t f and -r - t f of the points, see camera.c
    float extent_up, extent_down;    ///< m
    float nearest;                   ///< m; smallest place along `forward`
    PercaleVec3 eye;                 ///< m
} PercaleCamera;

PercaleCamera percale_camera_start(uint32_t width, uint32_t height);
void percale_camera_include(PercaleCamera *camera, PercaleVec3 point);
/// Places the eye; at least one point has been included.
void percale_camera_frame(PercaleCamera *camera);
/// Unit direction through (x, y), both in -1..1, x to the right and y up.
PercaleVec3 percale_camera_direction(const PercaleCamera *camera, float x, float y);

#endif
