// step.c: THE PIPELINE. One step is `substeps` times: predict, detect, color, solve, finish.
//
// Every stage is arrays in, arrays out, in the folder of its name; only this file knows their order.

#include "solver.h"

#include "base/parallel.h"
#include "base/timer.h"
#include "detect/carry.h"
#include "detect/renew.h"
#include "finish/advance.h"
#include "finish/guard.h"
#include "finish/pair_guard.h"
#include "predict/look_ahead.h"
#include "predict/obstacle_motion.h"
#include "predict/predict.h"
#include "solve/held_bending.h"
#include "solve/sweep.h"

#include <stdatomic.h>
#include <string.h>

static const float SEAM_SPEED = 0.5f; // m/s at which the gap of an open seam closes

enum { GRAIN_STENCILS = 512 }; // per chunk; even, as the kernels take two at a time

/// One substep of a step.
typedef struct Substep {
    PercaleSolver *solver;
    PercaleTeam *team;
    int index;       // 0 .. substeps - 1
    float dt;        // s
    double fraction; // of the step, at this substep's end
    bool has_pass;   // a collision pass falls into it
    bool any_leaves; // a contact opens fast
    bool renewed;    // stencils of pairs between passes
    double since;    // clock when the running stage began, s
} Substep;

static void end_stage(Substep *substep, PercaleStage stage)
{
    double now = percale_seconds();
    substep->solver->profile.stage_seconds[stage] += now - substep->since;
    substep->since = now;
}

// ---- predict ----

static f32x4 vector_of(const float v[3])
{
    return (f32x4){v[0], v[1], v[2], 0.0f};
}

static PercaleResult name_bad_vertex(PercaleSolver *solver, uint32_t slot)
{
    for (uint32_t c = 0; c < solver->model.cloth_count; c++) {
        for (uint32_t i = 0; i < solver->model.cloths[c].vertex_count; i++) {
            if (solver->model.cloths[c].slots[i] == slot) {
                return percale_fail(&solver->error, PERCALE_NOT_FINITE,
                                    "cloth '%s': vertex %u would become NaN or infinite",
                                    solver->objects.cloths[c].name, i);
            }
        }
    }
    return percale_fail(&solver->error, PERCALE_NOT_FINITE, "a vertex would become NaN or infinite");
}

/// Whether bending's force is found anew in this substep, where it acts less often than in each.
static bool is_bending_due(const Substep *substep)
{
    return (uint32_t)substep->index % substep->solver->bend_interval == 0;
}

static bool is_bending_held(const PercaleSolver *solver)
{
    return solver->model.hinge_count > 0 && solver->bend_interval > 1;
}

static PercaleResult predict(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    bool pushed = is_bending_held(solver) && !is_bending_due(substep);
    PercalePredictStage stage = {
        .model = &solver->model,
        .gravity = vector_of(solver->def.gravity),
        .wind = vector_of(solver->def.wind),
        .damping = (float)exp(-(double)solver->def.damping * (double)substep->dt),
        .speed_max = solver->def.speed_max,
        .dt = substep->dt,
        .pushes = pushed ? solver->bend_pushes : NULL,
    };
    uint32_t bad = percale_predict_cloth(&stage, substep->team);
    percale_predict_pins(&solver->model, solver->pin_from, solver->pin_to, (float)substep->fraction);
    end_stage(substep, PERCALE_STAGE_PREDICT);
    return bad == UINT32_MAX ? PERCALE_OK : name_bad_vertex(solver, bad);
}

// ---- detect ----

/// Collision pass i comes before sweep floor(i * S / P) of the step's S sweeps.
static bool is_pass_due(const PercaleSolverDef *def, uint64_t sweep)
{
    uint64_t sweeps = (uint64_t)def->substeps * (uint64_t)def->iterations;
    uint64_t passes = (uint64_t)def->passes;
    uint64_t i = (sweep * passes + sweeps - 1) / sweeps; // the first i with i * S / P >= sweep
    return i < passes && i * sweeps / passes == sweep;
}

/// Whether a collision pass comes before any sweep of the substep.
static bool has_pass(const PercaleSolverDef *def, int substep_index)
{
    uint64_t first = (uint64_t)substep_index * (uint64_t)def->iterations;
    bool due = false;
    for (uint64_t i = 0; i < (uint64_t)def->iterations; i++) {
        due = due || is_pass_due(def, first + i);
    }
    return due;
}

/// Substeps after this one until the next pass, at most.
static float later_substeps(const PercaleSolverDef *def)
{
    int between = (def->substeps + def->passes - 1) / def->passes;
    return (float)(between - 1);
}

static PercalePair pair_of(const Substep *substep, uint32_t obstacle)
{
    const PercaleSolver *solver = substep->solver;
    return (PercalePair){&solver->model, &solver->model.obstacles[obstacle],
                         substep->has_pass ? later_substeps(&solver->def) : 0.0f, substep->has_pass};
}

/// Moves the obstacle to the end of the substep; its tree is still at the start.
static void move_obstacle(Substep *substep, uint32_t o)
{
    PercaleSolver *solver = substep->solver;
    const PercaleObstacleObject *object = &solver->objects.obstacles[o];
    PercaleFrame *frame = &solver->frames[o];
    double before = (double)substep->index / (double)solver->def.substeps;
    frame->motion = object->moving ? object->motion : MOTION_STATIC;
    frame->is_in_own_space = object->motion == MOTION_RIGID;
    frame->start = percale_motion_between(&object->pose_from, &object->pose_to, before);
    frame->end = percale_motion_between(&object->pose_from, &object->pose_to, substep->fraction);
    solver->proximities[o].motion =
        object->moving ? percale_motion_apply(&solver->model, o, object, substep->fraction,
                                              (double)substep->dt * solver->def.substeps, substep->team)
                       : 0.0f;
    solver->proximities[o].traveled += (double)solver->proximities[o].motion;
    if (solver->def.ccd == PERCALE_CCD_OFF) {
        solver->proximities[o].doubt = INFINITY;
    } else { // next to a deforming surface the start of a path is moved along with the nearest triangle only
        solver->proximities[o].doubt =
            frame->motion == MOTION_DEFORMING ? 2.0f * solver->proximities[o].motion : 0.0f;
    }
}

/// Finds the vertices that can touch the obstacle, at its start pose, then takes tree and rays to the end
/// pose.
static bool find_active(Substep *substep, uint32_t o)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    PercaleProximity *proximity = &solver->proximities[o];
    PercalePair pair = pair_of(substep, o);
    PercaleSurface at_start = {pair.obstacle, &proximity->tree, model->position};
    uint64_t searches = percale_proximity_select(proximity, &pair, &at_start, substep->team);
    solver->counters.detections += searches;
    solver->counters.detections_skipped += model->slot_count - searches;
    if (proximity->motion > 0.0f) {
        percale_tree_refit(&proximity->tree, pair.obstacle->triangles, model->predicted, substep->team);
        if (solver->rays != NULL && solver->objects.obstacles[o].motion == MOTION_DEFORMING) {
            return percale_rays_refit(solver->rays, o, model->predicted + pair.obstacle->first_point);
        }
    }
    return true;
}

/// Nothing has been seen yet in this substep.
static bool begin_sightings(PercaleSolver *solver, PercaleProximity *proximity)
{
    proximity->sightings =
        percale_arena_new(&solver->arena, proximity->active_count, sizeof(PercaleSighting));
    for (uint32_t i = 0; proximity->sightings != NULL && i < proximity->active_count; i++) {
        proximity->sightings[i].nearest = NO_TRIANGLE;
    }
    return proximity->sightings != NULL;
}

static bool cast_paths(Substep *substep, uint32_t o)
{
    PercaleSolver *solver = substep->solver;
    PercaleProximity *proximity = &solver->proximities[o];
    solver->crossings[o] = NULL;
    if (solver->def.ccd == PERCALE_CCD_OFF) {
        return true;
    }
    PercalePair pair = pair_of(substep, o);
    PercaleSurface at_end = {pair.obstacle, &proximity->tree, solver->model.predicted};
    PercalePathStage stage = {&pair, proximity, &at_end, &solver->frames[o], solver->rays, o, substep->team};
    solver->crossings[o] =
        percale_arena_new(&solver->arena, proximity->active_count, sizeof(PercaleCrossing));
    return solver->crossings[o] != NULL &&
           percale_paths_cast(&stage, &solver->arena, solver->crossings[o], &solver->counters.rays);
}

static PercaleResult detect_obstacles(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    bool complete = true;
    for (uint32_t o = 0; complete && o < solver->model.obstacle_count; o++) {
        move_obstacle(substep, o);
        if (!solver->def.vertex_face) {
            continue;
        }
        if (!find_active(substep, o)) {
            return percale_fail(&solver->error, PERCALE_DEVICE_ERROR, "Embree can't refit obstacle '%s'",
                                solver->objects.obstacles[o].name);
        }
        complete = begin_sightings(solver, &solver->proximities[o]) && cast_paths(substep, o);
    }
    end_stage(substep, PERCALE_STAGE_DETECT);
    return complete ? PERCALE_OK : percale_fail_memory(&solver->error);
}

/// Where pairs are looked at. NULL without memory.
static const f32x4 *look_at_pairs(Substep *substep, bool first)
{
    PercaleModel *model = &substep->solver->model;
    if (!first) {
        return model->predicted;
    }
    f32x4 *coasting = percale_arena_new(&substep->solver->arena, model->point_count, sizeof(f32x4));
    if (coasting != NULL) {
        percale_look_coasting(model, substep->dt, coasting, substep->team);
    }
    return coasting;
}

/// Where they would be at the next pass. NULL without memory.
static const f32x4 *look_ahead(Substep *substep, const f32x4 *seen, float later_substeps)
{
    PercaleModel *model = &substep->solver->model;
    if (later_substeps <= 0.0f) {
        return seen;
    }
    f32x4 *ahead = percale_arena_new(&substep->solver->arena, model->point_count, sizeof(f32x4));
    if (ahead != NULL) {
        percale_look_ahead(model, seen, later_substeps, ahead, substep->team);
    }
    return ahead;
}

/// Pairs of features that may come within reach before the next pass, as long as they are not known. False
/// without memory.
static bool find_candidates(Substep *substep, const f32x4 *seen)
{
    PercaleSolver *solver = substep->solver;
    const PercaleModel *model = &solver->model;
    float later = later_substeps(&solver->def);
    const f32x4 *ahead = look_ahead(substep, seen, later);
    if (ahead == NULL) {
        return false;
    }
    PercaleCandidateStage stage = {.from = model->position,
                                   .to = ahead,
                                   .all_near = later > 0.0f,
                                   .collectors = &solver->collectors,
                                   .memory = &solver->detect_memory,
                                   .team = substep->team};
    return percale_candidates_keep(&solver->candidates, &stage, &solver->counters.candidates);
}

/// Pairs of the cloth's features, and of its edges and faces with the obstacles'; of some sources, or of all.
static bool detect_pairs(Substep *substep, const f32x4 *seen, const PercaleSources *only)
{
    PercaleSolver *solver = substep->solver;
    PercalePairStage stage = {.model = &solver->model,
                              .end = seen,
                              .candidates = &solver->candidates,
                              .known = &solver->notes[0],
                              .later_substeps = later_substeps(&solver->def),
                              .dt = substep->dt,
                              .may_be_crossed = solver->may_be_crossed,
                              .only = only,
                              .team = substep->team};
    PercalePairCounts counts = {0};
    bool complete = find_candidates(substep, seen) &&
                    percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                       &solver->notes[1], &counts);
    PercaleNoteList written = solver->notes[1];
    solver->notes[1] = solver->notes[0];
    solver->notes[0] = written;
    solver->counters.candidates += counts.candidates;
    solver->counters.stencils_vf += counts.vertex_face;
    solver->counters.stencils_ee += counts.edge_edge;
    solver->counters.born_crossed += counts.born_crossed;
    solver->may_be_crossed = counts.free_pairs > 0;
    return complete;
}

/// The stencils of the last pass become the known ones.
static void begin_stencils(PercaleSolver *solver)
{
    PercaleStencilList known = solver->stencils;
    known.count = solver->pass_stencil_count;
    solver->stencils = solver->known_stencils;
    solver->stencils.count = 0;
    solver->known_stencils = known;
}

/// Hands on what the known stencils know, and keeps those that still fit where points are at x; NULL: none.
/// False without memory.
static bool continue_stencils(Substep *substep, bool same_substep, const f32x4 *x)
{
    PercaleSolver *solver = substep->solver;
    PercaleCarryStage stage = {&solver->known_stencils, &solver->stencils, same_substep, substep->team};
    percale_carry_run(&stage);
    bool complete =
        x == NULL || percale_renew_merge(&solver->known_stencils, same_substep, x, &solver->arena,
                                         &solver->detect_memory, substep->team, &solver->stencils);
    solver->pass_stencil_count = solver->stencils.count;
    return complete;
}

/// Between passes: pairs that have slid on are found anew. False without memory.
static bool renew_pairs(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    solver->stencils.count = solver->pass_stencil_count;
    if (solver->candidates.lists == NULL || solver->stencils.count == 0) {
        return true;
    }
    const f32x4 *seen = look_at_pairs(substep, true);
    PercaleSources slid = {NULL, 0};
    bool complete =
        seen != NULL && percale_renew_find(&solver->stencils, seen, &solver->arena, substep->team, &slid);
    if (!complete || slid.count == 0) {
        return complete;
    }
    begin_stencils(solver);
    substep->renewed = true;
    return detect_pairs(substep, seen, solver->may_be_crossed ? NULL : &slid) &&
           continue_stencils(substep, false, seen);
}

/// A collision pass generates all stencils anew; between passes only those of vertices that have crossed are
/// added, and pairs that have slid on renewed. `first`: in the substep.
static PercaleResult detect_contacts(Substep *substep, bool pass, bool first)
{
    PercaleSolver *solver = substep->solver;
    bool complete = true;
    if (pass) {
        begin_stencils(solver);
    } else {
        complete = renew_pairs(substep);
    }
    solver->stencils.count = pass ? 0 : solver->pass_stencil_count;
    for (uint32_t o = 0; complete && solver->def.vertex_face && o < solver->model.obstacle_count; o++) {
        PercalePair pair = pair_of(substep, o);
        PercaleSurface at_end = {pair.obstacle, &solver->proximities[o].tree, solver->model.predicted};
        PercaleContactStage stage = {
            &pair,       &solver->proximities[o], &at_end,      solver->crossings[o], !pass,
            substep->dt, (uint64_t)o << 32,       substep->team};
        complete = percale_contacts_find(&stage, &solver->collectors, &solver->detect_memory,
                                         &solver->stencils, &solver->counters.candidates);
    }
    solver->counters.stencils_vf += solver->stencils.count - (pass ? 0 : solver->pass_stencil_count);
    if (complete && pass && solver->candidates.lists != NULL) {
        const f32x4 *seen = look_at_pairs(substep, first);
        complete = seen != NULL && detect_pairs(substep, seen, NULL);
    }
    if (complete && pass) {
        complete = continue_stencils(substep, !first, first ? NULL : solver->model.predicted);
    }
    if (!pass) {
        for (size_t i = 0; i < solver->pass_stencil_count; i++) { // a new substep: nothing has pushed yet
            solver->stencils.items[i].multiplier = (f32x4){0};
        }
    }
    end_stage(substep, PERCALE_STAGE_DETECT);
    return complete ? PERCALE_OK : percale_fail_memory(&solver->error);
}

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

static PercaleResult color(Substep *substep, bool pass)
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

/// Multipliers start at zero in every substep; open seams are asked to close a little further.
static void begin_solve(Substep *substep)
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
        float gap = length3(model->position[slots[0]] - model->position[slots[1]]) - SEAM_SPEED * substep->dt;
        solver->seam_targets[s] = gap > 0.0f ? gap : 0.0f;
    }
    end_stage(substep, PERCALE_STAGE_SOLVE);
}

static PercaleSolveArrays solve_arrays(const Substep *substep)
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

/// Slow bending is a force, like gravity, that is found anew in some substeps.
static PercaleResult hold_bending(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    if (!is_bending_held(solver) || !is_bending_due(substep)) {
        return PERCALE_OK;
    }
    PercaleHeldBending held = {.plan = {.arrays = solve_arrays(substep),
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

static PercaleResult solve(Substep *substep, uint32_t sweep_count)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    bool bends = model->hinge_count > 0 && solver->bend_interval == 1;
    PercaleBatches none = {0};
    PercaleSweepPlan plan = {
        .arrays = solve_arrays(substep),
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

/// After the last sweep: outer layers give way; the slip that friction still owes. False without memory.
static bool end_solve(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleSweepPlan plan = {.arrays = solve_arrays(substep), .contacts = &solver->contacts};
    if (solver->model.rank_count > 1) {
        if (!percale_sweep_outwards(&plan, substep->team, &solver->arena)) {
            return false;
        }
        solver->counters.projections_contact += solver->contacts.count;
        solver->counters.projections += solver->contacts.count;
    }
    Slips slips = {.arrays = plan.arrays};
    percale_team_for(substep->team, (uint32_t)solver->stencils.count, GRAIN_STENCILS, keep_slips, &slips);
    substep->any_leaves = slips.any_leaves;
    end_stage(substep, PERCALE_STAGE_SOLVE);
    return true;
}

// ---- finish ----

/// Cloth that has gone through cloth, or an edge of it through an obstacle's. False without memory.
static bool guard_pairs(Substep *substep, uint64_t *corrected)
{
    PercaleSolver *solver = substep->solver;
    if (solver->candidates.lists == NULL) {
        return true;
    }
    PercalePairGuardStage stage = {.model = &solver->model,
                                   .candidates = &solver->candidates,
                                   .proximities = solver->proximities,
                                   .obstacles = solver->def.vertex_face != 0,
                                   .known = solver->may_be_crossed ? &solver->notes[0] : NULL,
                                   .exact = solver->def.ccd == PERCALE_CCD_EXACT,
                                   .dt = substep->dt,
                                   .collectors = &solver->collectors,
                                   .passing = &solver->passing,
                                   .memory = &solver->detect_memory,
                                   .team = substep->team};
    PercalePairGuardCounts counts;
    bool complete = percale_pair_guard_run(&stage, &counts);
    solver->counters.candidates += counts.candidates;
    solver->counters.truncated += counts.pushed;
    solver->counters.left_crossed += counts.left;
    solver->may_be_crossed = solver->may_be_crossed || counts.left > 0;
    *corrected += counts.pushed;
    return complete;
}

/// What undid an overlap gives no velocity. False without memory.
static bool end_exits(Substep *substep)
{
    PercaleSweepPlan plan = {.arrays = solve_arrays(substep), .contacts = &substep->solver->contacts};
    return percale_sweep_exits(&plan, substep->team, &substep->solver->arena);
}

/// Whether an obstacle has moved in the running substep.
static bool has_moved_obstacles(const PercaleSolver *solver)
{
    bool moved = false;
    for (uint32_t o = 0; o < solver->model.obstacle_count; o++) {
        moved = moved || solver->frames[o].motion != MOTION_STATIC;
    }
    return moved;
}

static PercaleResult finish(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    uint32_t bad = percale_advance_velocities(model, substep->dt, substep->team);
    if (bad != UINT32_MAX) {
        return name_bad_vertex(solver, bad);
    }
    if (substep->any_leaves && !end_exits(substep)) {
        return percale_fail_memory(&solver->error);
    }
    uint64_t corrected = 0;
    for (uint32_t o = 0; solver->def.vertex_face && o < model->obstacle_count; o++) {
        PercalePair pair = pair_of(substep, o);
        PercaleSurface at_end = {pair.obstacle, &solver->proximities[o].tree, model->predicted};
        PercaleGuardStage stage = {&pair,
                                   &solver->proximities[o],
                                   &at_end,
                                   &solver->frames[o],
                                   model->predicted,
                                   model->next_velocity,
                                   substep->dt,
                                   solver->def.ccd != PERCALE_CCD_OFF,
                                   solver->proximities,
                                   o,
                                   substep->team};
        PercaleGuardCounts counts = percale_guard_run(&stage);
        solver->counters.left_inside += counts.left_inside;
        solver->counters.truncated += counts.truncated;
        corrected += counts.truncated;
        solver->counters.detections += counts.searches;
    }
    if (!guard_pairs(substep, &corrected)) {
        return percale_fail_memory(&solver->error);
    }
    bad = corrected > 0 ? percale_advance_find_bad(model, substep->team) : UINT32_MAX;
    if (bad != UINT32_MAX) {
        return name_bad_vertex(solver, bad);
    }
    percale_advance_commit(model, has_moved_obstacles(solver));
    end_stage(substep, PERCALE_STAGE_FINISH);
    return PERCALE_OK;
}

// ---- the step ----

static PercaleResult run_substep(Substep *substep)
{
    const PercaleSolverDef *def = &substep->solver->def;
    PercaleResult result = predict(substep);
    if (result == PERCALE_OK) {
        begin_solve(substep);
        result = hold_bending(substep);
    }
    if (result == PERCALE_OK) {
        result = detect_obstacles(substep);
    }
    uint64_t sweep = (uint64_t)substep->index * (uint64_t)def->iterations;
    uint64_t end = sweep + (uint64_t)def->iterations;
    for (bool first = true; result == PERCALE_OK && sweep < end; first = false) {
        bool pass = is_pass_due(def, sweep);
        if (pass || first) {
            result = detect_contacts(substep, pass, first);
            result = result == PERCALE_OK ? color(substep, pass) : result;
        }
        uint64_t next = sweep + 1;
        while (next < end && !is_pass_due(def, next)) {
            next++;
        }
        if (result == PERCALE_OK) {
            result = solve(substep, (uint32_t)(next - sweep));
        }
        sweep = next;
    }
    if (result == PERCALE_OK && !end_solve(substep)) {
        result = percale_fail_memory(&substep->solver->error);
    }
    return result == PERCALE_OK ? finish(substep) : result;
}

/// Pins go from where their vertices are to their targets.
static void begin_pins(PercaleSolver *solver)
{
    const PercaleModel *model = &solver->model;
    for (uint32_t i = 0; i < model->pinned_count; i++) {
        const PercalePinObject *pin = &solver->objects.pins[model->pinned_sources[i][0]];
        solver->pin_from[i] = model->position[model->pinned_slots[i]];
        solver->pin_to[i] = vector_of(pin->to + 3 * (size_t)model->pinned_sources[i][1]);
    }
}

/// Obstacles stay where the last good substep has left them; without one nothing has happened, and they still
/// have to go where they were sent.
static void end_obstacles(PercaleSolver *solver, int good_substeps)
{
    const PercaleModel *model = &solver->model;
    double fraction = (double)good_substeps / (double)solver->def.substeps;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        PercaleObstacleObject *object = &solver->objects.obstacles[o];
        if (good_substeps == 0) {
            continue;
        }
        percale_obstacle_object_arrive(object, object->moving && good_substeps == solver->def.substeps,
                                       &solver->object_memory);
        if (!object->moving) {
            continue;
        }
        object->moving = false;
        object->pose_from = percale_motion_between(&object->pose_from, &object->pose_to, fraction);
        object->pose_to = object->pose_from;
        const f32x4 *points = model->position + model->obstacles[o].first_point;
        for (size_t i = 0; i < object->vertex_count; i++) {
            for (size_t axis = 0; axis < 3; axis++) {
                object->from[3 * i + axis] = object->to[3 * i + axis] = points[i][axis];
            }
        }
    }
}

/// Pairs that have come within SEAM_CLOSED weld: the model is assembled anew before the next step.
static void close_seams(PercaleSolver *solver)
{
    const PercaleModel *model = &solver->model;
    bool closed = false;
    for (uint32_t s = 0; s < model->open_seam_count; s++) {
        const PercaleOpenSeam *seam = &model->open_seams[s];
        f32x4 gap = model->position[seam->slots[0]] - model->position[seam->slots[1]];
        if (length3(gap) <= SEAM_CLOSED) {
            solver->objects.seams[seam->seam_index].welded[seam->pair_index] = true;
            closed = true;
        }
    }
    if (closed) {
        percale_solver_release_model(solver);
    }
}

void percale_run_substeps(PercaleTeam *team, void *context)
{
    PercaleSubsteps *substeps = context;
    PercaleSolver *solver = substeps->solver;
    int count = solver->def.substeps;
    while (substeps->result == PERCALE_OK && substeps->good < count) {
        Substep substep = {solver,
                           team,
                           substeps->good,
                           (float)(substeps->seconds / count),
                           (double)(substeps->good + 1) / (double)count,
                           has_pass(&solver->def, substeps->good),
                           false,
                           false,
                           percale_seconds()};
        percale_arena_reset(&solver->arena);
        substeps->result = run_substep(&substep);
        substeps->good += substeps->result == PERCALE_OK;
    }
}

static PercaleResult run_step(PercaleSolver *solver, double seconds)
{
    const double SHORTEST = 1e-6; // s; below it positions of float32 no longer move
    solver->error.text[0] = '\0';
    if (!(seconds >= SHORTEST) || !(seconds <= 1.0)) {
        return percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT, "step: %g s is not in 1e-6 .. 1",
                            seconds);
    }
    PercaleResult result = percale_solver_prepare(solver);
    if (result != PERCALE_OK) {
        return result;
    }
    double began = percale_seconds();
    memset(&solver->profile, 0, sizeof(solver->profile));
    begin_pins(solver);
    PercaleSubsteps substeps = {solver, seconds, 0, PERCALE_OK};
    size_t work = (size_t)solver->model.slot_count + solver->edges.count + solver->hinges.count;
    percale_team_open(threads_for(work, solver->def.thread_count), &solver->crowding,
                      solver->engine->run_substeps, &substeps);
    result = substeps.result;
    end_obstacles(solver, substeps.good);
    if (result == PERCALE_OK) {
        close_seams(solver);
    } else {
        percale_solver_release_model(solver); // trees and predictions are those of the failed substep
    }
    solver->profile.step_seconds = percale_seconds() - began;
    return result;
}

PercaleResult percale_solver_step(PercaleSolver *solver, double seconds)
{
    uint32_t mode = float_mode_enter(); // the host may round otherwise
    PercaleResult result = run_step(solver, seconds);
    float_mode_leave(mode);
    return percale_solver_logged(solver, result);
}
