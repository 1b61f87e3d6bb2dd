// trace_crossings.h: where traces of contours cross each other on a triangle: there three layers meet.
//
//   in   contours
//   out  their kinds, Cross or Eight where a trace is crossed

#ifndef PERCALE_TRACE_CROSSINGS_H
#define PERCALE_TRACE_CROSSINGS_H

#include "untangle/contours.h"

/// False without memory.
bool percale_mark_trace_crossings(PercaleContours *contours, const PercaleTangleMesh *mesh,
                                  const PercaleTangleCrossings *crossings, const f32x4 *x,
                                  PercaleMemory *memory);

#endif
