#include "detect/swept.h"

#include "detect/impact_time.h"

#include <string.h>

// Share of the thickness by which a vertex that starts on the surface is taken to start above it.
static const double STARTS_ABOVE = 1e-3;

static Vec3 area_of(Vec3 a, Vec3 b, Vec3 c)
{
    return vcross(vsub(b, a), vsub(c, a));
}

/// The triangle's area, as a vector along its normal, on the way.
static Vec3 area_at(const Vec3 from[4], const Vec3 to[4], double time)
{
    Vec3 x[3];
    for (int k = 0; k < 3; k++) {
        x[k] = vadd(vscale(1.0 - time, from[1 + k]), vscale(time, to[1 + k]));
    }
    return area_of(x[0], x[1], x[2]);
}

/// On a closed surface is in front of it.
static void start_above(bool closed, double above, Vec3 from[4])
{
    Vec3 normal = vunit(area_of(from[1], from[2], from[3]));
    bool in_front = closed || vdot(normal, vsub(from[0], from[1])) >= 0.0;
    from[0] = vadd(from[0], vscale(in_front ? above : -above, normal));
}

/// Whether the vertex may have touched the triangle, coming from its front. At an edge or a corner one of the
/// triangles around it says so: what comes from in front of a fold is in front of one of its faces.
static bool meets_front(bool closed, double above, Vec3 from[4], const Vec3 to[4], PercaleImpact *impact)
{
    if (!percale_vertex_face_impact_time(from, to, 0.0, impact)) {
        return false;
    }
    if (!(impact->time > 0.0)) {
        start_above(closed, above, from);
        if (!percale_vertex_face_impact_time(from, to, 0.0, impact)) {
            return false;
        }
    }
    return !(vdot(impact->normal, area_at(from, to, impact->time)) < 0.0); // without a normal, too
}

static void keep_earlier(const PercalePair *pair, uint32_t slot, uint32_t triangle, PercaleCrossing *best)
{
    const PercaleModel *model = pair->model;
    const uint32_t *corners = pair->obstacle->triangles + 3 * (size_t)triangle;
    Vec3 from[4];
    Vec3 to[4];
    for (int k = 0; k < 4; k++) {
        uint32_t point = k == 0 ? slot : corners[k - 1];
        from[k] = vec3_of(model->position[point]);
        to[k] = vec3_of(model->predicted[point]);
    }
    PercaleImpact impact;
    double above = STARTS_ABOVE * (double)pair_thickness(pair, slot);
    if (!meets_front(pair->obstacle->closed, above, from, to, &impact)) {
        return;
    }
    if (best->triangle == NO_TRIANGLE || impact.time < best->time ||
        (impact.time <= best->time && triangle < best->triangle)) {
        *best = (PercaleCrossing){
            triangle, impact.time, {-impact.weights[1], -impact.weights[2], -impact.weights[3]}};
    }
}

PercaleCrossing percale_swept_crossing(const PercalePair *pair, const PercaleProximity *proximity,
                                       uint32_t slot)
{
    const PercaleTree *tree = swept_tree(proximity);
    f32x4 low = min4(pair->model->position[slot], pair->model->predicted[slot]);
    f32x4 high = max4(pair->model->position[slot], pair->model->predicted[slot]);
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
                keep_earlier(pair, slot, tree->order[TREE_WIDTH * entry.node + k], &best);
            }
        }
    }
    return best;
}
