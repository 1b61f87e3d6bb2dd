// solver.h: the solver's insides, for solver*.c and step.c only. Stages never see it.

#ifndef PERCALE_SOLVER_H
#define PERCALE_SOLVER_H

#include "base/arena.h"
#include "base/team.h"
#include "color/batch.h"
#include "detect/contacts.h"
#include "detect/pairs.h"
#include "detect/paths.h"
#include "detect/pinch.h"
#include "detect/rays.h"
#include "engine.h"
#include "healing.h"
#include "model/model.h"
#include "percale/percale.h"

struct PercaleSolver {
    PercaleCollectors collectors; // first: its parts are aligned to cache lines
    PercaleSolverDef def;         // passes resolved, isa resolved
    PercaleAllocator allocator;
    PercaleMemory object_memory, model_memory, detect_memory, color_memory, solve_memory;
    const PercaleEngine *engine;
    PercaleCrowding crowding;
    PercaleArena arena; // per substep
    PercaleMessage error;

    PercaleObjects objects;
    uint32_t last_id;

    bool assembled;      // the model below holds the state; else the objects do
    bool stands_still;   // time does, but for what untangles: nothing is moved or closed from outside
    bool may_be_crossed; // cloth with cloth: not yet looked, or it was at the last pass, or was left so
    PercaleModel model;
    PercaleColoring static_coloring, contact_coloring;
    PercaleBatches edges, hinges, contacts;
    PercaleBatches links[COARSE_LEVELS_MAX]; // of the model's coarse levels

    PercaleProximity *proximities;               // [obstacle_count]
    PercaleFrame *frames;                        // [obstacle_count] of the running substep
    PercaleCrossing **crossings;                 // [obstacle_count] arrays in the arena; NULL without CCD
    PercalePinches pinches;                      // where cloth vertices collide with obstacles
    PercaleRays *rays;                           // NULL without ccd=ray or obstacles
    PercaleCandidates candidates;                // without self_collision and edge_edge there are none
    PercaleNoteList notes[2];                    // of the last pass, and those that are being written
    PercaleStencilList stencils, known_stencils; // the latter of the last pass but one
    PercaleStencilList passing;                  // of the running substep
    f32x4 *guarded_from;                 // [point_count] with guard_passes: where the pairs' guard was last
    int unguarded;                       // substeps since
    PercaleCandidates audited;           // with reuse=audit: found anew in each pass
    PercaleStencilList audited_stencils; // theirs
    PercaleNoteList audited_notes;       // too
    size_t pass_stencil_count; // stencils of the last collision pass; CCD's of the running substep come after
                               // them

    f32x4 *pin_from, *pin_to; // [pinned_count] of the running step
    float *edge_multipliers;
    f32x4 *hinge_multipliers;
    f32x4 *bend_weights;     // for bend_dt
    float *bend_relaxations; // too
    f32x4 *bend_pushes;      // [slot_count] m/s, where there are hinges
    float bend_dt;           // s; 0: not computed yet
    uint32_t bend_interval;  // substeps
    float *seam_targets;
    PercaleHealing healing; // with untangle, where cloth collides with cloth

    PercaleProfile profile;
    PercaleCounters counters;
};

/// Brings the model up to date with the objects.
PercaleResult percale_solver_prepare(PercaleSolver *solver);

/// Moves the state back into the objects and drops the model; call before any change to the objects.
void percale_solver_release_model(PercaleSolver *solver);

/// Forgets what is tangled.
void percale_healing_close(PercaleSolver *solver);

/// Passes a result on; the text of a failure goes to the host's log.
PercaleResult percale_solver_logged(PercaleSolver *solver, PercaleResult result);

/// Index of the cloth in the objects, or SIZE_MAX with the error set.
size_t percale_solver_require_cloth(PercaleSolver *solver, PercaleCloth cloth);

#endif
