// step.c: THE PIPELINE. One step is `substeps` times: predict, detect, color, solve, finish.
//
// Every stage is arrays in, arrays out, in the folder of its name; only this file knows their order.

#include "substep.h"

#include "finish/advance.h"
#include "finish/pair_guard.h"
#include "finish/path_guard.h"
#include "predict/obstacle_motion.h"
#include "predict/predict.h"

#include <math.h>
#include <string.h>

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

static PercaleResult predict(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    f32x4 *pushes = is_bending_held(solver) ? solver->bend_pushes : NULL;
    bool due = pushes != NULL && is_bending_due(substep);
    PercalePredictStage stage = {
        .model = &solver->model,
        .gravity = vector_of(solver->def.gravity),
        .wind = vector_of(solver->def.wind),
        .damping = (float)exp(-(double)solver->def.damping * (double)substep->dt),
        .speed_max = solver->def.speed_max,
        .dt = substep->dt,
        .pushes = due ? NULL : pushes,
        .ahead = due ? pushes : NULL,
        .ahead_count = (float)solver->bend_interval,
    };
    uint32_t bad = percale_predict_cloth(&stage, substep->team);
    percale_predict_pins(&stage, solver->pin_from, solver->pin_to, (float)substep->fraction);
    end_stage(substep, PERCALE_STAGE_PREDICT);
    return bad == UINT32_MAX ? PERCALE_OK : name_bad_vertex(solver, bad);
}
// ---- passes ----

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

// ---- finish ----

/// Whether the guard of pairs has to ask now: with guard_passes before passes, and where obstacles pinch.
static bool is_pair_guard_due(const Substep *substep)
{
    const PercaleSolver *solver = substep->solver;
    return !solver->def.guard_passes || substep->index + 1 == solver->def.substeps ||
           has_pass(&solver->def, substep->index + 1) || solver->pinches.count > 0;
}

/// Cloth that has gone through cloth, or an edge of it through an obstacle's, since it was last asked. False
/// without memory.
static bool guard_pairs(Substep *substep, uint64_t *corrected)
{
    PercaleSolver *solver = substep->solver;
    if (solver->candidates.lists == NULL || !is_pair_guard_due(substep)) {
        return true;
    }
    f32x4 *start = solver->model.position;
    if (solver->unguarded > 0) {
        solver->model.position = solver->guarded_from;
    }
    PercalePairGuardStage stage = {.model = &solver->model,
                                   .candidates = &solver->candidates,
                                   .proximities = solver->proximities,
                                   .obstacles = solver->def.vertex_face != 0,
                                   .measures = !substep->has_pass,
                                   .known = solver->may_be_crossed ? &solver->notes[0] : NULL,
                                   .exact = solver->def.ccd == PERCALE_CCD_EXACT,
                                   .releases = releases_or_none(solver),
                                   .is_pinched = pinched_or_none(solver),
                                   .dt = substep->dt * (float)(solver->unguarded + 1),
                                   .collectors = &solver->collectors,
                                   .passing = &solver->passing,
                                   .memory = &solver->detect_memory,
                                   .arena = &solver->arena,
                                   .team = substep->team};
    PercalePinchStage pinches = pinch_stage_of(substep);
    percale_pinches_loosen(&pinches);
    PercalePairGuardCounts counts;
    bool complete = percale_pair_guard_run(&stage, &counts);
    percale_pinches_end(&pinches);
    solver->model.position = start;
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
    PercaleSweepPlan plan = {.arrays = percale_solve_arrays(substep), .contacts = &substep->solver->contacts};
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

/// Vertices whose ways have come through an obstacle (ccd=exact). Returns how many were put back.
static uint64_t guard_paths(Substep *substep, f32x4 *proved, bool again)
{
    PercaleSolver *solver = substep->solver;
    PercalePathGuardStage stage = {.model = &solver->model,
                                   .proximities = solver->proximities,
                                   .frames = solver->frames,
                                   .proved = proved,
                                   .again = again,
                                   .dt = substep->dt,
                                   .team = substep->team};
    PercalePathGuardCounts counts = percale_path_guard_run(&stage);
    solver->counters.left_inside += counts.left;
    solver->counters.truncated += counts.truncated;
    return counts.truncated;
}

/// Vertices that are below an obstacle's surface; `again`: that have been moved there since they were judged.
/// Returns how many were put back.
static uint64_t guard_obstacles(Substep *substep, bool again)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    uint64_t corrected = 0;
    for (uint32_t o = 0; solver->def.vertex_face && o < model->obstacle_count; o++) {
        PercalePair pair = pair_of(substep, o);
        PercaleSurface at_end = {pair.obstacle, &solver->proximities[o].tree, model->predicted,
                                 solver->proximities[o].convex.normals};
        PercaleGuardStage stage = {&pair,
                                   &solver->proximities[o],
                                   &at_end,
                                   &solver->frames[o],
                                   model->predicted,
                                   model->next_velocity,
                                   substep->dt,
                                   solver->def.ccd == PERCALE_CCD_RAY,
                                   solver->def.guard != 0,
                                   solver->proximities,
                                   o,
                                   substep->team};
        PercaleGuardCounts counts = again ? percale_guard_lift(&stage) : percale_guard_run(&stage);
        solver->counters.left_inside += counts.left_inside;
        solver->counters.truncated += counts.truncated;
        corrected += counts.truncated;
        solver->counters.detections += counts.searches;
    }
    return corrected;
}

/// The guards one after the other; what one of them has moved is shown to the other again. False without
/// memory.
static bool guard(Substep *substep, uint64_t *corrected)
{
    enum { ROUNDS = 4 }; // one is enough nearly always
    PercaleSolver *solver = substep->solver;
    f32x4 *proved = NULL;
    if (solver->def.guard == 0) { // nobody knows what has passed
        *corrected += guard_obstacles(substep, false);
        solver->may_be_crossed = true;
        return true;
    }
    if (solver->def.ccd == PERCALE_CCD_EXACT && solver->def.vertex_face && solver->model.obstacle_count > 0) {
        proved = percale_arena_new(&solver->arena, solver->model.slot_count, sizeof(f32x4));
        if (proved == NULL) {
            return false;
        }
        *corrected += guard_paths(substep, proved, false);
    }
    uint64_t moved = guard_obstacles(substep, false);
    for (int round = 0; round < ROUNDS; round++) {
        if (!guard_pairs(substep, &moved)) {
            return false;
        }
        *corrected += moved;
        if (moved > 0) {
            moved = proved != NULL ? guard_paths(substep, proved, true) : guard_obstacles(substep, true);
        }
        if (moved == 0) {
            return true;
        }
    }
    *corrected += moved;
    if (proved == NULL) { // cloth has the last word
        return guard_pairs(substep, corrected);
    }
    solver->counters.left_crossed += moved; // they may have come through cloth: obstacles have the last word
    solver->may_be_crossed = true;
    return true;
}

/// Where the next way that the guard of pairs asks begins: at this substep's end, or it goes on.
static void end_pair_guard(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    if (is_pair_guard_due(substep)) {
        solver->unguarded = 0;
        for (uint32_t o = 0; o < model->obstacle_count; o++) {
            solver->proximities[o].guarded = solver->proximities[o].traveled;
        }
        return;
    }
    if (solver->unguarded == 0 && solver->guarded_from != NULL) {
        memcpy(solver->guarded_from, model->position, model->point_count * sizeof(f32x4));
    }
    solver->unguarded++;
}

static PercaleResult finish(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleModel *model = &solver->model;
    uint32_t bad = percale_advance_velocities(model, substep->dt, substep->team);
    if (bad != UINT32_MAX) {
        return name_bad_vertex(solver, bad);
    }
    PercalePinchStage pinches = pinch_stage_of(substep);
    percale_pinches_end(&pinches);
    solver->counters.pinched += solver->pinches.held_count;
    if (substep->any_leaves && !end_exits(substep)) {
        return percale_fail_memory(&solver->error);
    }
    uint64_t corrected = 0;
    if (!guard(substep, &corrected)) {
        return percale_fail_memory(&solver->error);
    }
    bad = corrected > 0 ? percale_advance_find_bad(model, substep->team) : UINT32_MAX;
    if (bad != UINT32_MAX) {
        return name_bad_vertex(solver, bad);
    }
    end_pair_guard(substep);
    percale_advance_commit(model, has_moved_obstacles(solver));
    end_stage(substep, PERCALE_STAGE_FINISH);
    return PERCALE_OK;
}
// ---- the step ----

static PercaleResult run_substep(Substep *substep)
{
    const PercaleSolverDef *def = &substep->solver->def;
    percale_begin_solve(substep);
    PercaleResult result = predict(substep);
    if (result == PERCALE_OK) {
        result = percale_hold_bending(substep);
    }
    if (result == PERCALE_OK) {
        result = percale_detect_obstacles(substep);
    }
    uint64_t sweep = (uint64_t)substep->index * (uint64_t)def->iterations;
    uint64_t end = sweep + (uint64_t)def->iterations;
    for (bool first = true; result == PERCALE_OK && sweep < end; first = false) {
        bool pass = is_pass_due(def, sweep);
        if (pass || first) {
            result = percale_detect_contacts(substep, pass, first);
            result = result == PERCALE_OK ? percale_color_contacts(substep, pass) : result;
        }
        if (result == PERCALE_OK && first) {
            result = percale_solve_coarse(substep);
        }
        uint64_t next = sweep + 1;
        while (next < end && !is_pass_due(def, next)) {
            next++;
        }
        if (result == PERCALE_OK) {
            result = percale_solve(substep, (uint32_t)(next - sweep));
        }
        sweep = next;
    }
    if (result == PERCALE_OK && !percale_end_solve(substep)) {
        result = percale_fail_memory(&substep->solver->error);
    }
    return result == PERCALE_OK ? finish(substep) : result;
}

/// Pins go from where their vertices are to their targets, as long as time goes on.
static void begin_pins(PercaleSolver *solver)
{
    const PercaleModel *model = &solver->model;
    for (uint32_t i = 0; i < model->pinned_count; i++) {
        const PercalePinObject *pin = &solver->objects.pins[model->pinned_sources[i][0]];
        solver->pin_from[i] = model->position[model->pinned_slots[i]];
        solver->pin_to[i] = solver->stands_still
                                ? solver->pin_from[i]
                                : vector_of(pin->to + 3 * (size_t)model->pinned_sources[i][1]);
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

void percale_run_on(PercaleSubsteps *substeps, PercaleTeam *team)
{
    PercaleSolver *solver = substeps->solver;
    int count = solver->def.substeps;
    begin_pins(solver);
    if (solver->candidates.lists != NULL) {
        percale_candidates_begin_step(&solver->candidates, team);
    }
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

void percale_run_substeps(PercaleTeam *team, void *context)
{
    PercaleSubsteps *substeps = context;
    substeps->result = percale_begin_healing(substeps->solver, team);
    percale_run_on(substeps, team);
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
    PercaleSubsteps substeps = {solver, seconds, 0, PERCALE_OK};
    size_t work = (size_t)solver->model.slot_count + solver->edges.count + solver->hinges.count;
    percale_team_open(threads_for(work, solver->def.thread_count), &solver->crowding,
                      solver->engine->run_substeps, &substeps);
    result = substeps.result;
    end_obstacles(solver, substeps.good);
    if (result == PERCALE_OK) {
        solver->healing.steps++;
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
