// coloring.h: splits constraints into colours, so that no two of a colour move the same vertex.
//
//   in   vertices of each constraint, the weights they carry in it, inverse masses of the points
//   out  constraints sorted by colour, inside a colour in their old order
//
// Greedy first fit with one 64-bit mask per vertex, in the order of the constraints, which makes the result
// independent of threads. Those that wait choose after the others, whose colours so don't depend on them. A
// vertex that can't move (inverse mass 0) or carries no weight takes no part, if the kernel leaves it alone.
//
// What doesn't fit into the 64 colours of a mask is coloured again, in a further round of 64, as if the masks
// were longer; only a pile of sheets pressed together needs that, and only it pays. What is left after all
// rounds goes to a remainder that is solved on one thread, and is counted.

#ifndef PERCALE_COLORING_H
#define PERCALE_COLORING_H

#include "base/memory.h"
#include "base/simd.h"

enum {
    COLORS_OF_ROUND = 64, // bits of a mask
    ROUNDS_MAX = 16,      // colours of more constraints on one vertex than that would hold few of them
    COLORS_MAX = ROUNDS_MAX * COLORS_OF_ROUND
};

typedef struct PercaleColoring {
    uint32_t color_count;
    uint32_t first[COLORS_MAX + 1]; // [color_count + 1]; order[first[c]] .. order[first[c + 1]] have colour c
    uint32_t count;                 // all constraints; order[first[color_count]] .. is the remainder
    uint32_t *order;                // [count] constraint indices
    size_t order_capacity;
    uint16_t *color_of; // scratch
    size_t color_of_capacity;
    uint64_t *used; // [point_count] scratch, all zero between calls
    size_t used_capacity;
} PercaleColoring;

/// The constraints to colour. Strides are in elements from one constraint to the next.
typedef struct PercaleConstraints {
    const uint32_t *vertices; // arity of them per constraint
    size_t vertex_stride;
    const float *weights; // NULL: all non-zero
    size_t weight_stride;
    uint32_t arity;
    uint32_t count;
    bool all_take_part;   // also vertices that can't move: for kernels that write every vertex
    const uint8_t *waits; // [count] those that choose after the others; NULL: none
} PercaleConstraints;

/// points[v][3] is the inverse mass; NULL where all take part. False without memory.
bool percale_coloring_run(PercaleColoring *coloring, PercaleMemory *memory,
                          const PercaleConstraints *constraints, const f32x4 *points, uint32_t point_count);
void percale_coloring_free(PercaleColoring *coloring, PercaleMemory *memory);

#endif
