#include "detect/pair_parts.h"

// Edges and faces of the cloth that cross when a substep begins. Where one came out of the other is known
// from the five pairs of their features: the edge's ends and the face, the edge and the face's sides. A note
// of one of these remembers it. Else the two were born crossed (MATH.md, section 7).

// An edge crosses a face when its ends are farther from the face's plane than this share of their distance:
// in a flat sheet everything lies in one plane, and rounding would cross it with itself.
static const double CLEARLY = 1e-9;

/// Whether the edge goes through the face: its ends are on both sides of the plane, and the corners don't all
/// lie on one side of it; along a side of the face it does.
static bool do_cross(const Vec3 *ends, const Vec3 *corners)
{
    if (side_of_plane(ends[0], corners, CLEARLY) * side_of_plane(ends[1], corners, CLEARLY) >= 0) {
        return false;
    }
    int low = 1;
    int high = -1;
    for (int k = 0; k < 3; k++) {
        const Vec3 half[3] = {ends[0], ends[1], corners[k]};
        int turn = side_of_plane(corners[k == 2 ? 0 : k + 1], half, IN_PLANE);
        low = turn < low ? turn : low;
        high = turn > high ? turn : high;
    }
    return low >= 0 || high <= 0;
}

/// The five pairs of an edge and a face.
enum { PARTS = 5 };

static void list_parts(const PercaleModelSurface *cloth, uint32_t edge, uint32_t triangle,
                       uint64_t keys[PARTS])
{
    for (uint32_t k = 0; k < 2; k++) {
        keys[k] = face_key(cloth->edges.vertices[edge][k], triangle);
    }
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t other = cloth->edges.edge_of_side[3 * triangle + k];
        keys[2 + k] = edge < other ? edge_key(edge, other) : edge_key(other, edge);
    }
}

typedef enum Origin { EXPLAINED, BORN_EARLIER, BORN_NOW } Origin;

static Origin origin_of(const PercaleNoteList *known, const uint64_t keys[PARTS])
{
    bool explained = false;
    for (int k = 0; k < PARTS; k++) {
        const PercalePairNote *note = percale_pair_find_note(known, keys[k]);
        if (note != NULL && is_free(note)) {
            return BORN_EARLIER;
        }
        explained = explained || note != NULL;
    }
    return explained ? EXPLAINED : BORN_NOW;
}

static void visit_triangle(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge,
                           uint32_t triangle)
{
    const PercaleModel *model = stage->model;
    const uint32_t *own = model->cloth.edges.vertices[edge];
    const uint32_t *t = model->cloth.triangles + 3 * (size_t)triangle;
    const Vec3 ends[2] = {start_of(stage, own[0]), start_of(stage, own[1])};
    const Vec3 corners[3] = {start_of(stage, t[0]), start_of(stage, t[1]), start_of(stage, t[2])};
    Keep keep;
    if (has_corner(t, own[0]) || has_corner(t, own[1]) || is_line(t) ||
        !keep_of(model, own[0], t[0], &keep) || percale_candidates_are_sewn(model, own, t, 3) ||
        !do_cross(ends, corners)) {
        return;
    }
    uint64_t keys[PARTS];
    list_parts(&model->cloth, edge, triangle, keys);
    Origin origin = origin_of(stage->known, keys);
    collector->born_crossed += origin == BORN_NOW;
    for (int k = 0; k < PARTS && origin != EXPLAINED; k++) {
        percale_collect_note(collector, (PercalePairNote){.key = keys[k]});
    }
}

void percale_pair_find_crossings(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge)
{
    const f32x4 *x = stage->model->position;
    const PercaleTree *tree = &stage->candidates->faces;
    const uint32_t *own = stage->model->cloth.edges.vertices[edge];
    f32x4 low = min4(x[own[0]], x[own[1]]);
    f32x4 high = max4(x[own[0]], x[own[1]]);
    if (!percale_tree_overlap(tree, low, high, &collector->memory, &collector->nodes)) {
        collector->complete = false;
        return;
    }
    for (size_t i = 0; i < collector->nodes.count; i++) {
        uint32_t node = collector->nodes.items[i];
        uint32_t bits = lane_bits(tree_box_overlaps(&tree->nodes[node], low, high));
        for (; bits != 0; bits &= bits - 1) {
            visit_triangle(stage, collector, edge,
                           tree->order[TREE_WIDTH * node + (uint32_t)__builtin_ctz(bits)]);
        }
    }
}
