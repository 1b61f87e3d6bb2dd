#include "cli/progress.h"

#include <stdio.h>
#include <time.h>
#include <unistd.h>

enum { BAR_WIDTH = 30 }; // characters

static const double REDRAW = 0.1;            // s between two drawings
static const char CLEAR_LINE[] = "\r\033[K"; // to the line's start, erase to its end (ECMA-48)

static double now(void)
{
    struct timespec time = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

PercaleProgress percale_progress_start(uint32_t frame_count, bool quiet)
{
    PercaleProgress progress = {.visible = !quiet && isatty(STDERR_FILENO) != 0, .frame_count = frame_count};
    progress.start = now();
    progress.shown = progress.start;
    return progress;
}

void percale_progress_show(PercaleProgress *progress, uint32_t frame, double frame_ms)
{
    double time = now();
    if (!progress->visible || time - progress->shown < REDRAW)
        return;
    progress->shown = time;
    char bar[BAR_WIDTH + 1] = "";
    uint32_t filled = (uint32_t)((uint64_t)BAR_WIDTH * frame / progress->frame_count);
    for (uint32_t place = 0; place < BAR_WIDTH; ++place)
        bar[place] = place < filled ? '#' : '.';
    double left = (time - progress->start) / (double)frame * (double)(progress->frame_count - frame);
    unsigned long seconds = (unsigned long)(left + 0.5);
    (void)fprintf(stderr, "%s[%s] frame %u of %u  %.1f ms/frame  %lu:%02lu left", CLEAR_LINE, bar,
                  (unsigned)frame, (unsigned)progress->frame_count, frame_ms, seconds / 60, seconds % 60);
    (void)fflush(stderr);
}

void percale_progress_end(PercaleProgress *progress)
{
    if (progress->visible)
        (void)fputs(CLEAR_LINE, stderr);
    progress->visible = false;
}
