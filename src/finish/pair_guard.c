#include "finish/pair_guard.h"

#include "detect/impact_time.h"
#include "detect/passage.h"
#include "detect/pinch.h"
#include "finish/zones.h"
#include "percale/geometry.h"

#include <string.h>

enum {
    // Rounds: of each the one after its last.
    PUSHES = 48,             // what has passed is pushed back
    HALVES = PUSHES + 4,     // it goes half as far
    ROUNDS = HALVES + 20,    // it goes together
    LAST_ROUND = ROUNDS + 32 // all the rest stands still
};

// Share of the distance at the start that is left to what has passed, and the least distance, m: contact
// widens it again, but what is pressed on for long halves it in each substep, and rounding passes what is
// nearer than it.
static const double KEPT = 0.5;
static const double LEAST_KEPT = 1e-6;

// ---- who has passed ----

/// The candidates of one kind of item.
typedef struct Kind {
    const PercalePairGuardStage *stage;
    const PercaleModelSurface *mesh;
    double reach; // m; of contact
    PercaleVisiting visiting;
} Kind;

// With exact tests nothing comes nearer than this, m, or a tenth of its distance: the next start is apart,
// too.
static const double APART = 1e-6;
static const double SHARE_APART = 0.1;

static double start_distance(const Vec3 *from, bool edges)
{
    double x[4][3];
    double weights[4];
    for (int k = 0; k < 4; k++) {
        x[k][0] = from[k].x;
        x[k][1] = from[k].y;
        x[k][2] = from[k].z;
    }
    return edges ? percale_edge_edge_closest((const double(*)[3])x, weights)
                 : percale_vertex_face_closest((const double(*)[3])x, weights);
}

/// Whether two features may have touched on their ways; of those that overlap at the start, whether they
/// pass.
static bool may_touch(const Vec3 *from, const Vec3 *to, bool edges, PercalePassage *passage)
{
    PercaleImpact touch;
    PercaleImpact near;
    bool (*impact_time)(const Vec3 *, const Vec3 *, double, PercaleImpact *) =
        edges ? percale_edge_edge_impact_time : percale_vertex_face_impact_time;
    if (!impact_time(from, to, 0.0, &touch)) {
        return false;
    }
    double apart = fmin(APART, SHARE_APART * start_distance(from, edges));
    const PercaleImpact *impact = impact_time(from, to, apart, &near) ? &near : &touch;
    if (!(vdot(impact->normal, impact->normal) > 0.0)) {
        return edges ? percale_edges_pass(from, to, passage) : percale_vertex_passes(from, to, passage);
    }
    passage->time = impact->time;
    passage->normal = impact->normal;
    memcpy(passage->weights, impact->weights, sizeof(passage->weights));
    return true;
}

static bool has_passed(const PercalePairGuardStage *stage, const Vec3 *from, const Vec3 *to, bool edges,
                       PercalePassage *passage)
{
    if (stage->exact) {
        return may_touch(from, to, edges, passage);
    }
    return edges ? percale_edges_pass(from, to, passage) : percale_vertex_passes(from, to, passage);
}

/// Back to the side that it came from, a little less far than it was, if that is far enough.
static void add_push(PercaleCollector *collector, const uint32_t points[4], const Vec3 *from,
                     const PercalePassage *passage, bool edges, double most)
{
    double gap = vdot(passage->normal, weigh_points(from, passage->weights));
    PercaleStencil stencil = {.normal =
                                  f32x4_of(passage->normal, (float)fmax(KEPT * fmin(gap, most), LEAST_KEPT))};
    memcpy(stencil.points, points, sizeof(stencil.points));
    percale_stencil_weigh(&stencil, passage->weights, edges);
    percale_collect_stencil(collector, &stencil);
}

/// Outward normal of an obstacle's vertex or edge at the end of the substep; zero where no face is.
static Vec3 outward_of(const Kind *kind, uint32_t item)
{
    const PercaleModelSurface *mesh = kind->mesh;
    PercaleSurface surface = {mesh, NULL, kind->stage->model->predicted};
    if (kind->visiting.hood.arity == 2) {
        uint32_t side = mesh->edges.sides[mesh->edges.first_side[item]];
        return percale_surface_normal(&surface, side / 3, (PercaleRegion)(REGION_SIDE_0 + side % 3));
    }
    uint32_t first = mesh->vertex_first_face[item];
    if (first == mesh->vertex_first_face[item + 1]) {
        return vec3(0.0, 0.0, 0.0);
    }
    uint32_t face = mesh->vertex_faces[first];
    uint32_t corner = 0;
    while (mesh->triangles[3 * (size_t)face + corner] != mesh->first_point + item) {
        corner++;
    }
    return percale_surface_normal(&surface, face, (PercaleRegion)(REGION_CORNER_0 + corner));
}

/// Whether the cloth passes a feature of an obstacle from behind: through an open one that is a free way, out
/// of a closed one the only way.
static bool comes_from_behind(const Kind *kind, uint32_t item, const PercalePassage *passage)
{
    if (kind->mesh == &kind->stage->model->cloth) {
        return false;
    }
    Vec3 outward = outward_of(kind, item);
    return !(vdot(outward, outward) > 0.0) || vdot(passage->normal, outward) > 0.0;
}

/// Whether a feature of the cloth is held between obstacles: there is no holding it back from them.
static bool is_pinched(const Kind *kind, const uint32_t *corners)
{
    const uint8_t *pinched = kind->stage->is_pinched;
    return pinched != NULL && kind->mesh != &kind->stage->model->cloth &&
           percale_pinched_any(pinched, PINCH_HELD, corners, kind->visiting.hood.arity);
}

static bool is_free(const Kind *kind, uint32_t item, uint32_t primitive)
{
    const PercaleNoteList *known = kind->stage->known;
    return known != NULL && kind->mesh == &kind->stage->model->cloth &&
           percale_pairs_are_free(known, kind->visiting.hood.arity == 2, item, primitive);
}

static void find_passing(const void *context, PercaleCollector *collector, const PercaleQuery *query,
                         uint32_t place, uint32_t item)
{
    (void)place;
    const Kind *kind = context;
    const PercaleModel *model = kind->stage->model;
    bool edges = kind->visiting.hood.arity == 2;
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        const uint32_t *corners = kind->visiting.hood.primitives +
                                  (size_t)kind->visiting.hood.arity * collector->neighbors.items[i].index;
        uint32_t points[4] = {query->points[0], edges ? query->points[1] : corners[0], corners[edges ? 0 : 1],
                              corners[edges ? 1 : 2]};
        if (!percale_candidates_collide(kind->stage->candidates, query->points[0], corners[0]) ||
            is_free(kind, item, collector->neighbors.items[i].index) || is_pinched(kind, corners)) {
            continue;
        }
        Vec3 from[4];
        Vec3 to[4];
        for (int k = 0; k < 4; k++) {
            from[k] = vec3_of(model->position[points[k]]);
            to[k] = vec3_of(model->predicted[points[k]]);
        }
        PercalePassage passage;
        if (has_passed(kind->stage, from, to, edges, &passage) && !comes_from_behind(kind, item, &passage)) {
            add_push(collector, points, from, &passage, edges, kind->reach);
        }
    }
}

static void find_items(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Kind *kind = context;
    percale_candidates_visit(&kind->visiting, collector, first, end);
}

/// All passages from the start to where the points are now. `touched`: they have been found already; these
/// points have moved since, or passed.
static bool find_passages(const PercalePairGuardStage *stage, const uint8_t *touched,
                          PercalePairGuardCounts *counts)
{
    PercaleCandidates *candidates = stage->candidates;
    PercaleCandidateStage needed = {.from = stage->model->position,
                                    .to = stage->model->predicted,
                                    .again = touched != NULL,
                                    .spare = percale_candidates_least_reach(candidates),
                                    .collectors = stage->collectors,
                                    .memory = stage->memory,
                                    .team = stage->team};
    bool complete = percale_candidates_keep(candidates, &needed, &counts->candidates);
    stage->passing->count = 0;
    PercaleCollected to = {.stencils = stage->passing};
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        const PercaleCandidateList *list = &candidates->lists[i];
        Kind kind = {
            stage,
            list->mesh,
            (double)percale_candidates_least_reach(candidates),
            {candidates, i, percale_candidates_hood(candidates, i), touched, false, find_passing, &kind}};
        kind.visiting.hood.only_passing = true;
        complete = percale_collect(stage->team, percale_candidate_count(list), find_items, &kind,
                                   stage->collectors, stage->memory, &to);
        counts->candidates += stage->collectors->candidates;
    }
    return complete;
}

// ---- back ----

/// What the rounds work with.
typedef struct Work {
    const PercalePairGuardStage *stage;
    PercaleZones zones;
    uint8_t *touched; // [points] those that have passed when last looked for, or moved since
} Work;

/// Moves a point and gives it the velocity that it has so. What is known of its distances shrinks.
static void move_point(const Work *work, uint32_t slot, f32x4 to)
{
    const PercalePairGuardStage *stage = work->stage;
    PercaleModel *model = stage->model;
    work->touched[slot] = 1;
    f32x4 by = with_w(to - model->predicted[slot], 0.0f);
    model->predicted[slot] = with_w(to, model->predicted[slot][3]);
    model->next_velocity[slot] += by / stage->dt;
    for (uint32_t o = 0; stage->obstacles && o < model->obstacle_count; o++) {
        PercaleProximity *proximity = &stage->proximities[o];
        proximity->clearance[slot] -= length3(by);
        proximity->side[slot] = 0;
        proximity->nearest[slot] = NO_TRIANGLE;
    }
}

/// The projection of MATH.md, section 1.
static void push_back(const Work *work, const PercaleStencil *stencil)
{
    const f32x4 *x = work->stage->model->predicted;
    f32x4 offset = {0};
    float weight = 0.0f;
    for (int k = 1; k < 4; k++) {
        offset += (x[stencil->points[k]] - x[stencil->points[0]]) * stencil->weights[k];
    }
    float farthest = 0.0f;
    for (int k = 0; k < 4; k++) {
        float share = x[stencil->points[k]][3] * stencil->weights[k];
        weight += share * stencil->weights[k];
        farthest = fmaxf(farthest, fabsf(share));
    }
    weight = fmaxf(weight, farthest / LONGEST_LEVER);
    float depth = stencil->normal[3] - dot3(stencil->normal, offset);
    if (!(depth > 0.0f) || !(weight > 0.0f)) {
        return;
    }
    for (int k = 0; k < 4; k++) {
        float share = x[stencil->points[k]][3] * stencil->weights[k];
        if (share != 0.0f) {
            move_point(work, stencil->points[k],
                       x[stencil->points[k]] + stencil->normal * (share * depth / weight));
        }
    }
}

/// Those that still pass go half as far.
static void hold_back(const Work *work, const PercaleStencil *stencil)
{
    const PercaleModel *model = work->stage->model;
    for (int k = 0; k < 4; k++) {
        uint32_t point = stencil->points[k];
        if (model->predicted[point][3] > 0.0f) {
            f32x4 to = model->position[point] + (model->predicted[point] - model->position[point]) * 0.5f;
            move_point(work, point, to);
        }
    }
}

/// What still passes goes together; with `all` the rest stands still: then nothing passes but what pins and
/// obstacles force.
static void move_zones(Work *work, bool all)
{
    const PercaleModel *model = work->stage->model;
    PercaleZones *zones = &work->zones;
    for (size_t i = 0; i < work->stage->passing->count; i++) {
        percale_zones_add(zones, model, &work->stage->passing->items[i]);
    }
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        bool held = zones->parent[slot] != NO_ZONE;
        if (model->predicted[slot][3] > 0.0f && (held || all)) {
            f32x4 motion = held ? percale_zones_motion(zones, slot) : (f32x4){0};
            move_point(work, slot, model->position[slot] + motion);
        }
    }
}

/// What has passed, and so far nothing else, is touched.
static void touch_passing(const Work *work)
{
    const PercaleStencilList *passing = work->stage->passing;
    memset(work->touched, 0, work->stage->model->point_count);
    for (size_t i = 0; i < passing->count; i++) {
        for (int k = 0; k < 4; k++) {
            work->touched[passing->items[i].points[k]] = 1;
        }
    }
}

/// What of the guard's work is done in this round.
static bool put_back(Work *work, int round)
{
    const PercaleStencilList *passing = work->stage->passing;
    touch_passing(work);
    if (round == HALVES && !percale_zones_create(&work->zones, work->stage->model, work->stage->arena)) {
        return false;
    }
    if (round >= HALVES) {
        move_zones(work, round >= ROUNDS);
        return true;
    }
    for (size_t i = 0; i < passing->count; i++) { // few, and in a fixed order
        if (round < PUSHES) {
            push_back(work, &passing->items[i]);
        } else {
            hold_back(work, &passing->items[i]);
        }
    }
    return true;
}

bool percale_pair_guard_run(const PercalePairGuardStage *stage, PercalePairGuardCounts *counts)
{
    *counts = (PercalePairGuardCounts){0};
    Work work = {.stage = stage};
    bool complete = find_passages(stage, NULL, counts);
    for (int round = 0; complete && round < LAST_ROUND && stage->passing->count > 0; round++) {
        counts->pushed += stage->passing->count;
        if (work.touched == NULL) {
            work.touched = percale_arena_new(stage->arena, stage->model->point_count, 1);
        }
        complete =
            work.touched != NULL && put_back(&work, round) && find_passages(stage, work.touched, counts);
    }
    counts->left = stage->passing->count;
    return complete;
}
