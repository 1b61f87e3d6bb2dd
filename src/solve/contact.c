#include "solve/solve_arrays.h"

/// The four points of a stencil with what one projection needs of them.
typedef struct Gathered {
    f32x4 x[4];
    float weight; // sum w_k a_k^2
} Gathered;

static Gathered gather(const PercaleSolveArrays *arrays, const PercaleStencil *stencil)
{
    Gathered gathered = {.weight = 0.0f};
    for (int k = 0; k < 4; k++) {
        gathered.x[k] = arrays->x[stencil->points[k]];
        gathered.weight += gathered.x[k][3] * stencil->weights[k] * stencil->weights[k];
    }
    return gathered;
}

/// dx_k = w_k a_k impulse; a point that has no weight or can't move is not written.
static void apply(const PercaleSolveArrays *arrays, const PercaleStencil *stencil, Gathered *gathered,
                  f32x4 impulse)
{
    for (int k = 0; k < 4; k++) {
        float share = gathered->x[k][3] * stencil->weights[k];
        if (share != 0.0f) {
            gathered->x[k] += impulse * share;
            arrays->x[stencil->points[k]] = gathered->x[k];
        }
    }
}

/// n . sum a_k x_k - h, from differences to the first point (the weights sum to 0).
static float constraint(const PercaleStencil *stencil, const Gathered *gathered)
{
    f32x4 offset = {0};
    for (int k = 1; k < 4; k++) {
        offset += (gathered->x[k] - gathered->x[0]) * stencil->weights[k];
    }
    return dot3(stencil->normal, offset) - stencil->normal[3];
}

/// Coulomb on the substep's total: the friction vector undoes the slip as far as |lambda_t| <= mu lambda_n
/// allows, so what holds, holds without creeping, and what slides is braked by mu lambda_n exactly.
static f32x4 friction_impulse(const PercaleSolveArrays *arrays, PercaleStencil *stencil,
                              const Gathered *gathered, float normal_multiplier)
{
    f32x4 slip = {0};
    for (int k = 1; k < 4; k++) {
        f32x4 moved = gathered->x[k] - arrays->start[stencil->points[k]];
        f32x4 first = gathered->x[0] - arrays->start[stencil->points[0]];
        slip += (moved - first) * stencil->weights[k];
    }
    slip = with_w(slip, 0.0f);
    f32x4 normal = with_w(stencil->normal, 0.0f);
    slip -= normal * dot3(normal, slip);
    f32x4 before = with_w(stencil->multiplier, 0.0f);
    f32x4 wanted = before - slip / gathered->weight;
    float size = length3(wanted);
    float most = stencil->friction * normal_multiplier;
    f32x4 after = size > most ? wanted * (most / size) : wanted;
    stencil->multiplier = with_w(after, normal_multiplier);
    return after - before;
}

static void project(const PercaleSolveArrays *arrays, PercaleStencil *stencil)
{
    Gathered gathered = gather(arrays, stencil);
    if (gathered.weight <= 0.0f) {
        return;
    }
    float before = stencil->multiplier[3];
    float wanted = before - constraint(stencil, &gathered) / gathered.weight;
    float after = wanted > 0.0f ? wanted : 0.0f; // lambda_n >= 0: contact pushes, never pulls
    if (after <= 0.0f && before <= 0.0f) {
        return;
    }
    apply(arrays, stencil, &gathered, with_w(stencil->normal, 0.0f) * (after - before));
    f32x4 friction = friction_impulse(arrays, stencil, &gathered, after);
    apply(arrays, stencil, &gathered, friction);
}

void percale_solve_contact(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i++) {
        project(arrays, &arrays->stencils[arrays->stencil_order[i]]);
    }
}
