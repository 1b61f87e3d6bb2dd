// flat.h: where an obstacle is so flat that the cloth's vertices keep all the rest of the cloth away from it.
//
//   in   a surface that keeps its shape, the length of the cloth's edges
//   out  its vertices and edges that no edge or face of the cloth can come near, as long as all the vertices
//        keep away from it
//
// Between corners that lie on the surface, at most a length apart, an edge or a face goes below a point of it
// by no more than it falls off there within half that length; or by a quarter of what it falls off farther
// away (MATH.md, section 7, rule 1).

#ifndef PERCALE_FLAT_H
#define PERCALE_FLAT_H

#include "model/model.h"

typedef struct PercaleFlat {
    uint8_t *vertices; // [vertex_count] 1: flat
    uint8_t *edges;    // [edge_count] 1: flat
    float low;         // m; what has all its corners farther away than this is kept away
    float length;      // m; if it is no longer than this; else as often as far as it is as long, squared
} PercaleFlat;

/// length: m, of the cloth's edges. drop: m, by which they may go deeper than their vertices. False without
/// memory; to be freed even then.
bool percale_flat_find(const PercaleModelSurface *surface, const f32x4 *x, double length, double drop,
                       PercaleFlat *flat, PercaleMemory *memory);
void percale_flat_free(PercaleFlat *flat, PercaleMemory *memory);

#endif
