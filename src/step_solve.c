// step_solve.c: hands the solver's arrays to color and solve.

#include "substep.h"

#include "base/parallel.h"
#include "solve/coarse_sweep.h"
#include "solve/held_bending.h"

#include <stdatomic.h>
#include <string.h>

static const float SEAM_SPEED = 0.5f; // m/s at which the gap of an open seam closes

enum { GRAIN_STENCILS = 512 }; // per chunk; even, as the kernels take two at a time

// ---- color ----

// A stencil whose gap is this many of its distances wide touches nothing: it chooses its colour after those
// that do, whose order it would shuffle by coming and going.
static const float FAR_GAP = 1.5f;

/// What the chunks of the stencils share.
typedef struct Waits {
    const PercaleStencil *stencils;
    const f32x4 *x;
    uint8_t *waits;
} Waits;

static void find_waits(void *context, uint32_t first, uint32_t end)
{
    const Waits *waits = context;
    for (uint32_t i = first; i < end; i++) {
        const PercaleStencil *stencil = &waits->stencils[i];
        f32x4 offset = stencil_offset(stencil, waits->x);
        waits->waits[i] = dot3(stencil->normal, offset) > FAR_GAP * stencil->normal[3];
    }
}

/// Which stencils are far from touching. NULL without memory.
static const uint8_t *waits_of(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    uint32_t count = (uint32_t)solver->stencils.count;
    Waits waits = {solver->stencils.items, solver->model.predicted,
                   percale_arena_new(&solver->arena, count, sizeof(uint8_t))};
    if (waits.waits != NULL) {
        percale_team_for(substep->team, count, GRAIN_STENCILS, find_waits, &waits);
    }
    return waits.waits;
}

PercaleResult percale_color_contacts(Substep *substep, bool pass)
{
    PercaleSolver *solver = substep->solver;
    const PercaleStencil *stencils = solver->stencils.items;
    uint32_t count = (uint32_t)solver->stencils.count;
    if (!pass && !substep->renewed && count == solver->pass_stencil_count &&
        count == solver->contact_coloring.count) {
        return PERCALE_OK; // those of the last pass, which have their colours
    }
    PercaleConstraints constraints = {
        .vertices = count > 0 ? stencils[0].points : NULL,
        .vertex_stride = sizeof(PercaleStencil) / sizeof(uint32_t),
        .weights = count > 0 ? stencils[0].weights : NULL,
        .weight_stride = sizeof(PercaleStencil) / sizeof(float),
        .arity = 4,
        .count = count,
        .waits = waits_of(substep),
    };
    bool complete =
        constraints.waits != NULL &&
        percale_coloring_run(&solver->contact_coloring, &solver->color_memory, &constraints,
                             solver->model.predicted, solver->model.point_count) &&
        percale_batch_coloring(&solver->contact_coloring, &solver->color_memory, &solver->contacts);
    if (!complete) {
        return percale_fail_memory(&solver->error);
    }
    const PercaleColoring *coloring = &solver->contact_coloring;
    if (coloring->color_count > solver->counters.colors_max) {
        solver->counters.colors_max = coloring->color_count;
    }
    solver->counters.overflow += count - coloring->first[coloring->color_count];
    end_stage(substep, PERCALE_STAGE_COLOR);
    return PERCALE_OK;
}
// ---- solve ----

void percale_begin_solve(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    const PercaleModel *model = &solver->model;
    if (solver->edge_multipliers != NULL) {
        memset(solver->edge_multipliers, 0, model->edge_count * sizeof(float));
    }
    if (solver->hinge_multipliers != NULL) {
        memset(solver->hinge_multipliers, 0, model->hinge_count * sizeof(f32x4));
    }
    if (model->hinge_count > 0 && solver->bend_dt != substep->dt) {
        solver->bend_interval =
            percale_solve_bend_interval(model, substep->dt, (uint32_t)solver->def.substeps);
        percale_solve_bend_prepare(model, substep->dt, solver->bend_interval, solver->bend_weights,
                                   solver->bend_relaxations);
        solver->bend_dt = substep->dt;
    }
    for (uint32_t s = 0; s < model->open_seam_count; s++) {
        const uint32_t *slots = model->open_seams[s].slots;
        float closes = solver->stands_still ? 0.0f : SEAM_SPEED * substep->dt;
        float gap = length3(model->position[slots[0]] - model->position[slots[1]]) - closes;
        solver->seam_targets[s] = gap > 0.0f ? gap : 0.0f;
    }
    end_stage(substep, PERCALE_STAGE_SOLVE);
}

PercaleSolveArrays percale_solve_arrays(const Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    return (PercaleSolveArrays){model,
                                model->predicted,
                                model->position,
                                model->next_velocity,
                                substep->dt,
                                solver->edge_multipliers,
                                solver->bend_weights,
                                solver->bend_relaxations,
                                solver->hinge_multipliers,
                                solver->seam_targets,
                                solver->stencils.items,
                                solver->contact_coloring.order};
}

PercaleResult percale_hold_bending(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    if (!is_bending_held(solver) || !is_bending_due(substep)) {
        return PERCALE_OK;
    }
    PercaleHeldBending held = {.plan = {.arrays = percale_solve_arrays(substep),
                                        .hinges = &solver->hinges,
                                        .sweep_count = (uint32_t)solver->def.iterations},
                               .interval = solver->bend_interval,
                               .pushes = solver->bend_pushes};
    if (!percale_held_bending_run(&held, substep->team, &solver->arena)) {
        return percale_fail_memory(&solver->error);
    }
    uint64_t bend = (uint64_t)held.plan.sweep_count * solver->model.hinge_count;
    solver->counters.projections_bend += bend;
    solver->counters.projections += bend;
    end_stage(substep, PERCALE_STAGE_SOLVE);
    return PERCALE_OK;
}

PercaleResult percale_solve_coarse(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    const PercaleCoarse *coarse = &solver->model.coarse;
    if (solver->def.levels == 0 || coarse->level_count == 0) {
        return PERCALE_OK;
    }
    if (!percale_coarse_sweep(coarse, solver->links, solver->model.predicted, substep->team,
                              &solver->arena)) {
        return percale_fail_memory(&solver->error);
    }
    for (uint32_t i = 0; i < coarse->level_count; i++) {
        solver->counters.projections_link += coarse->levels[i].link_count;
        solver->counters.projections += coarse->levels[i].link_count;
    }
    end_stage(substep, PERCALE_STAGE_SOLVE);
    return PERCALE_OK;
}

PercaleResult percale_solve(Substep *substep, uint32_t sweep_count)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    bool bends = model->hinge_count > 0 && solver->bend_interval == 1;
    PercaleBatches none = {0};
    PercaleSweepPlan plan = {
        .arrays = percale_solve_arrays(substep),
        .edges = &solver->edges,
        .hinges = bends ? &solver->hinges : &none,
        .contacts = &solver->contacts,
        .sweep_count = sweep_count,
    };
    if (!percale_sweep_run(&plan, substep->team, &solver->arena)) {
        return percale_fail_memory(&solver->error);
    }
    PercaleCounters *counters = &solver->counters;
    uint64_t stretch = (uint64_t)sweep_count * model->edge_count;
    uint64_t bend = bends ? (uint64_t)sweep_count * model->hinge_count : 0;
    uint64_t tether = (uint64_t)sweep_count * model->tether_count;
    uint64_t seam = (uint64_t)sweep_count * model->open_seam_count;
    uint64_t contact = (uint64_t)sweep_count * solver->contacts.count;
    counters->projections_stretch += stretch;
    counters->projections_bend += bend;
    counters->projections_tether += tether;
    counters->projections_seam += seam;
    counters->projections_contact += contact;
    counters->projections += stretch + bend + tether + seam + contact;
    end_stage(substep, PERCALE_STAGE_SOLVE);
    return PERCALE_OK;
}

/// What the chunks of the stencils' end share.
typedef struct Slips {
    PercaleSolveArrays arrays;
    atomic_bool any_leaves;
} Slips;

static void keep_slips(void *context, uint32_t first, uint32_t end)
{
    Slips *slips = context;
    if (percale_solve_contact_slips(&slips->arrays, first, end)) {
        atomic_store_explicit(&slips->any_leaves, true, memory_order_relaxed);
    }
}

bool percale_end_solve(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleSweepPlan plan = {.arrays = percale_solve_arrays(substep), .contacts = &solver->contacts};
    if (solver->model.rank_count > 1 && !solver->stands_still) { // what is held heavy takes momentum
        if (!percale_sweep_outwards(&plan, substep->team, &solver->arena)) {
            return false;
        }
        solver->counters.projections_contact += solver->contacts.count;
        solver->counters.projections += solver->contacts.count;
    }
    Slips slips = {.arrays = plan.arrays};
    percale_team_for(substep->team, (uint32_t)solver->stencils.count, GRAIN_STENCILS, keep_slips, &slips);
    substep->any_leaves = slips.any_leaves || (solver->healing.is_tangled && !solver->stands_still);
    end_stage(substep, PERCALE_STAGE_SOLVE);
    return true;
}
