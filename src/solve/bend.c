#include "solve/solve_arrays.h"

/// K = sum c_k x_k with the energy k / 2 |K|^2. In XPBD form, with kappa = k dt^2 and per component
/// dlambda = -(kappa K + lambda) / (kappa sum w c^2 + 1): no normals, no division by a small stiffness.
void percale_solve_bend(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    const PercaleModel *model = arrays->model;
    float dt2 = arrays->dt * arrays->dt;
    for (uint32_t h = begin; h < end; h++) {
        const uint32_t *v = model->hinges[h];
        f32x4 c = model->hinge_weights[h];
        f32x4 x0 = arrays->x[v[0]];
        f32x4 x1 = arrays->x[v[1]];
        f32x4 x2 = arrays->x[v[2]];
        f32x4 x3 = arrays->x[v[3]];
        // differences to the first point: far from the origin the sum keeps its digits
        f32x4 curvature = (x1 - x0) * c[1] + (x2 - x0) * c[2] + (x3 - x0) * c[3];
        float weight = x0[3] * c[0] * c[0] + x1[3] * c[1] * c[1] + x2[3] * c[2] * c[2] + x3[3] * c[3] * c[3];
        float kappa = model->hinge_stiffnesses[h] * dt2;
        f32x4 multiplier = arrays->hinge_multipliers == NULL ? (f32x4){0} : arrays->hinge_multipliers[h];
        f32x4 change = with_w(-(curvature * kappa + multiplier) / (kappa * weight + 1.0f), 0.0f);
        if (arrays->hinge_multipliers != NULL) {
            arrays->hinge_multipliers[h] = multiplier + change;
        }
        move_point(&arrays->x[v[0]], x0, change, c[0] * x0[3]);
        move_point(&arrays->x[v[1]], x1, change, c[1] * x1[3]);
        move_point(&arrays->x[v[2]], x2, change, c[2] * x2[3]);
        move_point(&arrays->x[v[3]], x3, change, c[3] * x3[3]);
    }
}
