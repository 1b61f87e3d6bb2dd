#include "detect/pair_parts.h"
#include "percale/geometry.h"

#include <string.h>

// Closest points nearer to an end of their edge than this share of it belong to the end.
static const double INSIDE = 1e-6;

// Squared sine below which edges are parallel: their ends say all.
static const double PARALLEL = 1e-12;

/// Two edges over the substep.
typedef struct EdgeView {
    Vec3 from[4], to[4];
    double weights[4]; // of the closest points at the end, or where the edges met
    Vec3 between;      // from the second to the first; at the end
    double distance;   // m, too
    bool has_passed;   // through each other, on the way
} EdgeView;

/// Weights of the closest points of two lines, when they are inside both edges (`slack` of their lengths
/// beyond); else it is an end that is closest, or the edges are parallel.
static bool weigh_edges(const Vec3 *x, double slack, double weights[4])
{
    Vec3 a = vsub(x[1], x[0]);
    Vec3 b = vsub(x[3], x[2]);
    Vec3 c = vsub(x[0], x[2]);
    double aa = vdot(a, a);
    double bb = vdot(b, b);
    double ab = vdot(a, b);
    double ac = vdot(a, c);
    double bc = vdot(b, c);
    double sine2 = aa * bb - ab * ab;
    if (!(sine2 > PARALLEL * aa * bb)) {
        return false;
    }
    double s = (ab * bc - bb * ac) / sine2;
    double t = (aa * bc - ab * ac) / sine2;
    bool inside = s > -slack && s < 1.0 + slack && t > -slack && t < 1.0 + slack;
    s = fmin(fmax(s, 0.0), 1.0);
    t = fmin(fmax(t, 0.0), 1.0);
    weights[0] = 1.0 - s;
    weights[1] = s;
    weights[2] = t - 1.0;
    weights[3] = -t;
    return inside;
}

static Vec3 combine_all(const Vec3 *x, const double weights[4])
{
    Vec3 sum = vscale(weights[0], x[0]);
    for (int k = 1; k < 4; k++) {
        sum = vadd(sum, vscale(weights[k], x[k]));
    }
    return sum;
}

static bool weigh_meeting(const Vec3 *x, double weights[4])
{
    return weigh_edges(x, SEAMLESS, weights);
}

/// False when they are no pair: an end is closest, or they are too far apart.
static bool view_edges(const PercalePairStage *stage, const uint32_t points[4], const Keep *keep,
                       EdgeView *view)
{
    for (int k = 0; k < 4; k++) {
        view->from[k] = start_of(stage, points[k]);
        view->to[k] = end_of(stage, points[k]);
    }
    double meeting[4] = {0.0};
    bool inside = weigh_edges(view->to, -INSIDE, view->weights);
    view->has_passed = percale_pair_has_passed(view->from, view->to, weigh_meeting, meeting);
    if (!inside && view->has_passed) {
        memcpy(view->weights, meeting, sizeof(meeting));
    }
    view->between = combine_all(view->to, view->weights);
    view->distance = vlength(view->between);
    return view->has_passed ||
           (inside && view->distance <= percale_pair_reach(stage, keep, points, view->weights));
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
    return combine_all(view->from, weights);
}

/// `reference` says which way the normal points. Without a direction between the edges it is the normal
/// itself.
static Vec3 directed(const EdgeView *view, Vec3 reference, double thickness)
{
    double sign = vdot(view->between, reference) >= 0.0 ? 1.0 : -1.0;
    return view->distance > NO_DIRECTION * thickness ? vscale(sign / view->distance, view->between)
                                                     : vunit(reference);
}

/// Whether the solver has pushed two edges through each other since the last pass.
static bool were_pushed_through(const PercalePairStage *stage, const uint32_t points[4], const EdgeView *view)
{
    Vec3 earlier[4];
    double weights[4];
    for (int k = 0; k < 4; k++) {
        earlier[k] = earlier_of(stage, points[k]);
    }
    return percale_pair_has_passed(earlier, view->from, weigh_meeting, weights);
}

/// Which way the first edge belongs, seen from the second: as the note says; else as they were, which is as
/// they are unless they have passed through each other.
static Vec3 reference_of(const PercalePairStage *stage, const uint32_t points[4], const EdgeView *view,
                         const PercalePairNote *note, Vec3 before)
{
    if (note != NULL) {
        return vec3_of(note->normal);
    }
    bool pushed = were_pushed_through(stage, points, view);
    if (view->distance > 0.0) {
        return view->has_passed != pushed ? vscale(-1.0, view->between) : view->between;
    }
    return pushed ? vscale(-1.0, before) : before;
}

static void find_edge_pair(const PercalePairStage *stage, PercaleCollector *collector,
                           const uint32_t edges[2], const uint32_t points[4], Keep keep)
{
    EdgeView view;
    if (!view_edges(stage, points, &keep, &view)) {
        return;
    }
    const PercalePairNote *note = percale_pair_find_note(stage->known, edge_key(edges[0], edges[1]));
    Vec3 before = start_between(&view);
    Vec3 reference = reference_of(stage, points, &view, note, before);
    if (!(vdot(reference, reference) > 0.0)) {
        return; // they have always met: no way out is better than another
    }
    Push push = {.edges = true,
                 .normal = directed(&view, reference, (double)keep.thickness),
                 .thickness =
                     allowed(keep.thickness, percale_pair_rest_distance(stage, points, 2, points + 2, 2)),
                 .friction = keep.friction};
    memcpy(push.weights, view.weights, sizeof(push.weights));
    push.start_gap = vdot(before, reference) >= 0.0 ? vlength(before) : -vlength(before);
    percale_pair_add(stage, collector, points, &push);
    percale_collect_note(collector,
                         (PercalePairNote){edge_key(edges[0], edges[1]), f32x4_of(push.normal, 0.0f)});
}

/// An obstacle's edge and one of the cloth: only out of the obstacle. `key`: of the pair's note.
static void find_obstacle_edge_pair(const PercalePairStage *stage, PercaleCollector *collector, uint64_t key,
                                    Vec3 outward, const uint32_t points[4], Keep keep)
{
    EdgeView view;
    if (!view_edges(stage, points, &keep, &view)) {
        return;
    }
    Vec3 before = start_between(&view);
    Vec3 reference = reference_of(stage, points, &view, percale_pair_find_note(stage->known, key), before);
    Push push = {.edges = true,
                 .normal = directed(&view, reference, (double)keep.thickness),
                 .start_gap = vdot(before, reference) >= 0.0 ? vlength(before) : -vlength(before),
                 .thickness = keep.thickness,
                 .friction = keep.friction};
    if (vdot(push.normal, outward) < CLEAR_SIDE) { // the cloth came from behind
        return;
    }
    memcpy(push.weights, view.weights, sizeof(push.weights));
    percale_pair_add(stage, collector, points, &push);
    percale_collect_note(collector, (PercalePairNote){key, f32x4_of(push.normal, 0.0f)});
}

/// An edge of the cloth that this triangle is the first to have; UINT32_MAX: its side belongs to another.
static uint32_t owned_edge(const PercaleModelSurface *cloth, uint32_t side)
{
    uint32_t edge = cloth->edges.edge_of_side[side];
    return edge != UINT32_MAX && cloth->edges.sides[cloth->edges.first_side[edge]] == side ? edge
                                                                                           : UINT32_MAX;
}

void percale_pair_find_edge(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge)
{
    const PercaleModel *model = stage->model;
    const PercaleModelSurface *cloth = &model->cloth;
    const uint32_t *own = cloth->edges.vertices[edge];
    float radius = percale_pair_widest_reach(stage, model->cloths[model->cloth_of[own[0]]].thickness);
    Box box = widen(box_of(stage, own[0], own[1]), radius);
    if (!percale_pair_gather(stage, collector, &box)) {
        return;
    }
    for (size_t i = 0; i < 3 * collector->triangles.count; i++) {
        uint32_t other = owned_edge(cloth, 3 * collector->triangles.items[i / 3] + (uint32_t)(i % 3));
        if (other == UINT32_MAX || other <= edge) {
            continue;
        }
        const uint32_t *ends = cloth->edges.vertices[other];
        const uint32_t points[4] = {own[0], own[1], ends[0], ends[1]};
        Box other_box = box_of(stage, ends[0], ends[1]);
        Keep keep;
        if (own[0] == ends[0] || own[0] == ends[1] || own[1] == ends[0] || own[1] == ends[1] ||
            !overlap(&box, &other_box) || !keep_of(model, own[0], ends[0], &keep)) {
            continue;
        }
        collector->candidates++;
        find_edge_pair(stage, collector, (const uint32_t[2]){edge, other}, points, keep);
    }
}

void percale_pair_find_obstacle_edge(const PercalePairStage *stage, PercaleCollector *collector,
                                     const PercaleModelSurface *obstacle, uint32_t edge)
{
    const PercaleModel *model = stage->model;
    const PercaleModelSurface *cloth = &model->cloth;
    const uint32_t own[2] = {obstacle->first_point + obstacle->edges.vertices[edge][0],
                             obstacle->first_point + obstacle->edges.vertices[edge][1]};
    float radius = percale_pair_widest_reach(stage, obstacle->thickness);
    Box box = widen(box_of(stage, own[0], own[1]), radius);
    if (!percale_pair_gather(stage, collector, &box) || collector->triangles.count == 0) {
        return;
    }
    uint32_t first_edge = 0; // in a numbering of all obstacles' edges
    for (const PercaleModelSurface *o = model->obstacles; o < obstacle; o++) {
        first_edge += o->edges.edge_count;
    }
    uint32_t first = obstacle->edges.first_side[edge];
    Vec3 outward = percale_pair_outward(stage, obstacle, obstacle->edges.sides + first,
                                        obstacle->edges.first_side[edge + 1] - first, 3);
    for (size_t i = 0; i < 3 * collector->triangles.count; i++) {
        uint32_t other = owned_edge(cloth, 3 * collector->triangles.items[i / 3] + (uint32_t)(i % 3));
        if (other == UINT32_MAX) {
            continue;
        }
        const uint32_t *ends = cloth->edges.vertices[other];
        const uint32_t points[4] = {ends[0], ends[1], own[0], own[1]};
        Box other_box = box_of(stage, ends[0], ends[1]);
        Keep keep;
        if (!overlap(&box, &other_box) || !keep_of_obstacle(model, ends[0], obstacle, &keep)) {
            continue;
        }
        collector->candidates++;
        find_obstacle_edge_pair(stage, collector, obstacle_edge_key(other, first_edge + edge), outward,
                                points, keep);
    }
}
