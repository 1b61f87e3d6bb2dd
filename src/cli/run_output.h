// run_output.h: writes every cloth's motion into a folder.
//
//   in   a built scene, its solver after each frame
//   out  <cloth>.pc2 with a sample per frame and the start, and <cloth>.obj, the start mesh; or
//        <cloth>_%04d.obj, one per frame and the start
//
// Positions are written in the world: relative ones plus the scene's origin.

#ifndef PERCALE_RUN_OUTPUT_H
#define PERCALE_RUN_OUTPUT_H

#include "percale/scene.h"

typedef struct PercaleRunOutput {
    const PercaleScene *scene;
    const char *folder;
    bool as_obj;
    uint32_t cloth_count;
    PercalePc2Writer **writers; ///< [cloth_count]; NULL for OBJ
    float *positions;           ///< [3 * vertices of the largest cloth]
    double origin[3];           ///< m
} PercaleRunOutput;

/// Are all cloths' names good for files, and different? Creates nothing.
bool percale_run_output_check(const PercaleScene *scene, PercaleSceneError *error);

/// Makes the folder and opens the files under temporary names. On failure there is nothing to close.
bool percale_run_output_open(PercaleRunOutput *output, const PercaleScene *scene, const char *folder,
                             bool as_obj, uint32_t sample_count, PercaleSceneError *error);
/// Adds the solver's state as frame `frame` (0: the start).
bool percale_run_output_add(PercaleRunOutput *output, PercaleSolver *solver, uint32_t frame,
                            PercaleSceneError *error);
/// Renames the point caches and writes the meshes when every sample has come; else removes what is
/// unfinished.
bool percale_run_output_close(PercaleRunOutput *output, bool complete, PercaleSceneError *error);

#endif
