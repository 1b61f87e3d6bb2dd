// progress.h: a progress bar on stderr, only where stderr is a terminal.
//
//   in   the frame that has just been done, its time
//   out  one line that rewrites itself: frame k of n, ms per frame, time left

#ifndef PERCALE_PROGRESS_H
#define PERCALE_PROGRESS_H

#include <stdbool.h>
#include <stdint.h>

typedef struct PercaleProgress {
    bool visible;
    uint32_t frame_count;
    double start; ///< s, of a monotonic clock
    double shown; ///< s; when the line was last drawn
} PercaleProgress;

PercaleProgress percale_progress_start(uint32_t frame_count, bool quiet);
void percale_progress_show(PercaleProgress *progress, uint32_t frame, double frame_ms);
/// Clears the line.
void percale_progress_end(PercaleProgress *progress);

#endif
