// shapes.h: the plain meshes of the built-in scenes. Only + - * / and sqrt: the same bits everywhere.

#ifndef PERCALE_SHAPES_H
#define PERCALE_SHAPES_H

#include "percale/scene.h"

/// Columns and rows, at least 2 of each, of about `size` vertices in square cells on a sheet of so much along
/// and across, m.
void percale_sheet_divide(uint64_t size, double along, double across, uint32_t *columns, uint32_t *rows);

/// A grid of columns x rows vertices (at least 2 x 2), row by row, with alternating diagonals: vertex (row,
/// column) lies at corner + column / (columns - 1) * along + row / (rows - 1) * across. Triangles are
/// counter-clockwise seen from along x across.
bool percale_sheet_make(const char *name, uint32_t columns, uint32_t rows, const double corner[3],
                        const double along[3], const double across[3], PercaleMesh *mesh,
                        PercaleSceneError *error);

/// An icosahedron, each triangle cut into 4 `subdivisions` (0..8) times, on a sphere. 20 * 4^n triangles,
/// counter-clockwise seen from outside.
bool percale_icosphere_make(const char *name, int subdivisions, double radius, const double centre[3],
                            PercaleMesh *mesh, PercaleSceneError *error);

/// A box from `corner` along three sides, which are at right angles and right-handed. 12 triangles,
/// counter-clockwise seen from outside.
bool percale_box_make(const char *name, const double corner[3], const double along[3], const double up[3],
                      const double across[3], PercaleMesh *mesh, PercaleSceneError *error);

#endif
