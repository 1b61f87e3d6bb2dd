#include "solve/sweep.h"

#include "base/parallel.h"

enum {
    GRAIN_EDGES = 256,    // constraints per chunk: half a microsecond
    GRAIN_HINGES = 128,   // a multiple of WIDE, so that blocks are the same for any number of chunks
    GRAIN_TETHERS = 1024, // slots
    GRAIN_CONTACTS = 128,
};

/// One kind of constraint in a sweep.
typedef struct Kind {
    const PercaleSolveArrays *arrays;
    const PercaleBatches *batches;
    PercaleKernel *kernel;
    uint32_t grain;
} Kind;

// ---- ranges ----

/// Constraints of one run: `first` and `end` count constraints (slots, for tethers).
static void run_constraints(void *context, uint32_t first, uint32_t end)
{
    const Kind *kind = context;
    kind->kernel(kind->arrays, first, end);
}

/// Whole runs, one after the other.
static void run_runs(void *context, uint32_t first, uint32_t end)
{
    const Kind *kind = context;
    for (uint32_t run = first; run < end; run++) {
        kind->kernel(kind->arrays, kind->batches->run_first[run], kind->batches->run_first[run + 1]);
    }
}

/// Both kinds of a tile's own constraints.
typedef struct Tiles {
    Kind *hinges, *edges;
} Tiles;

static void run_tiles(void *context, uint32_t first, uint32_t end)
{
    const Tiles *tiles = context;
    Kind *kinds[2] = {tiles->hinges, tiles->edges};
    for (uint32_t tile = first; tile < end; tile++) {
        for (int i = 0; i < 2; i++) {
            const PercaleBatches *batches = kinds[i]->batches;
            if (batches->count > 0) {
                run_runs(kinds[i], batches->tile_first_run[tile], batches->tile_first_run[tile + 1]);
            }
        }
    }
}

// ---- the program ----

typedef struct Program {
    PercalePhase *phases;
    size_t count;
} Program;

static void add_phase(Program *program, PercaleRange *run, void *context, uint32_t first, uint32_t end,
                      uint32_t grain)
{
    if (end > first) {
        program->phases[program->count++] = (PercalePhase){run, context, first, end, grain};
    }
}

/// The tiles of each level are a phase.
static void add_tiles(Program *program, Tiles *tiles, const PercaleTiling *tiling)
{
    for (uint32_t level = 0; level < tiling->level_count; level++) {
        add_phase(program, run_tiles, tiles, tiling->first_tile[level], tiling->first_tile[level + 1], 1);
    }
}

/// The runs that join tiles: a phase each, short ones in a row as one phase of one chunk.
static void add_runs(Program *program, Kind *kind)
{
    const PercaleBatches *batches = kind->batches;
    uint32_t run = batches->run_count > 0 ? batches->tile_first_run[batches->tile_count] : 0;
    while (run < batches->run_count) {
        uint32_t end = run;
        while (end < batches->run_count &&
               batches->run_first[end + 1] - batches->run_first[end] <= kind->grain) {
            end++;
        }
        if (end > run) {
            add_phase(program, run_runs, kind, run, end, end - run);
            run = end;
        } else {
            add_phase(program, run_constraints, kind, batches->run_first[run], batches->run_first[run + 1],
                      kind->grain);
            run++;
        }
    }
}

bool percale_sweep_exits(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena)
{
    Kind contacts = {&plan->arrays, plan->contacts, percale_solve_contact_exit, GRAIN_CONTACTS};
    Program program = {percale_arena_new(arena, plan->contacts->run_count, sizeof(PercalePhase)), 0};
    if (program.phases == NULL) {
        return false;
    }
    add_runs(&program, &contacts);
    percale_team_run(team, program.phases, program.count);
    return true;
}

/// What the chunks of the slots share.
typedef struct Hold {
    const PercaleSolveArrays *arrays;
    uint32_t rank; // of the lowest layer that moves
} Hold;

static void hold_range(void *context, uint32_t first, uint32_t end)
{
    const Hold *hold = context;
    const PercaleModel *model = hold->arrays->model;
    for (uint32_t i = first; i < end; i++) {
        bool moves = model->cloths[model->cloth_of[i]].rank >= hold->rank;
        hold->arrays->x[i][3] = moves ? hold->arrays->start[i][3] : 0.0f;
    }
}

/// Of the outermost cloth that it moves.
static uint32_t rank_of(const PercaleModel *model, const PercaleStencil *stencil)
{
    uint32_t rank = 0;
    for (int k = 0; k < 4; k++) {
        uint32_t point = stencil->points[k];
        uint32_t here = point < model->slot_count ? model->cloths[model->cloth_of[point]].rank : 0;
        rank = here > rank ? here : rank;
    }
    return rank;
}

/// The contacts of one rank, in the runs of all.
static void select_rank(const PercaleSweepPlan *plan, const uint32_t *ranks, uint32_t rank, uint32_t *order,
                        PercaleBatches *selected)
{
    const PercaleSolveArrays *arrays = &plan->arrays;
    selected->count = selected->run_count = 0;
    for (uint32_t run = 0; run < plan->contacts->run_count; run++) {
        uint32_t before = selected->count;
        for (uint32_t i = plan->contacts->run_first[run]; i < plan->contacts->run_first[run + 1]; i++) {
            if (ranks[i] == rank) {
                order[selected->count++] = arrays->stencil_order[i];
            }
        }
        selected->run_first[selected->run_count] = before;
        selected->run_count += selected->count > before;
    }
    selected->run_first[selected->run_count] = selected->count;
}

bool percale_sweep_outwards(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena)
{
    const PercaleModel *model = plan->arrays.model;
    uint32_t no_tile = 0;
    PercaleSolveArrays arrays = plan->arrays;
    PercaleBatches selected = {.tile_first_run = &no_tile};
    uint32_t *order = percale_arena_new(arena, plan->contacts->count, sizeof(uint32_t));
    uint32_t *ranks = percale_arena_new(arena, plan->contacts->count, sizeof(uint32_t));
    selected.run_first = percale_arena_new(arena, (size_t)plan->contacts->run_count + 1, sizeof(uint32_t));
    Kind contacts = {&arrays, &selected, percale_solve_contact, GRAIN_CONTACTS};
    Program program = {percale_arena_new(arena, plan->contacts->run_count, sizeof(PercalePhase)), 0};
    if (order == NULL || ranks == NULL || selected.run_first == NULL || program.phases == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < plan->contacts->count; i++) {
        ranks[i] = rank_of(model, &arrays.stencils[arrays.stencil_order[i]]);
    }
    arrays.stencil_order = order;
    for (uint32_t rank = 0; rank < model->rank_count; rank++) {
        Hold hold = {&plan->arrays, rank};
        select_rank(plan, ranks, rank, order, &selected);
        program.count = 0;
        add_runs(&program, &contacts);
        percale_team_for(team, model->slot_count, GRAIN, hold_range, &hold);
        percale_team_run(team, program.phases, program.count);
    }
    Hold none = {&plan->arrays, 0};
    percale_team_for(team, model->slot_count, GRAIN, hold_range, &none);
    return true;
}

bool percale_sweep_hinges(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena)
{
    const PercaleBatches none = {0};
    Kind hinges = {&plan->arrays, plan->hinges, percale_solve_bend, GRAIN_HINGES};
    Kind edges = {&plan->arrays, &none, percale_solve_stretch, GRAIN_EDGES};
    Tiles tiles = {&hinges, &edges};
    size_t most = (size_t)plan->hinges->run_count + TILE_LEVELS_MAX;
    Program program = {percale_arena_new(arena, most, sizeof(PercalePhase)), 0};
    if (program.phases == NULL) {
        return false;
    }
    add_tiles(&program, &tiles, &plan->hinges->tiling);
    add_runs(&program, &hinges);
    for (uint32_t sweep = 0; sweep < plan->sweep_count; sweep++) {
        percale_team_run(team, program.phases, program.count);
    }
    return true;
}

bool percale_sweep_run(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena)
{
    const PercaleSolveArrays *arrays = &plan->arrays;
    Kind hinges = {arrays, plan->hinges, percale_solve_bend, GRAIN_HINGES};
    Kind edges = {arrays, plan->edges, percale_solve_stretch, GRAIN_EDGES};
    Kind contacts = {arrays, plan->contacts, percale_solve_contact, GRAIN_CONTACTS};
    Kind tethers = {arrays, NULL, percale_solve_tether, GRAIN_TETHERS};
    Kind seams = {arrays, NULL, percale_solve_seam, UINT32_MAX}; // one chunk: they may share vertices
    Tiles tiles = {&hinges, &edges};
    size_t most = (size_t)plan->hinges->run_count + plan->edges->run_count + plan->contacts->run_count +
                  TILE_LEVELS_MAX + 2;
    Program program = {percale_arena_new(arena, most, sizeof(PercalePhase)), 0};
    if (program.phases == NULL) {
        return false;
    }
    const PercaleTiling *tiling = plan->edges->count > 0 ? &plan->edges->tiling : &plan->hinges->tiling;
    add_tiles(&program, &tiles, tiling);
    add_runs(&program, &hinges);
    add_runs(&program, &edges);
    uint32_t tethered = arrays->model->tether_layers > 0 ? arrays->model->slot_count : 0;
    add_phase(&program, run_constraints, &tethers, 0, tethered, tethers.grain);
    add_phase(&program, run_constraints, &seams, 0, arrays->model->open_seam_count, seams.grain);
    add_runs(&program, &contacts);
    for (uint32_t sweep = 0; sweep < plan->sweep_count; sweep++) {
        percale_team_run(team, program.phases, program.count);
    }
    return true;
}
