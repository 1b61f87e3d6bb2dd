// tangle_sheet.h: sheets bent by a map, of which tangles are made.

#ifndef PERCALE_TANGLE_SHEET_H
#define PERCALE_TANGLE_SHEET_H

#include "percale/scene.h"

static const double TANGLE_SIZE = 0.4; // m, of a sheet

typedef struct Place {
    double x, y, z;
} Place;

/// Puts the point (u, v) of a pattern, m, into space.
typedef Place Map(const void *context, double u, double v);

typedef struct Pattern {
    const char *name;
    double u[2], v[2]; // m, from and to
    double edge;       // m
    Map *map;
    const void *context;
} Pattern;

/// Nothing in it is quite regular. False without memory.
bool tangle_sheet_make(const Pattern *pattern, uint64_t *seed, PercaleMesh *mesh);

#endif
