#include "garment_grid.h"

uint32_t percale_garment_columns(PercaleGarmentGrid grid)
{
    return 4 * grid.side + 2 * grid.face;
}

uint32_t percale_garment_rows(PercaleGarmentGrid grid)
{
    return grid.below + grid.hole + grid.yoke;
}

uint32_t percale_garment_rim(PercaleGarmentGrid grid)
{
    return 4 * grid.side + 2 * grid.hole;
}

void percale_garment_rim_point(PercaleGarmentGrid grid, int side, uint32_t step, uint32_t *row,
                               uint32_t *column)
{
    const uint32_t columns = percale_garment_columns(grid);
    const uint32_t rim = percale_garment_rim(grid);
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

bool percale_garment_in_armhole(PercaleGarmentGrid grid, uint32_t row, uint32_t column)
{
    const uint32_t half = percale_garment_columns(grid) / 2;
    const uint32_t from_seam = column % half;
    return row >= grid.below && row < grid.below + grid.hole &&
           (from_seam < grid.side || from_seam >= half - grid.side);
}

bool percale_garment_is_loose(PercaleGarmentGrid grid, uint32_t row, uint32_t column)
{
    const uint32_t left = (column + percale_garment_columns(grid) - 1) % percale_garment_columns(grid);
    return row > 0 && row < percale_garment_rows(grid) && !percale_garment_in_armhole(grid, row, column) &&
           !percale_garment_in_armhole(grid, row, left) &&
           !percale_garment_in_armhole(grid, row - 1, column) &&
           !percale_garment_in_armhole(grid, row - 1, left);
}

// ---- finer grids ----

// Grids agree at the ends of the stretches that their cells are counted in. The last point of all falls on
// the end of the last coarse cell.
static PercaleGarmentPlace place_of(uint32_t index, const uint32_t *fine, const uint32_t *coarse,
                                    int stretch_count)
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
    return (PercaleGarmentPlace){coarse_start + whole, share};
}

PercaleGarmentPlace percale_garment_row_place(uint32_t row, PercaleGarmentGrid fine,
                                              PercaleGarmentGrid coarse)
{
    const uint32_t fine_rows[3] = {fine.below, fine.hole, fine.yoke};
    const uint32_t rows[3] = {coarse.below, coarse.hole, coarse.yoke};
    return place_of(row, fine_rows, rows, 3);
}

PercaleGarmentPlace percale_garment_column_place(uint32_t column, PercaleGarmentGrid fine,
                                                 PercaleGarmentGrid coarse)
{
    const uint32_t fine_columns[6] = {fine.side, fine.face, fine.side, fine.side, fine.face, fine.side};
    const uint32_t columns[6] = {coarse.side, coarse.face, coarse.side,
                                 coarse.side, coarse.face, coarse.side};
    return place_of(column, fine_columns, columns, 6);
}

PercaleGarmentPlace percale_garment_sleeve_row_place(uint32_t row, PercaleGarmentGrid fine,
                                                     PercaleGarmentGrid coarse)
{
    return place_of(row, &fine.sleeve, &coarse.sleeve, 1);
}

PercaleGarmentPlace percale_garment_rim_place(uint32_t step, PercaleGarmentGrid fine,
                                              PercaleGarmentGrid coarse)
{
    const uint32_t fine_steps[6] = {fine.side, fine.hole, fine.side, fine.side, fine.hole, fine.side};
    const uint32_t steps[6] = {coarse.side, coarse.hole, coarse.side, coarse.side, coarse.hole, coarse.side};
    return place_of(step, fine_steps, steps, 6);
}
