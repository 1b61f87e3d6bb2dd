// dress_shape.c: a coarse grid is laid on an offset of the body and evened out once; finer grids are read off
// it and put back onto the offset.

#include "dress_shape.h"

#include "body_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const PercaleDressGrid GRID = {
    .side = 4, .face = 24, .below = 42, .hole = 10, .yoke = 5, .sleeve = 12};

// The cut, m, in the body's coordinates.
static const double AXIS_Z = -0.008; // of the trunk
static const double HEM_Y = 0.52;
static const double SKIRT_Y = 0.955;      // above it the skirt narrows quickly into the waist
static const double SKIRT_RADIUS = 0.113; // there
static const double SKIRT_FLAT = 0.060;   // half of the straight part of the oval in front and behind
static const double SKIRT_FLARE = 0.19;   // radius gained per metre downwards
static const double WAIST_FLARE = 1.20;   // the same above SKIRT_Y
static const double FLARE_BLEND = 0.04;   // half the height over which one becomes the other
static const double SKIRT_BLEND = 0.025;  // smooth union of skirt and bodice
static const double BODICE_END = 0.70;    // below it the trunk is out of reach

static const double SLEEVE_EASE = 0.024; // more radius at the elbow than the arm has
static const double ARM_BLEND = 0.070;   // wider than the body's: room under the arm
static const double CUFF = 0.160;        // from the shoulder along the arm

static const double ARMHOLE_CENTER[3] = {0.152, 1.335, -0.014}; // in an upright plane across the arm
static const double NECK_CENTER[3] = {0, 1.456, -0.020};
static const double NECK_TILT = 0.325; // slope of the neckline towards the front,
static const double NECK_DIP = 0.500;  // and more of it, downwards in front as behind
static const double BUST_Y = 1.225;    // of the front and back middle at the height of the armhole's bottom

// Folds: they open from FOLD_TOP to the hem, and stand outside the plain skirt everywhere.
static const double FOLD_TOP = 0.93;    // m
static const double FOLD_DEPTH = 0.060; // m from valley to crest at the hem
static const double TURN = 6.283185307179586;

static const int RELAXATIONS = 80;         // the first guess is good; only its corners must spread out
static const double RELAXATION_STEP = 0.7; // share of the way to the mean of the four neighbours
static const int PROJECTIONS = 16;         // Newton steps; two or three are the rule
static const double ROUGHLY = 1e-4;        // m off the surface while points still slide
static const double EXACTLY = 1e-7;        // m off the surface at the end: a float's last digits
static const double MARCH = 0.004;         // m; steps in search of the surface

struct PercaleDressShape {
    double clearance;
    double *trunk;      ///< [rows + 1][columns][3] m
    double *sleeves[2]; ///< [sleeve + 1][rim][3] m
};

// ---- grid ----

PercaleDressGrid percale_dress_shape_grid(void)
{
    return GRID;
}

uint32_t percale_dress_columns(PercaleDressGrid grid)
{
    return 4 * grid.side + 2 * grid.face;
}

uint32_t percale_dress_rows(PercaleDressGrid grid)
{
    return grid.below + grid.hole + grid.yoke;
}

uint32_t percale_dress_rim(PercaleDressGrid grid)
{
    return 4 * grid.side + 2 * grid.hole;
}

void percale_dress_rim_point(PercaleDressGrid grid, int side, uint32_t step, uint32_t *row, uint32_t *column)
{
    const uint32_t columns = percale_dress_columns(grid);
    const uint32_t rim = percale_dress_rim(grid);
    const bool behind = 2 * step > rim;
    const uint32_t climb = behind ? rim - step : step; // steps from the underarm on the shorter way
    uint32_t out = grid.side;                          // columns away from the seam
    *row = grid.below;
    if (climb <= grid.side) {
        out = climb;
    } else if (climb <= grid.side + grid.hole) {
        *row += climb - grid.side;
    } else {
        *row += grid.hole;
        out = rim / 2 - climb;
    }
    const bool with_columns = (side == 0) != behind;
    const uint32_t seam = side == 0 ? 0 : columns / 2;
    *column = (with_columns ? seam + out : seam + columns - out) % columns;
}

bool percale_dress_in_armhole(PercaleDressGrid grid, uint32_t row, uint32_t column)
{
    const uint32_t half = percale_dress_columns(grid) / 2;
    const uint32_t from_seam = column % half;
    return row >= grid.below && row < grid.below + grid.hole &&
           (from_seam < grid.side || from_seam >= half - grid.side);
}

// ---- the surface ----

// Radius of the skirt's oval at a height, and how it changes with it: two straight lines and a parabola.
static double skirt_radius(double y, double *slope)
{
    const double up = y - SKIRT_Y;
    const double bend = (WAIST_FLARE - SKIRT_FLARE) / (4.0 * FLARE_BLEND);
    const double into = fmin(fmax(up + FLARE_BLEND, 0.0), 2.0 * FLARE_BLEND);
    const double beyond = fmax(up - FLARE_BLEND, 0.0);
    *slope = -SKIRT_FLARE - 2.0 * bend * into;
    return SKIRT_RADIUS - SKIRT_FLARE * up - bend * into * into - (WAIST_FLARE - SKIRT_FLARE) * beyond;
}

static double skirt_field(const double point[3], double gradient[3])
{
    const double over = fmax(fabs(point[0]) - SKIRT_FLAT, 0.0);
    const double x = copysign(over, point[0]);
    const double z = point[2] - AXIS_Z;
    const double off = sqrt(x * x + z * z);
    double slope;
    const double radius = skirt_radius(point[1], &slope);
    const double steep = sqrt(1.0 + slope * slope);
    gradient[0] = off > 0.0 ? x / off / steep : 0.0;
    gradient[1] = -slope / steep;
    gradient[2] = off > 0.0 ? z / off / steep : 0.0;
    return (off - radius) / steep;
}

// Zero on the dress, without its folds.
static double dress_field(double clearance, const double point[3], double gradient[3])
{
    double value = skirt_field(point, gradient);
    if (point[1] > BODICE_END) {
        double bodice_gradient[3];
        const double bodice =
            percale_bodice_field(point, SLEEVE_EASE, ARM_BLEND, bodice_gradient) - clearance;
        percale_smooth_union(&value, gradient, bodice, bodice_gradient, SKIRT_BLEND);
    }
    return value;
}

static void settle(double clearance, double tolerance, double point[3])
{
    for (int step = 0; step < PROJECTIONS; step++) {
        double gradient[3];
        const double value = dress_field(clearance, point, gradient);
        const double square =
            gradient[0] * gradient[0] + gradient[1] * gradient[1] + gradient[2] * gradient[2];
        if (fabs(value) <= tolerance || !(square > 0.0)) {
            return;
        }
        for (int k = 0; k < 3; k++) {
            point[k] -= value / square * gradient[k];
        }
    }
}

// The first point of a ray that starts inside which is on the surface.
static void march_out(double clearance, const double origin[3], const double direction[3], double point[3])
{
    const double length =
        sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    double gradient[3];
    double inside = 0.0;
    double outside = 0.0;
    double step = MARCH;
    memcpy(point, origin, 3 * sizeof *point);
    while (step > EXACTLY) {
        const double t = inside + step;
        for (int k = 0; k < 3; k++) {
            point[k] = origin[k] + t * direction[k] / length;
        }
        if (dress_field(clearance, point, gradient) < 0.0) {
            inside = t;
        } else {
            outside = t;
        }
        if (outside > 0.0) {
            step = 0.5 * (outside - inside);
        }
    }
}

// ---- first guess ----

static double *trunk_point(const PercaleDressShape *shape, uint32_t row, uint32_t column)
{
    return shape->trunk + 3 * ((size_t)row * percale_dress_columns(GRID) + column);
}

static double *sleeve_point(const PercaleDressShape *shape, int side, uint32_t row, uint32_t step)
{
    return shape->sleeves[side] + 3 * ((size_t)row * percale_dress_rim(GRID) + step);
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

static void lay_rim(PercaleDressShape *shape)
{
    double curve[CURVE_POINTS + 1][3];
    double length[CURVE_POINTS + 1] = {0};
    for (int i = 0; i <= CURVE_POINTS; i++) {
        const double angle = TURN * (i % CURVE_POINTS) / CURVE_POINTS;
        const double direction[3] = {0.0, -cos(angle), sin(angle)};
        march_out(shape->clearance, ARMHOLE_CENTER, direction, curve[i]);
        length[i] = i > 0 ? length[i - 1] + distance_between(curve[i - 1], curve[i]) : 0.0;
    }
    const uint32_t rim = percale_dress_rim(GRID);
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
            percale_dress_rim_point(GRID, side, step, &row, &column);
            const double mirrored[3] = {side ? -point[0] : point[0], point[1], point[2]};
            memcpy(trunk_point(shape, row, column), mirrored, sizeof mirrored);
            memcpy(sleeve_point(shape, side, 0, step), mirrored, sizeof mirrored);
        }
    }
}

static void column_direction(uint32_t column, double direction[3])
{
    const double angle = TURN * column / percale_dress_columns(GRID);
    direction[0] = cos(angle);
    direction[1] = 0.0;
    direction[2] = sin(angle);
}

static void lay_neckline(PercaleDressShape *shape)
{
    for (uint32_t column = 0; column < percale_dress_columns(GRID); column++) {
        double direction[3];
        column_direction(column, direction);
        direction[1] = -direction[2] * (NECK_TILT + NECK_DIP * direction[2]);
        march_out(shape->clearance, NECK_CENTER, direction,
                  trunk_point(shape, percale_dress_rows(GRID), column));
    }
}

// One row of the front or the back, between its ends on two rims: a parabola through a point in the middle.
static void lay_arch(const PercaleDressShape *shape, uint32_t row, uint32_t first, const double summit[3])
{
    const double *left = trunk_point(shape, row, first);
    const double *right = trunk_point(shape, row, first + GRID.face);
    for (uint32_t column = first + 1; column < first + GRID.face; column++) {
        const double share = (double)(column - first) / GRID.face;
        const double arch = 4.0 * share * (1.0 - share);
        double *point = trunk_point(shape, row, column);
        for (int k = 0; k < 3; k++) {
            const double chord = left[k] + share * (right[k] - left[k]);
            point[k] = chord + arch * (summit[k] - 0.5 * (left[k] + right[k]));
        }
        settle(shape->clearance, ROUGHLY, point);
    }
}

// Between the armholes; the middles go up evenly from the bust to the neckline.
static void lay_chest(PercaleDressShape *shape)
{
    const uint32_t columns = percale_dress_columns(GRID);
    for (uint32_t row = GRID.below; row <= GRID.below + GRID.hole; row++) {
        for (uint32_t first = GRID.side; first < columns; first += columns / 2) {
            const uint32_t middle = first + GRID.face / 2;
            const double *neck = trunk_point(shape, percale_dress_rows(GRID), middle);
            const double up = (double)(row - GRID.below) / (GRID.hole + GRID.yoke);
            const double center[3] = {0, BUST_Y + up * (neck[1] - BUST_Y), AXIS_Z};
            double direction[3];
            double summit[3];
            column_direction(middle, direction);
            march_out(shape->clearance, center, direction, summit);
            lay_arch(shape, row, first, summit);
        }
    }
}

static void lay_yoke(PercaleDressShape *shape)
{
    const uint32_t low = GRID.below + GRID.hole;
    const uint32_t high = percale_dress_rows(GRID);
    for (uint32_t column = 0; column < percale_dress_columns(GRID); column++) {
        for (uint32_t row = low + 1; row < high; row++) {
            double *point = trunk_point(shape, row, column);
            blend(trunk_point(shape, low, column), trunk_point(shape, high, column),
                  (double)(row - low) / (high - low), point);
            settle(shape->clearance, ROUGHLY, point);
        }
    }
}

// From the hem, where the columns stand at equal angles, up to where they meet the row below the armholes.
static void lay_skirt(PercaleDressShape *shape)
{
    for (uint32_t column = 0; column < percale_dress_columns(GRID); column++) {
        const double *top = trunk_point(shape, GRID.below, column);
        const double off = sqrt(top[0] * top[0] + (top[2] - AXIS_Z) * (top[2] - AXIS_Z));
        const double top_direction[3] = {top[0] / off, 0.0, (top[2] - AXIS_Z) / off};
        double hem_direction[3];
        column_direction(column, hem_direction);
        for (uint32_t row = 0; row < GRID.below; row++) {
            const double up = (double)row / GRID.below;
            const double center[3] = {0, HEM_Y + up * (top[1] - HEM_Y), AXIS_Z};
            double direction[3];
            blend(hem_direction, top_direction, up * up * up, direction);
            march_out(shape->clearance, center, direction, trunk_point(shape, row, column));
        }
    }
}

static void lay_sleeve(PercaleDressShape *shape, int side)
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
    const double center[3] = {shoulder[0] + CUFF * axis[0], shoulder[1] + CUFF * axis[1],
                              shoulder[2] + CUFF * axis[2]};
    const uint32_t rim = percale_dress_rim(GRID);
    for (uint32_t step = 0; step < rim; step++) {
        const double angle = TURN * step / rim;
        const double direction[3] = {cos(angle) * under[0], cos(angle) * under[1], sin(angle)};
        double *cuff = sleeve_point(shape, side, GRID.sleeve, step);
        march_out(shape->clearance, center, direction, cuff);
        for (uint32_t row = 1; row < GRID.sleeve; row++) {
            double *point = sleeve_point(shape, side, row, step);
            blend(sleeve_point(shape, side, 0, step), cuff, (double)row / GRID.sleeve, point);
            settle(shape->clearance, ROUGHLY, point);
        }
    }
}

// ---- evening out ----

static void even_out_point(const PercaleDressShape *shape, const double *point, const double *neighbours[4],
                           double moved[3])
{
    for (int k = 0; k < 3; k++) {
        const double mean =
            0.25 * (neighbours[0][k] + neighbours[1][k] + neighbours[2][k] + neighbours[3][k]);
        moved[k] = point[k] + RELAXATION_STEP * (mean - point[k]);
    }
    settle(shape->clearance, ROUGHLY, moved);
}

// Points on the rim belong to cells that are left out and to cells that are not.
static bool is_loose(uint32_t row, uint32_t column)
{
    const uint32_t left = (column + percale_dress_columns(GRID) - 1) % percale_dress_columns(GRID);
    return row > 0 && row < percale_dress_rows(GRID) && !percale_dress_in_armhole(GRID, row, column) &&
           !percale_dress_in_armhole(GRID, row, left) && !percale_dress_in_armhole(GRID, row - 1, column) &&
           !percale_dress_in_armhole(GRID, row - 1, left);
}

static void even_out_trunk(const PercaleDressShape *shape, double *moved)
{
    const uint32_t columns = percale_dress_columns(GRID);
    for (uint32_t row = 0; row <= percale_dress_rows(GRID); row++) {
        for (uint32_t column = 0; column < columns; column++) {
            const double *point = trunk_point(shape, row, column);
            double *target = moved + 3 * ((size_t)row * columns + column);
            memcpy(target, point, 3 * sizeof *target);
            if (is_loose(row, column)) {
                const double *neighbours[4] = {trunk_point(shape, row - 1, column),
                                               trunk_point(shape, row + 1, column),
                                               trunk_point(shape, row, (column + columns - 1) % columns),
                                               trunk_point(shape, row, (column + 1) % columns)};
                even_out_point(shape, point, neighbours, target);
            }
        }
    }
}

static void even_out_sleeve(const PercaleDressShape *shape, int side, double *moved)
{
    const uint32_t rim = percale_dress_rim(GRID);
    for (uint32_t row = 0; row <= GRID.sleeve; row++) {
        for (uint32_t step = 0; step < rim; step++) {
            const double *point = sleeve_point(shape, side, row, step);
            double *target = moved + 3 * ((size_t)row * rim + step);
            memcpy(target, point, 3 * sizeof *target);
            if (row > 0 && row < GRID.sleeve) {
                const double *neighbours[4] = {sleeve_point(shape, side, row - 1, step),
                                               sleeve_point(shape, side, row + 1, step),
                                               sleeve_point(shape, side, row, (step + rim - 1) % rim),
                                               sleeve_point(shape, side, row, (step + 1) % rim)};
                even_out_point(shape, point, neighbours, target);
            }
        }
    }
}

static size_t trunk_bytes(void)
{
    return 3 * sizeof(double) * percale_dress_columns(GRID) * (percale_dress_rows(GRID) + 1);
}

static size_t sleeve_bytes(void)
{
    return 3 * sizeof(double) * percale_dress_rim(GRID) * (GRID.sleeve + 1);
}

PercaleDressShape *percale_dress_shape_make(double clearance)
{
    PercaleDressShape *shape = calloc(1, sizeof *shape);
    double *moved = malloc(trunk_bytes());
    if (shape) {
        shape->clearance = clearance;
        shape->trunk = calloc(1, trunk_bytes());
        shape->sleeves[0] = calloc(1, sleeve_bytes());
        shape->sleeves[1] = calloc(1, sleeve_bytes());
    }
    if (!shape || !moved || !shape->trunk || !shape->sleeves[0] || !shape->sleeves[1]) {
        free(moved);
        percale_dress_shape_free(shape);
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
        memcpy(shape->trunk, moved, trunk_bytes());
        for (int side = 0; side < 2; side++) {
            even_out_sleeve(shape, side, moved);
            memcpy(shape->sleeves[side], moved, sleeve_bytes());
        }
    }
    free(moved);
    return shape;
}

void percale_dress_shape_free(PercaleDressShape *shape)
{
    if (shape) {
        free(shape->trunk);
        free(shape->sleeves[0]);
        free(shape->sleeves[1]);
        free(shape);
    }
}

// ---- finer grids ----

/// Where a fine index falls on the coarse grid: at `index`, and so far towards the next.
typedef struct Place {
    uint32_t index;
    double share; ///< 0..1
} Place;

// Grids agree at the ends of the stretches that their cells are counted in. The last point of all falls on
// the end of the last coarse cell.
static Place place_of(uint32_t index, const uint32_t *fine, const uint32_t *coarse, int stretch_count)
{
    uint32_t fine_start = 0;
    uint32_t coarse_start = 0;
    int stretch = 0;
    while (stretch + 1 < stretch_count && index >= fine_start + fine[stretch]) {
        fine_start += fine[stretch];
        coarse_start += coarse[stretch];
        stretch++;
    }
    const uint64_t scaled = (uint64_t)(index - fine_start) * coarse[stretch];
    uint32_t whole = (uint32_t)(scaled / fine[stretch]);
    double share = (double)(scaled % fine[stretch]) / fine[stretch];
    if (whole == coarse[stretch]) {
        whole--;
        share = 1.0;
    }
    return (Place){coarse_start + whole, share};
}

static void mix_corners(const double *low_left, const double *low_right, const double *high_left,
                        const double *high_right, double right, double high, double point[3])
{
    double low_point[3];
    double high_point[3];
    blend(low_left, low_right, right, low_point);
    blend(high_left, high_right, right, high_point);
    blend(low_point, high_point, high, point);
}

// Crests of different width, so that no two folds are alike. `round`: 0..1 round the body.
static void add_folds(double round, double point[3])
{
    const double down = fmin(fmax((FOLD_TOP - point[1]) / (FOLD_TOP - HEM_Y), 0.0), 1.0);
    if (down <= 0.0) {
        return;
    }
    const double angle = TURN * round;
    const double crest = 0.5 + 0.34 * cos(11.0 * angle + 0.4) + 0.16 * cos(7.0 * angle + 2.0);
    const double depth = FOLD_DEPTH * down * down * (1.5 - 0.5 * down) * crest;
    double gradient[3];
    (void)skirt_field(point, gradient);
    const double flat = sqrt(gradient[0] * gradient[0] + gradient[2] * gradient[2]);
    point[0] += depth * gradient[0] / flat;
    point[2] += depth * gradient[2] / flat;
}

void percale_dress_trunk_point(const PercaleDressShape *shape, PercaleDressGrid grid, uint32_t row,
                               uint32_t column, double point[3])
{
    const uint32_t fine_rows[3] = {grid.below, grid.hole, grid.yoke};
    const uint32_t rows[3] = {GRID.below, GRID.hole, GRID.yoke};
    const uint32_t fine_columns[6] = {grid.side, grid.face, grid.side, grid.side, grid.face, grid.side};
    const uint32_t columns[6] = {GRID.side, GRID.face, GRID.side, GRID.side, GRID.face, GRID.side};
    const Place up = place_of(row, fine_rows, rows, 3);
    const Place along = place_of(column, fine_columns, columns, 6);
    const uint32_t left = along.index;
    const uint32_t right = (left + 1) % percale_dress_columns(GRID);
    mix_corners(trunk_point(shape, up.index, left), trunk_point(shape, up.index, right),
                trunk_point(shape, up.index + 1, left), trunk_point(shape, up.index + 1, right), along.share,
                up.share, point);
    settle(shape->clearance, EXACTLY, point);
    add_folds((along.index + along.share) / percale_dress_columns(GRID), point);
}

void percale_dress_sleeve_point(const PercaleDressShape *shape, PercaleDressGrid grid, int side, uint32_t row,
                                uint32_t step, double point[3])
{
    const uint32_t fine_steps[6] = {grid.side, grid.hole, grid.side, grid.side, grid.hole, grid.side};
    const uint32_t steps[6] = {GRID.side, GRID.hole, GRID.side, GRID.side, GRID.hole, GRID.side};
    const Place out = place_of(row, &grid.sleeve, &GRID.sleeve, 1);
    const Place round = place_of(step, fine_steps, steps, 6);
    const uint32_t next = (round.index + 1) % percale_dress_rim(GRID);
    mix_corners(sleeve_point(shape, side, out.index, round.index), sleeve_point(shape, side, out.index, next),
                sleeve_point(shape, side, out.index + 1, round.index),
                sleeve_point(shape, side, out.index + 1, next), round.share, out.share, point);
    settle(shape->clearance, EXACTLY, point);
}
