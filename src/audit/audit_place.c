// Where a point is: the winding number by exact signed crossings of a ray, the nearest point of the surface
// by the tree, and its side by pseudonormals.

#include <math.h>

#include "audit/audit_exact.h"
#include "audit/audit_surface.h"
#include "audit/audit_vector.h"

// m; nearer than this is on the surface, hence not inside: above the rounding of a distance in double between
// points some metres from the origin.
static const double ON_SURFACE = 1e-12;
// Squared sine of the angle below which a triangle is taken as its edges, because its normal is rounding.
static const double NO_AREA = 1e-20;

typedef enum Feature { CORNER = 0, EDGE, FACE } Feature;

typedef struct Nearest {
    double squared;   // m^2
    double offset[3]; // m, from the surface to the point
    uint32_t triangle;
    Feature feature;
    uint32_t feature_corner; // the corner, or where the edge starts
} Nearest;

// How often the triangle winds around the ray's axis: 1, -1 or 0. The ray is thought to lie an infinitesimal
// step to greater y and z, so that it meets no edge and no vertex, and neighbours agree on whose it is.
static int turns_around(const float *const corners[3], const float point[3])
{
    int turns = 0;
    for (size_t k = 0; k < 3; k++) {
        const float *from = corners[k];
        const float *to = corners[(k + 1) % 3];
        bool is_upward = to[2] > point[2];
        if (is_upward == (from[2] > point[2]))
            continue;
        int side = percale_audit_orient_yz(from, to, point);
        if (is_upward && side > 0)
            turns++;
        if (!is_upward && side < 0)
            turns--;
    }
    return turns;
}

static int winding_of_triangle(const PercaleAuditTree *tree, size_t triangle, const float point[3])
{
    const float *corners[3];
    for (size_t k = 0; k < 3; k++)
        corners[k] = percale_audit_corner(tree, triangle, k);
    int turns = turns_around(corners, point);
    if (turns == 0)
        return 0;
    bool is_ahead = turns * percale_audit_orient(corners[0], corners[1], corners[2], point) > 0;
    return is_ahead ? turns : 0;
}

// Signed crossings of the ray towards greater x. For a closed surface this is the winding number itself (the
// sum of the solid angles over 4 pi), so nothing needs to be approximated far away.
static int winding_number(const PercaleAuditTree *tree, const float point[3])
{
    uint32_t stack[PERCALE_AUDIT_STACK];
    size_t waiting = 0;
    int winding = 0;
    stack[waiting++] = 0;
    while (waiting > 0) {
        uint32_t index = stack[--waiting];
        const PercaleAuditNode *node = &tree->nodes[index];
        if (point[0] > node->high[0] || point[1] < node->low[1] || point[1] > node->high[1] ||
            point[2] < node->low[2] || point[2] > node->high[2])
            continue;
        for (size_t i = 0; i < node->count; i++)
            winding += winding_of_triangle(tree, node->first + i, point);
        if (node->count == 0) {
            stack[waiting++] = node->first;
            stack[waiting++] = index + 1;
        }
    }
    return winding;
}

static void offer(Nearest *nearest, const double offset[3], uint32_t triangle, Feature feature, size_t corner)
{
    double squared = dot(offset, offset);
    if (squared > nearest->squared || (squared == nearest->squared && nearest->triangle != PERCALE_AUDIT_RIM))
        return;
    nearest->squared = squared;
    for (size_t axis = 0; axis < 3; axis++)
        nearest->offset[axis] = offset[axis];
    nearest->triangle = triangle;
    nearest->feature = feature;
    nearest->feature_corner = (uint32_t)corner;
}

// Is the point above or below the inside of the triangle? Then its offset is along the normal.
static bool offset_from_face(double x[3][3], const double point[3], double offset[3])
{
    double edge[3][3];
    double normal[3];
    double away[3];
    for (size_t k = 0; k < 3; k++)
        subtract(x[(k + 1) % 3], x[k], edge[k]);
    cross(edge[0], edge[1], normal);
    double squared = dot(normal, normal);
    if (!(squared > NO_AREA * dot(edge[0], edge[0]) * dot(edge[1], edge[1])))
        return false;
    for (size_t k = 0; k < 3; k++) {
        double inward[3];
        cross(normal, edge[k], inward);
        subtract(point, x[k], away);
        if (!(dot(inward, away) > 0.0))
            return false;
    }
    double scale = dot(normal, away) / squared;
    for (size_t axis = 0; axis < 3; axis++)
        offset[axis] = scale * normal[axis];
    return true;
}

static void offer_edge(Nearest *nearest, double x[3][3], const double point[3], uint32_t triangle,
                       size_t corner)
{
    size_t next = (corner + 1) % 3;
    double edge[3];
    double offset[3];
    subtract(x[next], x[corner], edge);
    subtract(point, x[corner], offset);
    double squared = dot(edge, edge);
    double along = squared > 0.0 ? dot(offset, edge) / squared : 0.0;
    if (along <= 0.0) {
        offer(nearest, offset, triangle, CORNER, corner);
        return;
    }
    if (along >= 1.0) {
        subtract(point, x[next], offset);
        offer(nearest, offset, triangle, CORNER, next);
        return;
    }
    for (size_t axis = 0; axis < 3; axis++)
        offset[axis] -= along * edge[axis];
    offer(nearest, offset, triangle, EDGE, corner);
}

static void offer_triangle(Nearest *nearest, const PercaleAuditTree *tree, size_t triangle,
                           const double point[3])
{
    double x[3][3];
    double offset[3];
    for (size_t k = 0; k < 3; k++)
        load_point(tree->positions, tree->corners[3 * triangle + k], x[k]);
    if (offset_from_face(x, point, offset)) {
        offer(nearest, offset, tree->triangles[triangle], FACE, 0);
        return;
    }
    for (size_t k = 0; k < 3; k++)
        offer_edge(nearest, x, point, tree->triangles[triangle], k);
}

static double squared_distance_to_box(const PercaleAuditNode *node, const double point[3])
{
    double squared = 0.0;
    for (size_t axis = 0; axis < 3; axis++) {
        double below = (double)node->low[axis] - point[axis];
        double above = point[axis] - (double)node->high[axis];
        double gap = below > above ? below : above;
        squared += gap > 0.0 ? gap * gap : 0.0;
    }
    return squared;
}

// The nearest place of the surface not farther than `reach`; false where there is none.
static bool find_nearest(const PercaleAuditTree *tree, const double point[3], double reach, Nearest *nearest)
{
    uint32_t stack[PERCALE_AUDIT_STACK];
    size_t waiting = 0;
    *nearest = (Nearest){.squared = reach * reach, .triangle = PERCALE_AUDIT_RIM};
    stack[waiting++] = 0;
    while (waiting > 0) {
        uint32_t index = stack[--waiting];
        const PercaleAuditNode *node = &tree->nodes[index];
        if (squared_distance_to_box(node, point) > nearest->squared)
            continue;
        for (size_t i = 0; i < node->count; i++)
            offer_triangle(nearest, tree, node->first + i, point);
        if (node->count > 0)
            continue;
        uint32_t near_child = index + 1;
        uint32_t far_child = node->first;
        if (squared_distance_to_box(&tree->nodes[far_child], point) <
            squared_distance_to_box(&tree->nodes[near_child], point)) {
            near_child = far_child;
            far_child = index + 1;
        }
        stack[waiting++] = far_child;
        stack[waiting++] = near_child;
    }
    return nearest->triangle != PERCALE_AUDIT_RIM;
}

static bool is_behind_corner(const PercaleAuditSurface *surface, const Nearest *nearest)
{
    uint32_t vertex = surface->mesh->triangles[3 * (size_t)nearest->triangle + nearest->feature_corner];
    return !surface->is_rim[vertex] &&
           dot(nearest->offset, surface->vertex_normals + 3 * (size_t)vertex) < 0.0;
}

static bool is_behind_edge(const PercaleAuditSurface *surface, const Nearest *nearest)
{
    uint32_t neighbour = surface->neighbours[3 * (size_t)nearest->triangle + nearest->feature_corner];
    if (neighbour == PERCALE_AUDIT_RIM)
        return false;
    return dot(nearest->offset, surface->face_normals + 3 * (size_t)nearest->triangle) +
               dot(nearest->offset, surface->face_normals + 3 * (size_t)neighbour) <
           0.0;
}

static bool is_behind(const PercaleAuditSurface *surface, const Nearest *nearest)
{
    switch (nearest->feature) {
    case CORNER:
        return is_behind_corner(surface, nearest);
    case EDGE:
        return is_behind_edge(surface, nearest);
    case FACE:
        break;
    }
    return dot(nearest->offset, surface->face_normals + 3 * (size_t)nearest->triangle) < 0.0;
}

PercaleAuditPlace percale_audit_place(const PercaleAuditSurface *surface, const float point[3], double reach)
{
    PercaleAuditPlace place = {.depth = 0.0, .distance = (double)INFINITY};
    if (surface->tree.node_count == 0)
        return place;
    bool is_inside = surface->is_closed && winding_number(&surface->tree, point) > 0;
    if (is_inside)
        reach = (double)INFINITY;
    else if (!surface->is_closed)
        reach = fmax(reach, PERCALE_AUDIT_OPEN_DEPTH);
    double x[3];
    load_point(point, 0, x);
    Nearest nearest;
    if (!find_nearest(&surface->tree, x, reach, &nearest))
        return place;
    place.distance = sqrt(nearest.squared);
    if (!surface->is_closed)
        is_inside = place.distance <= PERCALE_AUDIT_OPEN_DEPTH && is_behind(surface, &nearest);
    if (is_inside && place.distance > ON_SURFACE)
        place.depth = place.distance;
    return place;
}
