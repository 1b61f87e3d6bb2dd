#include "detect/pair_parts.h"
#include "percale/geometry.h"

#include <string.h>

// Closest points nearer to an end of their edge than this share of it belong to the end.
static const double INSIDE = 1e-6;

// Cosine below which two directions count as perpendicular: notes are float32.
static const double PERPENDICULAR = 1e-6;

/// Two edges over the substep.
typedef struct EdgeView {
    Vec3 from[4], to[4];
    double weights[4]; // of the closest points at the end, or where the edges met
    Vec3 between;      // from the second to the first; at the end
    double distance;   // m, too
    bool may_pass;     // their ways touch
    bool has_passed;   // through each other, on the way
} EdgeView;

/// False when they are no pair: an end is closest, or they are too far apart, the sooner if they wait.
/// view->may_pass is given.
static bool view_edges(const PercalePairStage *stage, const uint32_t points[4], const Keep *keep, bool waits,
                       EdgeView *view)
{
    for (int k = 0; k < 4; k++) {
        view->from[k] = start_of(stage, points[k]);
        view->to[k] = end_of(stage, points[k]);
    }
    PercalePassage passage;
    bool inside = percale_weigh_edges(view->to, -INSIDE, view->weights);
    view->has_passed = view->may_pass && percale_edges_pass(view->from, view->to, &passage);
    if (!inside && view->has_passed) {
        memcpy(view->weights, passage.weights, sizeof(passage.weights));
    }
    view->between = weigh_points(view->to, view->weights);
    if (!inside && view->has_passed) { // they have slid apart since they met: that is no way back
        Vec3 across = vunit(vcross(vsub(view->to[1], view->to[0]), vsub(view->to[3], view->to[2])));
        view->between = vscale(vdot(view->between, across), across);
    }
    view->distance = vlength(view->between);
    double reach = percale_pair_reach(stage, keep, points, view->weights);
    if (waits) {
        reach -= (double)((CONTACT_REACH - EDGES_WAIT) * keep->thickness);
    }
    return view->has_passed || (inside && view->distance <= reach);
}

/// From the second edge to the first when the substep began, wherever they were closest.
static Vec3 start_between(const EdgeView *view)
{
    double x[4][3];
    double weights[4];
    for (int k = 0; k < 4; k++) {
        x[k][0] = view->from[k].x;
        x[k][1] = view->from[k].y;
        x[k][2] = view->from[k].z;
    }
    (void)percale_edge_edge_closest((const double(*)[3])x, weights);
    return weigh_points(view->from, weights);
}

/// Whether two directions are not opposite; perpendicular ones aren't, whichever way they are rounded.
static bool do_agree(Vec3 a, Vec3 b)
{
    return vdot(a, b) >= -PERPENDICULAR * vlength(a) * vlength(b);
}

/// `reference` says which way the normal points. Without a direction between the edges it is the normal
/// itself.
static Vec3 directed(const EdgeView *view, Vec3 reference, double thickness)
{
    double sign = do_agree(view->between, reference) ? 1.0 : -1.0;
    return view->distance > NO_DIRECTION * thickness ? vscale(sign / view->distance, view->between)
                                                     : vunit(reference);
}

/// Which way the first edge belongs, seen from the second: as the note says; else as they were, which is as
/// they are unless they have passed through each other. Zero where they have always met: no way out is better
/// than another.
static Vec3 reference_of(const EdgeView *view, const PercalePairNote *note, Vec3 before, double thickness)
{
    if (note != NULL && !is_free(note)) {
        return vec3_of(note->normal);
    }
    bool met = !(vlength(before) > MEETS * thickness);
    if (!(view->distance > MEETS * thickness)) {
        return met ? (Vec3){0.0, 0.0, 0.0} : before;
    }
    if (!view->has_passed && !met && !do_agree(before, view->between)) {
        return (Vec3){0.0, 0.0, 0.0}; // they have changed sides where one of their neighbours passed
    }
    return view->has_passed ? vscale(-1.0, view->between) : view->between;
}

static void find_edge_pair(const PercalePairStage *stage, PercaleCollector *collector,
                           const uint32_t edges[2], const uint32_t points[4], Keep keep, bool may_pass)
{
    const uint64_t key = edge_key(edges[0], edges[1]);
    keep = keep_at_rest(stage, keep, points, 2, points + 2, 2);
    EdgeView view = {.may_pass = may_pass};
    if (!view_edges(stage, points, &keep, false, &view) || is_born_crossed(stage, key)) {
        return;
    }
    const PercalePairNote *note = percale_pair_find_note(stage->known, key);
    Vec3 before = start_between(&view);
    Vec3 reference = reference_of(&view, note, before, (double)keep.thickness);
    if (!(vdot(reference, reference) > 0.0)) {
        return;
    }
    Push push = {.edges = true,
                 .normal = directed(&view, reference, (double)keep.thickness),
                 .thickness = keep.thickness,
                 .friction = keep.friction};
    memcpy(push.weights, view.weights, sizeof(push.weights));
    push.start_gap = do_agree(before, reference) ? vlength(before) : -vlength(before);
    percale_pair_add(stage, collector, points, &push);
    percale_collect_note(collector, (PercalePairNote){.key = key, .normal = f32x4_of(push.normal, 0.0f)});
}

/// An obstacle's edge and the cloth's.
typedef struct ObstacleEdge {
    const PercaleModelSurface *obstacle;
    Vec3 outward;
    bool waits;
} ObstacleEdge;

/// An obstacle's edge and one of the cloth: only out of the obstacle. `key`: of the pair's note. Whether they
/// get a stencil.
static bool find_obstacle_edge_pair(const PercalePairStage *stage, PercaleCollector *collector,
                                    const ObstacleEdge *edge, uint64_t key, const uint32_t points[4],
                                    Keep keep, bool may_pass)
{
    const PercalePairNote *note = percale_pair_find_note(stage->known, key);
    EdgeView view = {.may_pass = may_pass};
    if (!view_edges(stage, points, &keep, edge->waits && note == NULL, &view)) {
        return false;
    }
    Vec3 before = start_between(&view);
    Vec3 reference = reference_of(&view, note, before, (double)keep.thickness);
    if (is_leaving(stage, points, 2, edge->obstacle, edge->outward)) {
        reference = vscale(vdot(view.between, edge->outward) < 0.0 ? -1.0 : 1.0, view.between);
    }
    Push push = {.edges = true,
                 .normal = directed(&view, reference, (double)keep.thickness),
                 .start_gap = do_agree(before, reference) ? vlength(before) : -vlength(before),
                 .thickness = keep.thickness,
                 .friction = keep.friction};
    if (!(vdot(reference, reference) > 0.0) ||
        vdot(push.normal, edge->outward) < CLEAR_SIDE) { // not yet, or the cloth came from behind
        return false;
    }
    memcpy(push.weights, view.weights, sizeof(push.weights));
    percale_pair_add(stage, collector, points, &push);
    percale_collect_note(collector, (PercalePairNote){.key = key, .normal = f32x4_of(push.normal, 0.0f)});
    return true;
}

void percale_pair_find_edge(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge)
{
    const PercaleModel *model = stage->model;
    const PercaleEdges *all = &model->cloth.edges;
    const uint32_t *own = all->vertices[edge];
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        PercaleNeighbor other = collector->neighbors.items[i];
        const uint32_t *ends = all->vertices[other.index];
        const uint32_t points[4] = {own[0], own[1], ends[0], ends[1]};
        Keep keep;
        if (keep_of(model, own[0], ends[0], &keep)) {
            find_edge_pair(stage, collector, (const uint32_t[2]){edge, other.index}, points, keep,
                           other.may_pass);
        }
    }
}

void percale_pair_find_obstacle_edge(const PercalePairStage *stage, PercaleCollector *collector,
                                     const PercaleModelSurface *obstacle, uint32_t edge)
{
    const PercaleModel *model = stage->model;
    const uint32_t own[2] = {obstacle->first_point + obstacle->edges.vertices[edge][0],
                             obstacle->first_point + obstacle->edges.vertices[edge][1]};
    uint32_t first_edge = 0; // in a numbering of all obstacles' edges
    for (const PercaleModelSurface *o = model->obstacles; o < obstacle; o++) {
        first_edge += o->edges.edge_count;
    }
    uint32_t first = obstacle->edges.first_side[edge];
    const ObstacleEdge own_edge = {
        obstacle,
        percale_pair_outward(stage, obstacle, obstacle->edges.sides + first,
                             obstacle->edges.first_side[edge + 1] - first, 3),
        stage->edges_wait && obstacle->smooth_edges[edge],
    };
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        PercaleNeighbor *other = &collector->neighbors.items[i];
        const uint32_t *ends = model->cloth.edges.vertices[other->index];
        const uint32_t points[4] = {ends[0], ends[1], own[0], own[1]};
        Keep keep;
        if (keep_of_obstacle(model, ends[0], obstacle, &keep)) {
            other->watched = find_obstacle_edge_pair(stage, collector, &own_edge,
                                                     obstacle_edge_key(other->index, first_edge + edge),
                                                     points, keep, other->may_pass);
        }
    }
}
