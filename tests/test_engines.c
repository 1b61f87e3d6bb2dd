// One hash: for any number of threads and every instruction set that this machine and this build have, over
// the scenes that the benchmark measures.

#include "bench_scenes.h"
#include "engine.h"
#include "percale/scene.h"
#include "testing.h"

enum { SIZE = PERCALE_SANITIZED ? 1000 : 2500, FRAMES = PERCALE_SANITIZED ? 2 : 4 };

/// State hash after some frames of a scene that the benchmark measures, at a smaller size.
static uint64_t hash_of(const BenchScene *entry, const char *isa, int thread_count)
{
    PercaleSceneError error = {""};
    PercaleScene *scene = bench_scene_open(entry, SIZE, &error);
    ck_assert_msg(scene != NULL && percale_scene_set(scene, "isa", isa, &error), "%s", error.text);
    PercaleSolver *solver = percale_scene_build(scene, thread_count, &error);
    ck_assert_msg(solver != NULL, "%s", error.text);
    for (uint32_t frame = 1; frame <= FRAMES; frame++) {
        ck_assert_msg(percale_scene_move(scene, solver, frame, &error), "%s", error.text);
        PERCALE_TEST_OK(solver, percale_solver_step(solver, 1.0 / percale_scene_frame_rate(scene)));
    }
    uint64_t hash = percale_solver_hash(solver);
    percale_solver_destroy(solver);
    percale_scene_close(scene);
    return hash;
}

static void expect_hash(const BenchScene *entry, const char *isa, int thread_count, uint64_t expected)
{
    uint64_t hash = hash_of(entry, isa, thread_count);
    ck_assert_msg(hash == expected, "%s, %s, %d threads: %016lx instead of %016lx", entry->name, isa,
                  thread_count, (unsigned long)hash, (unsigned long)expected);
}

START_TEST(every_engine_and_thread_count_gives_one_hash)
{
    static const char *const ISAS[] = {NULL, "sse2", "avx2", "avx512"};
    static const int THREADS = 3; // of each engine; the widest has others, too
    const BenchScene *entry = bench_scene((uint32_t)_i);
    ck_assert_ptr_nonnull(entry);
    uint64_t expected = hash_of(entry, "auto", 1);
    expect_hash(entry, "auto", 2, expected);
    expect_hash(entry, "auto", 7, expected);
    for (PercaleIsa isa = PERCALE_ISA_SSE2; isa <= PERCALE_ISA_AVX512; isa++) {
        if (percale_engine_for(isa) != NULL) {
            expect_hash(entry, ISAS[isa], THREADS, expected);
        }
    }
}
END_TEST

START_TEST(the_solver_takes_the_engine_that_was_asked_for)
{
    for (PercaleIsa isa = PERCALE_ISA_SSE2; isa <= PERCALE_ISA_AVX512; isa++) {
        PercaleSolverDef def = percale_solver_def_default();
        PercaleSolver *solver;
        def.isa = isa;
        PercaleResult result = percale_solver_create(def, &solver);
        if (percale_engine_for(isa) == NULL) {
            ck_assert_int_eq(result, PERCALE_UNSUPPORTED);
            continue;
        }
        ck_assert_int_eq(result, PERCALE_OK);
        ck_assert_int_eq(percale_solver_isa(solver), isa);
        ck_assert_int_eq(percale_engine_for(isa)->isa, isa);
        percale_solver_destroy(solver);
    }
}
END_TEST

// Every table is another build of the pipeline: were two of them the same code, the test above would prove
// nothing.
START_TEST(every_engine_has_code_of_its_own)
{
    for (PercaleIsa a = PERCALE_ISA_SSE2; a <= PERCALE_ISA_AVX512; a++) {
        for (PercaleIsa b = PERCALE_ISA_SSE2; b < a; b++) {
            const PercaleEngine *one = percale_engine_for(a);
            const PercaleEngine *other = percale_engine_for(b);
            ck_assert(one == NULL || other == NULL || one->run_substeps != other->run_substeps);
        }
    }
}
END_TEST

int main(void)
{
    int scene_count = 0;
    while (bench_scene((uint32_t)scene_count) != NULL) {
        scene_count++;
    }
    Suite *suite = suite_create("engines");
    TCase *bits = tcase_create("bits");
    tcase_set_timeout(bits, 0); // a busy machine is slow
    tcase_add_loop_test(bits, every_engine_and_thread_count_gives_one_hash, 0, scene_count);
    suite_add_tcase(suite, bits);
    TCase *choice = tcase_create("choice");
    tcase_add_test(choice, the_solver_takes_the_engine_that_was_asked_for);
    tcase_add_test(choice, every_engine_has_code_of_its_own);
    suite_add_tcase(suite, choice);
    return percale_test_run(suite);
}
