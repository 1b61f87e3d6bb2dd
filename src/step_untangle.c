#include "step_untangle.h"

#include "base/parallel.h"
#include "substep.h"

#include <string.h>

/// Everything that an untangling holds besides the solver.
typedef struct Work {
    PercaleUntangling *untangling;
    PercaleSolver *solver;
    PercaleTeam *team;
    PercaleMemory *memory;
    f32x4 *start;      // [point_count] where the points were
    f32x4 *best;       // [point_count] the state with the fewest crossings
    f32x4 *velocities; // [slot_count] m/s, which stay as they were
    double seconds;    // of a round
} Work;

/// How tangled a state is: pairs that share no point, all crossings, length.
typedef struct Measure {
    uint64_t pairs, crossings, contours;
    double length;
} Measure;

static Measure measure_of(const PercaleTangler *tangler)
{
    return (Measure){tangler->contours.pair_count, tangler->crossings.count, tangler->contours.count,
                     percale_contours_length(&tangler->contours)};
}

static bool is_better(Measure a, Measure b)
{
    if (a.pairs != b.pairs) {
        return a.pairs < b.pairs;
    }
    return a.crossings != b.crossings ? a.crossings < b.crossings : a.length < b.length;
}

// ---- rounds ----

static void copy_points(const PercaleModel *model, f32x4 *to, const f32x4 *from)
{
    memcpy(to, from, model->point_count * sizeof(f32x4));
}

/// A step of a world in which nothing else moves. PERCALE_NOT_FINITE: there is no going on.
static PercaleResult move(Work *work)
{
    PercaleSolver *solver = work->solver;
    PercaleSubsteps substeps = {solver, work->seconds, 0, PERCALE_OK};
    percale_run_on(&substeps, work->team);
    return substeps.result;
}

static PercaleResult run_rounds(Work *work)
{
    PercaleUntangleReport *report = &work->untangling->report;
    const PercaleUntangleDef *def = &work->untangling->def;
    PercaleSolver *solver = work->solver;
    PercaleModel *model = &solver->model;
    if (!percale_healing_look(solver, work->team)) {
        return PERCALE_OUT_OF_MEMORY;
    }
    Measure best = measure_of(&solver->healing.tangler);
    report->ef_before = best.pairs;
    report->length_before = best.length;
    report->contours_before = best.contours;
    int idle = 0; // rounds without a better state
    PercaleResult result = PERCALE_OK;
    while (best.pairs > 0 && report->iterations < def->rounds && idle < def->patience) {
        result = move(work);
        if (result != PERCALE_OK) {
            break;
        }
        report->iterations++;
        if (!percale_healing_look(solver, work->team)) {
            return PERCALE_OUT_OF_MEMORY;
        }
        Measure now = measure_of(&solver->healing.tangler);
        idle++;
        if (is_better(now, best)) {
            idle = 0;
            best = now;
            copy_points(model, work->best, model->position);
        }
    }
    copy_points(model, model->position, work->best);
    report->ef_after = best.pairs;
    report->length_after = best.length;
    report->contours_after = best.contours;
    return result == PERCALE_NOT_FINITE ? PERCALE_OK : result;
}

// ---- begin and end ----

/// Cloth keeps the lengths that it has now: else all that is stretched would move.
static void keep_lengths(PercaleModel *model)
{
    for (uint32_t e = 0; e < model->edge_count; e++) {
        const uint32_t *ends = model->edges[e]; // bytes
        model->edge_lengths[e] =
            length3(model->position[ends[0] / sizeof(f32x4)] - model->position[ends[1] / sizeof(f32x4)]);
    }
}

/// So long that what has to come out moves an edge's length.
static double seconds_of_round(const PercaleTangler *tangler)
{
    const double SHORTEST = 1e-6;
    const double LONGEST = 1.0;
    double sum = 0.0;
    for (uint32_t e = 0; e < tangler->mesh.cloth_edge_count; e++) {
        sum += (double)tangler->edge_lengths[e];
    }
    double seconds = sum / fmax(tangler->mesh.cloth_edge_count, 1.0) / (double)EXIT_SPEED;
    return fmin(fmax(seconds, SHORTEST), LONGEST);
}

static bool open_work(Work *work)
{
    PercaleModel *model = &work->solver->model;
    work->start = percale_memory_new(work->memory, model->point_count, sizeof(f32x4));
    work->best = percale_memory_new(work->memory, model->point_count, sizeof(f32x4));
    work->velocities = percale_memory_new(work->memory, model->slot_count, sizeof(f32x4));
    if (work->start == NULL || work->best == NULL || work->velocities == NULL ||
        !percale_healing_open(work->solver, true, work->team)) {
        return false;
    }
    copy_points(model, work->start, model->position);
    copy_points(model, work->best, model->position);
    memcpy(work->velocities, model->velocity, model->slot_count * sizeof(f32x4));
    memset(model->velocity, 0, model->slot_count * sizeof(f32x4));
    work->seconds = seconds_of_round(&work->solver->healing.tangler);
    keep_lengths(model);
    return true;
}

static void close_work(Work *work)
{
    percale_memory_free(work->memory, work->start);
    percale_memory_free(work->memory, work->best);
    percale_memory_free(work->memory, work->velocities);
}

/// Mass, and mass times way, of the points that can move and have moved at least so far.
typedef struct Motion {
    Vec3 momentum;
    double mass, size, farthest;
} Motion;

static Motion motion_of(const PercaleModel *model, const f32x4 *start, double least)
{
    Motion motion = {vec3(0.0, 0.0, 0.0), 0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < model->slot_count; i++) {
        Vec3 way = vsub(vec3_of(model->position[i]), vec3_of(start[i]));
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
static double rounding_of(const PercaleModel *model, const f32x4 *start, int sweep_count)
{
    const double HALF_A_UNIT = 0x1p-24; // share of a coordinate
    const double STORES = 16.0;         // of a point in a sweep, by its edges and stencils
    double sum = 0.0;
    for (uint32_t i = 0; i < model->slot_count; i++) {
        Vec3 place = vec3_of(model->position[i]);
        bool has_moved = vlength(vsub(place, vec3_of(start[i]))) > 0.0;
        sum +=
            has_moved && model->position[i][3] > 0.0f ? vlength(place) / (double)model->position[i][3] : 0.0;
    }
    return HALF_A_UNIT * STORES * sweep_count * sum;
}

/// Where nothing holds the cloth, what momentum there is comes from rounding, if it is no more than that can
/// be: those that have moved farthest give it back.
static void give_back_rounding(PercaleModel *model, const f32x4 *start, int sweep_count)
{
    Motion all = motion_of(model, start, 0.0);
    Motion far = motion_of(model, start, 0.5 * all.farthest);
    if (model->obstacle_count > 0 || model->pinned_count > 0 ||
        vlength(all.momentum) > rounding_of(model, start, sweep_count) || !(far.mass > 0.0)) {
        return;
    }
    Vec3 shift = vscale(-1.0 / far.mass, all.momentum);
    for (uint32_t i = 0; i < model->slot_count; i++) {
        Vec3 place = vec3_of(model->position[i]);
        bool is_far = vlength(vsub(place, vec3_of(start[i]))) >= 0.5 * all.farthest;
        if (is_far && model->position[i][3] > 0.0f) {
            model->position[i] = f32x4_of(vadd(place, shift), model->position[i][3]);
        }
    }
}

/// |sum m dx| / sum m |dx| of all points that can move, and the farthest way.
static void report_motion(PercaleModel *model, const f32x4 *start, int sweeps, PercaleUntangleReport *report)
{
    give_back_rounding(model, start, sweeps * report->iterations);
    Motion motion = motion_of(model, start, 0.0);
    report->momentum_drift = drift_of(&motion);
    report->displacement_max = motion.farthest;
}

void percale_run_untangling(PercaleTeam *team, void *context)
{
    PercaleUntangling *untangling = context;
    PercaleSolver *solver = untangling->solver;
    PercaleModel *model = &solver->model;
    PercaleMemory memory = {&solver->allocator, 0};
    Work work = {.untangling = untangling, .solver = solver, .team = team, .memory = &memory};
    if (!open_work(&work)) {
        untangling->result = PERCALE_OUT_OF_MEMORY;
        close_work(&work);
        return;
    }
    untangling->result = run_rounds(&work);
    if (untangling->result == PERCALE_OK) {
        report_motion(model, work.start, untangling->def.sweeps, &untangling->report);
    } else {
        copy_points(model, model->position, work.start);
    }
    memcpy(model->velocity, work.velocities, model->slot_count * sizeof(f32x4));
    close_work(&work);
}
