#include "step_untangle.h"

#include "base/parallel.h"
#include "solve/sweep.h"
#include "solver.h"
#include "untangle/clusters.h"
#include "untangle/untangle.h"

#include <string.h>

static const float ONE_SECOND = 1.0f; // compliance has no time to act against: cloth keeps its lengths

// A state with so many times the best one's crossings, and so many more, is no way out.
enum { WORSE_TIMES = 3, WORSE_PAIRS = 50 };
enum { IDLE_ROUNDS = 12, TURNS_MOST = 8 }; // rounds without a better state, and how often one turns back

enum { FAILED_NOW = 0x80 }; // a mark among the failures

/// Everything that an untangling holds.
typedef struct Work {
    PercaleUntangling *untangling;
    PercaleSolver *solver;
    PercaleTeam *team;
    PercaleMemory *memory;
    PercaleTangleMesh mesh;
    PercaleCrossingSearch *search; // aligned to cache lines
    PercaleTangleCrossings crossings;
    PercaleContours contours;
    PercaleRegionFlood flood;
    PercaleTangleStage stage;
    PercaleTangleAges ages;
    PercaleStencilList stencils;
    PercaleColoring coloring;
    PercaleBatches contacts;
    float *edge_lengths;
    bool complete; // there was memory
    PercaleTangleClusters clusters;
    f32x4 *before; // [point_count] where the round began
    f32x4 *best;   // [point_count] the state with the fewest crossings
} Work;

// ---- look ----

static bool look(Work *work)
{
    const f32x4 *x = work->solver->model.predicted;
    return percale_crossing_search_run(work->search, x, work->team, work->memory, &work->crossings) &&
           percale_contours_build(&work->contours, &work->mesh, &work->crossings, x, work->memory);
}

/// How tangled a state is: pairs that share no point, all crossings, length.
typedef struct Measure {
    uint64_t pairs, crossings, contours;
    double length;
} Measure;

static Measure measure_of(const Work *work)
{
    return (Measure){work->contours.pair_count, work->crossings.count, work->contours.count,
                     percale_contours_length(&work->contours)};
}

static bool is_better(Measure a, Measure b)
{
    if (a.pairs != b.pairs) {
        return a.pairs < b.pairs;
    }
    return a.crossings != b.crossings ? a.crossings < b.crossings : a.length < b.length;
}

// ---- color and solve ----

static bool color(Work *work)
{
    const PercaleStencilList *stencils = &work->stencils;
    PercaleConstraints constraints = {
        .vertices = stencils->count > 0 ? stencils->items[0].points : NULL,
        .vertex_stride = sizeof(PercaleStencil) / sizeof(uint32_t),
        .weights = stencils->count > 0 ? stencils->items[0].weights : NULL,
        .weight_stride = sizeof(PercaleStencil) / sizeof(float),
        .arity = 4,
        .count = (uint32_t)stencils->count,
    };
    const PercaleModel *model = &work->solver->model;
    return percale_coloring_run(&work->coloring, work->memory, &constraints, model->predicted,
                                model->point_count) &&
           percale_batch_coloring(&work->coloring, work->memory, &work->contacts);
}

static bool solve(Work *work)
{
    PercaleSolver *solver = work->solver;
    PercaleModel *model = &solver->model;
    const PercaleBatches none = {0};
    for (uint32_t s = 0; s < model->open_seam_count; s++) { // an open seam stays as open as it is
        const uint32_t *slots = model->open_seams[s].slots;
        solver->seam_targets[s] = length3(model->predicted[slots[0]] - model->predicted[slots[1]]);
    }
    if (solver->edge_multipliers != NULL) {
        memset(solver->edge_multipliers, 0, model->edge_count * sizeof(float));
    }
    PercaleSweepPlan plan = {.arrays = {.model = model,
                                        .x = model->predicted,
                                        .start = model->position,
                                        .dt = ONE_SECOND,
                                        .edge_multipliers = solver->edge_multipliers,
                                        .seam_targets = solver->seam_targets,
                                        .stencils = work->stencils.items,
                                        .stencil_order = work->coloring.order},
                             .edges = &solver->edges,
                             .hinges = &none,
                             .contacts = &work->contacts,
                             .sweep_count = (uint32_t)work->untangling->def.sweeps};
    percale_arena_reset(&solver->arena);
    return percale_sweep_run(&plan, work->team, &solver->arena);
}

// ---- rounds ----

static bool is_finite(const PercaleModel *model)
{
    bool finite = true;
    for (uint32_t i = 0; i < model->slot_count; i++) {
        finite = finite && is_finite3(model->predicted[i]);
    }
    return finite;
}

/// Back to the best state: what was tried has made it worse.
static bool turn_back(Work *work)
{
    PercaleModel *model = &work->solver->model;
    memcpy(model->predicted, work->best, model->point_count * sizeof(f32x4));
    work->stencils.count = 0;
    work->ages.turns++;
    return look(work);
}

/// Notes the failure with the triangles that crossed before.
static void count_failures(Work *work)
{
    uint8_t *fails = work->ages.fails;
    for (size_t i = 0; i < work->clusters.pairs.count; i++) {
        for (int k = 0; k < 2; k++) {
            uint32_t triangle = work->clusters.pairs.items[i][k];
            uint32_t point = corners_of_triangle(&work->mesh, triangle)[0];
            fails[triangle] |= percale_tangle_cluster_is_worse(&work->clusters, point) ? FAILED_NOW : 0;
        }
    }
    for (uint32_t t = 0; t < work->mesh.triangle_count; t++) {
        uint8_t before = fails[t] & (FAILED_NOW - 1);
        fails[t] = (uint8_t)(before + (fails[t] != before && before + 1 < FAILED_NOW));
    }
}

/// Does the round again without the stencils of those parts of the state that it has made worse: so nothing
/// is lost but their work, and momentum is kept. False without memory.
static bool do_again(Work *work)
{
    PercaleModel *model = &work->solver->model;
    PercaleStencilList *stencils = &work->stencils;
    size_t kept = 0;
    count_failures(work);
    for (size_t i = 0; i < stencils->count; i++) {
        uint32_t point = stencils->items[i].points[0];
        uint32_t other = stencils->items[i].points[1];
        if (!percale_tangle_cluster_is_worse(&work->clusters, point < model->slot_count ? point : other)) {
            stencils->items[kept] = stencils->items[i];
            stencils->items[kept++].multiplier = (f32x4){0};
        }
    }
    stencils->count = kept;
    memcpy(model->predicted, work->before, model->point_count * sizeof(f32x4));
    return color(work) && solve(work) && look(work);
}

/// The best state so far, and for how many rounds it has been that.
typedef struct Progress {
    Measure best;
    int idle_rounds;
} Progress;

static void keep_best(Work *work, Progress *progress)
{
    const PercaleModel *model = &work->solver->model;
    Measure now = measure_of(work);
    progress->idle_rounds++;
    if (is_better(now, progress->best)) {
        progress->idle_rounds = 0;
        progress->best = now;
        memcpy(work->best, model->predicted, model->point_count * sizeof(f32x4));
    }
}

/// False: nothing more is to be tried, or there is no memory.
static bool run_round(Work *work, Progress *progress)
{
    percale_tangle_ages_count(&work->ages, &work->stage);
    work->complete = percale_tangle_find_stencils(&work->stage, &work->ages);
    if (!work->complete || work->stencils.count == 0) {
        return false;
    }
    const PercaleModel *model = &work->solver->model;
    memcpy(work->before, model->predicted, model->point_count * sizeof(f32x4));
    work->complete =
        percale_tangle_clusters_begin(&work->clusters, &work->stage) && color(work) && solve(work);
    work->untangling->report.iterations++;
    bool finite = work->complete && is_finite(&work->solver->model);
    if (finite) {
        work->complete =
            look(work) && (!percale_tangle_clusters_judge(&work->clusters, &work->stage) || do_again(work));
    }
    if (!work->complete) {
        return false;
    }
    Measure now = measure_of(work);
    if (finite) {
        keep_best(work, progress);
    }
    bool is_hopeless = !finite || now.pairs > WORSE_TIMES * progress->best.pairs + WORSE_PAIRS;
    if (is_hopeless || progress->idle_rounds >= IDLE_ROUNDS) {
        progress->idle_rounds = 0;
        work->complete = turn_back(work);
        return work->complete && work->ages.turns < TURNS_MOST;
    }
    return true;
}

static bool run_rounds(Work *work)
{
    PercaleUntangling *untangling = work->untangling;
    PercaleUntangleReport *report = &untangling->report;
    PercaleModel *model = &work->solver->model;
    work->complete = look(work);
    if (!work->complete) {
        return false;
    }
    Progress progress = {measure_of(work), 0};
    report->ef_before = progress.best.pairs;
    report->length_before = progress.best.length;
    report->contours_before = progress.best.contours;
    memcpy(work->best, model->predicted, model->point_count * sizeof(f32x4));
    bool goes_on = true;
    while (goes_on && progress.best.pairs > 0 && report->iterations < untangling->def.rounds) {
        goes_on = run_round(work, &progress);
    }
    memcpy(model->predicted, work->best, model->point_count * sizeof(f32x4));
    report->ef_after = progress.best.pairs;
    report->length_after = progress.best.length;
    report->contours_after = progress.best.contours;
    return work->complete;
}

// ---- begin and end ----

static bool open_work(Work *work)
{
    PercaleModel *model = &work->solver->model;
    PercaleMemory *memory = work->memory;
    if (!percale_tangle_mesh_build(&work->mesh, model, memory)) {
        return false;
    }
    work->search = percale_memory_new(memory, 1, sizeof(*work->search));
    work->ages.rounds = percale_memory_new(memory, work->mesh.triangle_count, sizeof(uint8_t));
    work->edge_lengths = percale_memory_new(memory, work->mesh.edges.edge_count, sizeof(float));
    work->ages.fails = percale_memory_new(memory, work->mesh.triangle_count, sizeof(uint8_t));
    work->before = percale_memory_new(memory, model->point_count, sizeof(f32x4));
    work->best = percale_memory_new(memory, model->point_count, sizeof(f32x4));
    work->stage = (PercaleTangleStage){
        .mesh = &work->mesh,
        .search = work->search,
        .crossings = &work->crossings,
        .contours = &work->contours,
        .x = model->predicted,
        .flood = &work->flood,
        .edge_lengths = work->edge_lengths,
        .labels = percale_memory_new(memory, model->point_count, sizeof(uint32_t)),
        .queue = percale_memory_new(memory, model->point_count, sizeof(uint32_t)),
        .is_inside = percale_memory_new(memory, model->point_count, sizeof(uint8_t)),
        .stencils = &work->stencils,
        .held_in = percale_memory_new(memory, model->point_count, sizeof(uint64_t)),
        .memory = memory,
    };
    bool complete =
        work->search != NULL && work->ages.rounds != NULL && work->best != NULL && work->before != NULL &&
        work->ages.fails != NULL &&
        percale_tangle_clusters_open(&work->clusters, model->point_count, memory) &&
        work->edge_lengths != NULL && work->stage.labels != NULL && work->stage.queue != NULL &&
        work->stage.is_inside != NULL && work->stage.held_in != NULL &&
        percale_region_flood_open(&work->flood, &work->mesh, model->predicted, memory) &&
        percale_crossing_search_open(work->search, &work->mesh, model->predicted, work->team, memory);
    for (uint32_t e = 0; complete && e < work->mesh.edges.edge_count; e++) {
        const uint32_t *ends = work->mesh.edges.vertices[e];
        work->edge_lengths[e] = length3(model->predicted[ends[0]] - model->predicted[ends[1]]);
    }
    work->flood.crossings = &work->crossings;
    work->flood.contours = &work->contours;
    work->ages.patience = (uint8_t)work->untangling->def.patience;
    return complete;
}

static void close_work(Work *work)
{
    PercaleMemory *memory = work->memory;
    if (work->search != NULL) {
        percale_crossing_search_close(work->search, memory);
    }
    percale_region_flood_close(&work->flood, memory);
    percale_contours_free(&work->contours, memory);
    percale_coloring_free(&work->coloring, memory);
    percale_batches_free(&work->contacts, memory);
    percale_tangle_mesh_free(&work->mesh, memory);
    percale_tangle_clusters_free(&work->clusters, memory);
    void *arrays[] = {work->search,          work->ages.rounds,    work->best,
                      work->stage.labels,    work->stage.queue,    work->stage.is_inside,
                      work->crossings.items, work->stencils.items, work->stage.held_in,
                      work->edge_lengths,    work->before,         work->ages.fails};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); i++) {
        percale_memory_free(memory, arrays[i]);
    }
}

/// Mass, and mass times way, of the points that can move and have moved at least so far.
typedef struct Motion {
    Vec3 momentum;
    double mass, size, farthest;
} Motion;

static Motion motion_of(const PercaleModel *model, double least)
{
    Motion motion = {vec3(0.0, 0.0, 0.0), 0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < model->slot_count; i++) {
        Vec3 way = vsub(vec3_of(model->predicted[i]), vec3_of(model->position[i]));
        double size = vlength(way);
        if (model->position[i][3] > 0.0f && size >= least) {
            double mass = 1.0 / (double)model->position[i][3];
            motion.momentum = vadd(motion.momentum, vscale(mass, way));
            motion.mass += mass;
            motion.size += mass * size;
            motion.farthest = size > motion.farthest ? size : motion.farthest;
        }
    }
    return motion;
}

static double drift_of(const Motion *motion)
{
    return motion->size > 0.0 ? vlength(motion->momentum) / motion->size : 0.0;
}

/// What momentum float32 can have left, m kg: each store of a point is off by half a unit in its last place.
static double rounding_of(const PercaleModel *model, int sweep_count)
{
    const double HALF_A_UNIT = 0x1p-24; // share of a coordinate
    const double STORES = 16.0;         // of a point in a sweep, by its edges and stencils
    double sum = 0.0;
    for (uint32_t i = 0; i < model->slot_count; i++) {
        Vec3 place = vec3_of(model->predicted[i]);
        bool has_moved = vlength(vsub(place, vec3_of(model->position[i]))) > 0.0;
        sum +=
            has_moved && model->position[i][3] > 0.0f ? vlength(place) / (double)model->position[i][3] : 0.0;
    }
    return HALF_A_UNIT * STORES * sweep_count * sum;
}

/// Where nothing holds the cloth, what momentum there is comes from rounding, if it is no more than that can
/// be: those that have moved farthest give it back.
static void give_back_rounding(PercaleModel *model, int sweep_count)
{
    Motion all = motion_of(model, 0.0);
    Motion far = motion_of(model, 0.5 * all.farthest);
    if (model->obstacle_count > 0 || model->pinned_count > 0 ||
        vlength(all.momentum) > rounding_of(model, sweep_count) || !(far.mass > 0.0)) {
        return;
    }
    Vec3 shift = vscale(-1.0 / far.mass, all.momentum);
    for (uint32_t i = 0; i < model->slot_count; i++) {
        Vec3 place = vec3_of(model->predicted[i]);
        bool is_far = vlength(vsub(place, vec3_of(model->position[i]))) >= 0.5 * all.farthest;
        if (is_far && model->position[i][3] > 0.0f) {
            model->predicted[i] = f32x4_of(vadd(place, shift), model->predicted[i][3]);
        }
    }
}

/// |sum m dx| / sum m |dx| of all points that can move, and the farthest way.
static void report_motion(PercaleModel *model, int sweeps, PercaleUntangleReport *report)
{
    give_back_rounding(model, sweeps * report->iterations);
    Motion motion = motion_of(model, 0.0);
    report->momentum_drift = drift_of(&motion);
    report->displacement_max = motion.farthest;
}

void percale_run_untangling(PercaleTeam *team, void *context)
{
    PercaleUntangling *untangling = context;
    PercaleModel *model = &untangling->solver->model;
    PercaleMemory memory = {&untangling->solver->allocator, 0};
    Work work = {.untangling = untangling, .solver = untangling->solver, .team = team, .memory = &memory};
    memcpy(model->predicted, model->position, model->point_count * sizeof(f32x4));
    bool complete = open_work(&work) && run_rounds(&work);
    if (complete) {
        report_motion(model, untangling->def.sweeps, &untangling->report);
        memcpy(model->position, model->predicted, model->point_count * sizeof(f32x4));
    }
    close_work(&work);
    untangling->result = complete ? PERCALE_OK : PERCALE_OUT_OF_MEMORY;
}
