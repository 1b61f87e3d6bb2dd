#include "detect/surface.h"

#include <float.h>

// Boxes are float32; a box is skipped only when it is farther than this share beyond the radius.
static const float BOX_SLACK = 1e-5f;

static void corners_of(const PercaleSurface *surface, uint32_t triangle, Vec3 corners[3])
{
    const uint32_t *indices = surface->mesh->triangles + 3 * (size_t)triangle;
    for (int k = 0; k < 3; k++) {
        corners[k] = vec3_of(surface->points[indices[k]]);
    }
}

Vec3 percale_surface_point(const PercaleSurface *surface, uint32_t triangle, const double weights[3])
{
    Vec3 c[3];
    corners_of(surface, triangle, c);
    return vadd(vadd(vscale(weights[0], c[0]), vscale(weights[1], c[1])), vscale(weights[2], c[2]));
}

// ---- traversal ----

/// Up to four triangles that are asked at once.
typedef struct Four {
    uint32_t triangles[CLOSEST_FOUR];
    uint32_t count;
    PercaleFourClosest closest;
} Four;

/// The same for the first alone.
static void ask_one(const PercaleSurface *surface, Vec3 point, Four *four)
{
    Vec3 c[3];
    corners_of(surface, four->triangles[0], c);
    PercaleClosest closest = percale_closest_on_triangle(point, c[0], c[1], c[2]);
    four->closest.distance2[0] = closest.distance2;
    four->closest.region[0] = (int64_t)closest.region;
    for (int k = 0; k < 3; k++) {
        four->closest.weights[k][0] = closest.weights[k];
    }
}

static void ask_four(const PercaleSurface *surface, Vec3 point, Four *four)
{
    if (four->count == 1) {
        ask_one(surface, point, four);
        return;
    }
    f32x4 corners[3][CLOSEST_FOUR];
    for (uint32_t i = 0; i < CLOSEST_FOUR; i++) {
        uint32_t triangle = four->triangles[i < four->count ? i : 0];
        const uint32_t *indices = surface->mesh->triangles + 3 * (size_t)triangle;
        for (int k = 0; k < 3; k++) {
            corners[k][i] = surface->points[indices[k]];
        }
    }
    percale_closest_on_four(point, (const f32x4(*)[CLOSEST_FOUR])corners, &four->closest);
}

/// Keeps the nearest; of what is not kept, how near it is.
static void keep_nearest(const PercaleSurface *surface, Vec3 point, Four *four, PercaleNearest *best,
                         double *beyond2)
{
    ask_four(surface, point, four);
    for (uint32_t i = 0; i < four->count; i++) {
        double distance2 = four->closest.distance2[i];
        uint32_t triangle = four->triangles[i];
        *beyond2 = distance2 < *beyond2 ? distance2 : *beyond2;
        if (distance2 < best->closest.distance2 ||
            (distance2 <= best->closest.distance2 && triangle < best->triangle)) {
            best->closest = one_of_four(&four->closest, i);
            best->triangle = triangle;
        }
    }
    four->count = 0;
}

/// How far the point is from its place in float32, which the boxes are compared with, m.
static double rounding_of(Vec3 point, f32x4 at)
{
    return vlength(vsub(point, vec3_of(at)));
}

static float box_limit(double distance2, double rounding)
{
    double distance = rounding > 0.0 ? sqrt(distance2) + rounding : 0.0;
    double limit = (rounding > 0.0 ? distance * distance : distance2) * (1.0 + (double)BOX_SLACK);
    return limit < (double)FLT_MAX ? (float)limit : FLT_MAX; // an absent child is infinitely far
}

/// The smaller of two by lane, where the second is beyond the limit.
static f32x8 least_beyond(f32x8 least, f32x8 distance2, float limit)
{
    i32x8 smaller = greater8(distance2, all8(limit)) & greater8(least, distance2);
    return (f32x8)(((i32x8)distance2 & smaller) | ((i32x8)least & ~smaller));
}

/// Of boxes at these squared distances, one that nothing in them is nearer than.
static double box_bound(f32x8 distance2, double rounding)
{
    float least = INFINITY;
    for (int k = 0; k < TREE_WIDTH; k++) {
        least = distance2[k] < least ? distance2[k] : least;
    }
    double distance = sqrt((double)least * (1.0 - (double)BOX_SLACK)) - rounding;
    return distance > 0.0 ? distance * distance : 0.0;
}

/// Pushes the children within the limit, the farthest first, so that the nearest is popped next.
static uint32_t push_near_children(PercaleTreeEntry *stack, uint32_t size, PercaleTreeEntry entry,
                                   f32x8 distance2, float limit)
{
    uint32_t chosen[TREE_WIDTH];
    uint32_t count = 0;
    for (uint32_t bits = lane_bits(at_most8(distance2, all8((float)limit))); bits != 0; bits &= bits - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(bits);
        uint32_t at = count++;
        for (; at > 0 && distance2[chosen[at - 1]] < distance2[k]; at--) {
            chosen[at] = chosen[at - 1];
        }
        chosen[at] = k;
    }
    for (uint32_t i = 0; i < count; i++) {
        stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + chosen[i]};
    }
    return size;
}

/// Nothing yet, and nothing beyond the radius is wanted.
static PercaleNearest none_within(double radius)
{
    return (PercaleNearest){NO_TRIANGLE, {radius * radius, {0.0, 0.0, 0.0}, REGION_FACE}, {0.0, 0.0, 0.0}};
}

/// With the foot; when nothing was found, with a bound of how far everything is.
static PercaleNearest finished(const PercaleSurface *surface, PercaleNearest best, double beyond2)
{
    if (best.triangle != NO_TRIANGLE) {
        best.foot = percale_surface_point(surface, best.triangle, best.closest.weights);
    } else {
        best.closest.distance2 = fmax(best.closest.distance2, beyond2);
    }
    return best;
}

PercaleNearest percale_surface_nearest(const PercaleSurface *surface, Vec3 point, double radius,
                                       uint32_t seed)
{
    const PercaleTree *tree = surface->tree;
    f32x4 at = f32x4_of(point, 0.0f);
    double rounding = rounding_of(point, at);
    PercaleNearest best = none_within(radius);
    f32x8 boxes_beyond2 = all8(INFINITY); // squared distances of boxes not looked into, and of triangles
    double beyond2 = HUGE_VAL;
    Four four = {.triangles = {seed}, .count = 1};
    if (seed != NO_TRIANGLE) {
        keep_nearest(surface, point, &four, &best, &beyond2);
    }
    four.count = 0;
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    stack[size++] = tree_root(tree);
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        f32x8 distance2 = tree_box_distance2(tree_node(tree, entry), at);
        boxes_beyond2 = least_beyond(boxes_beyond2, distance2, box_limit(best.closest.distance2, rounding));
        if (entry.level > 0) {
            size = push_near_children(stack, size, entry, distance2,
                                      box_limit(best.closest.distance2, rounding));
            continue;
        }
        float limit = box_limit(best.closest.distance2, rounding);
        for (uint32_t bits = lane_bits(at_most8(distance2, all8(limit))); bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            four.triangles[four.count++] = tree->order[TREE_WIDTH * entry.node + k];
            if (four.count == CLOSEST_FOUR || (bits & (bits - 1)) == 0) {
                keep_nearest(surface, point, &four, &best, &beyond2);
            }
        }
    }
    return finished(surface, best, fmin(beyond2, box_bound(boxes_beyond2, rounding)));
}

PercaleNearest percale_surface_nearest_of(const PercaleSurface *surface, Vec3 point, double radius,
                                          const uint32_t *triangles, uint32_t count)
{
    PercaleNearest best = none_within(radius);
    double beyond2 = HUGE_VAL;
    Four four = {.count = 0};
    for (uint32_t i = 0; i < count; i++) {
        four.triangles[four.count++] = triangles[i];
        if (four.count == CLOSEST_FOUR || i + 1 == count) {
            keep_nearest(surface, point, &four, &best, &beyond2);
        }
    }
    return finished(surface, best, beyond2);
}

/// Appends those that are near enough.
static bool append_near(const PercaleSurface *surface, Vec3 point, double radius2, Four *four,
                        PercaleMemory *memory, PercaleFeatureList *list)
{
    if (four->count == 0) {
        return true;
    }
    if (!percale_memory_reserve(memory, &list->items, &list->capacity, list->count + CLOSEST_FOUR,
                                sizeof(list->items[0]))) {
        return false;
    }
    ask_four(surface, point, four);
    for (uint32_t i = 0; i < four->count; i++) {
        if (four->closest.distance2[i] <= radius2) {
            list->items[list->count++] = (PercaleFeature){four->triangles[i], one_of_four(&four->closest, i)};
        }
    }
    four->count = 0;
    return true;
}

bool percale_surface_gather(const PercaleSurface *surface, Vec3 point, double radius, PercaleMemory *memory,
                            PercaleFeatureList *list)
{
    const PercaleTree *tree = surface->tree;
    f32x4 at = f32x4_of(point, 0.0f);
    double radius2 = radius * radius;
    float limit = box_limit(radius2, rounding_of(point, at));
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    stack[size++] = tree_root(tree);
    list->count = 0;
    Four four = {.count = 0};
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        f32x8 distance2 = tree_box_distance2(tree_node(tree, entry), at);
        for (uint32_t bits = lane_bits(at_most8(distance2, all8(limit))); bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            if (entry.level > 0) {
                stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + k};
                continue;
            }
            four.triangles[four.count++] = tree->order[TREE_WIDTH * entry.node + k];
            if (four.count == CLOSEST_FOUR && !append_near(surface, point, radius2, &four, memory, list)) {
                return false;
            }
        }
    }
    return append_near(surface, point, radius2, &four, memory, list);
}

bool percale_surface_gather_of(const PercaleSurface *surface, Vec3 point, double radius,
                               const uint32_t *triangles, uint32_t count, PercaleMemory *memory,
                               PercaleFeatureList *list)
{
    Four four = {.count = 0};
    list->count = 0;
    for (uint32_t i = 0; i < count; i++) {
        four.triangles[four.count++] = triangles[i];
        if (four.count == CLOSEST_FOUR &&
            !append_near(surface, point, radius * radius, &four, memory, list)) {
            return false;
        }
    }
    return append_near(surface, point, radius * radius, &four, memory, list);
}

// ---- features ----

static uint32_t edge_of(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region)
{
    return surface->mesh->edges.edge_of_side[3 * (size_t)triangle + (uint32_t)(region - REGION_SIDE_0)];
}

static uint32_t vertex_of(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region)
{
    return surface->mesh->triangles[3 * (size_t)triangle + (uint32_t)(region - REGION_CORNER_0)] -
           surface->mesh->first_point;
}

uint32_t percale_surface_face_count(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region)
{
    const PercaleModelSurface *mesh = surface->mesh;
    if (region == REGION_FACE) {
        return 1;
    }
    if (region < REGION_CORNER_0) {
        uint32_t edge = edge_of(surface, triangle, region);
        return mesh->edges.first_side[edge + 1] - mesh->edges.first_side[edge];
    }
    uint32_t vertex = vertex_of(surface, triangle, region);
    return mesh->vertex_first_face[vertex + 1] - mesh->vertex_first_face[vertex];
}

uint64_t percale_surface_feature_key(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region)
{
    if (region == REGION_FACE) {
        return triangle;
    }
    if (region < REGION_CORNER_0) {
        return (uint64_t)1 << 62 | edge_of(surface, triangle, region);
    }
    return (uint64_t)2 << 62 | vertex_of(surface, triangle, region);
}

void percale_surface_sort(const PercaleSurface *surface, PercaleFeatureList *list)
{
    for (size_t i = 1; i < list->count; i++) { // short lists, nearly always below ten
        PercaleFeature item = list->items[i];
        uint64_t key = percale_surface_feature_key(surface, item.triangle, item.closest.region);
        size_t at = i;
        for (; at > 0; at--) {
            const PercaleFeature *before = &list->items[at - 1];
            uint64_t other = percale_surface_feature_key(surface, before->triangle, before->closest.region);
            if (other < key || (other == key && before->triangle < item.triangle)) {
                break;
            }
            list->items[at] = *before;
        }
        list->items[at] = item;
    }
}

static Vec3 area_normal(const PercaleSurface *surface, uint32_t triangle)
{
    Vec3 c[3];
    corners_of(surface, triangle, c);
    return vcross(vsub(c[1], c[0]), vsub(c[2], c[0]));
}

Vec3 percale_surface_face_normal(const PercaleSurface *surface, uint32_t triangle)
{
    return surface->normals != NULL ? surface->normals[triangle] : vunit(area_normal(surface, triangle));
}

/// Interior angle of a triangle at its corner, rad. acos would do; atan2 keeps its digits for thin triangles.
static double corner_angle(const PercaleSurface *surface, uint32_t triangle, uint32_t vertex)
{
    Vec3 c[3];
    corners_of(surface, triangle, c);
    const uint32_t *indices = surface->mesh->triangles + 3 * (size_t)triangle;
    uint32_t k = indices[0] == vertex ? 0 : indices[1] == vertex ? 1 : 2;
    Vec3 u = vsub(c[next_corner(k)], c[k]);
    Vec3 v = vsub(c[next_corner(next_corner(k))], c[k]);
    return atan2(vlength(vcross(u, v)), vdot(u, v));
}

static Vec3 vertex_normal(const PercaleSurface *surface, uint32_t vertex)
{
    const PercaleModelSurface *mesh = surface->mesh;
    Vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = mesh->vertex_first_face[vertex]; i < mesh->vertex_first_face[vertex + 1]; i++) {
        uint32_t face = mesh->vertex_faces[i];
        double angle = corner_angle(surface, face, mesh->first_point + vertex);
        sum = vadd(sum, vscale(angle, percale_surface_face_normal(surface, face)));
    }
    return vunit(sum);
}

Vec3 percale_surface_normal(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region)
{
    if (region == REGION_FACE) {
        return percale_surface_face_normal(surface, triangle);
    }
    if (region >= REGION_CORNER_0) {
        return vertex_normal(surface, vertex_of(surface, triangle, region));
    }
    const PercaleEdges *edges = &surface->mesh->edges;
    uint32_t edge = edge_of(surface, triangle, region);
    Vec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = edges->first_side[edge]; i < edges->first_side[edge + 1]; i++) {
        sum = vadd(sum, percale_surface_face_normal(surface, edges->sides[i] / 3));
    }
    return vunit(sum);
}

int percale_surface_side(const PercaleSurface *surface, Vec3 point, const PercaleNearest *nearest)
{
    Vec3 normal = percale_surface_normal(surface, nearest->triangle, nearest->closest.region);
    return vdot(normal, vsub(point, nearest->foot)) >= 0.0 ? 1 : -1;
}

bool percale_surface_on_rim(const PercaleSurface *surface, uint32_t triangle, PercaleRegion region)
{
    const PercaleModelSurface *mesh = surface->mesh;
    if (mesh->closed || region == REGION_FACE) {
        return false;
    }
    if (region < REGION_CORNER_0) {
        return percale_surface_face_count(surface, triangle, region) == 1;
    }
    uint32_t vertex = vertex_of(surface, triangle, region);
    for (uint32_t i = mesh->vertex_first_face[vertex]; i < mesh->vertex_first_face[vertex + 1]; i++) {
        uint32_t face = mesh->vertex_faces[i];
        for (uint32_t side = 0; side < 3; side++) {
            bool touches =
                mesh->triangles[3 * (size_t)face + side] == mesh->first_point + vertex ||
                mesh->triangles[3 * (size_t)face + next_corner(side)] == mesh->first_point + vertex;
            if (touches &&
                percale_surface_face_count(surface, face, (PercaleRegion)(REGION_SIDE_0 + side)) == 1) {
                return true;
            }
        }
    }
    return false;
}

// ---- crossing ----

/// A path seen along itself (Woop et al. 2013): the axes permuted so that it runs mainly along the last, then
/// sheared until it does so entirely. Each point of the mesh has one place in this view, and two rounded
/// products keep their order, so the sign of a side is never wrong and triangles around a vertex leave no
/// gap.
typedef struct PathView {
    Vec3 origin;
    int across[2], forward; // axes
    double shear[2];
} PathView;

static double component(Vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static PathView view_along(Vec3 a, Vec3 b)
{
    Vec3 along = vsub(b, a);
    PathView view = {a, {0, 1}, 2, {0.0, 0.0}};
    for (int axis = 0; axis < 2; axis++) {
        if (fabs(component(along, axis)) > fabs(component(along, view.forward))) {
            view.forward = axis;
        }
    }
    double depth = component(along, view.forward);
    int turned = depth < 0.0; // seen from the other end, left and right change places
    view.across[turned] = (view.forward + 1) % 3;
    view.across[1 - turned] = (view.forward + 2) % 3;
    for (int k = 0; k < 2 && depth != 0.0; k++) {
        view.shear[k] = component(along, view.across[k]) / depth;
    }
    return view;
}

static void look_at(const PathView *view, Vec3 point, double place[2])
{
    Vec3 offset = vsub(point, view->origin);
    for (int k = 0; k < 2; k++) {
        place[k] = component(offset, view->across[k]) - view->shear[k] * component(offset, view->forward);
    }
}

static void keep_earlier(const PercaleSurface *surface, Vec3 a, Vec3 b, const PathView *view,
                         uint32_t triangle, PercaleCrossing *best)
{
    Vec3 c[3];
    corners_of(surface, triangle, c);
    Vec3 normal = vcross(vsub(c[1], c[0]), vsub(c[2], c[0]));
    double before = vdot(normal, vsub(a, c[0]));
    double after = vdot(normal, vsub(b, c[0]));
    if (!(before >= 0.0 && after < 0.0)) {
        return;
    }
    double place[3][2];
    for (int k = 0; k < 3; k++) {
        look_at(view, c[k], place[k]);
    }
    double w[3]; // all <= 0 for a path against the normal through the inside
    for (int k = 0; k < 3; k++) {
        const double *p = place[(k + 1) % 3];
        const double *q = place[(k + 2) % 3];
        w[k] = p[0] * q[1] - p[1] * q[0];
        if (w[k] > 0.0) {
            return;
        }
    }
    double sum = w[0] + w[1] + w[2];
    double time = before / (before - after);
    if (sum < 0.0 && (best->triangle == NO_TRIANGLE || time < best->time ||
                      (time <= best->time && triangle < best->triangle))) {
        *best = (PercaleCrossing){triangle, time, {w[0] / sum, w[1] / sum, w[2] / sum}};
    }
}

PercaleCrossing percale_surface_first_crossing(const PercaleSurface *surface, Vec3 a, Vec3 b)
{
    const PercaleTree *tree = surface->tree;
    f32x4 from = f32x4_of(a, 0.0f);
    f32x4 to = f32x4_of(b, 0.0f);
    f32x4 low = {0};
    f32x4 high = {0};
    for (int axis = 0; axis < 3; axis++) {
        float l = from[axis] < to[axis] ? from[axis] : to[axis];
        float h = from[axis] < to[axis] ? to[axis] : from[axis];
        float slack = BOX_SLACK * (fabsf(l) + fabsf(h)); // the ends were rounded to float
        low[axis] = l - slack;
        high[axis] = h + slack;
    }
    PathView view = view_along(a, b);
    PercaleCrossing best = NO_CROSSING;
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    stack[size++] = tree_root(tree);
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        for (uint32_t bits = lane_bits(tree_box_overlaps(tree_node(tree, entry), low, high)); bits != 0;
             bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            if (entry.level > 0) {
                stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + k};
            } else {
                keep_earlier(surface, a, b, &view, tree->order[TREE_WIDTH * entry.node + k], &best);
            }
        }
    }
    return best;
}
