#include "solve/solve_arrays.h"

// No point is moved farther than this many times the violation: where only points of small weight can move
// (the others are held), the lever would be as long as one likes.
static const float LONGEST_LEVER = 4.0f;

/// Two stencils with the points that they name, every scalar spread over its half.
typedef struct Gathered {
    PercaleStencil *stencils[2]; // the same twice at the end of an odd number
    f32x8 x[4];
    f32x8 share[4]; // w_k a_k
    f32x8 a[4];
    f32x8 weight; // sum w_k a_k^2, but for the longest lever
    f32x8 normal; // fourth components 0
    f32x8 target;
} Gathered;

static inline Gathered gather(const PercaleSolveArrays *arrays, PercaleStencil *low, PercaleStencil *high)
{
    Gathered gathered = {.stencils = {low, high}, .weight = all8(0.0f)};
    f32x4 weights_low = {low->weights[0], low->weights[1], low->weights[2], low->weights[3]};
    f32x4 weights_high = {high->weights[0], high->weights[1], high->weights[2], high->weights[3]};
    f32x8 weights = pair_of_points(weights_low, weights_high);
    f32x8 a[4] = {SPREAD(weights, 0), SPREAD(weights, 1), SPREAD(weights, 2), SPREAD(weights, 3)};
    f32x8 farthest = all8(0.0f);
    for (int k = 0; k < 4; k++) {
        gathered.x[k] = pair_of_points(arrays->x[low->points[k]], arrays->x[high->points[k]]);
        gathered.a[k] = a[k];
        gathered.share[k] = SPREAD(gathered.x[k], 3) * a[k];
        gathered.weight += gathered.share[k] * a[k];
        farthest = max8(farthest, max8(gathered.share[k], -gathered.share[k]));
    }
    gathered.weight = max8(gathered.weight, farthest / LONGEST_LEVER);
    f32x8 normal = pair_of_points(low->normal, high->normal);
    gathered.normal = without_w(normal);
    gathered.target = SPREAD(normal, 3);
    return gathered;
}

/// dx_k = w_k a_k impulse.
static inline void apply(Gathered *gathered, f32x8 impulse)
{
    for (int k = 0; k < 4; k++) {
        gathered->x[k] += impulse * gathered->share[k];
    }
}

/// A point that has no weight or can't move is not even written: stencils of one colour may share it.
static inline void store(const PercaleSolveArrays *arrays, const Gathered *gathered)
{
    for (int k = 0; k < 4; k++) {
        f32x8 share = gathered->share[k];
        if (share[0] != 0.0f) {
            arrays->x[gathered->stencils[0]->points[k]] = low_point(gathered->x[k]);
        }
        if (share[4] != 0.0f) {
            arrays->x[gathered->stencils[1]->points[k]] = high_point(gathered->x[k]);
        }
    }
}

/// n . sum a_k x_k - h, from differences to the first point (the weights sum to 0).
static inline f32x8 constraint(const Gathered *gathered)
{
    f32x8 offset = (gathered->x[1] - gathered->x[0]) * gathered->a[1];
    offset += (gathered->x[2] - gathered->x[0]) * gathered->a[2];
    offset += (gathered->x[3] - gathered->x[0]) * gathered->a[3];
    return dot3_pairs(gathered->normal, offset) - gathered->target;
}

/// How the stencil has slipped along its surface since the substep began.
static inline f32x8 slip_of(const PercaleSolveArrays *arrays, const Gathered *gathered)
{
    const uint32_t *low = gathered->stencils[0]->points;
    const uint32_t *high = gathered->stencils[1]->points;
    f32x8 slip = all8(0.0f);
    f32x8 first = gathered->x[0] - pair_of_points(arrays->start[low[0]], arrays->start[high[0]]);
    for (int k = 1; k < 4; k++) {
        f32x8 moved = gathered->x[k] - pair_of_points(arrays->start[low[k]], arrays->start[high[k]]);
        slip += (moved - first) * gathered->a[k];
    }
    slip = without_w(slip);
    return slip - gathered->normal * dot3_pairs(gathered->normal, slip);
}

/// Coulomb on the substep's total: the friction vector undoes the slip as far as |lambda_t| <= mu lambda_n
/// allows, so what holds, holds without creeping, and what slides is braked by mu lambda_n exactly.
static inline f32x8 friction_after(const PercaleSolveArrays *arrays, const Gathered *gathered, f32x8 before,
                                   f32x8 normal_multiplier)
{
    f32x8 wanted = before - slip_of(arrays, gathered) / gathered->weight;
    f32x8 size = sqrt8(dot3_pairs(wanted, wanted));
    f32x8 most =
        spread_two(gathered->stencils[0]->friction, gathered->stencils[1]->friction) * normal_multiplier;
    return select8(greater8(size, most), wanted * (most / size), wanted);
}

static inline void project(const PercaleSolveArrays *arrays, PercaleStencil *low, PercaleStencil *high)
{
    Gathered gathered = gather(arrays, low, high);
    f32x8 multiplier = pair_of_points(low->multiplier, high->multiplier);
    f32x8 before = SPREAD(multiplier, 3);
    f32x8 wanted = before - constraint(&gathered) / gathered.weight;
    f32x8 after = max8(wanted, all8(0.0f)); // lambda_n >= 0: contact pushes, never pulls
    i32x8 acts =
        greater8(gathered.weight, all8(0.0f)) & (greater8(after, all8(0.0f)) | greater8(before, all8(0.0f)));
    if (lane_bits(acts) == 0) {
        return;
    }
    for (int k = 0; k < 4; k++) {
        gathered.share[k] = where8(acts, gathered.share[k]); // the other of the two is not touched
    }
    after = where8(acts, after);
    apply(&gathered, gathered.normal * (after - before));
    f32x8 friction = without_w(multiplier);
    f32x8 friction_now = friction_after(arrays, &gathered, friction, after);
    apply(&gathered, friction_now - friction);
    store(arrays, &gathered);
    f32x8 kept = select8((i32x8){0, 0, 0, -1, 0, 0, 0, -1}, after, friction_now);
    multiplier = select8(acts, kept, multiplier);
    low->multiplier = low_point(multiplier);
    high->multiplier = high_point(multiplier);
}

void percale_solve_contact(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i += 2) {
        PercaleStencil *low = &arrays->stencils[arrays->stencil_order[i]];
        PercaleStencil *high = i + 1 < end ? &arrays->stencils[arrays->stencil_order[i + 1]] : low;
        project(arrays, low, high);
    }
}
