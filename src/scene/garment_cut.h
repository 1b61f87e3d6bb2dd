// garment_cut.h: how the garments differ: a dress, a jacket over it, a coat over both.
//
// One field is the surface of them all (garment_surface.h); a cut says how wide and how long. A cut that has
// at least the flare of another lies outside it everywhere, and so do its folds if the flare has room for
// the other's.

#ifndef PERCALE_GARMENT_CUT_H
#define PERCALE_GARMENT_CUT_H

#include "garment_grid.h"

typedef struct PercaleGarmentCut {
    const char *name;
    uint64_t smallest;       ///< vertices; fewer cannot follow the armholes
    uint64_t smooth;         ///< vertices; with fewer it cuts the corners of the body, with more not
    PercaleGarmentGrid grid; ///< the one that the shape is made on; its proportions give nearly square cells
    double hem;              ///< m, height over the floor
    double flare;            ///< radius gained per metre downwards, below the waist
    double fold_depth;       ///< m from valley to crest at the hem
    double cuff;             ///< m from the shoulder along the arm
} PercaleGarmentCut;

extern const PercaleGarmentCut percale_dress_cut;
extern const PercaleGarmentCut percale_jacket_cut;
extern const PercaleGarmentCut percale_coat_cut;

#endif
