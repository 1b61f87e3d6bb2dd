#include "bench_progress.h"

#include "base/timer.h"

#include <stdio.h>
#include <unistd.h>

static const double REDRAW = 0.1;            // s between two drawings
static const char CLEAR_LINE[] = "\r\033[K"; // to the line's start, erase to its end (ECMA-48)

BenchProgress bench_progress_start(size_t run_count)
{
    return (BenchProgress){.visible = isatty(STDERR_FILENO) != 0, .run_count = run_count};
}

void bench_progress_run(BenchProgress *progress, const char *name)
{
    ++progress->run;
    progress->name = name;
    if (progress->visible) {
        (void)fprintf(stderr, "%s[%zu of %zu] %s", CLEAR_LINE, progress->run, progress->run_count, name);
        (void)fflush(stderr);
    }
}

void bench_progress_frame(BenchProgress *progress, uint32_t frame, uint32_t frame_count)
{
    double now = percale_seconds();
    if (!progress->visible || now - progress->shown < REDRAW) {
        return;
    }
    progress->shown = now;
    (void)fprintf(stderr, "%s[%zu of %zu] %s: frame %u of %u", CLEAR_LINE, progress->run, progress->run_count,
                  progress->name, (unsigned)frame, (unsigned)frame_count);
    (void)fflush(stderr);
}

void bench_progress_clear(const BenchProgress *progress)
{
    if (progress->visible) {
        (void)fputs(CLEAR_LINE, stderr);
        (void)fflush(stderr);
    }
}
