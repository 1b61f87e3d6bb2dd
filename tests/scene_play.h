// scene_play.h: a built-in scene opened, built and stepped by a test. Every function fails the running test
// when it can't do its work.

#ifndef PERCALE_SCENE_PLAY_H
#define PERCALE_SCENE_PLAY_H

#include "percale/scene.h"
#include "scene/scene_model.h"
#include "testing.h"

#include <stdlib.h>

/// A scene that is open, and its solver once it is built.
typedef struct Play {
    PercaleScene *scene;
    PercaleSolver *solver;
    uint32_t frame;
} Play;

static inline Play open_play(const char *name, uint64_t size)
{
    PercaleSceneError error = {""};
    Play play = {percale_scene_open(name, size, &error), NULL, 0};
    ck_assert_msg(play.scene != NULL, "%s", error.text);
    return play;
}

static inline void set(Play *play, const char *key, const char *value)
{
    PercaleSceneError error = {""};
    ck_assert_msg(percale_scene_set(play->scene, key, value, &error), "%s", error.text);
}

static inline void build(Play *play, int thread_count)
{
    PercaleSceneError error = {""};
    play->solver = percale_scene_build(play->scene, thread_count, &error);
    ck_assert_msg(play->solver != NULL, "%s", error.text);
}

static inline void run_frame(Play *play)
{
    PercaleSceneError error = {""};
    const double seconds = 1.0 / percale_scene_frame_rate(play->scene);
    ck_assert_msg(percale_scene_move(play->scene, play->solver, ++play->frame, &error), "%s", error.text);
    PERCALE_TEST_OK(play->solver, percale_solver_step(play->solver, seconds));
}

static inline void run_frames(Play *play, uint32_t count)
{
    for (uint32_t k = 0; k < count; ++k) {
        run_frame(play);
    }
}

static inline void close_play(Play *play)
{
    percale_solver_destroy(play->solver);
    percale_scene_close(play->scene);
}

static inline PercaleQuality judge(const Play *play)
{
    PercaleQuality quality;
    PERCALE_TEST_OK(play->solver, percale_solver_quality(play->solver, &quality));
    return quality;
}

static inline uint32_t count_vertices(const Play *play)
{
    uint32_t count = 0;
    for (uint32_t k = 0; k < percale_scene_cloth_count(play->scene); ++k) {
        count += percale_scene_cloth(play->scene, k).vertex_count;
    }
    return count;
}

/// Where a cloth is now; the caller's to free.
static inline float *positions_of(const Play *play, uint32_t cloth)
{
    const PercaleSceneObject object = percale_scene_cloth(play->scene, cloth);
    float *positions = calloc(3 * (size_t)object.vertex_count, sizeof *positions);
    ck_assert_ptr_nonnull(positions);
    PERCALE_TEST_OK(play->solver, percale_cloth_get_positions(play->solver, object.cloth, positions, 0));
    return positions;
}

#endif
