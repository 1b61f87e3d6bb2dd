#include "bench_scenes.h"

static const uint64_t drape_sizes[] = {16384, 65536, 262144, 1048576, 0};
static const uint64_t small_sizes[] = {16384, 0};
static const uint64_t dress_sizes[] = {20000, 0};
static const uint64_t flag_sizes[] = {9600, 0};
static const uint64_t dense_sizes[] = {10000, 0};

static const char *const hang_settings[] = {"hang",     "2",  "obstacle",   "off", "self", "off",
                                            "substeps", "20", "iterations", "1",   NULL};
static const char *const obstacle_settings[] = {"self", "off", "substeps", "20", "iterations", "1", NULL};
// As many substeps as bring the 99th percentile of stretch below 1 %.
static const char *const hang_tight_settings[] = {"hang", "2",        "obstacle", "off", "self",
                                                  "off",  "substeps", "120",      NULL};
static const char *const obstacle_tight_settings[] = {"self", "off",    "ee", "off", "substeps",
                                                      "100",  "passes", "4",  NULL};
static const char *const no_settings[] = {NULL};

const BenchScene *bench_scene(uint32_t index)
{
    static const BenchScene scenes[] = {
        {"drape_hang", "drape", drape_sizes, 120, hang_settings},
        {"drape_obstacle", "drape", drape_sizes, 120, obstacle_settings},
        {"drape_hang_tight", "drape", small_sizes, 120, hang_tight_settings},
        {"drape_obstacle_tight", "drape", small_sizes, 120, obstacle_tight_settings},
        {"dress", "dress", dress_sizes, 120, no_settings},
        {"flag", "flag", flag_sizes, 240, no_settings},
        {"funnel", "funnel", dense_sizes, 240, no_settings},
        {"twist", "twist", dense_sizes, 240, no_settings},
        {"cards", "cards", dense_sizes, 120, no_settings},
    };
    return index < sizeof scenes / sizeof scenes[0] ? &scenes[index] : NULL;
}

PercaleScene *bench_scene_open(const BenchScene *scene, uint64_t size, PercaleSceneError *error)
{
    PercaleScene *opened = percale_scene_open(scene->scene, size, error);
    bool done = opened != NULL;
    for (const char *const *pair = scene->settings; done && *pair != NULL; pair += 2) {
        done = percale_scene_set(opened, pair[0], pair[1], error);
    }
    if (!done) {
        percale_scene_close(opened);
        return NULL;
    }
    return opened;
}
