// run_picture.h: a picture of the scene as it is now, its cloths coloured by what is wrong with them.
//
//   in   a built scene and its solver
//   out  a PNG file

#ifndef PERCALE_RUN_PICTURE_H
#define PERCALE_RUN_PICTURE_H

#include "percale/scene.h"

typedef enum PercaleHeat {
    PERCALE_HEAT_NONE,
    PERCALE_HEAT_STRETCH,    ///< largest |l / l0 - 1| of a vertex's edges, 0..10 %
    PERCALE_HEAT_PENETRATION ///< depth below the obstacles' surfaces, 0..2 mm
} PercaleHeat;

bool percale_run_picture(const char *path, const PercaleScene *scene, PercaleSolver *solver, PercaleHeat heat,
                         PercaleSceneError *error);

#endif
