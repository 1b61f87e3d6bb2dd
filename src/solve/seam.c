#include "solve/solve_arrays.h"

void percale_solve_seam(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    for (uint32_t s = begin; s < end; s++) {
        f32x4 *a = &arrays->x[arrays->model->open_seams[s].slots[0]];
        f32x4 *b = &arrays->x[arrays->model->open_seams[s].slots[1]];
        f32x4 xa = *a;
        f32x4 xb = *b;
        f32x4 between = with_w(xa - xb, 0.0f);
        float length = length3(between);
        float weight = xa[3] + xb[3];
        if (length <= arrays->seam_targets[s] || weight <= 0.0f) {
            continue; // closing further than asked is welcome
        }
        f32x4 push = between * ((arrays->seam_targets[s] - length) / (weight * length));
        *a = xa + push * xa[3];
        *b = xb - push * xb[3];
    }
}
