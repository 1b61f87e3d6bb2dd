// contours.h: crossings chained into the curves along which surfaces go through each other.
//
//   in   crossings
//   out  contours: each a row of crossings, with what is left and right of each of its two traces
//
// Two triangles that cross share a straight piece, which begins and ends at a crossing; each crossing ends
// the pieces of its face with the two triangles at its edge. So pieces chain. A contour leaves a *trace* on
// each of the two surfaces that it joins; on one surface that goes through itself both are on it. Its end is,
// on either trace, at a boundary (B), in the surface's interior, where the other's boundary pierces it (I),
// or at a loop vertex (L), which the two triangles share.

#ifndef PERCALE_CONTOURS_H
#define PERCALE_CONTOURS_H

#include "untangle/crossings.h"

/// Ends as in Wicke et al. 2006, "Untangling cloth with boundaries".
typedef enum PercaleContourKind {
    CONTOUR_CLOSED = 0,
    CONTOUR_BBII,  // one trace from boundary to boundary, the other is a slit
    CONTOUR_BIBI,  // each trace begins at a boundary and ends inside
    CONTOUR_BLI,   // one end is a loop vertex
    CONTOUR_LL,    // both are
    CONTOUR_CROSS, // a trace is crossed by another trace: three layers meet
    CONTOUR_EIGHT, // a trace crosses itself, or both traces are one curve
    CONTOUR_KINDS
} PercaleContourKind;

/// One crossing of a contour, in its order.
typedef struct PercaleContourStep {
    uint32_t crossing;
    uint32_t trace;         // whose surface the edge belongs to: 0 or 1; the face belongs to the other
    uint32_t before, after; // triangle of that trace on either side of the edge; NO_INDEX at a boundary
    uint32_t left;          // 0 or 1: which end of the edge is left of the trace as it goes
} PercaleContourStep;

typedef struct PercaleContour {
    uint32_t first, count; // steps
    bool is_closed;
    bool is_joined;        // closed, but only when gone round twice: both traces are one curve
    char ends[2][2];       // of each trace, where it begins and where it ends: B, I or L; 0 when closed
    uint32_t triangles[2]; // of each trace, before the first step
    PercaleContourKind kind;
    uint32_t pair_count; // its pieces whose triangles share no point
    double length;       // m
} PercaleContour;

/// A piece of a contour: two triangles and the one or two crossings where it ends.
typedef struct PercaleContourPiece {
    uint32_t triangles[2]; // the smaller first
    uint32_t crossings[2]; // NO_INDEX: at a point that the triangles share
    uint32_t contour;      // NO_INDEX: not yet in one
    uint32_t first_trace;  // of its contour: the one on triangles[0]
} PercaleContourPiece;

typedef struct PercaleContours {
    PercaleContour *items;
    size_t count, capacity;
    PercaleContourStep *steps;
    size_t step_count, step_capacity;
    PercaleContourPiece *pieces;
    size_t piece_count, piece_capacity;
    uint32_t pair_count;      // pieces of triangles that share no point: what the audit counts
    uint32_t (*pieces_of)[2]; // [crossings] pieces that end there; NO_INDEX: none
    size_t pieces_of_capacity;
    void *sorting; // scratch
    size_t sorting_capacity;
} PercaleContours;

/// Replaces the contours. False without memory.
bool percale_contours_build(PercaleContours *contours, const PercaleTangleMesh *mesh,
                            const PercaleTangleCrossings *crossings, const f32x4 *x, PercaleMemory *memory);
void percale_contours_free(PercaleContours *contours, PercaleMemory *memory);

/// Whether both traces end in one point, and so are one curve on one surface: it turns back there.
static inline bool is_folded(const PercaleContour *contour)
{
    return contour->ends[0][0] == 'L' || contour->ends[0][1] == 'L';
}

/// The point that both traces end in at the contour's first (end 0) or last step; NO_INDEX: none.
uint32_t percale_loop_vertex(const PercaleContours *contours, const PercaleTangleMesh *mesh,
                             const PercaleContour *contour, uint32_t end);

/// Where a piece ends: at a crossing, or at the point that its triangles share.
Vec3 percale_piece_end(const PercaleTangleMesh *mesh, const PercaleTangleCrossings *crossings, const f32x4 *x,
                       const PercaleContourPiece *piece, uint32_t end);

/// Sum of their lengths, m.
double percale_contours_length(const PercaleContours *contours);

const char *percale_contour_kind_name(PercaleContourKind kind);

#endif
