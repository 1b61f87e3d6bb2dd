// solver_reading.h: what the caller gives, checked and copied. A function that fails has set the solver's
// error.

#ifndef PERCALE_SOLVER_READING_H
#define PERCALE_SOLVER_READING_H

#include "solver.h"

static const float FARTHEST =
    1e6f; // m from the origin; beyond it float32 has no millimetres left: use `origin`

/// An array of points with a stride in bytes (0: 12).
PercaleResult percale_check_array(PercaleSolver *solver, const char *what, const float *array, size_t stride);

/// Reads count points with a stride (0: 12 bytes) into packed floats; fails on a coordinate that is not
/// finite or too large, naming its index in `what`.
PercaleResult percale_read_points(PercaleSolver *solver, const char *what, const float *source, size_t stride,
                                  uint32_t count, float *points);

PercaleResult percale_check_triangles(PercaleSolver *solver, const char *what, const uint32_t *triangles,
                                      uint32_t triangle_count, uint32_t vertex_count);

/// Lengths of all triangle sides in a shape of 2 or 3 floats a vertex, and areas where asked for; refuses
/// triangles without area.
PercaleResult percale_measure_sides(PercaleSolver *solver, const char *what, const float *shape,
                                    uint32_t dimensions, const uint32_t *triangles, uint32_t triangle_count,
                                    float *lengths, double *areas);

PercaleResult percale_check_material(PercaleSolver *solver, const char *what,
                                     const PercaleMaterial *material);

/// Without a name it is that of its kind and number.
void percale_copy_name(char target[NAME_SIZE], const char *name, const char *kind, uint32_t id);

#endif
