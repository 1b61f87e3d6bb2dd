#include "tangle_sheet.h"

#include "bench_random.h"
#include "scene/shapes.h"

#include <math.h>

static const double JITTER = 0.05; // of an edge

static uint32_t cells(const double range[2], double edge)
{
    double count = floor((range[1] - range[0]) / edge + 0.5);
    return count < 2.0 ? 2 : (uint32_t)count;
}

bool tangle_sheet_make(const Pattern *pattern, uint64_t *seed, PercaleMesh *mesh)
{
    PercaleSceneError error = {""};
    const double corner[3] = {pattern->u[0], pattern->v[0], 0.0};
    const double along[3] = {pattern->u[1] - pattern->u[0], 0.0, 0.0};
    const double across[3] = {0.0, pattern->v[1] - pattern->v[0], 0.0};
    if (!percale_sheet_make(pattern->name, cells(pattern->u, pattern->edge) + 1,
                            cells(pattern->v, pattern->edge) + 1, corner, along, across, mesh, &error)) {
        return false;
    }
    double jitter = JITTER * pattern->edge;
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        float *x = mesh->positions + 3 * (size_t)i;
        Place place = pattern->map(pattern->context, (double)x[0], (double)x[1]);
        x[0] = (float)(place.x + jitter * bench_random_signed(seed));
        x[1] = (float)(place.y + jitter * bench_random_signed(seed));
        x[2] = (float)(place.z + jitter * bench_random_signed(seed));
    }
    return true;
}
