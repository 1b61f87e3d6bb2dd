// step_detect.c: hands the solver's arrays to detect: obstacles and their paths, candidates, pairs, contacts.

#include "substep.h"

#include "base/parallel.h"
#include "detect/carry.h"
#include "detect/renew.h"
#include "predict/look_ahead.h"
#include "predict/obstacle_motion.h"

#include <string.h>

enum { GRAIN_STENCILS = 512 }; // per chunk

/// Moves the obstacle to the end of the substep; its tree is still at the start.
static void move_obstacle(Substep *substep, uint32_t o)
{
    PercaleSolver *solver = substep->solver;
    const PercaleObstacleObject *object = &solver->objects.obstacles[o];
    PercaleFrame *frame = &solver->frames[o];
    double before = solver->stands_still ? 0.0 : (double)substep->index / (double)solver->def.substeps;
    double after = solver->stands_still ? 0.0 : substep->fraction;
    bool moves = object->moving && !solver->stands_still;
    frame->motion = moves ? object->motion : MOTION_STATIC;
    frame->is_in_own_space = object->motion == MOTION_RIGID;
    frame->start = percale_motion_between(&object->pose_from, &object->pose_to, before);
    frame->end = percale_motion_between(&object->pose_from, &object->pose_to, after);
    solver->proximities[o].motion =
        moves ? percale_motion_apply(&solver->model, o, object, substep->fraction,
                                     (double)substep->dt * solver->def.substeps, substep->team)
              : 0.0f;
    solver->proximities[o].traveled += (double)solver->proximities[o].motion;
    if (solver->def.ccd == PERCALE_CCD_OFF) {
        solver->proximities[o].doubt = INFINITY;
    } else if (solver->def.ccd == PERCALE_CCD_EXACT) {
        solver->proximities[o].doubt = -INFINITY;
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
    PercaleSurface at_start = {pair.obstacle, &proximity->tree, model->position, proximity->convex.normals};
    PercaleSelectionCounts counts = percale_proximity_select(proximity, &pair, &at_start, substep->team);
    solver->counters.detections += counts.searches;
    solver->counters.detections_skipped += model->slot_count - counts.searches;
    solver->counters.missed += counts.missed;
    if (proximity->motion > 0.0f) {
        percale_tree_refit(&proximity->tree, pair.obstacle->triangles, model->predicted, substep->team);
        if (solver->def.ccd == PERCALE_CCD_EXACT) {
            const f32x4 *const ends[] = {model->position, model->predicted};
            percale_tree_refit_swept(&proximity->swept, pair.obstacle->triangles, ends, 2, substep->team);
        }
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
    PercaleSurface at_end = {pair.obstacle, &proximity->tree, solver->model.predicted,
                             proximity->convex.normals};
    PercalePathStage stage = {&pair, proximity, &at_end, &solver->frames[o], solver->rays, o, substep->team};
    solver->crossings[o] =
        percale_arena_new(&solver->arena, proximity->active_count, sizeof(PercaleCrossing));
    return solver->crossings[o] != NULL &&
           percale_paths_cast(&stage, &solver->arena, solver->crossings[o], &solver->counters.rays);
}

PercaleResult percale_detect_obstacles(Substep *substep)
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
    if (complete && solver->pinches.count > 0) {
        PercalePinchStage stage = pinch_stage_of(substep);
        percale_pinches_ride(&stage);
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
static bool find_candidates(Substep *substep, const f32x4 *seen, PercaleCandidates *candidates,
                            uint64_t *tested)
{
    PercaleSolver *solver = substep->solver;
    const PercaleModel *model = &solver->model;
    float later = later_substeps_of_pairs(&solver->def);
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
    return percale_candidates_keep(candidates, &stage, tested);
}

/// Finds the pairs of a pass anew beside those that were found (reuse=audit): what these lack is counted.
/// False without memory.
static bool audit_pairs(Substep *substep, const PercalePairStage *kept)
{
    PercaleSolver *solver = substep->solver;
    PercalePairStage stage = *kept;
    PercalePairCounts counts = {0};
    uint64_t tested = 0;
    stage.candidates = &solver->audited;
    solver->audited.known = false;
    solver->audited_stencils.count = 0;
    bool complete = find_candidates(substep, kept->end, &solver->audited, &tested) &&
                    percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory,
                                       &solver->audited_stencils, &solver->audited_notes, &counts);
    solver->counters.missed +=
        complete ? percale_pairs_count_missing(&solver->stencils, &solver->audited_stencils) : 0;
    return complete;
}

/// Pairs of the cloth's features, and of its edges and faces with the obstacles'; of some sources, or of all.
static bool detect_pairs(Substep *substep, const f32x4 *seen, const PercaleSources *only)
{
    PercaleSolver *solver = substep->solver;
    PercalePairStage stage = {.model = &solver->model,
                              .end = seen,
                              .candidates = &solver->candidates,
                              .known = &solver->notes[0],
                              .later_substeps = later_substeps_of_pairs(&solver->def),
                              .dt = substep->dt,
                              .may_be_crossed = solver->may_be_crossed,
                              .only = only,
                              .pinches = pinches_or_none(solver),
                              .releases = releases_or_none(solver),
                              .edges_wait =
                                  solver->def.passes <= solver->def.substeps && solver->pinches.count == 0,
                              .arena = &solver->arena,
                              .team = substep->team};
    PercalePairCounts counts = {0};
    if (only == NULL && solver->def.reuse == PERCALE_REUSE_ALWAYS) {
        solver->candidates.known = false; // it is a pass
    }
    bool complete = find_candidates(substep, seen, &solver->candidates, &solver->counters.candidates) &&
                    percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                       &solver->notes[1], &counts);
    if (complete && only == NULL && solver->def.reuse == PERCALE_REUSE_AUDIT) {
        complete = audit_pairs(substep, &stage);
    }
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

/// False without memory.
static bool find_pinches(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercalePinchStage stage = pinch_stage_of(substep);
    return !solver->def.vertex_face ||
           percale_pinches_find(&stage, &solver->stencils, &solver->arena, &solver->detect_memory);
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

/// Between passes: pairs that have slid on are found anew, unless the guard hasn't asked them since. False
/// without memory.
static bool renew_pairs(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    solver->stencils.count = solver->pass_stencil_count;
    if (solver->candidates.lists == NULL || solver->stencils.count == 0 || solver->def.guard_passes) {
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

/// A new substep: nothing has pushed yet.
static void forget_pushes(void *context, uint32_t first, uint32_t end)
{
    PercaleStencil *stencils = context;
    for (uint32_t i = first; i < end; i++) {
        if (stencils[i].multiplier[3] > 0.0f) { // many only stand by: they stay clean in the caches
            stencils[i].multiplier = (f32x4){0};
        }
    }
}

PercaleResult percale_detect_contacts(Substep *substep, bool pass, bool first)
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
        PercaleSurface at_end = {pair.obstacle, &solver->proximities[o].tree, solver->model.predicted,
                                 solver->proximities[o].convex.normals};
        PercaleContactStage stage = {
            &pair,       &solver->proximities[o], &at_end,      solver->crossings[o], !pass,
            substep->dt, (uint64_t)o << 32,       substep->team};
        complete = percale_contacts_find(&stage, &solver->collectors, &solver->detect_memory,
                                         &solver->stencils, &solver->counters.candidates);
    }
    solver->counters.stencils_vf += solver->stencils.count - (pass ? 0 : solver->pass_stencil_count);
    complete = complete && (!pass || find_pinches(substep));
    if (complete && pass && solver->candidates.lists != NULL) {
        const f32x4 *seen = look_at_pairs(substep, first);
        complete = seen != NULL && detect_pairs(substep, seen, NULL);
    }
    complete = complete && (!pass || percale_add_healing(substep));
    if (complete && pass) {
        complete = continue_stencils(substep, !first, first ? NULL : solver->model.predicted);
    }
    if (complete && !pass) {
        percale_raise_healing(substep);
        percale_team_for(substep->team, (uint32_t)solver->pass_stencil_count, GRAIN_STENCILS, forget_pushes,
                         solver->stencils.items);
    }
    end_stage(substep, PERCALE_STAGE_DETECT);
    return complete ? PERCALE_OK : percale_fail_memory(&solver->error);
}
