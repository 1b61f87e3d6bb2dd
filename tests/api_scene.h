// api_scene.h: a small scene with one of everything, and how a refused call is checked.
//
// A header of inline functions: each test that includes it uses some of them.

#ifndef PERCALE_API_SCENE_H
#define PERCALE_API_SCENE_H

#include "testing.h"

#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s

// ---- the scene ----

typedef struct Log {
    int line_count;
    char last[512];
} Log;

static inline void keep_line(void *user, const char *text)
{
    Log *log = user;
    log->line_count++;
    (void)snprintf(log->last, sizeof(log->last), "%s", text);
}

/// A sheet above a box, with a second cloth, a pin and a seam.
typedef struct Scene {
    Log log;
    PercaleSolver *solver;
    PercaleMesh sheet, patch, box;
    PercaleCloth cloth, patch_cloth;
    PercaleObstacle obstacle;
    PercalePin pin;
    PercaleSeam seam;
} Scene;

static inline PercaleResult pin_vertex(Scene *scene, uint32_t vertex, const float *target, PercalePin *pin)
{
    PercalePinDef def = percale_pin_def_default();
    def.cloth = scene->cloth;
    def.vertices = &vertex;
    def.vertex_count = 1;
    def.targets = target;
    return percale_pin_add(scene->solver, &def, pin);
}

static inline PercaleResult sew(Scene *scene, PercaleCloth b, uint32_t vertex_a, uint32_t vertex_b,
                                PercaleSeam *seam)
{
    PercaleSeamDef def = percale_seam_def_default();
    def.cloth_a = scene->cloth;
    def.cloth_b = b;
    def.vertices_a = &vertex_a;
    def.vertices_b = &vertex_b;
    def.pair_count = 1;
    return percale_seam_add(scene->solver, &def, seam);
}

static inline Scene *create(void)
{
    Scene *scene = calloc(1, sizeof(*scene));
    ck_assert_ptr_nonnull(scene);
    PercaleSolverDef def = percale_solver_def_default();
    def.log = keep_line;
    def.log_user = &scene->log;
    def.substeps = 5;
    scene->solver = percale_test_solver(def);
    scene->sheet = percale_test_sheet(8, 0.3f);
    percale_test_translate(&scene->sheet, 0.0f, 0.01f, 0.0f);
    scene->patch = percale_test_sheet(4, 0.1f);
    percale_test_translate(&scene->patch, 0.25f, 0.01f, 0.0f);
    scene->box = percale_test_box(1.0f, 1.0f, 1.0f);
    percale_test_translate(&scene->box, 0.0f, -0.5f, 0.0f);
    scene->cloth = percale_test_add_cloth(scene->solver, &scene->sheet);
    scene->patch_cloth = percale_test_add_cloth(scene->solver, &scene->patch);
    scene->obstacle = percale_test_add_obstacle(scene->solver, &scene->box);
    PERCALE_TEST_OK(scene->solver, pin_vertex(scene, 3, NULL, &scene->pin));
    PERCALE_TEST_OK(scene->solver, sew(scene, scene->patch_cloth, 63, 0, &scene->seam));
    return scene;
}

static inline void destroy(Scene *scene)
{
    percale_solver_destroy(scene->solver);
    percale_mesh_free(&scene->sheet);
    percale_mesh_free(&scene->patch);
    percale_mesh_free(&scene->box);
    free(scene);
}

static inline void run(PercaleSolver *solver, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
    }
}

/// The call has failed as expected: it named the culprit, in the log too, and nothing has changed.
#define PERCALE_REFUSED(SCENE, CALL, EXPECTED, CULPRIT)                                              \
    do {                                                                                             \
        uint64_t hash_before = percale_solver_hash((SCENE)->solver);                                 \
        int lines_before = (SCENE)->log.line_count;                                                  \
        PercaleResult result = (CALL);                                                               \
        expect_refusal((SCENE), result, (EXPECTED), (CULPRIT), lines_before, hash_before, __LINE__); \
    } while (0)

static inline void expect_refusal(Scene *scene, PercaleResult result, PercaleResult expected,
                                  const char *culprit, int lines_before, uint64_t hash_before, int line)
{
    const char *text = percale_solver_last_error(scene->solver);
    ck_assert_msg(result == expected, "line %d: %s, not %s (%s)", line, percale_result_string(result),
                  percale_result_string(expected), text);
    ck_assert_msg(strstr(text, culprit) != NULL, "line %d: '%s' does not name '%s'", line, text, culprit);
    ck_assert_msg(strcmp(text, scene->log.last) == 0 && scene->log.line_count == lines_before + 1,
                  "line %d: not logged once: '%s', '%s'", line, text, scene->log.last);
    ck_assert_msg(percale_solver_hash(scene->solver) == hash_before, "line %d: the state has changed", line);
    PERCALE_TEST_OK(scene->solver, percale_solver_validate(scene->solver));
}

#endif
