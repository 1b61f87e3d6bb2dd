#include "detect/pair_parts.h"

#include <string.h>

static int side_of_note(const PercalePairNote *note)
{
    return note->normal[3] > 0.0f ? 1 : -1;
}

/// The side that is known of a vertex and the neighbours of a face: a vertex that slides on below the cloth
/// stays below it. 0: none, or the neighbours don't agree.
static int side_of_neighbours(const PercalePairStage *stage, uint32_t vertex, uint32_t triangle)
{
    const PercaleNoteList *known = stage->known;
    const PercaleModelSurface *cloth = &stage->model->cloth;
    int sum = 0;
    for (uint32_t side = 3 * triangle; known->count > 0 && side < 3 * triangle + 3; side++) {
        uint32_t edge = cloth->edges.edge_of_side[side];
        for (uint32_t i = cloth->edges.first_side[edge]; i < cloth->edges.first_side[edge + 1]; i++) {
            uint32_t other = cloth->edges.sides[i];
            const PercalePairNote *note =
                other != side ? percale_pair_find_note(known, face_key(vertex, other / 3)) : NULL;
            if (note != NULL && !is_free(note)) {
                int turned = cloth->triangles[other] == cloth->triangles[side] ? -1 : 1;
                sum += turned * side_of_note(note);
            }
        }
    }
    return (sum > 0) - (sum < 0);
}

/// A vertex seen from a face, over the substep.
typedef struct FaceView {
    uint32_t points[4]; // the vertex, the triangle
    Keep keep;
    PercaleClosest closest;   // at the end
    double distance;          // m
    double side_scale;        // twice the triangle's area at the end, 0 without
    Vec3 unit;                // its normal
    int start_side, end_side; // 0: in its plane
    bool has_passed;          // through the inside of the face, on the way
    PercalePassage passage;
} FaceView;

/// `may_pass`: else it is known that it hasn't gone through the face.
static FaceView view_face(const PercalePairStage *stage, uint32_t vertex, uint32_t triangle, Keep keep,
                          bool may_pass)
{
    const uint32_t *corners = stage->model->cloth.triangles + 3 * (size_t)triangle;
    FaceView view = {.points = {vertex, corners[0], corners[1], corners[2]}, .keep = keep};
    Vec3 from[4];
    Vec3 to[4];
    for (int k = 0; k < 4; k++) {
        from[k] = start_of(stage, view.points[k]);
        to[k] = end_of(stage, view.points[k]);
    }
    view.closest = percale_closest_on_triangle(to[0], to[1], to[2], to[3]);
    view.distance = sqrt(view.closest.distance2);
    Vec3 area = vcross(vsub(to[2], to[1]), vsub(to[3], to[1]));
    view.side_scale = vlength(area);
    view.unit = vunit(area);
    view.start_side = side_of_plane(from[0], from + 1, IN_PLANE);
    view.end_side = side_of_plane(to[0], to + 1, IN_PLANE);
    view.has_passed =
        may_pass && view.start_side * view.end_side < 0 && percale_vertex_passes(from, to, &view.passage);
    return view;
}

/// Distance of the vertex and the face when the substep began, m.
static double start_distance(const PercalePairStage *stage, const uint32_t points[4])
{
    return sqrt(percale_closest_on_triangle(start_of(stage, points[0]), start_of(stage, points[1]),
                                            start_of(stage, points[2]), start_of(stage, points[3]))
                    .distance2);
}

static void note_side(PercaleCollector *collector, uint32_t vertex, uint32_t triangle, int side)
{
    const f32x4 normal = {0.0f, 0.0f, 0.0f, side > 0 ? 1.0f : -1.0f};
    percale_collect_note(collector, (PercalePairNote){.key = face_key(vertex, triangle), .normal = normal});
}

static void add_face(const PercalePairStage *stage, PercaleCollector *collector, const FaceView *view,
                     uint32_t triangle, int side, const double weights[4])
{
    double start = start_distance(stage, view->points);
    Push push = {false,
                 {weights[0], weights[1], weights[2], weights[3]},
                 vscale((double)side, view->unit),
                 side == view->start_side ? start : -start,
                 view->keep.thickness,
                 view->keep.friction};
    percale_pair_add(stage, collector, view->points, &push);
    note_side(collector, view->points[0], triangle, side);
}

/// The side that a vertex keeps to: as it is known; else that of the start. The path changes it only where it
/// leads around the face. 0: it has always been in the face's plane.
static int side_of(const PercalePairStage *stage, const FaceView *view, uint32_t triangle)
{
    if (view->start_side * view->end_side < 0 && !view->has_passed) {
        return view->end_side;
    }
    const PercalePairNote *note = percale_pair_find_note(stage->known, face_key(view->points[0], triangle));
    int now = view->start_side != 0 ? view->start_side : view->end_side;
    if (note != NULL) {
        return is_free(note) ? now : side_of_note(note);
    }
    int known = side_of_neighbours(stage, view->points[0], triangle);
    return known != 0 ? known : now;
}

/// Whether a vertex is in the region of a corner of the cloth, as each triangle around that says.
static bool sees_corner(const PercalePairStage *stage, uint32_t vertex, uint32_t corner)
{
    const PercaleModelSurface *cloth = &stage->model->cloth;
    for (uint32_t i = cloth->vertex_first_face[corner]; i < cloth->vertex_first_face[corner + 1]; i++) {
        const uint32_t *t = cloth->triangles + 3 * (size_t)cloth->vertex_faces[i];
        const Vec3 x[4] = {end_of(stage, vertex), end_of(stage, t[0]), end_of(stage, t[1]),
                           end_of(stage, t[2])};
        PercaleClosest closest[CLOSEST_MOST] = {percale_closest_on_triangle(x[0], x[1], x[2], x[3])};
        int count = percale_closest_features(x[0], x[1], x[2], x[3], closest);
        bool sees = false;
        for (int k = 0; k < count; k++) {
            sees = sees ||
                   (closest[k].region >= REGION_CORNER_0 && t[closest[k].region - REGION_CORNER_0] == corner);
        }
        if (!sees) {
            return false;
        }
    }
    return true;
}

/// The points of the feature that a region names.
static uint32_t feature_of(const FaceView *view, uint32_t feature[3])
{
    PercaleRegion region = view->closest.region;
    if (region == REGION_FACE) {
        memcpy(feature, view->points + 1, 3 * sizeof(feature[0]));
        return 3;
    }
    if (region >= REGION_CORNER_0) {
        feature[0] = view->points[1 + (uint32_t)(region - REGION_CORNER_0)];
        return 1;
    }
    uint32_t side = (uint32_t)(region - REGION_SIDE_0);
    feature[0] = view->points[1 + side];
    feature[1] = view->points[1 + next_corner(side)];
    return 2;
}

/// A vertex and an edge or a vertex: along the line between the closest points. The rim has no memory.
/// `start`: distance of the vertex and the triangles around an edge when the substep began, m.
static void add_rim(const PercalePairStage *stage, PercaleCollector *collector, const FaceView *view,
                    double start)
{
    uint32_t feature[3];
    if (feature_of(view, feature) == 1) { // a pair of vertices belongs to the first of them, if both see it
        if (feature[0] < view->points[0] && sees_corner(stage, feature[0], view->points[0])) {
            return;
        }
        start = vlength(vsub(start_of(stage, view->points[0]), start_of(stage, feature[0])));
    }
    const double *b = view->closest.weights;
    Push push = {false, {1.0, -b[0], -b[1], -b[2]}, {0.0, 0.0, 0.0},
                 start, view->keep.thickness,       view->keep.friction};
    Vec3 between = combine(stage, view->points, push.weights, false);
    if (vlength(between) <= NO_DIRECTION * (double)view->keep.thickness) {
        between = combine(stage, view->points, push.weights, true);
    }
    push.normal = vunit(between);
    if (vlength(between) > MEETS * (double)view->keep.thickness) {
        percale_pair_add(stage, collector, view->points, &push);
    }
}

/// Notes all features with which the triangle is closest.
static void gather_features(const PercalePairStage *stage, PercaleCollector *collector, const FaceView *view,
                            uint32_t triangle)
{
    const uint32_t *points = view->points;
    PercaleFeatureList *list = &collector->features;
    if (!percale_memory_reserve(&collector->memory, &list->items, &list->capacity, list->count + CLOSEST_MOST,
                                sizeof(list->items[0]))) {
        collector->complete = false;
        return;
    }
    PercaleClosest closest[CLOSEST_MOST] = {view->closest};
    int count = percale_closest_features(end_of(stage, points[0]), end_of(stage, points[1]),
                                         end_of(stage, points[2]), end_of(stage, points[3]), closest);
    for (int k = 0; k < count; k++) {
        list->items[list->count++] = (PercaleFeature){triangle, closest[k]};
    }
}

/// End of the run of one feature in a sorted list.
static size_t end_of_feature(const PercaleSurface *cloth, const PercaleFeatureList *list, size_t first)
{
    const PercaleFeature *items = list->items;
    uint64_t key = percale_surface_feature_key(cloth, items[first].triangle, items[first].closest.region);
    size_t end = first + 1;
    while (end < list->count &&
           percale_surface_feature_key(cloth, items[end].triangle, items[end].closest.region) == key) {
        end++;
    }
    return end;
}

/// Distance of the vertex and the nearest of some triangles when the substep began, m.
static double nearest_start(const PercalePairStage *stage, uint32_t vertex, const PercaleFeature *features,
                            size_t count)
{
    double nearest = HUGE_VAL;
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = stage->model->cloth.triangles + 3 * (size_t)features[i].triangle;
        const uint32_t points[4] = {vertex, t[0], t[1], t[2]};
        nearest = fmin(nearest, start_distance(stage, points));
    }
    return nearest;
}

/// Features in whose region the vertex is: faces, and edges and vertices of which all triangles say so; or
/// vertices only.
static void add_features(const PercalePairStage *stage, PercaleCollector *collector, uint32_t vertex,
                         bool vertices_only)
{
    PercaleSurface cloth = {&stage->model->cloth, &stage->candidates->faces, stage->end, NULL};
    PercaleFeatureList *list = &collector->features;
    percale_surface_sort(&cloth, list);
    for (size_t first = 0, end; first < list->count; first = end) {
        PercaleFeature feature = list->items[first];
        PercaleRegion region = feature.closest.region;
        end = end_of_feature(&cloth, list, first);
        if (end - first != percale_surface_face_count(&cloth, feature.triangle, region) ||
            (vertices_only && region < REGION_CORNER_0)) {
            continue;
        }
        Keep keep;
        (void)keep_of(stage->model, vertex, cloth.mesh->triangles[3 * (size_t)feature.triangle], &keep);
        FaceView view = view_face(stage, vertex, feature.triangle, keep, false);
        view.closest = feature.closest;
        const double *b = feature.closest.weights;
        const double weights[4] = {1.0, -b[0], -b[1], -b[2]};
        uint32_t points[3];
        view.keep = keep_at_rest(stage, keep, &vertex, 1, points, feature_of(&view, points));
        if (!(view.distance <= percale_pair_reach(stage, &view.keep, view.points, weights))) {
            continue;
        }
        if (region == REGION_FACE && view.end_side != 0 &&
            !is_born_crossed(stage, face_key(vertex, feature.triangle))) {
            add_face(stage, collector, &view, feature.triangle, view.end_side, weights);
        } else if (region != REGION_FACE) {
            add_rim(stage, collector, &view, nearest_start(stage, vertex, list->items + first, end - first));
        }
    }
}

/// A vertex of the cloth. While it is on the wrong side of a face it gets no stencils with other faces and
/// edges: they would hold it there. (A pair of vertices belongs to the other as much.)
void percale_pair_find_vertex(const PercalePairStage *stage, PercaleCollector *collector, uint32_t vertex)
{
    const PercaleModel *model = stage->model;
    collector->features.count = 0;
    bool held = false;
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        uint32_t triangle = collector->neighbors.items[i].index;
        const uint32_t *corners = model->cloth.triangles + 3 * (size_t)triangle;
        Keep keep;
        if (is_line(corners) || !keep_of(model, vertex, corners[0], &keep)) {
            continue;
        }
        FaceView view = view_face(stage, vertex, triangle, keep, collector->neighbors.items[i].may_pass);
        const double *b = view.closest.weights;
        const double weights[4] = {1.0, -b[0], -b[1], -b[2]};
        bool near = view.distance <= percale_pair_reach(stage, &keep, view.points, weights);
        if (!near && !view.has_passed) {
            continue;
        }
        bool above = view.closest.region == REGION_FACE;
        bool born = is_born_crossed(stage, face_key(vertex, triangle));
        view.keep = keep_at_rest(stage, keep, &vertex, 1, corners, 3);
        bool in_reach =
            above && near && view.distance <= percale_pair_reach(stage, &view.keep, view.points, weights);
        if (!born && view.side_scale > 0.0 && (view.has_passed || in_reach)) {
            int side = side_of(stage, &view, triangle);
            if (side != 0 && side != view.end_side) {
                add_face(stage, collector, &view, triangle, side, above ? weights : view.passage.weights);
                held = true;
            }
        }
        if (near) {
            gather_features(stage, collector, &view, triangle);
        }
    }
    add_features(stage, collector, vertex, held);
}

// ---- obstacles ----

/// An obstacle's vertex and the cloth.
typedef struct ObstacleVertex {
    const PercaleModelSurface *obstacle;
    uint32_t point;
    Vec3 outward;
} ObstacleVertex;

/// Below the inside of a face, or gone through it.
static void add_obstacle_face(const PercalePairStage *stage, PercaleCollector *collector,
                              const ObstacleVertex *vertex, const FaceView *view, uint32_t triangle)
{
    double across = vdot(view->unit, vertex->outward);
    int side = across < 0.0 ? 1 : -1; // of the cloth on which the obstacle belongs
    bool is_outside = is_leaving(stage, view->points + 1, 3, vertex->obstacle, vertex->outward) ||
                      side_of(stage, view, triangle) != -side;
    if (fabs(across) < CLEAR_SIDE || !is_outside) { // the cloth came from behind
        return;
    }
    const double *b = view->closest.weights;
    const double weights[4] = {1.0, -b[0], -b[1], -b[2]};
    const double *at = view->closest.region == REGION_FACE ? weights : view->passage.weights;
    double start = start_distance(stage, view->points);
    Push push = {false,
                 {at[0], at[1], at[2], at[3]},
                 vscale((double)side, view->unit),
                 side == view->start_side ? start : -start,
                 view->keep.thickness,
                 view->keep.friction};
    percale_pair_add(stage, collector, view->points, &push);
    note_side(collector, vertex->point, triangle, side);
}

/// Whether of the obstacle around the vertex nothing is nearer in that direction: else a vertex in the middle
/// of a plane would push a rim that comes along away to the side.
static bool is_foremost(const PercalePairStage *stage, const ObstacleVertex *vertex, Vec3 direction)
{
    const double LEVEL = 1e-3; // sine of the angle by which a plane may look tilted
    const PercaleModelSurface *obstacle = vertex->obstacle;
    const uint32_t *first = obstacle->vertex_first_face + (vertex->point - obstacle->first_point);
    Vec3 tip = end_of(stage, vertex->point);
    for (uint32_t i = first[0]; i < first[1]; i++) {
        for (int k = 0; k < 3; k++) {
            Vec3 side = vsub(
                end_of(stage, obstacle->triangles[3 * (size_t)obstacle->vertex_faces[i] + (size_t)k]), tip);
            if (vdot(direction, side) > LEVEL * vlength(side)) {
                return false;
            }
        }
    }
    return true;
}

/// In the region of an edge of the cloth, which is outside of the obstacle: along the line between the two.
/// `start`: as of add_rim.
static void add_obstacle_rim(const PercalePairStage *stage, PercaleCollector *collector,
                             const ObstacleVertex *vertex, const FaceView *view, double start)
{
    const double *b = view->closest.weights;
    Push push = {.weights = {1.0, -b[0], -b[1], -b[2]},
                 .thickness = view->keep.thickness,
                 .friction = view->keep.friction};
    Vec3 between = combine(stage, view->points, push.weights, false);
    push.normal = vunit(between);
    if (vlength(between) > NO_DIRECTION * (double)view->keep.thickness &&
        vdot(push.normal, vertex->outward) < -CLEAR_SIDE &&
        is_foremost(stage, vertex, vscale(-1.0, push.normal))) {
        push.start_gap = start;
        percale_pair_add(stage, collector, view->points, &push);
    }
}

/// Edges of the cloth in whose region the vertex is, as all triangles around say. A vertex of the cloth
/// belongs to that vertex's contacts.
static void add_obstacle_rims(const PercalePairStage *stage, PercaleCollector *collector,
                              const ObstacleVertex *vertex)
{
    PercaleSurface cloth = {&stage->model->cloth, &stage->candidates->faces, stage->end, NULL};
    PercaleFeatureList *list = &collector->features;
    percale_surface_sort(&cloth, list);
    for (size_t first = 0, end; first < list->count; first = end) {
        PercaleFeature feature = list->items[first];
        PercaleRegion region = feature.closest.region;
        end = end_of_feature(&cloth, list, first);
        if (region >= REGION_CORNER_0 ||
            end - first != percale_surface_face_count(&cloth, feature.triangle, region)) {
            continue;
        }
        Keep keep;
        (void)keep_of_obstacle(stage->model, cloth.mesh->triangles[3 * (size_t)feature.triangle],
                               vertex->obstacle, &keep);
        FaceView view = view_face(stage, vertex->point, feature.triangle, keep, false);
        view.closest = feature.closest;
        add_obstacle_rim(stage, collector, vertex, &view,
                         nearest_start(stage, vertex->point, list->items + first, end - first));
    }
}

/// An obstacle's vertex and the cloth's faces and edges. The cloth's vertices look for the obstacle's
/// features themselves.
void percale_pair_find_obstacle_vertex(const PercalePairStage *stage, PercaleCollector *collector,
                                       const PercaleModelSurface *obstacle, uint32_t point)
{
    const PercaleModel *model = stage->model;
    const uint32_t *first = obstacle->vertex_first_face + (point - obstacle->first_point);
    ObstacleVertex vertex = {
        obstacle, point,
        percale_pair_outward(stage, obstacle, obstacle->vertex_faces + first[0], first[1] - first[0], 1)};
    collector->features.count = 0;
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        uint32_t triangle = collector->neighbors.items[i].index;
        const uint32_t *corners = model->cloth.triangles + 3 * (size_t)triangle;
        Keep keep;
        if (is_line(corners) || !keep_of_obstacle(model, corners[0], obstacle, &keep)) {
            continue;
        }
        FaceView view = view_face(stage, point, triangle, keep, collector->neighbors.items[i].may_pass);
        const double *b = view.closest.weights;
        const double weights[4] = {1.0, -b[0], -b[1], -b[2]};
        PercaleRegion region = view.closest.region;
        bool near = view.distance <= percale_pair_reach(stage, &keep, view.points, weights);
        if (view.has_passed || (near && region == REGION_FACE)) {
            add_obstacle_face(stage, collector, &vertex, &view, triangle);
        } else if (near) {
            gather_features(stage, collector, &view, triangle);
        }
    }
    add_obstacle_rims(stage, collector, &vertex);
}
