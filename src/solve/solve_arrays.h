// solve_arrays.h: what the solver kernels work on within one substep.
//
//   in   constraints in colour order, inverse masses in points[v][3]
//   out  predicted, moved until the constraints hold as well as the sweeps allow

#ifndef PERCALE_SOLVE_ARRAYS_H
#define PERCALE_SOLVE_ARRAYS_H

#include "base/wide.h"
#include "color/batch.h"
#include "detect/stencil.h"
#include "model/model.h"

typedef struct PercaleSolveArrays {
    const PercaleModel *model;
    f32x4 *x;                      // predicted points
    const f32x4 *start;            // where they were when the substep began
    f32x4 *velocity;               // new ones, once they are known: for percale_solve_contact_exit
    float dt;                      // s
    float *edge_multipliers;       // [edge_count] N s^2; NULL when no edge has a compliance
    const f32x4 *bend_weights;     // [hinge_count]; see percale_solve_bend_prepare
    const float *bend_relaxations; // [hinge_count]; NULL with the multipliers
    f32x4 *hinge_multipliers;      // [hinge_count]; NULL when one sweep needs none
    const float *seam_targets;     // [open_seam_count] m, gap that an open seam is pulled to in this substep
    PercaleStencil *stencils;
    const uint32_t *stencil_order; // by colour
} PercaleSolveArrays;

/// The point of a batched constraint.
static inline f32x4 *point_at(f32x4 *x, uint32_t offset)
{
    return (f32x4 *)(void *)((char *)x + offset);
}

/// Every kernel projects the constraints [begin, end) of its kind, which share no vertex: any order, and
/// eight at a time, gives the same bits.
typedef void PercaleKernel(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end);

/// Distance constraints, XPBD (Macklin et al. 2016, eq. 18): C = |xa - xb| - l, compliance in m/N.
PercaleKernel percale_solve_stretch;
/// Isometric bending as a linear vector constraint: C = sum c_k x_k = 0.
PercaleKernel percale_solve_bend;
/// Tethers of the slots [begin, end): a vertex is no farther from its anchors than the cloth is long.
PercaleKernel percale_solve_tether;
/// Open seams: the gap of a pair is pulled to its target of this substep. One after the other: they may share
/// vertices.
PercaleKernel percale_solve_seam;
/// Contact stencils with Coulomb friction. Stencils may share points that can't move.
PercaleKernel percale_solve_contact;
/// After the last sweep: what of their slip the stencils [begin, end), in the order of the list, hand on to
/// the next substep. Whether any of them opens so fast that percale_solve_contact_exit is worth while.
bool percale_solve_contact_slips(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end);
/// Takes the velocity away with which an overlap at the start was undone: a correction is no motion.
PercaleKernel percale_solve_contact_exit;

/// Every how many substeps the force of bending needs to be found (multiple time stepping: Tuckerman et al.
/// 1992): 1 where it is stiff, up to 20 where even so the fastest hinge turns
/// slowly. It divides substep_count.
uint32_t percale_solve_bend_interval(const PercaleModel *model, float dt, uint32_t substep_count);

/// What bending needs of dt, with kappa = stiffness dt^2 interval and r = 1 / (kappa sum w c^2 + 1): weights
/// sqrt(kappa r) c, and relaxations r (may be NULL). Both [hinge_count].
void percale_solve_bend_prepare(const PercaleModel *model, float dt, uint32_t interval, f32x4 *weights,
                                float *relaxations);

#endif
