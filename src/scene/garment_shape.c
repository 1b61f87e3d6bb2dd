// garment_shape.c: a coarse grid is laid on an offset of the body and evened out once; finer grids are read
// off it and put back onto the offset.

#include "garment_shape.h"

#include "body_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// m, in the body's coordinates.
static const double ARMHOLE_CENTER[3] = {0.152, 1.335, -0.014}; // in an upright plane across the arm
static const double NECK_CENTER[3] = {0, 1.456, -0.020};
static const double NECK_TILT = 0.325; // slope of the neckline towards the front,
static const double NECK_DIP = 0.500;  // and more of it, downwards in front as behind
static const double BUST_Y = 1.225;    // of the front and back middle at the height of the armhole's bottom
static const double TURN = 6.283185307179586;

static const int RELAXATIONS = 80;         // the first guess is good; only its corners must spread out
static const double RELAXATION_STEP = 0.7; // share of the way to the mean of the four neighbours
static const double ROUGHLY = 1e-4;        // m off the surface while points still slide

struct PercaleGarmentShape {
    PercaleGarmentSurface surface;
    PercaleGarmentGrid grid; ///< the cut's
    double *trunk;           ///< [rows + 1][columns][3] m
    double *sleeves[2];      ///< [sleeve + 1][rim][3] m
};

// ---- first guess ----

static double *trunk_point(const PercaleGarmentShape *shape, uint32_t row, uint32_t column)
{
    return shape->trunk + 3 * ((size_t)row * percale_garment_columns(shape->grid) + column);
}

static double *sleeve_point(const PercaleGarmentShape *shape, int side, uint32_t row, uint32_t step)
{
    return shape->sleeves[side] + 3 * ((size_t)row * percale_garment_rim(shape->grid) + step);
}

static void blend(const double from[3], const double to[3], double share, double point[3])
{
    for (int k = 0; k < 3; k++) {
        point[k] = from[k] + share * (to[k] - from[k]);
    }
}

static double distance_between(const double a[3], const double b[3])
{
    return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) +
                (a[2] - b[2]) * (a[2] - b[2]));
}

// The left rim: the curve where an upright plane through the shoulder cuts the surface, in equal steps of
// length, from the underarm over the front.
enum { CURVE_POINTS = 256 };

static void lay_rim(PercaleGarmentShape *shape)
{
    // Farther out on the arm, where the surface is farther out: else the trunk would hide the armpit.
    const double center[3] = {ARMHOLE_CENTER[0] + shape->surface.outwards, ARMHOLE_CENTER[1],
                              ARMHOLE_CENTER[2]};
    double curve[CURVE_POINTS + 1][3];
    double length[CURVE_POINTS + 1] = {0};
    for (int i = 0; i <= CURVE_POINTS; i++) {
        const double angle = TURN * (i % CURVE_POINTS) / CURVE_POINTS;
        const double direction[3] = {0.0, -cos(angle), sin(angle)};
        percale_garment_march_out(&shape->surface, center, direction, curve[i]);
        length[i] = i > 0 ? length[i - 1] + distance_between(curve[i - 1], curve[i]) : 0.0;
    }
    const uint32_t rim = percale_garment_rim(shape->grid);
    int after = 0;
    for (uint32_t step = 0; step < rim; step++) {
        const double along = length[CURVE_POINTS] * step / rim;
        while (length[after] <= along) {
            after++;
        }
        double point[3];
        blend(curve[after - 1], curve[after],
              (along - length[after - 1]) / (length[after] - length[after - 1]), point);
        for (int side = 0; side < 2; side++) {
            uint32_t row;
            uint32_t column;
            percale_garment_rim_point(shape->grid, side, step, &row, &column);
            const double mirrored[3] = {side ? -point[0] : point[0], point[1], point[2]};
            memcpy(trunk_point(shape, row, column), mirrored, sizeof mirrored);
            memcpy(sleeve_point(shape, side, 0, step), mirrored, sizeof mirrored);
        }
    }
}

static void column_direction(const PercaleGarmentShape *shape, uint32_t column, double direction[3])
{
    const double angle = TURN * column / percale_garment_columns(shape->grid);
    direction[0] = cos(angle);
    direction[1] = 0.0;
    direction[2] = sin(angle);
}

// A garment farther out lies higher on the shoulders.
static void lay_neckline(PercaleGarmentShape *shape)
{
    const double center[3] = {NECK_CENTER[0], NECK_CENTER[1] + shape->surface.outwards, NECK_CENTER[2]};
    for (uint32_t column = 0; column < percale_garment_columns(shape->grid); column++) {
        double direction[3];
        column_direction(shape, column, direction);
        direction[1] = -direction[2] * (NECK_TILT + NECK_DIP * direction[2]);
        percale_garment_march_out(&shape->surface, center, direction,
                                  trunk_point(shape, percale_garment_rows(shape->grid), column));
    }
}

// One row of the front or the back, between its ends on two rims: a parabola through a point in the middle.
static void lay_arch(const PercaleGarmentShape *shape, uint32_t row, uint32_t first, const double summit[3])
{
    const double *left = trunk_point(shape, row, first);
    const double *right = trunk_point(shape, row, first + shape->grid.face);
    for (uint32_t column = first + 1; column < first + shape->grid.face; column++) {
        const double share = (double)(column - first) / shape->grid.face;
        const double arch = 4.0 * share * (1.0 - share);
        double *point = trunk_point(shape, row, column);
        for (int k = 0; k < 3; k++) {
            const double chord = left[k] + share * (right[k] - left[k]);
            point[k] = chord + arch * (summit[k] - 0.5 * (left[k] + right[k]));
        }
        percale_garment_settle(&shape->surface, ROUGHLY, point);
    }
}

// Between the armholes; the middles go up evenly from the bust to the neckline.
static void lay_chest(PercaleGarmentShape *shape)
{
    const uint32_t columns = percale_garment_columns(shape->grid);
    for (uint32_t row = shape->grid.below; row <= shape->grid.below + shape->grid.hole; row++) {
        for (uint32_t first = shape->grid.side; first < columns; first += columns / 2) {
            const uint32_t middle = first + shape->grid.face / 2;
            const double *neck = trunk_point(shape, percale_garment_rows(shape->grid), middle);
            const double up = (double)(row - shape->grid.below) / (shape->grid.hole + shape->grid.yoke);
            const double center[3] = {0, BUST_Y + up * (neck[1] - BUST_Y), PERCALE_GARMENT_AXIS_Z};
            double direction[3];
            double summit[3];
            column_direction(shape, middle, direction);
            percale_garment_march_out(&shape->surface, center, direction, summit);
            lay_arch(shape, row, first, summit);
        }
    }
}

static void lay_yoke(PercaleGarmentShape *shape)
{
    const uint32_t low = shape->grid.below + shape->grid.hole;
    const uint32_t high = percale_garment_rows(shape->grid);
    for (uint32_t column = 0; column < percale_garment_columns(shape->grid); column++) {
        for (uint32_t row = low + 1; row < high; row++) {
            double *point = trunk_point(shape, row, column);
            blend(trunk_point(shape, low, column), trunk_point(shape, high, column),
                  (double)(row - low) / (high - low), point);
            percale_garment_settle(&shape->surface, ROUGHLY, point);
        }
    }
}

// From the hem, where the columns stand at equal angles, up to where they meet the row below the armholes.
static void lay_skirt(PercaleGarmentShape *shape)
{
    const double hem = shape->surface.cut->hem;
    for (uint32_t column = 0; column < percale_garment_columns(shape->grid); column++) {
        const double *top = trunk_point(shape, shape->grid.below, column);
        const double off =
            sqrt(top[0] * top[0] + (top[2] - PERCALE_GARMENT_AXIS_Z) * (top[2] - PERCALE_GARMENT_AXIS_Z));
        const double top_direction[3] = {top[0] / off, 0.0, (top[2] - PERCALE_GARMENT_AXIS_Z) / off};
        double hem_direction[3];
        column_direction(shape, column, hem_direction);
        for (uint32_t row = 0; row < shape->grid.below; row++) {
            const double up = (double)row / shape->grid.below;
            const double center[3] = {0, hem + up * (top[1] - hem), PERCALE_GARMENT_AXIS_Z};
            double direction[3];
            blend(hem_direction, top_direction, up * up * up, direction);
            percale_garment_march_out(&shape->surface, center, direction, trunk_point(shape, row, column));
        }
    }
}

static void lay_sleeve(PercaleGarmentShape *shape, int side)
{
    double shoulder[3];
    double elbow[3];
    double axis[3];
    percale_bone_joint(side ? PERCALE_BONE_UPPER_ARM_RIGHT : PERCALE_BONE_UPPER_ARM, shoulder);
    percale_bone_joint(side ? PERCALE_BONE_FOREARM_RIGHT : PERCALE_BONE_FOREARM, elbow);
    const double length = distance_between(shoulder, elbow);
    for (int k = 0; k < 3; k++) {
        axis[k] = (elbow[k] - shoulder[k]) / length;
    }
    const double under[3] = {side ? -axis[1] : axis[1], side ? axis[0] : -axis[0], 0.0};
    const double cuff_at = shape->surface.cut->cuff;
    const double center[3] = {shoulder[0] + cuff_at * axis[0], shoulder[1] + cuff_at * axis[1],
                              shoulder[2] + cuff_at * axis[2]};
    const uint32_t rim = percale_garment_rim(shape->grid);
    for (uint32_t step = 0; step < rim; step++) {
        const double angle = TURN * step / rim;
        const double direction[3] = {cos(angle) * under[0], cos(angle) * under[1], sin(angle)};
        double *cuff = sleeve_point(shape, side, shape->grid.sleeve, step);
        percale_garment_march_out(&shape->surface, center, direction, cuff);
        for (uint32_t row = 1; row < shape->grid.sleeve; row++) {
            double *point = sleeve_point(shape, side, row, step);
            blend(sleeve_point(shape, side, 0, step), cuff, (double)row / shape->grid.sleeve, point);
            percale_garment_settle(&shape->surface, ROUGHLY, point);
        }
    }
}

// ---- evening out ----

static void even_out_point(const PercaleGarmentShape *shape, const double *point, const double *neighbours[4],
                           double moved[3])
{
    for (int k = 0; k < 3; k++) {
        const double mean =
            0.25 * (neighbours[0][k] + neighbours[1][k] + neighbours[2][k] + neighbours[3][k]);
        moved[k] = point[k] + RELAXATION_STEP * (mean - point[k]);
    }
    percale_garment_settle(&shape->surface, ROUGHLY, moved);
}

static void even_out_trunk(const PercaleGarmentShape *shape, double *moved)
{
    const uint32_t columns = percale_garment_columns(shape->grid);
    for (uint32_t row = 0; row <= percale_garment_rows(shape->grid); row++) {
        for (uint32_t column = 0; column < columns; column++) {
            const double *point = trunk_point(shape, row, column);
            double *target = moved + 3 * ((size_t)row * columns + column);
            memcpy(target, point, 3 * sizeof *target);
            if (percale_garment_is_loose(shape->grid, row, column)) {
                const double *neighbours[4] = {trunk_point(shape, row - 1, column),
                                               trunk_point(shape, row + 1, column),
                                               trunk_point(shape, row, (column + columns - 1) % columns),
                                               trunk_point(shape, row, (column + 1) % columns)};
                even_out_point(shape, point, neighbours, target);
            }
        }
    }
}

static void even_out_sleeve(const PercaleGarmentShape *shape, int side, double *moved)
{
    const uint32_t rim = percale_garment_rim(shape->grid);
    for (uint32_t row = 0; row <= shape->grid.sleeve; row++) {
        for (uint32_t step = 0; step < rim; step++) {
            const double *point = sleeve_point(shape, side, row, step);
            double *target = moved + 3 * ((size_t)row * rim + step);
            memcpy(target, point, 3 * sizeof *target);
            if (row > 0 && row < shape->grid.sleeve) {
                const double *neighbours[4] = {sleeve_point(shape, side, row - 1, step),
                                               sleeve_point(shape, side, row + 1, step),
                                               sleeve_point(shape, side, row, (step + rim - 1) % rim),
                                               sleeve_point(shape, side, row, (step + 1) % rim)};
                even_out_point(shape, point, neighbours, target);
            }
        }
    }
}

static size_t trunk_bytes(const PercaleGarmentShape *shape)
{
    return 3 * sizeof(double) * percale_garment_columns(shape->grid) *
           (percale_garment_rows(shape->grid) + 1);
}

static size_t sleeve_bytes(const PercaleGarmentShape *shape)
{
    return 3 * sizeof(double) * percale_garment_rim(shape->grid) * (shape->grid.sleeve + 1);
}

PercaleGarmentShape *percale_garment_shape_make(const PercaleGarmentSurface *surface)
{
    PercaleGarmentShape *shape = calloc(1, sizeof *shape);
    if (!shape) {
        return NULL;
    }
    shape->surface = *surface;
    shape->grid = surface->cut->grid;
    shape->trunk = calloc(1, trunk_bytes(shape));
    shape->sleeves[0] = calloc(1, sleeve_bytes(shape));
    shape->sleeves[1] = calloc(1, sleeve_bytes(shape));
    double *moved = malloc(trunk_bytes(shape)); // a sleeve is smaller
    if (!moved || !shape->trunk || !shape->sleeves[0] || !shape->sleeves[1]) {
        free(moved);
        percale_garment_shape_free(shape);
        return NULL;
    }
    lay_rim(shape);
    lay_neckline(shape);
    lay_chest(shape);
    lay_yoke(shape);
    lay_skirt(shape);
    lay_sleeve(shape, 0);
    lay_sleeve(shape, 1);
    for (int round = 0; round < RELAXATIONS; round++) {
        even_out_trunk(shape, moved);
        memcpy(shape->trunk, moved, trunk_bytes(shape));
        for (int side = 0; side < 2; side++) {
            even_out_sleeve(shape, side, moved);
            memcpy(shape->sleeves[side], moved, sleeve_bytes(shape));
        }
    }
    free(moved);
    return shape;
}

void percale_garment_shape_free(PercaleGarmentShape *shape)
{
    if (shape) {
        free(shape->trunk);
        free(shape->sleeves[0]);
        free(shape->sleeves[1]);
        free(shape);
    }
}

// ---- finer grids ----

static void mix_corners(const double *low_left, const double *low_right, const double *high_left,
                        const double *high_right, double right, double high, double point[3])
{
    double low_point[3];
    double high_point[3];
    blend(low_left, low_right, right, low_point);
    blend(high_left, high_right, right, high_point);
    blend(low_point, high_point, high, point);
}

void percale_garment_trunk_point(const PercaleGarmentShape *shape, PercaleGarmentGrid grid, uint32_t row,
                                 uint32_t column, double point[3])
{
    const PercaleGarmentPlace up = percale_garment_row_place(row, grid, shape->grid);
    const PercaleGarmentPlace along = percale_garment_column_place(column, grid, shape->grid);
    const uint32_t columns = percale_garment_columns(shape->grid);
    const uint32_t left = along.index;
    const uint32_t right = (left + 1) % columns;
    mix_corners(trunk_point(shape, up.index, left), trunk_point(shape, up.index, right),
                trunk_point(shape, up.index + 1, left), trunk_point(shape, up.index + 1, right), along.share,
                up.share, point);
    percale_garment_settle(&shape->surface, PERCALE_GARMENT_EXACTLY, point);
    percale_garment_add_folds(shape->surface.cut, (along.index + along.share) / columns, point);
}

void percale_garment_sleeve_point(const PercaleGarmentShape *shape, PercaleGarmentGrid grid, int side,
                                  uint32_t row, uint32_t step, double point[3])
{
    const PercaleGarmentPlace out = percale_garment_sleeve_row_place(row, grid, shape->grid);
    const PercaleGarmentPlace round = percale_garment_rim_place(step, grid, shape->grid);
    const uint32_t next = (round.index + 1) % percale_garment_rim(shape->grid);
    mix_corners(sleeve_point(shape, side, out.index, round.index), sleeve_point(shape, side, out.index, next),
                sleeve_point(shape, side, out.index + 1, round.index),
                sleeve_point(shape, side, out.index + 1, next), round.share, out.share, point);
    percale_garment_settle(&shape->surface, PERCALE_GARMENT_EXACTLY, point);
}
