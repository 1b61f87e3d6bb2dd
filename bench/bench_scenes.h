// bench_scenes.h: the named configurations of the built-in scenes that are measured. The tests run the same
// ones.

#ifndef PERCALE_BENCH_SCENES_H
#define PERCALE_BENCH_SCENES_H

#include "percale/scene.h"

typedef struct BenchScene {
    const char *name;            ///< of the entry
    const char *scene;           ///< built-in
    const uint64_t *sizes;       ///< cloth vertices, 0 ends
    uint32_t frames;             ///< of a run
    const char *const *settings; ///< key, value, key, value, ..., NULL
} BenchScene;

/// NULL past the last.
const BenchScene *bench_scene(uint32_t index);

/// Opens the scene with its settings made; later percale_scene_set calls win.
PercaleScene *bench_scene_open(const BenchScene *scene, uint64_t size, PercaleSceneError *error);

#endif
