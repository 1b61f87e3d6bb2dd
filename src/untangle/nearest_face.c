#include "untangle/nearest_face.h"

/// A search that is under way.
typedef struct Query {
    const PercaleTangleMesh *mesh;
    const PercaleTree *tree;
    uint32_t first_face;
    const f32x4 *x;
    Vec3 point;
    f32x4 rounded; // the point
    const PercaleFaceChoice *choice;
    PercaleNearestFace best;
} Query;

// Boxes are compared in float32: what is this much nearer than it may be is looked at.
static const float ROUNDING = 1.00001f;

static bool does_count(const Query *query, uint32_t face)
{
    const PercaleFaceChoice *choice = query->choice;
    const uint32_t *corners = corners_of_triangle(query->mesh, face);
    bool counts = choice->object == NO_INDEX || choice->object == query->mesh->object_of[face];
    for (int k = 0; choice->labels != NULL && k < 3; k++) {
        counts = counts && choice->labels[corners[k]] == choice->label;
    }
    return counts;
}

static void ask_face(Query *query, uint32_t face)
{
    if (!does_count(query, face)) {
        return;
    }
    const uint32_t *corners = corners_of_triangle(query->mesh, face);
    Vec3 c[3];
    for (int k = 0; k < 3; k++) {
        c[k] = vec3_of(query->x[corners[k]]);
    }
    PercaleClosest closest = percale_closest_on_triangle(query->point, c[0], c[1], c[2]);
    PercaleNearestFace *best = &query->best;
    bool is_nearer = closest.distance2 < best->closest.distance2 ||
                     (closest.distance2 == best->closest.distance2 && face < best->face);
    if (is_nearer) {
        best->face = face;
        best->closest = closest;
        best->foot = vadd(vadd(vscale(closest.weights[0], c[0]), vscale(closest.weights[1], c[1])),
                          vscale(closest.weights[2], c[2]));
    }
}

/// A box that waits.
typedef struct Waiting {
    PercaleTreeEntry entry;
    float distance2;
} Waiting;

static bool may_hold_nearer(const Query *query, float distance2)
{
    return (double)distance2 <= query->best.closest.distance2 * (double)ROUNDING;
}

/// Adds the children that may hold something nearer, the farthest first.
static uint32_t push_children(const Query *query, PercaleTreeEntry entry, f32x8 distances, Waiting *stack,
                              uint32_t size)
{
    uint32_t first = size;
    for (uint32_t k = 0; k < TREE_WIDTH; k++) {
        if (!(distances[k] < INFINITY) || !may_hold_nearer(query, distances[k])) {
            continue;
        }
        uint32_t place = size++;
        for (; place > first && stack[place - 1].distance2 < distances[k]; place--) {
            stack[place] = stack[place - 1];
        }
        stack[place] = (Waiting){{entry.level - 1, TREE_WIDTH * entry.node + k}, distances[k]};
    }
    return size;
}

static void ask_node(Query *query, PercaleTreeEntry entry, f32x8 distances)
{
    for (uint32_t k = 0; k < TREE_WIDTH; k++) {
        if (distances[k] < INFINITY && may_hold_nearer(query, distances[k])) {
            ask_face(query, query->first_face + query->tree->order[TREE_WIDTH * entry.node + k]);
        }
    }
}

PercaleNearestFace percale_nearest_face(const PercaleCrossingSearch *search, bool obstacles, const f32x4 *x,
                                        Vec3 point, const PercaleFaceChoice *choice)
{
    Query query = {.mesh = search->mesh,
                   .tree = obstacles ? &search->obstacles : &search->cloth,
                   .first_face = obstacles ? search->mesh->cloth_triangle_count : 0,
                   .x = x,
                   .point = point,
                   .rounded = f32x4_of(point, 0.0f),
                   .choice = choice,
                   .best = {NO_INDEX, {HUGE_VAL, {0.0, 0.0, 0.0}, REGION_FACE}, {0.0, 0.0, 0.0}}};
    Waiting stack[TREE_STACK];
    uint32_t size = 0;
    if (query.tree->primitive_count > 0) {
        stack[size++] = (Waiting){tree_root(query.tree), 0.0f};
    }
    while (size > 0) {
        Waiting waiting = stack[--size];
        if (!may_hold_nearer(&query, waiting.distance2)) {
            continue;
        }
        f32x8 distances = tree_box_distance2(tree_node(query.tree, waiting.entry), query.rounded);
        if (waiting.entry.level == 0) {
            ask_node(&query, waiting.entry, distances);
        } else {
            size = push_children(&query, waiting.entry, distances, stack, size);
        }
    }
    return query.best;
}
