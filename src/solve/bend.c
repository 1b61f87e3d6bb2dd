#include "solve/solve_arrays.h"

enum { LONGEST_BEND_INTERVAL = 20 };    // substeps
static const float SLOW_BENDING = 0.2f; // (omega dt)^2 of a hinge up to which an interval counts as short

/// K = sum c_k x_k with the energy k / 2 |K|^2. In XPBD form, with kappa = k dt^2 and per component
/// dlambda = -(kappa K + lambda) r, r = 1 / (kappa sum w c^2 + 1): no normals, no division by a small
/// stiffness. With e = sqrt(kappa r) c and lambda in units of sqrt(kappa r) that is x_k -= w_k e_k (sum e_j
/// x_j + r lambda). Two hinges; `second` is 1, or 0 for the last of an odd number.
static inline void project(const PercaleSolveArrays *arrays, uint32_t first, uint32_t second, bool again)
{
    const uint32_t *low = arrays->model->hinges[first];
    const uint32_t *high = arrays->model->hinges[first + second];
    f32x8 p[4];
    for (int k = 0; k < 4; k++) {
        p[k] = pair_of_points(*point_at(arrays->x, low[k]), *point_at(arrays->x, high[k]));
    }
    f32x8 weights = pair_of_points(arrays->bend_weights[first], arrays->bend_weights[first + second]);
    f32x8 e[4] = {SPREAD(weights, 0), SPREAD(weights, 1), SPREAD(weights, 2), SPREAD(weights, 3)};
    // differences to the first point: far from the origin the sum keeps its digits
    f32x8 change = ((p[1] - p[0]) * e[1] + (p[2] - p[0]) * e[2]) + (p[3] - p[0]) * e[3];
    change = without_w(change);
    if (again) {
        f32x4 *multipliers = arrays->hinge_multipliers + first;
        f32x8 multiplier = pair_of_points(multipliers[0], multipliers[second]);
        change += multiplier *
                  spread_two(arrays->bend_relaxations[first], arrays->bend_relaxations[first + second]);
        multiplier -= change;
        multipliers[0] = low_point(multiplier);
        multipliers[second] = high_point(multiplier);
    }
    for (int k = 0; k < 4; k++) {
        f32x8 moved = p[k] - change * (e[k] * SPREAD(p[k], 3));
        *point_at(arrays->x, low[k]) = low_point(moved);
        *point_at(arrays->x, high[k]) = high_point(moved);
    }
}

static inline void project_all(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end, bool again)
{
    uint32_t h = begin;
    for (; h + 2 <= end; h += 2) {
        project(arrays, h, 1, again);
    }
    if (h < end) {
        project(arrays, h, 0, again);
    }
}

void percale_solve_bend(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    if (arrays->hinge_multipliers == NULL) {
        project_all(arrays, begin, end, false);
    } else {
        project_all(arrays, begin, end, true);
    }
}

/// sum w c^2 of a hinge.
static float weight_of(const PercaleModel *model, uint32_t hinge)
{
    float weight = 0.0f;
    for (int k = 0; k < 4; k++) {
        float c = model->hinge_weights[hinge][k];
        weight += model->position[slot_at(model->hinges[hinge][k])][3] * c * c;
    }
    return weight;
}

uint32_t percale_solve_bend_interval(const PercaleModel *model, float dt, uint32_t substep_count)
{
    float stiffest = 0.0f; // of a hinge on its own: its (omega dt)^2
    for (uint32_t h = 0; h < model->hinge_count; h++) {
        float stiffness = model->hinge_stiffnesses[h] * weight_of(model, h) * (dt * dt);
        stiffest = stiffness > stiffest ? stiffness : stiffest;
    }
    uint32_t interval = LONGEST_BEND_INTERVAL;
    while (interval > 1 &&
           (substep_count % interval != 0 || stiffest * (float)(interval * interval) > SLOW_BENDING)) {
        interval--;
    }
    return interval;
}

void percale_solve_bend_prepare(const PercaleModel *model, float dt, uint32_t interval, f32x4 *weights,
                                float *relaxations)
{
    for (uint32_t h = 0; h < model->hinge_count; h++) {
        float kappa = model->hinge_stiffnesses[h] * (dt * dt * (float)interval);
        float relaxation = 1.0f / (kappa * weight_of(model, h) + 1.0f);
        f32x4 e = model->hinge_weights[h] * sqrtf(kappa * relaxation);
        e[3] = -((e[0] + e[1]) + e[2]); // the sum stays 0
        weights[h] = e;
        if (relaxations != NULL) {
            relaxations[h] = relaxation;
        }
    }
}
