#include "solve/solve_arrays.h"

/// C = |xa - xb| - l;  dlambda = (-C - alpha lambda) / (wa + wb + alpha), alpha = compliance / dt^2.
void percale_solve_stretch(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    const PercaleModel *model = arrays->model;
    float inverse_dt2 = 1.0f / (arrays->dt * arrays->dt);
    for (uint32_t e = begin; e < end; e++) {
        f32x4 *a = &arrays->x[model->edges[e][0]];
        f32x4 *b = &arrays->x[model->edges[e][1]];
        f32x4 xa = *a;
        f32x4 xb = *b;
        f32x4 between = with_w(xa - xb, 0.0f);
        float length = length3(between);
        float alpha = model->edge_compliances == NULL ? 0.0f : model->edge_compliances[e] * inverse_dt2;
        float weight = xa[3] + xb[3] + alpha;
        if (length <= 0.0f || weight <= 0.0f) {
            continue; // no direction, or nothing to move
        }
        float multiplier = arrays->edge_multipliers == NULL ? 0.0f : arrays->edge_multipliers[e];
        float change = (model->edge_lengths[e] - length - alpha * multiplier) / weight;
        if (arrays->edge_multipliers != NULL) {
            arrays->edge_multipliers[e] = multiplier + change;
        }
        f32x4 push = between * (change / length);
        move_point(a, xa, push, xa[3]);
        move_point(b, xb, push, -xb[3]);
    }
}
