#include "untangle/push.h"

// Least |mean cosine| of the two surfaces' normals along a contour with which one part's side tells the
// other's: surfaces that stand on each other have nothing to say
static const double ALIKE = 0.3;

// Way of a point in one round, lengths of its edges, where its surface stands on the other: what hangs on it
// has to follow. Surfaces that lie on each other change sides at once, for half way they would be one.
static const double PUSH_STEP = 1.0;
static const double LIES_ON = 0.5; // |cosine| of the normals from which they do

enum { RINGS_BEYOND = 3 }; // around the other trace, more than the region is deep

/// A contour that is being pushed apart.
typedef struct Push {
    PercaleTangleStage *stage;
    uint32_t contour;
    const PercaleContour *items;
    double alike; // mean cosine of the turned normals
} Push;

// ---- sides ----

/// Sum of the signs with which the ends of the trace's edges on `side` lie before or behind the other
/// surface.
static int side_of_region(const Push *push, uint32_t trace, uint32_t side)
{
    const PercaleTangleStage *stage = push->stage;
    int sum = 0;
    for (uint32_t i = 0; i < push->items->count; i++) {
        const PercaleContourStep *step = &stage->contours->steps[push->items->first + i];
        if (step->trace != trace) {
            continue;
        }
        const PercaleTangleCrossing *crossing = &stage->crossings->items[step->crossing];
        const uint32_t *ends = stage->mesh->edges.vertices[crossing->edge];
        Vec3 left = vsub(vec3_of(stage->x[ends[step->left]]), vec3_of(stage->x[ends[1 - step->left]]));
        bool is_before = vdot(left, turned_normal(stage->mesh, stage->x, crossing->face)) > 0.0;
        sum += is_before == (side == SIDE_LEFT) ? 1 : -1;
    }
    return sum;
}

static double mean_likeness(const PercaleTangleStage *stage, const PercaleContour *contour)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < contour->count; i++) {
        const PercaleContourStep *step = &stage->contours->steps[contour->first + i];
        const PercaleTangleCrossing *crossing = &stage->crossings->items[step->crossing];
        uint32_t own = step->before != NO_INDEX ? step->before : step->after;
        sum += vdot(turned_normal(stage->mesh, stage->x, own),
                    turned_normal(stage->mesh, stage->x, crossing->face));
    }
    return sum / contour->count;
}

/// Which side of the trace is wrong because of what the other surface is: behind an obstacle, or behind a
/// cloth of a lower layer; SIDE_SMALLER: nothing says so.
static uint32_t given_side(const Push *push, uint32_t trace)
{
    const PercaleTangleMesh *mesh = push->stage->mesh;
    const PercaleTangleObject *own = object_of_triangle(mesh, push->items->triangles[trace]);
    const PercaleTangleObject *other = object_of_triangle(mesh, push->items->triangles[1 - trace]);
    int behind = 0;
    if (other->is_obstacle || (!own->is_obstacle && other->rank < own->rank)) {
        behind = -1;
    } else if (own->is_obstacle || own->rank < other->rank) {
        behind = 1; // seen from the lower one, what is before the upper one is wrong
    }
    if (behind == 0) {
        return SIDE_SMALLER;
    }
    int left = side_of_region(push, trace, SIDE_LEFT);
    return left * behind > 0 ? SIDE_LEFT : left * behind < 0 ? SIDE_RIGHT : SIDE_SMALLER;
}

// ---- the other surface's patch ----

static void label_seed(PercaleTangleStage *stage, uint32_t point, uint32_t label, uint32_t *end)
{
    if (stage->labels[point] / 2 != stage->epoch) {
        stage->labels[point] = label;
        stage->queue[(*end)++] = point;
    }
}

/// Labels the points within some rings of the two traces with the nearer one: 2 * epoch + trace. Returns
/// their number; they are in the queue.
static uint32_t label_patches(const Push *push, uint32_t rings)
{
    PercaleTangleStage *stage = push->stage;
    const PercaleTangleMesh *mesh = stage->mesh;
    uint32_t begin = 0;
    uint32_t end = 0;
    stage->epoch++;
    for (uint32_t i = 0; i < push->items->count; i++) {
        const PercaleContourStep *step = &stage->contours->steps[push->items->first + i];
        const PercaleTangleCrossing *crossing = &stage->crossings->items[step->crossing];
        for (uint32_t k = 0; k < 2; k++) {
            label_seed(stage, mesh->edges.vertices[crossing->edge][k], 2 * stage->epoch + step->trace, &end);
        }
        for (uint32_t k = 0; k < 3; k++) {
            label_seed(stage, corners_of_triangle(mesh, crossing->face)[k],
                       2 * stage->epoch + 1 - step->trace, &end);
        }
    }
    for (uint32_t ring = 0; ring < rings && begin < end; ring++) {
        for (uint32_t ring_end = end; begin < ring_end; begin++) {
            uint32_t point = stage->queue[begin];
            for (uint32_t i = mesh->first_edge[point]; i < mesh->first_edge[point + 1]; i++) {
                const uint32_t *ends = mesh->edges.vertices[mesh->point_edges[i]];
                label_seed(stage, ends[0] == point ? ends[1] : ends[0], stage->labels[point], &end);
            }
        }
    }
    return end;
}

/// Edges from the trace to the farthest point, about: a region of n points is no wider than twice that of a
/// round one.
static uint32_t rings_of(const PercaleTangleRegion *region, uint32_t steps)
{
    double round = sqrt((double)region->count);
    double most = fmax(round, (double)region->count / (double)(steps + 1));
    return (uint32_t)most + RINGS_BEYOND;
}

// ---- stencils ----

static bool is_on_boundary(const PercaleTangleMesh *mesh, const PercaleNearestFace *nearest)
{
    uint32_t side = NO_INDEX;
    switch (nearest->closest.region) {
    case REGION_FACE:
    case REGION_CORNER_0:
    case REGION_CORNER_1:
    case REGION_CORNER_2:
        break;
    case REGION_SIDE_0:
        side = 0;
        break;
    case REGION_SIDE_1:
        side = 1;
        break;
    case REGION_SIDE_2:
        side = 2;
        break;
    }
    return side != NO_INDEX &&
           triangle_beyond(mesh, mesh->edges.edge_of_side[3 * (size_t)nearest->face + side], nearest->face) ==
               NO_INDEX;
}

/// Mean length of the edges around a point when the untangling began, m.
static double edge_length_at(const PercaleTangleStage *stage, uint32_t point)
{
    const PercaleTangleMesh *mesh = stage->mesh;
    double sum = 0.0;
    for (uint32_t i = mesh->first_edge[point]; i < mesh->first_edge[point + 1]; i++) {
        sum += (double)stage->edge_lengths[mesh->point_edges[i]];
    }
    uint32_t count = mesh->first_edge[point + 1] - mesh->first_edge[point];
    return count > 0 ? sum / count : 0.0;
}

/// Normal of the surface around a point, as its piece of cloth is turned; zero for an obstacle's.
static Vec3 normal_at(const PercaleTangleStage *stage, uint32_t point)
{
    const PercaleModel *model = stage->mesh->model;
    Vec3 sum = vec3(0.0, 0.0, 0.0);
    if (point < model->slot_count) {
        for (uint32_t i = model->cloth.vertex_first_face[point];
             i < model->cloth.vertex_first_face[point + 1]; i++) {
            sum = vadd(sum, turned_normal(stage->mesh, stage->x, model->cloth.vertex_faces[i]));
        }
    }
    return vunit(sum);
}

/// wrong: +1 when what is before the face (as turned) is wrong, else -1.
static bool push_point(const Push *push, uint32_t point, uint32_t own_face, const PercaleNearestFace *nearest,
                       int wrong)
{
    PercaleTangleStage *stage = push->stage;
    Vec3 normal = turned_normal(stage->mesh, stage->x, nearest->face);
    Vec3 offset = vsub(vec3_of(stage->x[point]), nearest->foot);
    double before = vdot(offset, normal);
    double distance = distance_between(stage->mesh, own_face, nearest->face);
    bool is_wrong = before * wrong > 0.0;
    const uint32_t *corners = corners_of_triangle(stage->mesh, nearest->face);
    bool is_own = corners[0] == point || corners[1] == point || corners[2] == point;
    if (is_own || (!is_wrong && vlength(offset) > distance) || is_on_boundary(stage->mesh, nearest)) {
        return true;
    }
    Vec3 direction = vscale(-wrong, normal);
    bool has_own = nearest->closest.region != REGION_FACE && vlength(offset) > 0.1 * distance;
    if (has_own) { // beside the face: the closest points' own direction
        direction = vscale(is_wrong ? -1.0 : 1.0, vunit(offset));
    }
    double now = vdot(direction, offset);
    bool lies_on = fabs(vdot(normal_at(stage, point), normal)) > LIES_ON;
    double reach = lies_on ? distance : now + PUSH_STEP * edge_length_at(stage, point);
    return percale_add_tangle_stencil(stage, point, nearest->face, nearest->closest.weights, direction,
                                      fmin(distance, reach));
}

/// Nothing holds the region on this side of the patch.
static void release_region(const Push *push, const PercaleTangleRegion *region, uint32_t patch_label,
                           uint32_t label_count)
{
    PercaleTangleStage *stage = push->stage;
    uint32_t bit = 1U << push->contour % RELEASE_BITS;
    for (uint32_t i = 0; i < region->count; i++) {
        bool is_other = stage->labels[region->points[i]] == patch_label;
        stage->releases.wrong[region->points[i]] |= is_other ? 0 : bit;
    }
    for (uint32_t i = 0; i < label_count; i++) {
        bool is_other = stage->labels[stage->queue[i]] == patch_label;
        stage->releases.others[stage->queue[i]] |= is_other ? bit : 0;
    }
}

/// The region of one trace against the patch of the other.
static bool push_points(const Push *push, uint32_t trace, const PercaleTangleRegion *region)
{
    PercaleTangleStage *stage = push->stage;
    uint32_t own_face = push->items->triangles[trace];
    uint32_t other_face = push->items->triangles[1 - trace];
    bool is_obstacle = object_of_triangle(stage->mesh, other_face)->is_obstacle;
    int wrong = side_of_region(push, trace, region->side) > 0 ? 1 : -1;
    uint32_t label_count = label_patches(push, rings_of(region, push->items->count));
    PercaleFaceChoice choice = {stage->labels, 2 * stage->epoch + 1 - trace, NO_INDEX};
    release_region(push, region, choice.label, label_count);
    bool is_shared = is_folded(push->items) || push->items->is_joined;
    bool complete = true;
    for (uint32_t i = 0; complete && i < region->count; i++) {
        uint32_t point = region->points[i];
        if (is_shared && stage->labels[point] != 2 * stage->epoch + trace) {
            continue; // it belongs to the other trace
        }
        PercaleNearestFace nearest =
            percale_nearest_face(stage->search, is_obstacle, stage->x, vec3_of(stage->x[point]), &choice);
        complete = nearest.face == NO_INDEX || push_point(push, point, own_face, &nearest, wrong);
    }
    return complete;
}

/// The other trace's side that moves the surfaces the same way; SIDE_SMALLER: can't be told.
static uint32_t matching_side(const Push *push, uint32_t trace, uint32_t side)
{
    if (fabs(push->alike) < ALIKE) {
        return SIDE_SMALLER;
    }
    int wrong = side_of_region(push, trace, side);
    int left = side_of_region(push, 1 - trace, SIDE_LEFT);
    bool left_matches = wrong * left * (push->alike > 0.0 ? 1 : -1) < 0;
    return wrong == 0 || left == 0 ? SIDE_SMALLER : left_matches ? SIDE_LEFT : SIDE_RIGHT;
}

bool percale_push_region(PercaleTangleStage *stage, uint32_t contour, bool *pushed)
{
    Push push = {stage, contour, &stage->contours->items[contour], 0.0};
    push.alike = mean_likeness(stage, push.items);
    PercaleTangleRegion found[2];
    for (uint32_t trace = 0; trace < 2; trace++) {
        if (!percale_region_find(stage->flood, contour, trace, given_side(&push, trace), stage->memory,
                                 &found[trace])) {
            return false;
        }
    }
    *pushed = found[0].is_cut_off || found[1].is_cut_off;
    if (!*pushed) {
        return true;
    }
    uint32_t first = !found[0].is_cut_off || (found[1].is_cut_off && found[1].area < found[0].area) ? 1 : 0;
    PercaleTangleRegion region;
    bool complete =
        percale_region_find(stage->flood, contour, first, found[first].side, stage->memory, &region) &&
        push_points(&push, first, &region);
    if (complete &&
        is_folded(push.items)) { // one region, behind the fold on the other side of the other trace
        region.side = 1 - region.side;
        return push_points(&push, 1 - first, &region);
    }
    uint32_t side = matching_side(&push, first, region.side);
    if (!complete || side == SIDE_SMALLER || !found[1 - first].is_cut_off) {
        return complete;
    }
    return percale_region_find(stage->flood, contour, 1 - first, side, stage->memory, &region) &&
           (!region.is_cut_off || push_points(&push, 1 - first, &region));
}
