// dress_shape.h: the surface that the dress is cut from, the same at every resolution.
//
//   in   the distance to keep from the skin
//   out  points of a trunk tube with two armholes and of two sleeves, by grid coordinates
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

#ifndef PERCALE_DRESS_SHAPE_H
#define PERCALE_DRESS_SHAPE_H

#include <stdbool.h>
#include <stdint.h>

/// How many grid cells each part has.
typedef struct PercaleDressGrid {
    uint32_t side;   ///< columns from a side seam to the armhole's edge, a quarter of what is left out
    uint32_t face;   ///< columns from armhole to armhole, in front as behind
    uint32_t below;  ///< rows from the hem to the armhole
    uint32_t hole;   ///< rows beside the armhole
    uint32_t yoke;   ///< rows from the armhole to the neck
    uint32_t sleeve; ///< rows from the armhole to the cuff
} PercaleDressGrid;

typedef struct PercaleDressShape PercaleDressShape;

/// The grid that the shape is stored on: its proportions give nearly square cells.
PercaleDressGrid percale_dress_shape_grid(void);

uint32_t percale_dress_columns(PercaleDressGrid grid); ///< round the body
uint32_t percale_dress_rows(PercaleDressGrid grid);    ///< hem to neck
uint32_t percale_dress_rim(PercaleDressGrid grid);     ///< round an armhole

/// The trunk's grid point on an armhole's rim: `step` counts from the underarm over the front, 0..rim; the
/// front of the right armhole runs against the columns. side: 0 left, 1 right.
void percale_dress_rim_point(PercaleDressGrid grid, int side, uint32_t step, uint32_t *row, uint32_t *column);

/// Whether the cell above row and right of column is left out for an armhole.
bool percale_dress_in_armhole(PercaleDressGrid grid, uint32_t row, uint32_t column);

/// clearance: m between the skin and the dress where it fits tightly. NULL without memory.
PercaleDressShape *percale_dress_shape_make(double clearance);
void percale_dress_shape_free(PercaleDressShape *shape); ///< NULL is allowed

/// A grid point of the trunk, or of a sleeve (side: 0 left, 1 right), of a grid of any fineness, m.
void percale_dress_trunk_point(const PercaleDressShape *shape, PercaleDressGrid grid, uint32_t row,
                               uint32_t column, double point[3]);
void percale_dress_sleeve_point(const PercaleDressShape *shape, PercaleDressGrid grid, int side, uint32_t row,
                                uint32_t step, double point[3]);

#endif
