// bench_scene_run.h: one repetition of a scene: built anew, stepped, judged.
//
//   in   a named configuration, its size, the flags' preset, settings and frames
//   out  ms per frame (median over the frames after the first), stages, work, quality, state hash
//
// Only percale_solver_step is timed: moving the obstacles and judging the end are not.

#ifndef PERCALE_BENCH_SCENE_RUN_H
#define PERCALE_BENCH_SCENE_RUN_H

#include "bench_entry.h"
#include "bench_progress.h"

/// Can the scene be opened, and has it all the settings that the flags make?
bool bench_scene_check(const BenchEntry *entry, const BenchFlags *flags, PercaleSceneError *error);

/// A failure is noted in the result.
void bench_scene_run(const BenchEntry *entry, const BenchFlags *flags, BenchProgress *progress,
                     BenchResult *result);

#endif
