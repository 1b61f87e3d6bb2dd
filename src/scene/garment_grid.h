// garment_grid.h: the grids that a garment with sleeves is cut from.
//
//   in   how many cells its parts have
//   out  rows and columns, where the armholes are
//
// The trunk is a grid: columns run round the body from the left side seam over the front, the right side seam
// and the back; rows run from the hem up to the neckline. An armhole is a rectangle left out of the grid
// around each side seam. A sleeve is a grid as well: columns run round the arm from the underarm over the
// front and the top, rows from the armhole to the cuff. Its column count is that of the armhole's rim.
//
//        neck  +----+--------+----+----+--------+----+
//        yoke  |    |        |    |    |        |    |
//              +----+        +----+----+        +----+
//        hole        | front |         |  back  |
//              +----+        +----+----+        +----+
//        below |    |        |    |    |        |    |
//        hem   +----+--------+----+----+--------+----+
//              side   face   side side   face   side

#ifndef PERCALE_GARMENT_GRID_H
#define PERCALE_GARMENT_GRID_H

#include <stdbool.h>
#include <stdint.h>

/// How many grid cells each part has.
typedef struct PercaleGarmentGrid {
    uint32_t side;   ///< columns from a side seam to the armhole's edge, a quarter of what is left out
    uint32_t face;   ///< columns from armhole to armhole, in front as behind
    uint32_t below;  ///< rows from the hem to the armhole
    uint32_t hole;   ///< rows beside the armhole
    uint32_t yoke;   ///< rows from the armhole to the neck
    uint32_t sleeve; ///< rows from the armhole to the cuff
} PercaleGarmentGrid;

uint32_t percale_garment_columns(PercaleGarmentGrid grid); ///< round the body
uint32_t percale_garment_rows(PercaleGarmentGrid grid);    ///< hem to neck
uint32_t percale_garment_rim(PercaleGarmentGrid grid);     ///< round an armhole

/// The trunk's grid point on an armhole's rim: `step` counts from the underarm over the front, 0..rim; the
/// front of the right armhole runs against the columns. side: 0 left, 1 right.
void percale_garment_rim_point(PercaleGarmentGrid grid, int side, uint32_t step, uint32_t *row,
                               uint32_t *column);

/// Whether the cell above row and right of column is left out for an armhole.
bool percale_garment_in_armhole(PercaleGarmentGrid grid, uint32_t row, uint32_t column);

/// Whether a trunk's grid point is off the rims of the armholes, the hem and the neckline.
bool percale_garment_is_loose(PercaleGarmentGrid grid, uint32_t row, uint32_t column);

/// Where an index of one grid falls on another: at `index`, and so far towards the next.
typedef struct PercaleGarmentPlace {
    uint32_t index;
    double share; ///< 0..1
} PercaleGarmentPlace;

/// Where grid points of a fine grid fall on a coarse one.
PercaleGarmentPlace percale_garment_row_place(uint32_t row, PercaleGarmentGrid fine,
                                              PercaleGarmentGrid coarse);
PercaleGarmentPlace percale_garment_column_place(uint32_t column, PercaleGarmentGrid fine,
                                                 PercaleGarmentGrid coarse);
PercaleGarmentPlace percale_garment_sleeve_row_place(uint32_t row, PercaleGarmentGrid fine,
                                                     PercaleGarmentGrid coarse);
PercaleGarmentPlace percale_garment_rim_place(uint32_t step, PercaleGarmentGrid fine,
                                              PercaleGarmentGrid coarse);

#endif
