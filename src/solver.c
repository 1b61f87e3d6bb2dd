// solver.c: create, destroy, prepare and the questions that a host may ask.

#include "solver.h"

#include "base/parallel.h"
#include "predict/obstacle_motion.h"
#include "state/digest.h"
#include "state/validate.h"

#include <string.h>

// ---- names ----

const char *percale_version(void)
{
    return "0.1.0";
}

const char *percale_result_string(PercaleResult result)
{
    switch (result) {
    case PERCALE_OK:
        return "ok";
    case PERCALE_INVALID_ARGUMENT:
        return "invalid argument";
    case PERCALE_INVALID_HANDLE:
        return "invalid handle";
    case PERCALE_UNSUPPORTED:
        return "not in this version";
    case PERCALE_OUT_OF_MEMORY:
        return "out of memory";
    case PERCALE_NOT_FINITE:
        return "not finite";
    case PERCALE_DEVICE_ERROR:
        return "device error";
    }
    return "unknown result";
}

const char *percale_stage_name(PercaleStage stage)
{
    static const char *const NAMES[PERCALE_STAGE_COUNT] = {"predict", "detect", "untangle",
                                                           "color",   "solve",  "finish"};
    return (unsigned)stage < PERCALE_STAGE_COUNT ? NAMES[stage] : "unknown";
}

// ---- create and destroy ----

PercaleSolverDef percale_solver_def_default(void)
{
    return (PercaleSolverDef){
        .size = sizeof(PercaleSolverDef),
        .gravity = {0.0f, -9.81f, 0.0f},
        .damping = 0.02f,
        .speed_max = 100.0f,
        .substeps = 20,
        .iterations = 1,
        .thread_count = 1,
        .reuse = PERCALE_REUSE_AUTO,
        .ccd = PERCALE_CCD_RAY,
        .isa = PERCALE_ISA_AUTO,
        .vertex_face = 1,
        .guard = 1,
        .untangle = 1,
        .tethers = 1,
        .bending = 1,
    };
}

static PercaleResult check_finite(PercaleMessage *message, const char *name, const double *values, int count)
{
    for (int i = 0; i < count; i++) {
        if (!isfinite(values[i])) {
            return percale_fail(message, PERCALE_INVALID_ARGUMENT, "%s is not a finite number", name);
        }
    }
    return PERCALE_OK;
}

static PercaleResult check_numbers(const PercaleSolverDef *def, PercaleMessage *message)
{
    const struct {
        const char *name;
        double values[3];
    } VECTORS[] = {
        {"origin", {def->origin[0], def->origin[1], def->origin[2]}},
        {"gravity", {(double)def->gravity[0], (double)def->gravity[1], (double)def->gravity[2]}},
        {"wind", {(double)def->wind[0], (double)def->wind[1], (double)def->wind[2]}},
    };
    for (size_t i = 0; i < sizeof(VECTORS) / sizeof(VECTORS[0]); i++) {
        if (check_finite(message, VECTORS[i].name, VECTORS[i].values, 3) != PERCALE_OK) {
            return PERCALE_INVALID_ARGUMENT;
        }
    }
    if (!(def->damping >= 0.0f) || !isfinite(def->damping)) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "damping %g is not >= 0",
                            (double)def->damping);
    }
    if (!(def->speed_max > 0.0f) || !(def->speed_max <= 1e6f)) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "speed_max %g is not in 0 .. 1e6",
                            (double)def->speed_max);
    }
    return PERCALE_OK;
}

static PercaleResult check_counts(const PercaleSolverDef *def, PercaleMessage *message)
{
    const int MOST = 1000; // substeps or iterations
    if (def->substeps < 1 || def->substeps > MOST) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "substeps %d is not in 1..%d", def->substeps,
                            MOST);
    }
    if (def->iterations < 1 || def->iterations > MOST) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "iterations %d is not in 1..%d",
                            def->iterations, MOST);
    }
    if (def->passes < 0 || def->passes > def->substeps * def->iterations) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT,
                            "passes %d is not in 1..%d (substeps x iterations = %d x %d)", def->passes,
                            def->substeps * def->iterations, def->substeps, def->iterations);
    }
    if (def->levels < 0 || def->levels > PERCALE_MAX_LEVELS) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "levels %d is not in 0..%d", def->levels,
                            PERCALE_MAX_LEVELS);
    }
    if (def->thread_count < 1 || def->thread_count > PERCALE_MAX_THREADS) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "thread count %d is not in 1..%d",
                            def->thread_count, PERCALE_MAX_THREADS);
    }
    return PERCALE_OK;
}

static PercaleResult check_features(const PercaleSolverDef *def, PercaleMessage *message)
{
    if ((unsigned)def->ccd > PERCALE_CCD_EXACT || (unsigned)def->reuse > PERCALE_REUSE_AUDIT) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "ccd %d or reuse %d is no choice",
                            (int)def->ccd, (int)def->reuse);
    }
    if ((unsigned)def->isa > PERCALE_ISA_AVX512) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT, "isa %d is no choice", (int)def->isa);
    }
    if (percale_engine_for(def->isa) == NULL) {
        static const char *const NAMES[] = {"auto", "sse2", "avx2", "avx512"};
        return percale_fail(message, PERCALE_UNSUPPORTED, "this machine or this build has no %s",
                            NAMES[def->isa]);
    }
    return PERCALE_OK;
}

static PercaleResult check_def(const PercaleSolverDef *def, PercaleMessage *message)
{
    if (def->size != sizeof(*def)) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT,
                            "the solver Def did not come from percale_solver_def_default");
    }
    if ((def->allocate == NULL) != (def->release == NULL)) {
        return percale_fail(message, PERCALE_INVALID_ARGUMENT,
                            "allocate and release come together or not at all");
    }
    PercaleResult result = check_numbers(def, message);
    result = result == PERCALE_OK ? check_counts(def, message) : result;
    return result == PERCALE_OK ? check_features(def, message) : result;
}

/// A zeroed solver with the host's allocator in place; NULL without memory.
static PercaleSolver *allocate_solver(const PercaleSolverDef *def)
{
    PercaleAllocator allocator = def->allocate != NULL
                                     ? (PercaleAllocator){def->allocate, def->release, def->allocator_user}
                                     : percale_allocator_default();
    PercaleSolver *solver = allocator.allocate(allocator.user, (sizeof(*solver) + 63) / 64 * 64, 64);
    if (solver == NULL) {
        return NULL;
    }
    memset(solver, 0, sizeof(*solver));
    solver->allocator = allocator;
    PercaleMemory memory = {&solver->allocator, 0};
    solver->object_memory = solver->model_memory = solver->detect_memory = memory;
    solver->color_memory = solver->solve_memory = solver->arena.memory = memory;
    return solver;
}

PercaleResult percale_solver_create(PercaleSolverDef def, PercaleSolver **solver)
{
    PercaleMessage message = {{0}};
    PercaleResult result = check_def(&def, &message);
    PercaleSolver *created = result == PERCALE_OK ? allocate_solver(&def) : NULL;
    *solver = created;
    if (result == PERCALE_OK && created == NULL) {
        result = percale_fail_memory(&message);
    }
    if (created == NULL) {
        if (def.size == sizeof(def) && def.log != NULL) {
            def.log(def.log_user, message.text);
        }
        return result;
    }
    created->def = def;
    created->def.passes = def.passes == 0 ? def.substeps : def.passes;
    created->engine = percale_engine_for(def.isa);
    created->def.isa = created->engine->isa;
    return PERCALE_OK;
}

void percale_solver_destroy(PercaleSolver *solver)
{
    if (solver == NULL) {
        return;
    }
    percale_solver_release_model(solver);
    percale_objects_free(&solver->objects, &solver->object_memory);
    percale_collectors_free(&solver->collectors, &solver->detect_memory);
    percale_memory_free(&solver->detect_memory, solver->stencils.items);
    percale_memory_free(&solver->detect_memory, solver->passing.items);
    percale_memory_free(&solver->detect_memory, solver->audited_stencils.items);
    percale_memory_free(&solver->detect_memory, solver->audited_notes.items);
    percale_memory_free(&solver->detect_memory, solver->known_stencils.items);
    percale_memory_free(&solver->detect_memory, solver->notes[0].items);
    percale_memory_free(&solver->detect_memory, solver->notes[1].items);
    percale_batches_free(&solver->edges, &solver->color_memory);
    percale_batches_free(&solver->hinges, &solver->color_memory);
    percale_batches_free(&solver->contacts, &solver->color_memory);
    for (int level = 0; level < COARSE_LEVELS_MAX; level++) {
        percale_batches_free(&solver->links[level], &solver->color_memory);
    }
    percale_coloring_free(&solver->static_coloring, &solver->color_memory);
    percale_coloring_free(&solver->contact_coloring, &solver->color_memory);
    percale_arena_free(&solver->arena);
    PercaleAllocator allocator = solver->allocator;
    allocator.release(allocator.user, solver);
}

// ---- prepare ----

static void drop_model(PercaleSolver *solver)
{
    PercaleMemory *detect = &solver->detect_memory;
    PercaleMemory *solve = &solver->solve_memory;
    percale_rays_destroy(solver->rays, detect);
    for (uint32_t o = 0; solver->proximities != NULL && o < solver->model.obstacle_count; o++) {
        percale_proximity_free(&solver->proximities[o], detect);
    }
    percale_healing_close(solver);
    percale_pinches_free(&solver->pinches, detect);
    percale_candidates_free(&solver->candidates, detect);
    percale_candidates_free(&solver->audited, detect);
    percale_memory_free(detect, solver->proximities);
    percale_memory_free(detect, solver->frames);
    percale_memory_free(detect, solver->crossings);
    percale_memory_free(detect, solver->guarded_from);
    percale_memory_free(solve, solver->pin_from);
    percale_memory_free(solve, solver->pin_to);
    percale_memory_free(solve, solver->edge_multipliers);
    percale_memory_free(solve, solver->hinge_multipliers);
    percale_memory_free(solve, solver->bend_weights);
    percale_memory_free(solve, solver->bend_relaxations);
    percale_memory_free(solve, solver->bend_pushes);
    percale_memory_free(solve, solver->seam_targets);
    solver->rays = NULL;
    solver->proximities = NULL;
    solver->frames = NULL;
    solver->crossings = NULL;
    solver->guarded_from = NULL;
    solver->unguarded = 0;
    solver->pin_from = solver->pin_to = NULL;
    solver->edge_multipliers = NULL;
    solver->hinge_multipliers = NULL;
    solver->bend_weights = NULL;
    solver->bend_relaxations = NULL;
    solver->bend_pushes = NULL;
    solver->bend_dt = 0.0f;
    solver->seam_targets = NULL;
    percale_model_free(&solver->model, &solver->model_memory);
    solver->stencils.count = 0;
    solver->known_stencils.count = 0;
    solver->notes[0].count = 0;
    solver->pass_stencil_count = 0;
    solver->assembled = false;
}

void percale_solver_release_model(PercaleSolver *solver)
{
    if (solver->assembled) {
        percale_model_store(&solver->model, &solver->objects);
    }
    drop_model(solver);
}

/// Obstacle points of all three arrays at the start of the next step.
static void place_obstacles(PercaleSolver *solver)
{
    PercaleModel *model = &solver->model;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        (void)percale_motion_apply(model, o, &solver->objects.obstacles[o], 0.0, 0.0, percale_team_alone());
        for (uint32_t i = 0; i < model->obstacles[o].vertex_count; i++) {
            uint32_t point = model->obstacles[o].first_point + i;
            model->position[point] = model->predicted[point];
        }
    }
    memcpy(model->predicted, model->position, model->slot_count * sizeof(f32x4));
}

/// Points of a tile: with the constraints that it holds they fit into a core's cache, see bench/README.md.
enum { TILE_POINTS = 1024 };

static bool batch_constraints(PercaleSolver *solver)
{
    PercaleModel *model = &solver->model;
    PercaleColoring *coloring = &solver->static_coloring;
    PercaleMemory *memory = &solver->color_memory;
    bool complete = percale_batch_edges(model, TILE_POINTS, coloring, memory, &solver->edges) &&
                    percale_batch_hinges(model, TILE_POINTS, coloring, memory, &solver->hinges);
    for (uint32_t i = 0; complete && i < model->coarse.level_count; i++) {
        complete = percale_batch_links(&model->coarse.levels[i], coloring, memory, &solver->links[i]);
    }
    return complete;
}

/// *array gets `count` elements, no memory for none. Returns false without memory.
static bool allocate_some(PercaleMemory *memory, void *array, uint32_t count, size_t element_size)
{
    void *block = count > 0 ? percale_memory_new(memory, count, element_size) : NULL;
    memcpy(array, &block, sizeof(block));
    return count == 0 || block != NULL;
}

/// Multipliers need memory only where a later sweep reads them.
static bool allocate_solve(PercaleSolver *solver)
{
    const PercaleModel *model = &solver->model;
    PercaleMemory *memory = &solver->solve_memory;
    uint32_t compliant_count = model->edge_compliances != NULL ? model->edge_count : 0;
    uint32_t repeated_count = solver->def.iterations > 1 ? model->hinge_count : 0;
    return allocate_some(memory, &solver->edge_multipliers, compliant_count, sizeof(float)) &&
           allocate_some(memory, &solver->bend_weights, model->hinge_count, sizeof(f32x4)) &&
           allocate_some(memory, &solver->hinge_multipliers, repeated_count, sizeof(f32x4)) &&
           allocate_some(memory, &solver->bend_relaxations, repeated_count, sizeof(float)) &&
           allocate_some(memory, &solver->bend_pushes, model->hinge_count > 0 ? model->slot_count : 0,
                         sizeof(f32x4)) &&
           allocate_some(memory, &solver->pin_from, model->pinned_count, sizeof(f32x4)) &&
           allocate_some(memory, &solver->pin_to, model->pinned_count, sizeof(f32x4)) &&
           allocate_some(memory, &solver->seam_targets, model->open_seam_count, sizeof(float));
}

static PercaleResult prepare_detection(PercaleSolver *solver)
{
    PercaleModel *model = &solver->model;
    PercaleMemory *memory = &solver->detect_memory;
    uint32_t count = model->obstacle_count;
    bool complete = allocate_some(memory, &solver->proximities, count, sizeof(PercaleProximity)) &&
                    allocate_some(memory, &solver->frames, count, sizeof(PercaleFrame)) &&
                    allocate_some(memory, &solver->crossings, count, sizeof(PercaleCrossing *));
    if (complete && solver->def.vertex_face && count > 0) {
        complete = percale_pinches_create(&solver->pinches, model, memory);
    }
    for (uint32_t o = 0; complete && solver->def.vertex_face && o < model->obstacle_count; o++) {
        complete = percale_proximity_create(&solver->proximities[o], model, &model->obstacles[o],
                                            solver->def.ccd == PERCALE_CCD_EXACT, memory);
        complete =
            complete && percale_proximity_begin(&solver->proximities[o], model, &model->obstacles[o], memory);
    }
    solver->healing.is_unknown = true;
    solver->healing.look = 0;
    if (complete && model->cloth.edges.edge_count > 0) {
        bool edges = solver->def.edge_edge != 0;
        solver->may_be_crossed = true;
        bool cloth = solver->def.self_collision != 0;
        bool obstacles = edges && solver->def.vertex_face != 0;
        complete = percale_candidates_create(&solver->candidates, model, cloth, edges, obstacles, memory) &&
                   (solver->def.reuse != PERCALE_REUSE_AUDIT ||
                    percale_candidates_create(&solver->audited, model, cloth, edges, obstacles, memory));
    }
    if (complete && solver->candidates.lists != NULL && solver->def.guard_passes) {
        complete = allocate_some(memory, &solver->guarded_from, model->point_count, sizeof(f32x4));
    }
    if (!complete) {
        return percale_fail_memory(&solver->error);
    }
    bool cast = solver->def.vertex_face && solver->def.ccd == PERCALE_CCD_RAY && model->obstacle_count > 0;
    return cast ? percale_rays_create(&solver->rays, &solver->objects, memory, &solver->error) : PERCALE_OK;
}

static PercaleResult assemble(PercaleSolver *solver)
{
    bool edges_collide =
        solver->def.edge_edge != 0 && solver->def.vertex_face != 0 && solver->objects.obstacle_count > 0;
    PercaleParts parts = {solver->def.bending != 0, solver->def.tethers != 0,
                          solver->def.self_collision != 0 || edges_collide, (uint32_t)solver->def.levels};
    PercaleResult result = percale_model_assemble(&solver->model, &solver->objects, parts,
                                                  &solver->model_memory, &solver->error);
    if (result == PERCALE_OK && (!batch_constraints(solver) || !allocate_solve(solver))) {
        result = percale_fail_memory(&solver->error);
    }
    if (result == PERCALE_OK) {
        place_obstacles(solver);
        result = prepare_detection(solver);
    }
    if (result != PERCALE_OK) {
        drop_model(solver); // the objects still hold the state
        return result;
    }
    solver->assembled = true;
    return PERCALE_OK;
}

PercaleResult percale_solver_prepare(PercaleSolver *solver)
{
    if (solver->assembled) {
        return PERCALE_OK;
    }
    uint32_t mode = float_mode_enter(); // the same bits, whoever asks first
    PercaleResult result = assemble(solver);
    float_mode_leave(mode);
    return result;
}

// ---- errors ----

PercaleResult percale_solver_logged(PercaleSolver *solver, PercaleResult result)
{
    if (result != PERCALE_OK && solver->def.log != NULL) {
        solver->def.log(solver->def.log_user, solver->error.text);
    }
    return result;
}

size_t percale_solver_require_cloth(PercaleSolver *solver, PercaleCloth cloth)
{
    size_t index = percale_find_cloth(&solver->objects, cloth);
    if (index == SIZE_MAX) {
        (void)percale_fail(&solver->error, PERCALE_INVALID_HANDLE, "there is no cloth with handle %u",
                           cloth.id);
    }
    return index;
}

// ---- questions ----

PercaleResult percale_solver_set_thread_count(PercaleSolver *solver, int thread_count)
{
    if (thread_count < 1 || thread_count > PERCALE_MAX_THREADS) {
        return percale_solver_logged(solver, percale_fail(&solver->error, PERCALE_INVALID_ARGUMENT,
                                                          "thread count %d is not in 1..%d", thread_count,
                                                          PERCALE_MAX_THREADS));
    }
    solver->def.thread_count = thread_count;
    return PERCALE_OK;
}

PercaleProfile percale_solver_profile(const PercaleSolver *solver)
{
    return solver->profile;
}

PercaleCounters percale_solver_counters(const PercaleSolver *solver)
{
    return solver->counters;
}

PercaleBytes percale_solver_bytes(const PercaleSolver *solver)
{
    return (PercaleBytes){solver->model_memory.bytes + solver->object_memory.bytes,
                          solver->detect_memory.bytes, solver->color_memory.bytes, solver->solve_memory.bytes,
                          solver->arena.memory.bytes};
}

PercaleIsa percale_solver_isa(const PercaleSolver *solver)
{
    return solver->def.isa;
}

const char *percale_solver_last_error(const PercaleSolver *solver)
{
    return solver->error.text;
}

uint64_t percale_solver_hash(PercaleSolver *solver)
{
    PercaleResult result = percale_solver_prepare(solver);
    return percale_solver_logged(solver, result) == PERCALE_OK ? percale_digest(&solver->model) : 0;
}

PercaleResult percale_solver_validate(PercaleSolver *solver)
{
    PercaleResult result = percale_solver_prepare(solver);
    if (result == PERCALE_OK) {
        result = percale_validate_model(&solver->model, &solver->edges, &solver->hinges,
                                        &solver->model_memory, &solver->error);
    }
    return percale_solver_logged(solver, result);
}
