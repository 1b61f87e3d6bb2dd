#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/shapes.h"

#include <math.h>
#include <string.h>

void percale_sheet_divide(uint64_t size, double along, double across, uint32_t *columns, uint32_t *rows)
{
    // Square cells: columns / rows is along / across.
    const double wanted_rows = sqrt((double)size * across / along);
    *rows = wanted_rows < 2.0 ? 2 : (uint32_t)(wanted_rows + 0.5);
    const uint64_t wanted_columns = (size + *rows / 2) / *rows;
    *columns = wanted_columns < 2 ? 2 : (uint32_t)wanted_columns;
}

static void fill_positions(uint32_t columns, uint32_t rows, const double corner[3], const double along[3],
                           const double across[3], float *positions)
{
    for (size_t row = 0; row < rows; ++row) {
        for (size_t column = 0; column < columns; ++column) {
            const double s = (double)column / (columns - 1);
            const double t = (double)row / (rows - 1);
            for (size_t axis = 0; axis < 3; ++axis) {
                positions[3 * (row * columns + column) + axis] =
                    (float)(corner[axis] + s * along[axis] + t * across[axis]);
            }
        }
    }
}

// Diagonals alternate like a chequerboard: no direction of the cloth is stiffer than its mirror image.
static void fill_triangles(uint32_t columns, uint32_t rows, uint32_t *triangles)
{
    for (uint32_t row = 0; row + 1 < rows; ++row) {
        for (uint32_t column = 0; column + 1 < columns; ++column) {
            const uint32_t a = row * columns + column;
            const uint32_t b = a + 1;
            const uint32_t c = b + columns;
            const uint32_t d = a + columns;
            const bool rising = (row + column) % 2 == 0;
            const uint32_t cell[2][6] = {{a, b, d, b, c, d}, {a, b, c, a, c, d}};
            memcpy(triangles, cell[rising], sizeof cell[rising]);
            triangles += 6;
        }
    }
}

bool percale_sheet_make(const char *name, uint32_t columns, uint32_t rows, const double corner[3],
                        const double along[3], const double across[3], PercaleMesh *mesh,
                        PercaleSceneError *error)
{
    const uint64_t vertex_count = (uint64_t)columns * rows;
    const uint64_t triangle_count = 2 * (uint64_t)(columns - 1) * (rows - 1);
    *mesh = (PercaleMesh){.name = strdup(name),
                          .positions = percale_array_new(3 * vertex_count, sizeof *mesh->positions),
                          .vertex_count = (uint32_t)vertex_count,
                          .triangles = percale_array_new(3 * triangle_count, sizeof *mesh->triangles),
                          .triangle_count = (uint32_t)triangle_count};
    if (mesh->name == NULL || mesh->positions == NULL || mesh->triangles == NULL) {
        percale_mesh_free(mesh);
        return percale_scene_out_of_memory(error);
    }
    fill_positions(columns, rows, corner, along, across, mesh->positions);
    fill_triangles(columns, rows, mesh->triangles);
    return true;
}
