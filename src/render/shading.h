// shading.h: the light that one sample of the picture sees.
//
//   in   the rays' scene, the ray's start and direction, its place in the picture
//   out  a linear RGB colour
//
// One soft key light, a sky that lights from everywhere (shadow rays into a few directions), and a floor
// under the lowest point that shows nothing but shadow.

#ifndef PERCALE_SHADING_H
#define PERCALE_SHADING_H

#include "render/ray_scene.h"

typedef struct PercaleStudio {
    const PercaleRayScene *scene;
    PercaleVec3 center;            ///< m; middle of the scene on the floor
    float radius;                  ///< m; half the scene's diagonal
    float offset;                  ///< m; secondary rays start this far off a surface
    PercaleVec3 key_light;         ///< unit, towards the light
    PercaleVec3 key_right, key_up; ///< span the light's disc
} PercaleStudio;

/// One sample of one pixel.
typedef struct PercaleSample {
    PercaleVec3 start, direction;
    float height;   ///< of the place in the picture: 0 bottom, 1 top
    uint32_t pixel; ///< number of the pixel; neighbours get unlike rotations
    uint32_t index; ///< of the sample in its pixel
} PercaleSample;

/// `right` is the camera's: the key light comes from the left and above.
PercaleStudio percale_studio_create(const PercaleRayScene *scene, PercaleVec3 right, PercaleVec3 forward);
PercaleVec3 percale_studio_shade(const PercaleStudio *studio, const PercaleSample *sample);

#endif
