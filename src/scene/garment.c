// garment.c: cuts the panels out of the garment's shape and notes where they are sewn.

#include "garment.h"

#include "garment_shape.h"
#include "scene_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const uint64_t LARGEST = 4000000; // vertices
static const double THINNEST = 0.0005;   // m
static const double THICKEST = 0.01;     // m; the sleeves are not wider
static const double TIGHT = 1.10;        // thicknesses to the skin where it fits tightly
static const double FACETS = 0.00045;    // m by which the body's triangles may stand out of its hollows

static const double SAG =
    0.0012; // m by which a garment of half the vertices of a smooth one cuts the corners

static const uint32_t NO_VERTEX = UINT32_MAX;

/// The garment while it is cut. Front and back are the halves of the trunk's grid.
typedef struct Cutting {
    PercaleGarmentGrid grid;
    const PercaleGarmentShape *shape;
    PercaleMesh *mesh;
    uint32_t *halves[2]; ///< [rows + 1][columns / 2 + 1]: vertex of the front or the back, or NO_VERTEX
    uint32_t
        sleeves[2]; ///< first vertex of a sleeve: [sleeve + 1][rim + 1], its first and last column coincide
    uint32_t (*seams)[2];
    uint32_t seam_count;
} Cutting;

// ---- how fine ----

static uint64_t half_count(PercaleGarmentGrid grid)
{
    const uint64_t all = (uint64_t)(percale_garment_columns(grid) / 2 + 1) * (percale_garment_rows(grid) + 1);
    return all - 2ULL * grid.side * (grid.hole - 1);
}

static uint64_t sleeve_count(PercaleGarmentGrid grid)
{
    return (uint64_t)(percale_garment_rim(grid) + 1) * (grid.sleeve + 1);
}

static uint64_t vertex_count(PercaleGarmentGrid grid)
{
    return 2 * half_count(grid) + 2 * sleeve_count(grid);
}

static uint32_t scaled(uint32_t cells, double scale)
{
    return (uint32_t)fmax(floor(cells * scale + 0.5), 1.0);
}

static PercaleGarmentGrid scaled_grid(PercaleGarmentGrid grid, double scale)
{
    return (PercaleGarmentGrid){.side = scaled(grid.side, scale),
                                .face = scaled(grid.face, scale),
                                .below = scaled(grid.below, scale),
                                .hole = scaled(grid.hole, scale),
                                .yoke = scaled(grid.yoke, scale),
                                .sleeve = scaled(grid.sleeve, scale)};
}

// The scale whose whole numbers of cells come closest.
static PercaleGarmentGrid grid_for(const PercaleGarmentCut *cut, uint64_t size)
{
    enum { STEPS = 400 };
    const double rough = sqrt((double)size / (double)vertex_count(cut->grid));
    PercaleGarmentGrid best = scaled_grid(cut->grid, rough);
    double best_error = HUGE_VAL;
    for (int step = 0; step <= STEPS; step++) {
        const PercaleGarmentGrid grid = scaled_grid(cut->grid, rough * (0.9 + 0.2 * step / STEPS));
        const double error = fabs((double)vertex_count(grid) - (double)size);
        if (error < best_error) {
            best_error = error;
            best = grid;
        }
    }
    return best;
}

// ---- vertices ----

static uint32_t add_vertex(PercaleMesh *mesh, const double point[3])
{
    for (size_t k = 0; k < 3; k++) {
        mesh->positions[3 * (size_t)mesh->vertex_count + k] = (float)point[k];
    }
    return mesh->vertex_count++;
}

// Repeats a vertex where it is sewn to another panel.
static uint32_t copy_vertex(PercaleMesh *mesh, uint32_t vertex)
{
    memcpy(mesh->positions + 3 * (size_t)mesh->vertex_count, mesh->positions + 3 * (size_t)vertex,
           3 * sizeof *mesh->positions);
    return mesh->vertex_count++;
}

static uint32_t *half_vertex(const Cutting *cutting, int half, uint32_t row, uint32_t column)
{
    const size_t width = percale_garment_columns(cutting->grid) / 2 + 1;
    return cutting->halves[half] + width * row + column;
}

// Inside an armhole, not on its rim.
static bool is_cut_out(PercaleGarmentGrid grid, uint32_t row, uint32_t column)
{
    const uint32_t last = percale_garment_columns(grid) / 2;
    return row > grid.below && row < grid.below + grid.hole &&
           (column < grid.side || column > last - grid.side);
}

static void cut_half(Cutting *cutting, int half)
{
    const uint32_t last = percale_garment_columns(cutting->grid) / 2;
    for (uint32_t row = 0; row <= percale_garment_rows(cutting->grid); row++) {
        for (uint32_t column = 0; column <= last; column++) {
            uint32_t *vertex = half_vertex(cutting, half, row, column);
            if (is_cut_out(cutting->grid, row, column)) {
                *vertex = NO_VERTEX;
            } else if (half == 1 && (column == 0 || column == last)) {
                *vertex = copy_vertex(cutting->mesh, *half_vertex(cutting, 0, row, last - column));
            } else {
                double point[3];
                percale_garment_trunk_point(cutting->shape, cutting->grid, row, column + (half ? last : 0),
                                            point);
                *vertex = add_vertex(cutting->mesh, point);
            }
        }
    }
}

// The vertex of the front or the back on an armhole's rim.
static uint32_t rim_vertex(const Cutting *cutting, int side, uint32_t step)
{
    const uint32_t half_columns = percale_garment_columns(cutting->grid) / 2;
    const uint32_t rim = percale_garment_rim(cutting->grid);
    uint32_t row;
    uint32_t column;
    percale_garment_rim_point(cutting->grid, side, step, &row, &column);
    const bool behind = 2 * step > rim;
    if (behind) {
        column =
            column == 0 ? half_columns : column - half_columns; // the left seam closes the back's last column
    }
    return *half_vertex(cutting, behind, row, column);
}

static void cut_sleeve(Cutting *cutting, int side)
{
    const uint32_t rim = percale_garment_rim(cutting->grid);
    cutting->sleeves[side] = cutting->mesh->vertex_count;
    for (uint32_t row = 0; row <= cutting->grid.sleeve; row++) {
        for (uint32_t step = 0; step <= rim; step++) {
            if (row == 0) {
                (void)copy_vertex(cutting->mesh, rim_vertex(cutting, side, step));
            } else if (step == rim) {
                (void)copy_vertex(cutting->mesh, cutting->mesh->vertex_count - rim);
            } else {
                double point[3];
                percale_garment_sleeve_point(cutting->shape, cutting->grid, side, row, step, point);
                (void)add_vertex(cutting->mesh, point);
            }
        }
    }
}

// ---- triangles ----

// corners: counter-clockwise seen from outside. Diagonals alternate, so that the cloth has no grain along
// them.
static void add_cell(PercaleMesh *mesh, const uint32_t corners[4], bool turned)
{
    const uint32_t order[6] = {0, 1, 2, 0, 2, 3};
    uint32_t *triangle = mesh->triangles + 3 * (size_t)mesh->triangle_count;
    for (int k = 0; k < 6; k++) {
        triangle[k] = corners[(order[k] + (turned ? 1 : 0)) % 4];
    }
    mesh->triangle_count += 2;
}

static void fill_half(Cutting *cutting, int half)
{
    const uint32_t width = percale_garment_columns(cutting->grid) / 2;
    for (uint32_t row = 0; row < percale_garment_rows(cutting->grid); row++) {
        for (uint32_t column = 0; column < width; column++) {
            if (percale_garment_in_armhole(cutting->grid, row, column)) {
                continue;
            }
            const uint32_t corners[4] = {*half_vertex(cutting, half, row, column),
                                         *half_vertex(cutting, half, row + 1, column),
                                         *half_vertex(cutting, half, row + 1, column + 1),
                                         *half_vertex(cutting, half, row, column + 1)};
            add_cell(cutting->mesh, corners, (row + column) % 2 == 1);
        }
    }
}

static void fill_sleeve(Cutting *cutting, int side)
{
    const uint32_t rim = percale_garment_rim(cutting->grid);
    for (uint32_t row = 0; row < cutting->grid.sleeve; row++) {
        for (uint32_t step = 0; step < rim; step++) {
            const uint32_t low = cutting->sleeves[side] + row * (rim + 1) + step;
            const uint32_t high = low + rim + 1;
            const uint32_t left[4] = {low, high, high + 1, low + 1};
            const uint32_t right[4] = {low, low + 1, high + 1, high};
            add_cell(cutting->mesh, side ? right : left, (row + step) % 2 == 1);
        }
    }
}

// ---- seams ----

static void sew(Cutting *cutting, uint32_t a, uint32_t b)
{
    cutting->seams[cutting->seam_count][0] = a;
    cutting->seams[cutting->seam_count][1] = b;
    cutting->seam_count++;
}

// Front to back along both sides and both shoulders.
static void sew_halves(Cutting *cutting)
{
    const uint32_t last = percale_garment_columns(cutting->grid) / 2;
    for (uint32_t row = 0; row <= percale_garment_rows(cutting->grid); row++) {
        if (!is_cut_out(cutting->grid, row, 0)) {
            sew(cutting, *half_vertex(cutting, 0, row, 0), *half_vertex(cutting, 1, row, last));
            sew(cutting, *half_vertex(cutting, 0, row, last), *half_vertex(cutting, 1, row, 0));
        }
    }
}

// Round the armhole, then along the underarm, whose first pair the armhole and the side seam already hold.
static void sew_sleeve(Cutting *cutting, int side)
{
    const uint32_t rim = percale_garment_rim(cutting->grid);
    const uint32_t first = cutting->sleeves[side];
    for (uint32_t step = 0; step <= rim; step++) {
        sew(cutting, rim_vertex(cutting, side, step), first + step);
    }
    for (uint32_t row = 1; row <= cutting->grid.sleeve; row++) {
        sew(cutting, first + row * (rim + 1), first + row * (rim + 1) + rim);
    }
}

// ---- all together ----

static bool reserve(Cutting *cutting, const char *name)
{
    const PercaleGarmentGrid grid = cutting->grid;
    const size_t vertices = (size_t)vertex_count(grid);
    const size_t half_points =
        ((size_t)percale_garment_columns(grid) / 2 + 1) * (percale_garment_rows(grid) + 1);
    const size_t seams = 2 * (size_t)(percale_garment_rows(grid) + 1) +
                         2 * ((size_t)percale_garment_rim(grid) + 1 + grid.sleeve);
    cutting->mesh->name = strdup(name);
    cutting->mesh->positions = calloc(3 * vertices, sizeof *cutting->mesh->positions);
    cutting->mesh->triangles = calloc(6 * vertices, sizeof *cutting->mesh->triangles);
    cutting->halves[0] = calloc(half_points, sizeof *cutting->halves[0]);
    cutting->halves[1] = calloc(half_points, sizeof *cutting->halves[1]);
    cutting->seams = calloc(seams, sizeof *cutting->seams);
    return cutting->mesh->name && cutting->mesh->positions && cutting->mesh->triangles &&
           cutting->halves[0] && cutting->halves[1] && cutting->seams;
}

static void cut_and_sew(Cutting *cutting)
{
    for (int half = 0; half < 2; half++) {
        cut_half(cutting, half);
        fill_half(cutting, half);
    }
    sew_halves(cutting);
    for (int side = 0; side < 2; side++) {
        cut_sleeve(cutting, side);
        fill_sleeve(cutting, side);
        sew_sleeve(cutting, side);
    }
}

uint64_t percale_garment_vertices(const PercaleGarmentCut *cut)
{
    return vertex_count(cut->grid);
}

double percale_garment_sag(const PercaleGarmentCut *cut, uint64_t size)
{
    return SAG * fmax((double)cut->smooth / (double)size - 1.0, 0.0);
}

static bool check_wish(const PercaleGarmentCut *cut, uint64_t size, double thickness,
                       PercaleSceneError *error)
{
    if (size < cut->smallest || size > LARGEST) {
        return percale_scene_fail(error, "%s: size %llu is not in %llu..%llu vertices", cut->name,
                                  (unsigned long long)size, (unsigned long long)cut->smallest,
                                  (unsigned long long)LARGEST);
    }
    return (thickness >= THINNEST && thickness <= THICKEST) ||
           percale_scene_fail(error, "%s: thickness %g m is not in %g..%g m", cut->name, thickness, THINNEST,
                              THICKEST);
}

bool percale_garment_make(const PercaleGarmentCut *cut, uint64_t size, float thickness, double outwards,
                          PercaleMesh *mesh, uint32_t (**seams)[2], uint32_t *seam_count,
                          PercaleSceneError *error)
{
    memset(mesh, 0, sizeof *mesh);
    *seams = NULL;
    *seam_count = 0;
    if (!check_wish(cut, size, (double)thickness, error)) {
        return false;
    }
    const double clearance = TIGHT * (double)thickness + FACETS + percale_garment_sag(cut, size);
    const PercaleGarmentSurface surface = {.cut = cut, .clearance = clearance, .outwards = outwards};
    PercaleGarmentShape *shape = percale_garment_shape_make(&surface);
    Cutting cutting = {.grid = grid_for(cut, size), .shape = shape, .mesh = mesh};
    const bool good = reserve(&cutting, cut->name) && shape;
    if (good) {
        cut_and_sew(&cutting);
        *seams = cutting.seams;
        *seam_count = cutting.seam_count;
    } else {
        percale_scene_fail(error, "%s: out of memory for %llu vertices", cut->name, (unsigned long long)size);
        percale_mesh_free(mesh);
        free(cutting.seams);
    }
    free(cutting.halves[0]);
    free(cutting.halves[1]);
    percale_garment_shape_free(shape);
    return good;
}
