// tangle_cases.h: a seeded set of tangles. The benchmark counts how many come apart; the tests take the seven
// standard ones.
//
// Five kinds: the seven standard cases of Wicke et al. 2006 at three depths and two resolutions, a garment
// pushed into a body, two layers swapped over a part of their area, a fold of a sheet pushed through the
// sheet, crumpled sheets put into each other. The same on every machine, up to the C library's sine and
// exponential.

#ifndef PERCALE_TANGLE_CASES_H
#define PERCALE_TANGLE_CASES_H

#include "percale/scene.h"

enum { TANGLE_CLOTHS_MAX = 3, TANGLE_STANDARD = 7, TANGLE_DEPTHS = 3, TANGLE_RESOLUTIONS = 2 };

typedef enum TangleKind {
    TANGLE_KIND_STANDARD = 0,
    TANGLE_KIND_BODY,
    TANGLE_KIND_LAYERS,
    TANGLE_KIND_FOLD,
    TANGLE_KIND_CRUMPLED,
    TANGLE_KINDS
} TangleKind;

typedef struct TangleCase {
    TangleKind kind;
    char name[64];
    PercaleMesh cloths[TANGLE_CLOTHS_MAX];
    uint32_t cloth_count;
    int32_t layers[TANGLE_CLOTHS_MAX];
    PercaleMesh body; ///< no vertices: none
    float thickness;  ///< m
    double edge;      ///< m, length of a typical edge
    double extent;    ///< m, how far the tangle reaches
} TangleCase;

uint32_t tangle_case_count(void);
const char *tangle_kind_name(TangleKind kind);

/// False without memory. Free with tangle_case_free.
bool tangle_case_make(uint32_t index, TangleCase *tangle);
/// Of the seven, 0 <= index < TANGLE_STANDARD.
const char *tangle_standard_name(uint32_t index);
/// One of the seven, named as in percale_contour_kind_name.
bool tangle_case_make_standard(const char *name, uint32_t depth, uint32_t resolution, TangleCase *tangle);
void tangle_case_free(TangleCase *tangle);

#endif
