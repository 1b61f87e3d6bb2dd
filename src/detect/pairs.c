#include "detect/pairs.h"

#include "base/radix_sort.h"
#include "detect/contacts.h"
#include "detect/coplanar.h"
#include "percale/geometry.h"

#include <string.h>

// Below this share of the thickness the vector between two closest points has no direction left.
static const double NO_DIRECTION = 1e-3;

// Closest points nearer to an end of their edge than this share of it belong to the end.
static const double INSIDE = 1e-6;

// Share of the way on the rest shape that two features of a cloth can keep from each other.
static const float REST_SHARE = 0.5f;

// Squared sine below which edges are parallel: their ends say all.
static const double PARALLEL = 1e-12;

// A path this share of a triangle's size beside it still goes through it: neighbours leave no gap.
static const double SEAMLESS = 1e-6;

// An obstacle's vertex or edge whose normal is nearly in the plane of the pair doesn't say which way is out.
static const double CLEAR_SIDE = 0.1;

// ---- what a pair is ----

/// What a pair of features keeps to.
typedef struct Keep {
    float thickness, friction;
} Keep;

/// False when the two don't collide.
static bool keep_of(const PercaleModel *model, uint32_t slot, uint32_t other, Keep *keep)
{
    const PercaleModelCloth *a = &model->cloths[model->cloth_of[slot]];
    const PercaleModelCloth *b = &model->cloths[model->cloth_of[other]];
    *keep = (Keep){0.5f * (a->thickness + b->thickness), sqrtf(a->friction * b->friction)};
    return (a->mask & b->mask) != 0;
}

static bool keep_of_obstacle(const PercaleModel *model, uint32_t slot, const PercaleModelSurface *obstacle,
                             Keep *keep)
{
    const PercaleModelCloth *a = &model->cloths[model->cloth_of[slot]];
    *keep = (Keep){0.5f * (a->thickness + obstacle->thickness), sqrtf(a->friction * obstacle->friction)};
    return (a->mask & obstacle->mask) != 0;
}

static Vec3 start_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->model->position[point]);
}

static Vec3 end_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->model->predicted[point]);
}

/// Sum of weights times points, at the start (1) or the end (0) of the substep.
static Vec3 combine(const PercalePairStage *stage, const uint32_t points[4], const double weights[4],
                    bool at_start)
{
    Vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++) {
        Vec3 x = at_start ? start_of(stage, points[k]) : end_of(stage, points[k]);
        sum = vadd(sum, vscale(weights[k], x));
    }
    return sum;
}

/// Distance at which a pair gets a stencil, m: its thickness, as much again for what the solver moves it, and
/// what it moves until the next pass.
static double reach_of(const PercalePairStage *stage, const Keep *keep, const uint32_t points[4],
                       const double weights[4])
{
    double reach = 2.0 * (double)keep->thickness;
    if (stage->later_substeps > 0.0f) {
        Vec3 moved = vsub(combine(stage, points, weights, false), combine(stage, points, weights, true));
        reach += (double)stage->later_substeps * vlength(moved);
    }
    return reach;
}

/// What a stencil needs besides its points.
typedef struct Push {
    double weights[4];
    Vec3 normal;
    double start_gap; // m, along the normal's side
    float thickness;  // m
    float friction;
} Push;

/// Overlap at the start of a substep is undone at a limited speed (MATH.md, section 6).
static void add_stencil(const PercalePairStage *stage, PercaleCollector *collector, const uint32_t points[4],
                        const Push *push)
{
    float risen = (float)push->start_gap + EXIT_SPEED * stage->dt;
    PercaleStencil stencil = {.normal =
                                  f32x4_of(push->normal, risen < push->thickness ? risen : push->thickness),
                              .friction = push->friction};
    memcpy(stencil.points, points, sizeof(stencil.points));
    // multiples of 2^-24: those of each sign sum to exactly 1
    if (push->weights[1] > 0.0) {
        const double first[3] = {push->weights[0], push->weights[1], 0.0};
        const double second[3] = {-push->weights[2], -push->weights[3], 0.0};
        float a[3];
        float b[3];
        quantize_weights(first, a);
        quantize_weights(second, b);
        stencil.weights[0] = 1.0f - a[1];
        stencil.weights[1] = a[1];
        stencil.weights[2] = -(1.0f - b[1]);
        stencil.weights[3] = -b[1];
    } else {
        const double face[3] = {-push->weights[1], -push->weights[2], -push->weights[3]};
        float b[3];
        quantize_weights(face, b);
        stencil.weights[0] = 1.0f;
        for (int k = 0; k < 3; k++) {
            stencil.weights[1 + k] = -b[k];
        }
    }
    percale_collect_stencil(collector, &stencil);
}

// ---- notes ----

static uint64_t face_key(uint32_t vertex, uint32_t triangle)
{
    return (uint64_t)vertex << 31 | triangle;
}

static uint64_t edge_key(uint32_t edge, uint32_t other)
{
    return (uint64_t)1 << 62 | (uint64_t)edge << 31 | other;
}

static const PercalePairNote *find_note(const PercaleNoteList *known, uint64_t key)
{
    size_t low = 0;
    size_t high = known->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (known->items[middle].key < key) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < known->count && known->items[low].key == key ? &known->items[low] : NULL;
}

/// The side that is known of a vertex and a face, or of the vertex and a neighbour of the face: a vertex that
/// slides on below the cloth stays below it. 0: none.
static int known_side(const PercalePairStage *stage, uint32_t vertex, uint32_t triangle)
{
    const PercaleNoteList *known = stage->known;
    const PercaleModelSurface *cloth = &stage->model->cloth;
    const PercalePairNote *note = find_note(known, face_key(vertex, triangle));
    if (note != NULL) {
        return note->normal[3] > 0.0f ? 1 : -1;
    }
    for (uint32_t side = 3 * triangle; known->count > 0 && side < 3 * triangle + 3; side++) {
        uint32_t edge = cloth->edges.edge_of_side[side];
        for (uint32_t i = cloth->edges.first_side[edge]; i < cloth->edges.first_side[edge + 1]; i++) {
            uint32_t other = cloth->edges.sides[i];
            note = other != side ? find_note(known, face_key(vertex, other / 3)) : NULL;
            if (note != NULL) {
                int turned = cloth->triangles[other] == cloth->triangles[side] ? -1 : 1;
                return note->normal[3] > 0.0f ? turned : -turned;
            }
        }
    }
    return 0;
}

// ---- a vertex and a face ----

/// A vertex seen from a face, over the substep.
typedef struct FaceView {
    uint32_t points[4]; // the vertex, the triangle
    Keep keep;
    PercaleClosest closest; // at the end
    double distance;        // m
    double side_scale;      // twice the triangle's area at the end, 0 without
    Vec3 unit;              // its normal
    int start_side, end_side;
    bool has_passed;   // through the inside of the face, on the way
    double passing[3]; // where
} FaceView;

static Vec3 area_of(const Vec3 corners[3])
{
    return vcross(vsub(corners[1], corners[0]), vsub(corners[2], corners[0]));
}

/// Four points at a time of the substep, 0 .. 1.
static void place_at(const Vec3 *from, const Vec3 *to, double time, Vec3 x[4])
{
    for (int k = 0; k < 4; k++) {
        x[k] = vadd(from[k], vscale(time, vsub(to[k], from[k])));
    }
}

/// Barycentric coordinates of the point x[0] in the triangle of the others. False when it isn't above its
/// inside.
static bool weigh(const Vec3 *x, double weights[3])
{
    Vec3 area = area_of(x + 1);
    double scale = vdot(area, area);
    if (!(scale > 0.0)) {
        return false;
    }
    bool inside = true;
    for (int k = 0; k < 3; k++) {
        Vec3 a = x[1 + (k + 1) % 3];
        Vec3 b = x[1 + (k + 2) % 3];
        weights[k] = vdot(area, vcross(vsub(b, a), vsub(x[0], a))) / scale;
        inside = inside && weights[k] >= -SEAMLESS;
    }
    return inside;
}

/// Whether the vertex has gone through the inside of the face, straight paths taken, and not come back; where
/// that was.
static bool has_gone_through(const Vec3 *from, const Vec3 *to, double weights[3])
{
    double times[3];
    int count = percale_coplanar_times(from, to, times);
    int passages = 0;
    for (int i = 0; i < count; i++) {
        Vec3 x[4];
        double here[3];
        place_at(from, to, times[i], x);
        if (weigh(x, here)) {
            memcpy(weights, here, sizeof(here));
            passages++;
        }
    }
    return passages % 2 == 1;
}

static FaceView view_face(const PercalePairStage *stage, uint32_t vertex, uint32_t triangle, Keep keep)
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
    Vec3 area[2] = {area_of(from + 1), area_of(to + 1)};
    view.side_scale = vlength(area[1]);
    view.unit = vunit(area[1]);
    view.start_side = vdot(area[0], vsub(from[0], from[1])) >= 0.0 ? 1 : -1;
    view.end_side = vdot(area[1], vsub(to[0], to[1])) >= 0.0 ? 1 : -1;
    view.has_passed = view.start_side != view.end_side && has_gone_through(from, to, view.passing);
    return view;
}

/// Distance of the vertex and the face when the substep began, m.
static double start_distance(const PercalePairStage *stage, const uint32_t points[4])
{
    return sqrt(percale_closest_on_triangle(start_of(stage, points[0]), start_of(stage, points[1]),
                                            start_of(stage, points[2]), start_of(stage, points[3]))
                    .distance2);
}

static float rest_distance(const PercalePairStage *stage, const uint32_t *a, int a_count, const uint32_t *b,
                           int b_count)
{
    float nearest = INFINITY;
    for (int i = 0; i < a_count; i++) {
        for (int k = 0; k < b_count; k++) {
            float distance = near_distance(&stage->model->near, a[i], b[k]);
            nearest = distance < nearest ? distance : nearest;
        }
    }
    return nearest;
}

static float allowed(float thickness, float rest)
{
    float most = REST_SHARE * rest;
    return most < thickness ? most : thickness;
}

static void add_face(const PercalePairStage *stage, PercaleCollector *collector, const FaceView *view,
                     uint32_t triangle, int side, const double weights[3])
{
    double start = start_distance(stage, view->points);
    Push push = {{1.0, -weights[0], -weights[1], -weights[2]},
                 vscale((double)side, view->unit),
                 side == view->start_side ? start : -start,
                 allowed(view->keep.thickness, rest_distance(stage, view->points, 1, view->points + 1, 3)),
                 view->keep.friction};
    add_stencil(stage, collector, view->points, &push);
    percale_collect_note(collector, (PercalePairNote){face_key(view->points[0], triangle),
                                                      {0.0f, 0.0f, 0.0f, side > 0 ? 1.0f : -1.0f}});
}

/// The side that a vertex keeps to: that of the start, as far as it is known; the path changes it only where
/// it leads around the face.
static int side_of(const PercalePairStage *stage, const FaceView *view, uint32_t triangle)
{
    if (view->start_side != view->end_side && !view->has_passed) {
        return view->end_side;
    }
    int known = known_side(stage, view->points[0], triangle);
    return known != 0 ? known : view->start_side;
}

/// Whether a vertex is in the region of a corner of the cloth, as each triangle around that says.
static bool sees_corner(const PercalePairStage *stage, uint32_t vertex, uint32_t corner)
{
    const PercaleModelSurface *cloth = &stage->model->cloth;
    for (uint32_t i = cloth->vertex_first_face[corner]; i < cloth->vertex_first_face[corner + 1]; i++) {
        const uint32_t *t = cloth->triangles + 3 * (size_t)cloth->vertex_faces[i];
        PercaleClosest closest = percale_closest_on_triangle(end_of(stage, vertex), end_of(stage, t[0]),
                                                             end_of(stage, t[1]), end_of(stage, t[2]));
        if (closest.region < REGION_CORNER_0 || t[closest.region - REGION_CORNER_0] != corner) {
            return false;
        }
    }
    return true;
}

/// A vertex and an edge or a vertex: along the line between the closest points. The rim has no memory.
static void add_rim(const PercalePairStage *stage, PercaleCollector *collector, const FaceView *view)
{
    PercaleRegion region = view->closest.region;
    if (region >= REGION_CORNER_0) { // a pair of vertices belongs to the first of them, if both see it
        uint32_t corner = view->points[1 + (int)(region - REGION_CORNER_0)];
        if (corner < view->points[0] && sees_corner(stage, corner, view->points[0])) {
            return;
        }
    }
    const double *b = view->closest.weights;
    Push push = {{1.0, -b[0], -b[1], -b[2]},
                 {0.0, 0.0, 0.0},
                 start_distance(stage, view->points),
                 allowed(view->keep.thickness, rest_distance(stage, view->points, 1, view->points + 1, 3)),
                 view->keep.friction};
    Vec3 between = combine(stage, view->points, push.weights, false);
    if (vlength(between) <= NO_DIRECTION * (double)view->keep.thickness) {
        between = combine(stage, view->points, push.weights, true);
    }
    push.normal = vunit(between);
    if (vdot(push.normal, push.normal) > 0.0) {
        add_stencil(stage, collector, view->points, &push);
    }
}

static bool has_corner(const uint32_t *corners, uint32_t vertex)
{
    return corners[0] == vertex || corners[1] == vertex || corners[2] == vertex;
}

/// Sewn to a line: no face.
static bool is_line(const uint32_t *corners)
{
    return corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
}

typedef struct Box {
    f32x4 low, high;
} Box;

/// Around the way of two points until the next pass.
static Box box_of(const PercalePairStage *stage, uint32_t a, uint32_t b)
{
    const f32x4 *from = stage->model->position;
    return (Box){min4(min4(from[a], stage->ahead[a]), min4(from[b], stage->ahead[b])),
                 max4(max4(from[a], stage->ahead[a]), max4(from[b], stage->ahead[b]))};
}

/// Wider by the radius, and by what float32 may have rounded away.
static Box widen(Box box, float radius)
{
    for (int axis = 0; axis < 3; axis++) {
        float slack = radius + 1e-6f * (fabsf(box.low[axis]) + fabsf(box.high[axis]));
        box.low[axis] -= slack;
        box.high[axis] += slack;
    }
    return box;
}

static bool overlap(const Box *a, const Box *b)
{
    f32x4 apart = max4(a->low - b->high, b->low - a->high);
    return apart[0] <= 0.0f && apart[1] <= 0.0f && apart[2] <= 0.0f;
}

/// Triangles whose way touches the box.
static bool gather(const PercalePairStage *stage, PercaleCollector *collector, const Box *box)
{
    bool complete =
        percale_tree_overlap(stage->tree, box->low, box->high, &collector->memory, &collector->triangles);
    collector->complete = collector->complete && complete;
    return complete;
}

static float widest_reach(const PercalePairStage *stage, float thickness)
{
    float thickest = 0.0f;
    for (uint32_t c = 0; c < stage->model->cloth_count; c++) {
        thickest = fmaxf(thickest, stage->model->cloths[c].thickness);
    }
    return 1.001f * (thickness + thickest); // twice the mean
}

static void add_feature(PercaleCollector *collector, PercaleFeature feature)
{
    PercaleFeatureList *list = &collector->features;
    if (percale_memory_reserve(&collector->memory, &list->items, &list->capacity, list->count + 1,
                               sizeof(feature))) {
        list->items[list->count++] = feature;
    } else {
        collector->complete = false;
    }
}

/// Features in whose region the vertex is: faces, and edges and vertices of which all triangles say so.
static void add_features(const PercalePairStage *stage, PercaleCollector *collector, uint32_t vertex)
{
    PercaleSurface cloth = {&stage->model->cloth, stage->tree, stage->model->predicted};
    PercaleFeatureList *list = &collector->features;
    percale_surface_sort(&cloth, list);
    for (size_t first = 0, end; first < list->count; first = end) {
        PercaleFeature feature = list->items[first];
        PercaleRegion region = feature.closest.region;
        uint64_t key = percale_surface_feature_key(&cloth, feature.triangle, region);
        for (end = first + 1; end < list->count; end++) {
            if (percale_surface_feature_key(&cloth, list->items[end].triangle,
                                            list->items[end].closest.region) != key) {
                break;
            }
        }
        if (end - first != percale_surface_face_count(&cloth, feature.triangle, region)) {
            continue;
        }
        Keep keep;
        (void)keep_of(stage->model, vertex, cloth.mesh->triangles[3 * (size_t)feature.triangle], &keep);
        FaceView view = view_face(stage, vertex, feature.triangle, keep);
        if (region == REGION_FACE) {
            add_face(stage, collector, &view, feature.triangle, view.end_side, feature.closest.weights);
        } else {
            add_rim(stage, collector, &view);
        }
    }
}

/// A vertex of the cloth. While it is on the wrong side of a face it gets no other stencils: they would hold
/// it there.
static void find_vertex(const PercalePairStage *stage, PercaleCollector *collector, uint32_t vertex)
{
    const PercaleModel *model = stage->model;
    float radius = widest_reach(stage, model->cloths[model->cloth_of[vertex]].thickness);
    collector->features.count = 0;
    Box box = widen(box_of(stage, vertex, vertex), radius);
    if (!gather(stage, collector, &box)) {
        return;
    }
    bool held = false;
    for (size_t i = 0; i < collector->triangles.count; i++) {
        uint32_t triangle = collector->triangles.items[i];
        const uint32_t *corners = model->cloth.triangles + 3 * (size_t)triangle;
        Keep keep;
        if (has_corner(corners, vertex) || is_line(corners) || !keep_of(model, vertex, corners[0], &keep)) {
            continue;
        }
        collector->candidates++;
        FaceView view = view_face(stage, vertex, triangle, keep);
        const double *b = view.closest.weights;
        const double weights[4] = {1.0, -b[0], -b[1], -b[2]};
        bool near = view.distance <= reach_of(stage, &keep, view.points, weights);
        bool above = view.closest.region == REGION_FACE;
        if (view.side_scale > 0.0 && (view.has_passed || (above && near))) {
            int side = side_of(stage, &view, triangle);
            if (side != view.end_side) {
                add_face(stage, collector, &view, triangle, side, above ? b : view.passing);
                held = true;
                continue;
            }
        }
        if (near) {
            add_feature(collector, (PercaleFeature){triangle, view.closest});
        }
    }
    if (!held) {
        add_features(stage, collector, vertex);
    }
}

// ---- obstacles ----

static const PercaleModelSurface *obstacle_of(const PercaleModel *model, uint32_t point)
{
    uint32_t o = 0;
    while (point - model->obstacles[o].first_point >= model->obstacles[o].vertex_count) {
        o++;
    }
    return &model->obstacles[o];
}

/// Outward normal of an obstacle's vertex or edge, from the faces around it at the end of the substep; zero
/// where they face each other.
static Vec3 outward_of(const PercalePairStage *stage, const PercaleModelSurface *obstacle,
                       const uint32_t *faces, uint32_t count, uint32_t divisor)
{
    PercaleSurface surface = {obstacle, NULL, stage->model->predicted};
    Vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < count; i++) {
        sum = vadd(sum, percale_surface_face_normal(&surface, faces[i] / divisor));
    }
    return vunit(sum);
}

/// An obstacle's vertex below the inside of a face of the cloth; its edges and vertices are those of the
/// cloth's vertices and edges.
static void find_obstacle_vertex(const PercalePairStage *stage, PercaleCollector *collector, uint32_t point)
{
    const PercaleModel *model = stage->model;
    const PercaleModelSurface *obstacle = obstacle_of(model, point);
    Box box = widen(box_of(stage, point, point), widest_reach(stage, obstacle->thickness));
    if (!gather(stage, collector, &box) || collector->triangles.count == 0) {
        return;
    }
    const uint32_t *first = obstacle->vertex_first_face + (point - obstacle->first_point);
    Vec3 outward = outward_of(stage, obstacle, obstacle->vertex_faces + first[0], first[1] - first[0], 1);
    for (size_t i = 0; i < collector->triangles.count; i++) {
        uint32_t triangle = collector->triangles.items[i];
        const uint32_t *corners = model->cloth.triangles + 3 * (size_t)triangle;
        Keep keep;
        if (is_line(corners) || !keep_of_obstacle(model, corners[0], obstacle, &keep)) {
            continue;
        }
        collector->candidates++;
        FaceView view = view_face(stage, point, triangle, keep);
        double across = vdot(view.unit, outward);
        int side = across < 0.0 ? 1 : -1; // of the cloth on which the obstacle belongs
        const double *b = view.closest.weights;
        const double weights[4] = {1.0, -b[0], -b[1], -b[2]};
        bool near = view.closest.region == REGION_FACE &&
                    view.distance <= reach_of(stage, &keep, view.points, weights);
        if ((!near && !view.has_passed) || fabs(across) < CLEAR_SIDE ||
            (!obstacle->closed && view.start_side != side)) { // the cloth came from behind
            continue;
        }
        double start = start_distance(stage, view.points);
        const double *at = near ? b : view.passing;
        Push push = {{1.0, -at[0], -at[1], -at[2]},
                     vscale((double)side, view.unit),
                     side == view.start_side ? start : -start,
                     keep.thickness,
                     keep.friction};
        add_stencil(stage, collector, view.points, &push);
    }
}

// ---- two edges ----

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
    weights[0] = 1.0 - s;
    weights[1] = s;
    weights[2] = t - 1.0;
    weights[3] = -t;
    return s > -slack && s < 1.0 + slack && t > -slack && t < 1.0 + slack;
}

static Vec3 combine_all(const Vec3 *x, const double weights[4])
{
    Vec3 sum = vscale(weights[0], x[0]);
    for (int k = 1; k < 4; k++) {
        sum = vadd(sum, vscale(weights[k], x[k]));
    }
    return sum;
}

static bool have_gone_through(EdgeView *view, double weights[4])
{
    double times[3];
    int count = percale_coplanar_times(view->from, view->to, times);
    int passages = 0;
    for (int i = 0; i < count; i++) {
        Vec3 x[4];
        double here[4];
        place_at(view->from, view->to, times[i], x);
        if (weigh_edges(x, SEAMLESS, here)) {
            memcpy(weights, here, sizeof(here));
            passages++;
        }
    }
    return passages % 2 == 1;
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
    view->has_passed = have_gone_through(view, meeting);
    if (!inside && view->has_passed) {
        memcpy(view->weights, meeting, sizeof(meeting));
    }
    view->between = combine_all(view->to, view->weights);
    view->distance = vlength(view->between);
    return view->has_passed || (inside && view->distance <= reach_of(stage, keep, points, view->weights));
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

/// Which way the first edge belongs, seen from the second: as the note says; else as they were, which is as
/// they are unless they have passed through each other.
static Vec3 reference_of(const EdgeView *view, const PercalePairNote *note, Vec3 before)
{
    if (note != NULL) {
        return vec3_of(note->normal);
    }
    if (view->distance > 0.0) {
        return view->has_passed ? vscale(-1.0, view->between) : view->between;
    }
    return before;
}

static void find_edge_pair(const PercalePairStage *stage, PercaleCollector *collector,
                           const uint32_t edges[2], const uint32_t points[4], Keep keep)
{
    EdgeView view;
    if (!view_edges(stage, points, &keep, &view)) {
        return;
    }
    const PercalePairNote *note = find_note(stage->known, edge_key(edges[0], edges[1]));
    Vec3 before = start_between(&view);
    Vec3 reference = reference_of(&view, note, before);
    if (!(vdot(reference, reference) > 0.0)) {
        return; // they have always met: no way out is better than another
    }
    Push push = {.normal = directed(&view, reference, (double)keep.thickness),
                 .thickness = allowed(keep.thickness, rest_distance(stage, points, 2, points + 2, 2)),
                 .friction = keep.friction};
    memcpy(push.weights, view.weights, sizeof(push.weights));
    push.start_gap = vdot(before, reference) >= 0.0 ? vlength(before) : -vlength(before);
    add_stencil(stage, collector, points, &push);
    percale_collect_note(collector,
                         (PercalePairNote){edge_key(edges[0], edges[1]), f32x4_of(push.normal, 0.0f)});
}

/// An obstacle's edge against one of the cloth: out of the obstacle.
static void find_obstacle_edge_pair(const PercalePairStage *stage, PercaleCollector *collector,
                                    const PercaleModelSurface *obstacle, Vec3 outward,
                                    const uint32_t points[4], Keep keep)
{
    EdgeView view;
    if (!view_edges(stage, points, &keep, &view)) {
        return;
    }
    Push push = {.normal = directed(&view, outward, (double)keep.thickness),
                 .thickness = keep.thickness,
                 .friction = keep.friction};
    Vec3 before = start_between(&view);
    bool was_outside = vdot(before, outward) >= 0.0;
    if (fabs(vdot(push.normal, outward)) < CLEAR_SIDE || (!obstacle->closed && !was_outside)) {
        return;
    }
    memcpy(push.weights, view.weights, sizeof(push.weights));
    push.start_gap = was_outside ? vlength(before) : -vlength(before);
    add_stencil(stage, collector, points, &push);
}

/// An edge of the cloth that this triangle is the first to have; UINT32_MAX: its side belongs to another.
static uint32_t owned_edge(const PercaleModelSurface *cloth, uint32_t side)
{
    uint32_t edge = cloth->edges.edge_of_side[side];
    return edge != UINT32_MAX && cloth->edges.sides[cloth->edges.first_side[edge]] == side ? edge
                                                                                           : UINT32_MAX;
}

static void find_edge(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge)
{
    const PercaleModel *model = stage->model;
    const PercaleModelSurface *cloth = &model->cloth;
    const uint32_t *own = cloth->edges.vertices[edge];
    float radius = widest_reach(stage, model->cloths[model->cloth_of[own[0]]].thickness);
    Box box = widen(box_of(stage, own[0], own[1]), radius);
    if (!gather(stage, collector, &box)) {
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

static void find_obstacle_edge(const PercalePairStage *stage, PercaleCollector *collector,
                               const PercaleModelSurface *obstacle, uint32_t edge)
{
    const PercaleModel *model = stage->model;
    const PercaleModelSurface *cloth = &model->cloth;
    const uint32_t own[2] = {obstacle->first_point + obstacle->edges.vertices[edge][0],
                             obstacle->first_point + obstacle->edges.vertices[edge][1]};
    float radius = widest_reach(stage, obstacle->thickness);
    Box box = widen(box_of(stage, own[0], own[1]), radius);
    if (!gather(stage, collector, &box) || collector->triangles.count == 0) {
        return;
    }
    uint32_t first = obstacle->edges.first_side[edge];
    Vec3 outward = outward_of(stage, obstacle, obstacle->edges.sides + first,
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
        find_obstacle_edge_pair(stage, collector, obstacle, outward, points, keep);
    }
}

// ---- all ----

/// Items: points from `first` on; both kinds in the order of the arrays.
typedef struct Points {
    const PercalePairStage *stage;
    uint32_t first;
} Points;

static void find_points(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Points *points = context;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        uint32_t point = points->first + (uint32_t)i;
        if (point < points->stage->model->slot_count) {
            find_vertex(points->stage, collector, point);
        } else {
            find_obstacle_vertex(points->stage, collector, point);
        }
    }
}

/// Items: edges of the cloth, or of an obstacle.
typedef struct Edges {
    const PercalePairStage *stage;
    const PercaleModelSurface *obstacle; // NULL: the cloth
} Edges;

static void find_edges(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Edges *edges = context;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        if (edges->obstacle == NULL) {
            find_edge(edges->stage, collector, (uint32_t)i);
        } else {
            find_obstacle_edge(edges->stage, collector, edges->obstacle, (uint32_t)i);
        }
    }
}

/// By key, which is unique.
static bool sort_notes(PercaleNoteList *notes, PercaleMemory *memory)
{
    PercaleKeyed *keyed = percale_memory_new(memory, notes->count, sizeof(keyed[0]));
    PercaleKeyed *scratch = percale_memory_new(memory, notes->count, sizeof(keyed[0]));
    PercalePairNote *sorted = percale_memory_new(memory, notes->count, sizeof(sorted[0]));
    bool complete = keyed != NULL && scratch != NULL && sorted != NULL;
    if (complete) {
        for (size_t i = 0; i < notes->count; i++) {
            keyed[i] = (PercaleKeyed){notes->items[i].key, (uint32_t)i};
        }
        percale_radix_sort(keyed, scratch, notes->count);
        for (size_t i = 0; i < notes->count; i++) {
            sorted[i] = notes->items[keyed[i].value];
        }
        if (notes->count > 0) {
            memcpy(notes->items, sorted, notes->count * sizeof(sorted[0]));
        }
    }
    percale_memory_free(memory, keyed);
    percale_memory_free(memory, scratch);
    percale_memory_free(memory, sorted);
    return complete;
}

bool percale_pairs_find(const PercalePairStage *stage, PercaleCollectors *collectors, PercaleMemory *memory,
                        PercaleStencilList *stencils, PercaleNoteList *notes, PercalePairCounts *counts)
{
    const PercaleModel *model = stage->model;
    Points points = {stage, stage->cloth ? 0 : model->slot_count};
    uint32_t point_end = stage->obstacles ? model->point_count : model->slot_count;
    size_t before = stencils->count;
    notes->count = 0;
    bool complete = percale_collect(stage->team, point_end - points.first, find_points, &points, collectors,
                                    memory, stencils, notes, &counts->candidates);
    counts->vertex_face += stencils->count - before;
    before = stencils->count;
    if (complete && stage->edges && stage->cloth) {
        Edges cloth = {stage, NULL};
        complete = percale_collect(stage->team, model->cloth.edges.edge_count, find_edges, &cloth, collectors,
                                   memory, stencils, notes, &counts->candidates);
    }
    for (uint32_t o = 0; complete && stage->obstacles && o < model->obstacle_count; o++) {
        Edges edges = {stage, &model->obstacles[o]};
        complete = percale_collect(stage->team, model->obstacles[o].edges.edge_count, find_edges, &edges,
                                   collectors, memory, stencils, notes, &counts->candidates);
    }
    counts->edge_edge += stencils->count - before;
    return complete && sort_notes(notes, memory);
}
