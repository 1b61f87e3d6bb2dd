// step_heal.c: the stage between detect and color: where cloth goes through cloth it is taken apart a little
// in each substep, while all that isn't tangled collides as ever.
//
// When a step begins a share of the edges is looked at, all where something has been left crossed. As long as
// something crosses, contours are found anew in each step, and what has to move gets stencils against what it
// has to come through, which open no faster than EXIT_SPEED, and give no velocity. Those pairs are released
// from contact and from the guard.

#include "substep.h"

#include "untangle/watch.h"

#include <string.h>

enum { LOOKS = 10 }; // steps in which every edge is looked at

static const uint32_t EPOCHS_MOST = 1U << 30; // of the tangler's labels, which take 31 bits

/// Edges and faces that the stages have counted as crossed.
static uint64_t crossed_of(const PercaleSolver *solver)
{
    return solver->counters.born_crossed + solver->counters.left_crossed;
}

/// The edges whose turn it is. False without memory.
static bool watch(PercaleSolver *solver, PercaleTeam *team, bool *crossed)
{
    PercaleHealing *healing = &solver->healing;
    uint64_t count = solver->model.cloth.edges.edge_count;
    uint32_t first = (uint32_t)(count * healing->look / LOOKS);
    uint32_t end = (uint32_t)(count * (healing->look + 1) / LOOKS);
    healing->look = healing->look + 1 < LOOKS ? healing->look + 1 : 0;
    PercaleWatchStage stage = {.model = &solver->model,
                               .faces = &solver->candidates.faces,
                               .x = solver->model.position,
                               .collectors = &solver->collectors,
                               .memory = &solver->detect_memory,
                               .team = team};
    return healing->is_unknown ? percale_watch_run(&stage, 0, (uint32_t)count, crossed)
                               : percale_watch_run(&stage, first, end, crossed);
}

bool percale_healing_open(PercaleSolver *solver, bool obstacles, PercaleTeam *team)
{
    PercaleHealing *healing = &solver->healing;
    const PercaleModel *model = &solver->model;
    PercaleMemory *memory = &solver->detect_memory;
    healing->is_tangled = true;
    healing->releases.wrong = percale_memory_new(memory, model->point_count, sizeof(uint32_t));
    healing->releases.others = percale_memory_new(memory, model->point_count, sizeof(uint32_t));
    return healing->releases.wrong != NULL && healing->releases.others != NULL &&
           percale_tangler_open(&healing->tangler, model, model->position, obstacles, team, memory);
}

void percale_healing_close(PercaleSolver *solver)
{
    PercaleHealing *healing = &solver->healing;
    percale_tangler_close(&healing->tangler);
    percale_memory_free(&solver->detect_memory, healing->releases.wrong);
    percale_memory_free(&solver->detect_memory, healing->releases.others);
    healing->releases = (PercaleReleases){NULL, NULL};
    healing->is_tangled = false;
}

bool percale_healing_look(PercaleSolver *solver, PercaleTeam *team)
{
    PercaleHealing *healing = &solver->healing;
    PercaleTangler *tangler = &healing->tangler;
    size_t size = solver->model.point_count * sizeof(uint32_t);
    memset(healing->releases.wrong, 0, size);
    memset(healing->releases.others, 0, size);
    tangler->stage.releases = healing->releases;
    tangler->stage.frees_crossings = !solver->stands_still; // without history less is left if they are held
    return percale_tangler_look(tangler, solver->model.position, team) &&
           percale_tangle_find_stencils(&tangler->stage);
}

PercaleResult percale_begin_healing(PercaleSolver *solver, PercaleTeam *team)
{
    PercaleHealing *healing = &solver->healing;
    if (!solver->def.untangle || solver->candidates.lists == NULL || !solver->candidates.cloth) {
        return PERCALE_OK;
    }
    double began = percale_seconds();
    bool crossed = false;
    bool complete = true;
    if (crossed_of(solver) > healing->known_crossed) {
        healing->is_unknown = true;
    }
    if (healing->tangler.stage.epoch > EPOCHS_MOST || healing->tangler.flood.epoch > EPOCHS_MOST) {
        percale_healing_close(solver); // labels are numbered on: begins again
        healing->is_unknown = true;
    }
    if (!healing->is_tangled) {
        complete = watch(solver, team, &crossed) && (!crossed || percale_healing_open(solver, false, team));
    }
    if (complete && healing->is_tangled) {
        complete = percale_healing_look(solver, team);
        if (healing->tangler.contours.pair_count == 0) {
            percale_healing_close(solver);
        } else {
            solver->counters.last_crossed_frame = healing->steps;
        }
    }
    healing->is_unknown = false;
    healing->known_crossed = crossed_of(solver);
    solver->profile.stage_seconds[PERCALE_STAGE_UNTANGLE] += percale_seconds() - began;
    return complete ? PERCALE_OK : percale_fail_memory(&solver->error);
}

// ---- stencils of a substep ----

static uint64_t source_of(const PercaleSolver *solver)
{
    uint64_t group = solver->model.obstacle_count + solver->candidates.list_count; // after all pairs'
    return group << 32;
}

/// How far a pair is to be apart when the substep ends.
static float target_of(const Substep *substep, const PercaleStencil *stencil, float wanted)
{
    f32x4 offset = stencil_offset(stencil, substep->solver->model.position);
    return fminf(wanted, dot3(stencil->normal, offset) + EXIT_SPEED * substep->dt);
}

bool percale_add_healing(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleStencilList *stencils = &solver->stencils;
    const PercaleStencilList *healing = &solver->healing.tangler.stencils;
    if (!solver->healing.is_tangled || healing->count == 0) {
        return true;
    }
    if (!percale_memory_reserve(&solver->detect_memory, &stencils->items, &stencils->capacity,
                                stencils->count + healing->count, sizeof(stencils->items[0]))) {
        return false;
    }
    for (size_t i = 0; i < healing->count; i++) {
        PercaleStencil stencil = healing->items[i];
        stencil.source = source_of(solver) + i;
        stencil.multiplier = (f32x4){0};
        stencil.normal[3] = target_of(substep, &stencil, stencil.normal[3]);
        stencils->items[stencils->count++] = stencil;
    }
    return true;
}

void percale_raise_healing(Substep *substep)
{
    PercaleSolver *solver = substep->solver;
    PercaleStencilList *stencils = &solver->stencils;
    const PercaleStencilList *healing = &solver->healing.tangler.stencils;
    if (!solver->healing.is_tangled || healing->count == 0) {
        return;
    }
    for (size_t i = solver->pass_stencil_count; i > 0 && stencils->items[i - 1].source >= source_of(solver);
         i--) {
        PercaleStencil *stencil = &stencils->items[i - 1];
        const PercaleStencil *wanted = &healing->items[stencil->source - source_of(solver)];
        stencil->normal[3] = target_of(substep, stencil, wanted->normal[3]);
    }
}
