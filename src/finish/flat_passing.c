#include "finish/flat_passing.h"

#include "base/wide.h"
#include "detect/flat.h"

// Times the low distance within which a vertex is measured that may be low.
static const double KNOWN = 4.0;

/// What the chunks of a search share.
typedef struct Search {
    const PercalePairGuardStage *stage;
    const PercaleFlat *flat;
    PercaleProximity *proximity; // whose clearances become true ones
    const uint8_t *touched;
    float low;                   // m; for the longest edge of the cloth
    PercalePassing faces, edges; // the obstacle's vertices against faces, edges against edges
} Search;

/// Below which distance from the obstacle vertices don't keep what is between them away, m.
static float low_of(const PercaleFlat *flat, float length)
{
    float times = length / flat->length;
    return flat->low * fmaxf(1.0f, times * times);
}

/// Whether a vertex has come so near that it may not keep the rest away.
static bool is_low(const Search *search, uint32_t slot)
{
    const PercaleModel *model = search->stage->model;
    return search->proximity->clearance[slot] < search->low &&
           (model->cloths[model->cloth_of[slot]].mask & search->edges.mesh->mask) != 0;
}

static bool is_touched(const Search *search, const uint32_t *slots, uint32_t count)
{
    bool touched = search->touched == NULL;
    for (uint32_t k = 0; !touched && k < count; k++) {
        touched = search->touched[slots[k]] != 0;
    }
    return touched;
}

/// The box of a feature's way.
typedef struct Box {
    f32x4 low, high;
} Box;

static Box box_of(const PercaleModel *model, const uint32_t *points, uint32_t count)
{
    Box box = {model->position[points[0]], model->position[points[0]]};
    for (uint32_t k = 0; k < count; k++) {
        f32x4 from = model->position[points[k]];
        f32x4 to = model->predicted[points[k]];
        box.low = min4(box.low, min4(from, to));
        box.high = max4(box.high, max4(from, to));
    }
    return box;
}

static bool do_overlap(Box a, Box b)
{
    bool overlap = true;
    for (int axis = 0; axis < 3; axis++) {
        overlap = overlap && a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis];
    }
    return overlap;
}

/// An obstacle's flat edge of which this is the first side. False for none.
static bool name_edge(const Search *search, uint32_t side, uint32_t *item, uint32_t points[2])
{
    const PercaleModelSurface *mesh = search->edges.mesh;
    uint32_t edge = mesh->edges.edge_of_side[side];
    if (edge == UINT32_MAX || mesh->edges.sides[mesh->edges.first_side[edge]] != side) {
        return false;
    }
    *item = edge;
    points[0] = mesh->first_point + mesh->edges.vertices[edge][0];
    points[1] = mesh->first_point + mesh->edges.vertices[edge][1];
    return search->flat->edges[edge] != 0;
}

/// An obstacle's flat vertex of which this corner's is the first triangle. False for none.
static bool name_vertex(const Search *search, uint32_t corner, uint32_t *item, uint32_t points[2])
{
    const PercaleModelSurface *mesh = search->faces.mesh;
    points[0] = points[1] = mesh->triangles[corner];
    *item = points[0] - mesh->first_point;
    return search->flat->vertices[*item] != 0 &&
           mesh->vertex_faces[mesh->vertex_first_face[*item]] == corner / 3;
}

/// A feature of the cloth and the box of its way.
typedef struct Feature {
    uint32_t primitive;
    const uint32_t *corners;
    bool is_edge;
    Box box;
} Feature;

static void ask_triangle(const Search *search, PercaleCollector *collector, uint32_t triangle,
                         const Feature *feature)
{
    for (uint32_t side = 3 * triangle; side < 3 * triangle + 3; side++) {
        uint32_t points[2];
        PercaleFeaturePair pair = {0, feature->primitive, points, feature->corners};
        bool named = feature->is_edge ? name_edge(search, side, &pair.item, points)
                                      : name_vertex(search, side, &pair.item, points);
        if (named && do_overlap(box_of(search->stage->model, points, 2), feature->box)) {
            collector->candidates++;
            percale_passing_ask(feature->is_edge ? &search->edges : &search->faces, collector, &pair);
        }
    }
}

/// Whether a face or an edge of the cloth isn't kept away by its corners.
static bool is_free(const Search *search, const uint32_t *corners, uint32_t count)
{
    const f32x4 *x = search->stage->model->predicted;
    float nearest = INFINITY;
    float longest = 0.0f;
    for (uint32_t k = 0; k < count; k++) {
        nearest = fminf(nearest, search->proximity->clearance[corners[k]]);
        longest = fmaxf(longest, length3(x[corners[k]] - x[corners[k == 0 ? count - 1 : k - 1]]));
    }
    return nearest < low_of(search->flat, longest);
}

/// A face or an edge of the cloth against all that its way comes near.
static void ask_feature(const Search *search, PercaleCollector *collector, uint32_t primitive,
                        const uint32_t *corners, bool is_edge)
{
    const PercaleTree *tree = &search->proximity->tree;
    Feature feature = {primitive, corners, is_edge, box_of(search->stage->model, corners, is_edge ? 2 : 3)};
    f32x4 low = feature.box.low;
    f32x4 high = feature.box.high;
    float motion = (float)(search->proximity->traveled - search->proximity->guarded);
    f32x4 wider = max4(-low, high) * 1e-6f + 1.001f * motion; // the tree is at the end
    if (!percale_tree_overlap(tree, low - wider, high + wider, &collector->memory, &collector->nodes)) {
        collector->complete = false;
        return;
    }
    for (size_t i = 0; i < collector->nodes.count; i++) {
        uint32_t node = collector->nodes.items[i];
        uint32_t bits = lane_bits(tree_box_overlaps(&tree->nodes[node], low - wider, high + wider));
        for (; bits != 0; bits &= bits - 1) {
            uint32_t triangle = tree->order[TREE_WIDTH * node + (uint32_t)__builtin_ctz(bits)];
            ask_triangle(search, collector, triangle, &feature);
        }
    }
}

/// Whether no other low corner comes before this one: then the face or edge is this one's.
static bool is_first_low(const Search *search, uint32_t slot, const uint32_t *corners, uint32_t count)
{
    bool first = true;
    for (uint32_t k = 0; k < count; k++) {
        first = first && (corners[k] >= slot || !is_low(search, corners[k]));
    }
    return first;
}

static void ask_around(const Search *search, PercaleCollector *collector, uint32_t slot)
{
    const PercaleModelSurface *cloth = &search->stage->model->cloth;
    for (uint32_t i = cloth->vertex_first_face[slot]; i < cloth->vertex_first_face[slot + 1]; i++) {
        uint32_t face = cloth->vertex_faces[i];
        const uint32_t *corners = cloth->triangles + 3 * (size_t)face;
        if (is_touched(search, corners, 3) && is_first_low(search, slot, corners, 3) &&
            is_free(search, corners, 3)) {
            ask_feature(search, collector, face, corners, false);
        }
        for (uint32_t side = 3 * face; side < 3 * face + 3; side++) {
            uint32_t edge = cloth->edges.edge_of_side[side];
            if (edge == UINT32_MAX || cloth->edges.sides[cloth->edges.first_side[edge]] != side) {
                continue;
            }
            const uint32_t *ends = cloth->edges.vertices[edge];
            if ((ends[0] == slot || ends[1] == slot) && is_touched(search, ends, 2) &&
                is_first_low(search, slot, ends, 2) && is_free(search, ends, 2)) {
                ask_feature(search, collector, edge, ends, true);
            }
        }
    }
}

/// Of a vertex in front of the obstacle that is known to be no farther away than a bound: its distance.
static void measure(const Search *search, uint32_t slot)
{
    const double ROUNDING = 1e-6; // share of the distance
    PercaleProximity *proximity = search->proximity;
    const f32x4 *x = search->stage->model->predicted;
    PercaleSurface surface = {search->edges.mesh, &proximity->tree, x, proximity->convex.normals};
    Vec3 point = vec3_of(x[slot]);
    uint32_t seed = proximity->nearest[slot];
    PercaleNearest nearest;
    if (!percale_convex_nearest(&proximity->convex, &surface, point, HUGE_VAL, seed, &nearest)) {
        nearest = percale_surface_nearest(&surface, point, KNOWN * (double)search->low, seed);
    }
    if (nearest.triangle != NO_TRIANGLE && percale_surface_side(&surface, point, &nearest) > 0) {
        float distance = (float)(sqrt(nearest.closest.distance2) * (1.0 - ROUNDING));
        proximity->clearance[slot] = fmaxf(proximity->clearance[slot], distance);
    }
}

static void measure_range(void *context, uint32_t first, uint32_t end)
{
    const Search *search = context;
    for (uint32_t slot = first; slot < end; slot++) {
        if (is_low(search, slot)) {
            measure(search, slot);
        }
    }
}

static void find_low(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Search *search = context;
    const float *clearance = search->proximity->clearance;
    for (uint64_t slot = first; slot < end; slot++) {
        bool eight = slot + WIDE <= end;
        if (eight && lane_bits(greater8(all8(search->low), load8(clearance + slot))) == 0) {
            slot += WIDE - 1;
        } else if (is_low(search, (uint32_t)slot)) {
            ask_around(search, collector, (uint32_t)slot);
        }
    }
}

bool percale_flat_passages_find(const PercalePairGuardStage *stage, uint32_t obstacle, const uint8_t *touched,
                                double reach)
{
    enum { GRAIN_SLOTS = 512 };
    const PercaleModelSurface *mesh = &stage->model->obstacles[obstacle];
    const PercaleFlat *flat = &stage->candidates->flats[obstacle];
    stage->collectors->candidates = 0;
    if (flat->vertices == NULL) {
        return true;
    }
    Search search = {stage,
                     flat,
                     &stage->proximities[obstacle],
                     touched,
                     low_of(flat, stage->candidates->longest),
                     {stage, mesh, false, reach},
                     {stage, mesh, true, reach}};
    PercaleCollected to = {.stencils = stage->passing};
    if (stage->measures) {
        percale_team_for(stage->team, stage->model->slot_count, GRAIN_SLOTS, measure_range, &search);
    }
    return percale_collect(stage->team, stage->model->slot_count, find_low, &search, stage->collectors,
                           stage->memory, &to);
}
