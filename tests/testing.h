// testing.h: what the tests share: small meshes, random numbers, calls that have to succeed.
//
// Meshes are PercaleMesh of scene.h, centred on the origin, in metres, free with percale_mesh_free. Every
// function here fails the running test when it can't do its work.

#ifndef PERCALE_TESTING_H
#define PERCALE_TESTING_H

#include "percale/scene.h"

#include <check.h>

/// 1 where code runs some ten times slower: tests then take smaller scenes.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define PERCALE_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define PERCALE_SANITIZED 1
#endif
#endif
#ifndef PERCALE_SANITIZED
#define PERCALE_SANITIZED 0
#endif

// Tags of test cases (tcase_set_tags), where the time matters: the presets avx2, clang and tsan leave some
// out (CK_EXCLUDE_TAGS). A case without a tag runs in every build.

#define PERCALE_ONE_THREAD "one_thread" // no other thread runs: there is no race to find
#define PERCALE_ANY_ENGINE "any_engine" // sees the solver from outside: test_engines says that all are one

/// Fails the test, with the solver's own words, unless `call` returns PERCALE_OK. SOLVER may be NULL.
#define PERCALE_TEST_OK(SOLVER, CALL) percale_test_expect((SOLVER), (CALL), #CALL, __FILE__, __LINE__)

void percale_test_expect(const PercaleSolver *solver, PercaleResult result, const char *call,
                         const char *file, int line);

/// Runs the suite (CK_ENV decides how much is printed) and returns main's exit code; frees the suite.
int percale_test_run(Suite *suite);

/// Uniform in [0, 1); the state is the seed and must not be 0. The same on every machine.
double percale_test_random(uint64_t *state);

// ---- meshes ----

/// Level square sheet of side_count x side_count vertices at y = 0, row by row along x; its triangles face
/// up.
PercaleMesh percale_test_sheet(uint32_t side_count, float width);
/// Closed box of 8 vertices and 12 triangles, facing outwards.
PercaleMesh percale_test_box(float width_x, float width_y, float width_z);
/// Icosahedron whose triangles are split in four `level` times (20 * 4^level of them), facing outwards.
PercaleMesh percale_test_sphere(uint32_t level, float radius);
void percale_test_translate(PercaleMesh *mesh, float x, float y, float z);

// ---- scenes ----

/// Def of a cloth or obstacle with the mesh's arrays and defaults else; the mesh must outlive the Def.
PercaleClothDef percale_test_cloth_def(const PercaleMesh *mesh);
PercaleObstacleDef percale_test_obstacle_def(const PercaleMesh *mesh);

PercaleSolver *percale_test_solver(PercaleSolverDef def);
PercaleCloth percale_test_add_cloth(PercaleSolver *solver, const PercaleMesh *mesh);
PercaleObstacle percale_test_add_obstacle(PercaleSolver *solver, const PercaleMesh *mesh);

#endif
