// solve_arrays.h: what the solver kernels work on within one substep.
//
//   in   constraints in colour order, inverse masses in points[v][3]
//   out  predicted, moved until the constraints hold as well as the sweeps allow

#ifndef PERCALE_SOLVE_ARRAYS_H
#define PERCALE_SOLVE_ARRAYS_H

#include "color/batch.h"
#include "detect/stencil.h"
#include "model/model.h"

typedef struct PercaleSolveArrays {
    const PercaleModel *model;
    f32x4 *x;                  // predicted points
    const f32x4 *start;        // where they were when the substep began
    float dt;                  // s
    float *edge_multipliers;   // [edge_count] N s^2; NULL when no edge has a compliance
    f32x4 *hinge_multipliers;  // [hinge_count]; NULL when one sweep needs none
    const float *seam_targets; // [open_seam_count] m, gap that an open seam is pulled to in this substep
    PercaleStencil *stencils;
    const uint32_t *stencil_order; // by colour
} PercaleSolveArrays;

/// Writes before + share * push. A point that can't move is not even written: constraints of one colour may
/// share it.
static inline void move_point(f32x4 *point, f32x4 before, f32x4 push, float share)
{
    if (share != 0.0f) {
        *point = before + push * share;
    }
}

/// Every kernel projects the constraints [begin, end) of its kind, which share no movable vertex unless they
/// run on one thread.
typedef void PercaleKernel(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end);

/// Distance constraints, XPBD (Macklin et al. 2016, eq. 18): C = |xa - xb| - l, compliance in m/N.
PercaleKernel percale_solve_stretch;
/// Isometric bending as a linear vector constraint: C = sum c_k x_k = 0.
PercaleKernel percale_solve_bend;
/// Open seams: the gap of a pair is pulled to its target of this substep.
PercaleKernel percale_solve_seam;
/// Contact stencils with Coulomb friction.
PercaleKernel percale_solve_contact;

#endif
