#include "untangle/watch.h"

#include "untangle/crossings.h"

/// A range of edges, asked in groups: consecutive ones lie together.
typedef struct Watch {
    const PercaleWatchStage *stage;
    uint32_t first, end;
} Watch;

/// Whether a face has one of the points.
static bool has_any(const uint32_t *face, const uint32_t *points, uint32_t count)
{
    bool any = false;
    for (uint32_t k = 0; k < count; k++) {
        any = any || face[0] == points[k] || face[1] == points[k] || face[2] == points[k];
    }
    return any;
}

/// Whether one of the triangles at the edge shares no point with the face, nor will when seams have closed:
/// else the two are neighbours.
static bool is_apart(const PercaleModel *model, uint32_t edge, const uint32_t *face)
{
    const PercaleModelSurface *cloth = &model->cloth;
    bool apart = false;
    for (uint32_t i = cloth->edges.first_side[edge]; i < cloth->edges.first_side[edge + 1]; i++) {
        const uint32_t *corners = cloth->triangles + (size_t)(cloth->edges.sides[i] / 3) * 3;
        apart =
            apart || !(has_any(face, corners, 3) || percale_candidates_are_sewn(model, corners, face, 3) ||
                       percale_candidates_are_sewn(model, corners + 1, face, 3));
    }
    return apart;
}

/// Whether the ends of the edge are clearly on both sides of the face's plane: in a flat sheet everything
/// lies in one plane, and to know what crosses there would take long.
static bool is_pierced(const f32x4 *x, const uint32_t *ends, const uint32_t *face)
{
    const double CLEARLY = 1e-9; // share of the distance
    Vec3 a = vec3_of(x[face[0]]);
    Vec3 normal = vcross(vsub(vec3_of(x[face[1]]), a), vsub(vec3_of(x[face[2]]), a));
    Vec3 p = vsub(vec3_of(x[ends[0]]), a);
    Vec3 q = vsub(vec3_of(x[ends[1]]), a);
    double before = vdot(p, normal);
    double behind = vdot(q, normal);
    double least2 = CLEARLY * CLEARLY * vdot(normal, normal);
    return before * behind < 0.0 && before * before > least2 * vdot(p, p) &&
           behind * behind > least2 * vdot(q, q);
}

static bool does_cross(const PercaleWatchStage *stage, uint32_t edge, uint32_t triangle)
{
    const PercaleModel *model = stage->model;
    const PercaleModelSurface *cloth = &model->cloth;
    const uint32_t *ends = cloth->edges.vertices[edge];
    const uint32_t *face = cloth->triangles + (size_t)triangle * 3;
    uint32_t mask = model->cloths[model->cloth_of[ends[0]]].mask;
    return !has_any(face, ends, 2) && (mask & model->cloths[model->cloth_of[face[0]]].mask) != 0 &&
           is_pierced(stage->x, ends, face) && is_apart(model, edge, face) &&
           !percale_candidates_are_sewn(model, ends, face, 3) &&
           percale_does_edge_cross(stage->x, ends, face);
}

static void look_at_group(const Watch *watch, PercaleCollector *collector, uint32_t first, uint32_t end)
{
    const PercaleWatchStage *stage = watch->stage;
    f32x4 low[TREE_WIDTH];
    f32x4 high[TREE_WIDTH];
    f32x4 least = {INFINITY, INFINITY, INFINITY, INFINITY};
    f32x4 most = {-INFINITY, -INFINITY, -INFINITY, -INFINITY};
    for (uint32_t edge = first; edge < end; edge++) {
        const uint32_t *ends = stage->model->cloth.edges.vertices[edge];
        uint32_t k = edge - first;
        low[k] = min4(stage->x[ends[0]], stage->x[ends[1]]);
        high[k] = max4(stage->x[ends[0]], stage->x[ends[1]]);
        least = min4(least, low[k]);
        most = max4(most, high[k]);
    }
    if (!percale_tree_overlap(stage->faces, least, most, &collector->memory, &collector->nodes)) {
        collector->complete = false;
        return;
    }
    for (size_t i = 0; i < collector->nodes.count; i++) {
        const PercaleTreeNode *node = &stage->faces->nodes[collector->nodes.items[i]];
        const uint32_t *order = stage->faces->order + (size_t)collector->nodes.items[i] * TREE_WIDTH;
        for (uint32_t edge = first; edge < end; edge++) {
            uint32_t bits = lane_bits(tree_box_overlaps(node, low[edge - first], high[edge - first]));
            for (; bits != 0; bits &= bits - 1) {
                collector->born_crossed += does_cross(stage, edge, order[__builtin_ctz(bits)]);
            }
        }
    }
}

static void look_at_groups(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Watch *watch = context;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        uint32_t edge = watch->first + (uint32_t)i * TREE_WIDTH;
        look_at_group(watch, collector, edge,
                      edge + TREE_WIDTH < watch->end ? edge + TREE_WIDTH : watch->end);
    }
}

bool percale_watch_run(const PercaleWatchStage *stage, uint32_t first, uint32_t end, bool *crossed)
{
    const Watch watch = {stage, first, end};
    *crossed = false;
    if (first >= end) {
        return true;
    }
    percale_tree_refit(stage->faces, stage->model->cloth.triangles, stage->x, stage->team);
    uint32_t count = (end - first + TREE_WIDTH - 1) / TREE_WIDTH;
    bool complete = percale_collect(stage->team, count, look_at_groups, &watch, stage->collectors,
                                    stage->memory, &(PercaleCollected){0});
    *crossed = stage->collectors->born_crossed > 0;
    return complete;
}
