#include "solve/solve_arrays.h"

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

/// How the two surfaces have moved against each other since the substep began.
static inline f32x8 motion_of(const PercaleSolveArrays *arrays, const Gathered *gathered)
{
    const uint32_t *low = gathered->stencils[0]->points;
    const uint32_t *high = gathered->stencils[1]->points;
    f32x8 motion = all8(0.0f);
    f32x8 first = gathered->x[0] - pair_of_points(arrays->start[low[0]], arrays->start[high[0]]);
    for (int k = 1; k < 4; k++) {
        f32x8 moved = gathered->x[k] - pair_of_points(arrays->start[low[k]], arrays->start[high[k]]);
        motion += (moved - first) * gathered->a[k];
    }
    return without_w(motion);
}

/// The part of a motion along the surface, and what friction owes from earlier.
static inline f32x8 slip_of(const Gathered *gathered, f32x8 motion)
{
    f32x8 slip = motion - gathered->normal * dot3_pairs(gathered->normal, motion);
    return slip + pair_of_points(gathered->stencils[0]->owed, gathered->stencils[1]->owed);
}

/// What friction comes to.
typedef struct Friction {
    f32x8 multiplier;
    f32x8 held; // share of what was wanted
} Friction;

/// Coulomb on the substep's total: the friction vector undoes the slip as far as |lambda_t| <= mu lambda_n
/// allows, so what holds, holds without creeping, and what slides is braked by mu lambda_n exactly.
static inline Friction friction_after(const PercaleSolveArrays *arrays, const Gathered *gathered,
                                      f32x8 before, f32x8 normal_multiplier)
{
    f32x8 wanted = before - slip_of(gathered, motion_of(arrays, gathered)) / gathered->weight;
    f32x8 size = sqrt8(dot3_pairs(wanted, wanted));
    f32x8 most =
        spread_two(gathered->stencils[0]->friction, gathered->stencils[1]->friction) * normal_multiplier;
    f32x8 held = select8(greater8(size, most), most / size, all8(1.0f));
    return (Friction){wanted * held, held};
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
    Friction friction_now = friction_after(arrays, &gathered, friction, after);
    apply(&gathered, friction_now.multiplier - friction);
    store(arrays, &gathered);
    f32x8 kept = select8((i32x8){0, 0, 0, -1, 0, 0, 0, -1}, after, friction_now.multiplier);
    multiplier = select8(acts, kept, multiplier);
    low->multiplier = low_point(multiplier);
    high->multiplier = high_point(multiplier);
    low->held = friction_now.held[0]; // of one that doesn't act nobody asks
    high->held = friction_now.held[4];
}

void percale_solve_contact(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i += 2) {
        PercaleStencil *low = &arrays->stencils[arrays->stencil_order[i]];
        PercaleStencil *high = i + 1 < end ? &arrays->stencils[arrays->stencil_order[i + 1]] : low;
        project(arrays, low, high);
    }
}

// Speed of a contact that opens below which nobody sees it pop, m/s: it would rise half a millimetre.
static const float SLOW_EXIT = 0.1f;

/// Slip that is left when the last sweep is done, without the part that the cone has refused: the anchor is
/// dragged along by that. What remains is what others have moved the pair after its own turn.
static inline f32x8 slip_left(const Gathered *gathered, f32x8 motion, f32x8 multiplier)
{
    const PercaleStencil *low = gathered->stencils[0];
    const PercaleStencil *high = gathered->stencils[1];
    f32x8 held = spread_two(low->held, high->held);
    f32x8 refused = without_w(multiplier) * gathered->weight * (all8(1.0f) - all8(1.0f) / held);
    f32x8 most = spread_two(low->friction, high->friction) * SPREAD(multiplier, 3);
    i32x8 pulls = greater8(most, all8(0.0f)) & greater8(held, all8(0.0f));
    return where8(pulls, slip_of(gathered, motion) - refused);
}

bool percale_solve_contact_slips(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    bool any_leaves = false;
    for (uint32_t i = begin; i < end; i += 2) {
        PercaleStencil *low = &arrays->stencils[i];
        PercaleStencil *high = i + 1 < end ? low + 1 : low;
        if (!(low->multiplier[3] > 0.0f) && !(high->multiplier[3] > 0.0f)) { // many only stand by
            low->owed = high->owed = (f32x4){0};
            continue;
        }
        Gathered gathered = gather(arrays, low, high);
        f32x8 motion = motion_of(arrays, &gathered);
        f32x8 multiplier = pair_of_points(low->multiplier, high->multiplier);
        f32x8 slip = slip_left(&gathered, motion, multiplier);
        low->owed = low_point(slip);
        high->owed = high_point(slip);
        f32x8 rise = dot3_pairs(gathered.normal, motion);
        i32x8 leaves =
            greater8(rise, all8(SLOW_EXIT * arrays->dt)) & greater8(SPREAD(multiplier, 3), all8(0.0f));
        any_leaves = any_leaves || lane_bits(leaves) != 0;
    }
    return any_leaves;
}

/// A contact whose overlap is being undone.
typedef struct Exit {
    float overlap;       // m, when the substep began
    float speed, before; // m/s at which it opens, and did when the substep began
    float weight;        // sum w_k a_k^2
} Exit;

static Exit exit_of(const PercaleSolveArrays *arrays, const PercaleStencil *stencil)
{
    f32x4 offset = {0};
    f32x4 velocity = {0};
    f32x4 before = {0};
    float weight = 0.0f;
    float farthest = 0.0f;
    for (int k = 0; k < 4; k++) {
        uint32_t point = stencil->points[k];
        bool moves = point < arrays->model->slot_count; // else it is an obstacle's
        f32x4 carried = (arrays->x[point] - arrays->start[point]) / arrays->dt;
        float a = stencil->weights[k];
        offset += (arrays->start[point] - arrays->start[stencil->points[0]]) * a;
        velocity += (moves ? arrays->velocity[point] : carried) * a;
        before += (moves ? arrays->model->velocity[point] : carried) * a;
        weight += arrays->x[point][3] * a * a;
        farthest = fmaxf(farthest, arrays->x[point][3] * fabsf(a));
    }
    weight = fmaxf(weight, farthest / LONGEST_LEVER);
    return (Exit){stencil->normal[3] - dot3(stencil->normal, offset), dot3(stencil->normal, velocity),
                  dot3(stencil->normal, before), weight};
}

void percale_solve_contact_exit(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    for (uint32_t i = begin; i < end; i++) {
        const PercaleStencil *stencil = &arrays->stencils[arrays->stencil_order[i]];
        Exit leaving = exit_of(arrays, stencil);
        float gained = leaving.speed - fmaxf(leaving.before, 0.0f);
        float speed = fminf(gained, leaving.overlap / arrays->dt);
        if (!(stencil->multiplier[3] > 0.0f) || !(speed > 0.0f) || !(leaving.weight > 0.0f)) {
            continue;
        }
        f32x4 taken = with_w(stencil->normal * (speed / leaving.weight), 0.0f);
        for (int k = 0; k < 4; k++) {
            float share = arrays->x[stencil->points[k]][3] * stencil->weights[k];
            if (share != 0.0f) {
                arrays->velocity[stencil->points[k]] -= taken * share;
            }
        }
    }
}
