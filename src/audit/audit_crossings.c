// Pairs of triangles that cross. Two triangles cross when what they share is longer than a point and each
// goes through the other: it has corners strictly on both sides of the other's plane. So touching is not
// crossing, nor is lying in one plane, and a triangle without area crosses nothing. Decided exactly: no
// tolerance, no tie depends on an order.

#include "audit/audit.h"
#include "audit/audit_exact.h"
#include "audit/audit_vector.h"

#include <math.h>

typedef struct Crossings {
    const PercaleAuditTree *a;
    const PercaleAuditTree *b;
    const uint32_t *points_a; // welded points of a's vertices; NULL: nothing is shared
    const uint32_t *points_b;
    const uint8_t *is_sewn;
    uint64_t crossing_count;
    uint64_t seam_count;
    PercaleAuditCrossing here; // whose triangles these are
    PercaleAuditCrossing *deepest;
} Crossings;

static void load_corners(const PercaleAuditTree *tree, size_t triangle, const float *corners[3])
{
    for (size_t k = 0; k < 3; k++)
        corners[k] = percale_audit_corner(tree, triangle, k);
}

// Sides of b's corners of the plane of a. True: strictly on both sides.
static bool is_split(const float *const a[3], const float *const b[3], int sides[3])
{
    bool is_below = false;
    bool is_above = false;
    for (size_t k = 0; k < 3; k++) {
        sides[k] = percale_audit_orient(a[0], a[1], a[2], b[k]);
        is_below |= sides[k] > 0;
        is_above |= sides[k] < 0;
    }
    return is_below && is_above;
}

// The corner that the plane cuts off from the other two: both edges from it meet the plane.
static size_t cut_off_corner(const int sides[3])
{
    for (size_t k = 0; k < 2; k++) {
        if (sides[k] != 0 && sides[k] * sides[(k + 1) % 3] <= 0 && sides[k] * sides[(k + 2) % 3] <= 0)
            return k;
    }
    return 2;
}

// Both triangles cut the line in which the planes meet, each in an interval between the two edges from its
// cut-off corner. orient(p, q, r, s) orders where edge pq and edge rs meet the line, with one sign convention
// for all four couples (after Guigue and Devillers 2003): the intervals overlap in more than a point if and
// only if both orders occur.
static bool do_cross(const float *const a[3], const float *const b[3])
{
    int sides_a[3];
    int sides_b[3];
    if (!is_split(b, a, sides_a) || !is_split(a, b, sides_b))
        return false;
    size_t p = cut_off_corner(sides_a);
    size_t r = cut_off_corner(sides_b);
    bool is_before = false;
    bool is_after = false;
    for (size_t i = 1; i < 3; i++) {
        for (size_t j = 1; j < 3; j++) {
            int order = percale_audit_orient(a[p], a[(p + i) % 3], b[r], b[(r + j) % 3]);
            is_before |= order < 0;
            is_after |= order > 0;
        }
    }
    return is_before && is_after;
}

// Does the edge of a opposite to `corner_a` pierce b, which shares its `corner_b` with that corner of a?
// Along the two edges of b at the shared corner, meeting is touching.
static bool does_opposite_edge_pierce(const float *const a[3], size_t corner_a, const float *const b[3],
                                      size_t corner_b)
{
    const float *from = a[(corner_a + 1) % 3];
    const float *to = a[(corner_a + 2) % 3];
    if (percale_audit_orient(b[0], b[1], b[2], from) * percale_audit_orient(b[0], b[1], b[2], to) >= 0)
        return false;
    const float *shared = b[corner_b];
    const float *next = b[(corner_b + 1) % 3];
    const float *last = b[(corner_b + 2) % 3];
    int one = percale_audit_orient(from, to, shared, next);
    int opposite = percale_audit_orient(from, to, next, last);
    int other = percale_audit_orient(from, to, last, shared);
    return one != 0 && one == other && one * opposite >= 0;
}

// How many pairs of corners are one point; the last of them is told.
static size_t count_shared(const Crossings *crossings, size_t a, size_t b, size_t *corner_a, size_t *corner_b)
{
    size_t count = 0;
    for (size_t i = 0; crossings->points_a && i < 3; i++) {
        uint32_t point = crossings->points_a[crossings->a->corners[3 * a + i]];
        for (size_t j = 0; j < 3; j++) {
            if (crossings->points_b[crossings->b->corners[3 * b + j]] != point)
                continue;
            *corner_a = i;
            *corner_b = j;
            count++;
        }
    }
    return count;
}

static bool are_boxes_apart(const float *const a[3], const float *const b[3])
{
    for (size_t axis = 0; axis < 3; axis++) {
        bool is_below = true;
        bool is_above = true;
        for (size_t i = 0; i < 3; i++) {
            for (size_t j = 0; j < 3; j++) {
                is_below &= a[i][axis] < b[j][axis];
                is_above &= a[i][axis] > b[j][axis];
            }
        }
        if (is_below || is_above)
            return true;
    }
    return false;
}

// How far a's corners reach through the plane of b, to the side where they reach less far.
static double reach_through(const float *const a[3], const float *const b[3])
{
    double p[4][3];
    for (size_t k = 0; k < 3; k++)
        load_point(b[k], 0, p[k]);
    double u[3], v[3], normal[3];
    subtract(p[1], p[0], u);
    subtract(p[2], p[0], v);
    cross(u, v, normal);
    double length = sqrt(dot(normal, normal));
    double above = 0.0;
    double below = 0.0;
    for (size_t k = 0; k < 3; k++) {
        load_point(a[k], 0, p[3]);
        subtract(p[3], p[0], u);
        double height = length > 0.0 ? dot(normal, u) / length : 0.0;
        above = fmax(above, height);
        below = fmax(below, -height);
    }
    return fmin(above, below);
}

static void keep_deepest(Crossings *crossings, size_t a, size_t b, const float *const corners_a[3],
                         const float *const corners_b[3])
{
    double depth = fmin(reach_through(corners_a, corners_b), reach_through(corners_b, corners_a));
    if (!(depth > crossings->deepest->depth))
        return;
    *crossings->deepest = crossings->here;
    crossings->deepest->triangle = crossings->a->triangles[a];
    crossings->deepest->other_triangle = crossings->b->triangles[b];
    crossings->deepest->depth = depth;
}

static void cross_triangles(Crossings *crossings, size_t a, size_t b)
{
    const float *corners_a[3];
    const float *corners_b[3];
    load_corners(crossings->a, a, corners_a);
    load_corners(crossings->b, b, corners_b);
    if (are_boxes_apart(corners_a, corners_b))
        return;
    size_t i = 0;
    size_t j = 0;
    size_t shared_count = count_shared(crossings, a, b, &i, &j);
    if (shared_count == 0) {
        if (do_cross(corners_a, corners_b)) {
            crossings->crossing_count++;
            keep_deepest(crossings, a, b, corners_a, corners_b);
        }
        return;
    }
    if (shared_count > 1 || !crossings->is_sewn[crossings->points_a[crossings->a->corners[3 * a + i]]])
        return;
    if (does_opposite_edge_pierce(corners_a, i, corners_b, j) ||
        does_opposite_edge_pierce(corners_b, j, corners_a, i))
        crossings->seam_count++;
}

static bool are_nodes_apart(const PercaleAuditNode *a, const PercaleAuditNode *b)
{
    for (size_t axis = 0; axis < 3; axis++) {
        if (a->low[axis] > b->high[axis] || b->low[axis] > a->high[axis])
            return true;
    }
    return false;
}

static double longest_side(const PercaleAuditNode *node)
{
    double longest = 0.0;
    for (size_t axis = 0; axis < 3; axis++) {
        double side = (double)node->high[axis] - (double)node->low[axis];
        longest = side > longest ? side : longest;
    }
    return longest;
}

// Calls itself at most as deep as both trees together.
static void cross_nodes(Crossings *crossings, uint32_t a, uint32_t b)
{
    const PercaleAuditNode *node_a = &crossings->a->nodes[a];
    const PercaleAuditNode *node_b = &crossings->b->nodes[b];
    if (are_nodes_apart(node_a, node_b))
        return;
    if (node_a->count > 0 && node_b->count > 0) {
        for (size_t i = node_a->first; i < node_a->first + node_a->count; i++) {
            for (size_t j = node_b->first; j < node_b->first + node_b->count; j++)
                cross_triangles(crossings, i, j);
        }
    } else if (node_b->count > 0 || (node_a->count == 0 && longest_side(node_a) > longest_side(node_b))) {
        cross_nodes(crossings, a + 1, b);
        cross_nodes(crossings, node_a->first, b);
    } else {
        cross_nodes(crossings, a, b + 1);
        cross_nodes(crossings, a, node_b->first);
    }
}

// Every pair below one node of one tree once. Calls itself as deep as the tree.
static void cross_within(Crossings *crossings, uint32_t index)
{
    const PercaleAuditNode *node = &crossings->a->nodes[index];
    for (size_t i = node->first; i < node->first + node->count; i++) {
        for (size_t j = i + 1; j < node->first + node->count; j++)
            cross_triangles(crossings, i, j);
    }
    if (node->count > 0)
        return;
    cross_within(crossings, index + 1);
    cross_within(crossings, node->first);
    cross_nodes(crossings, index + 1, node->first);
}

// One cloth with another one or with itself.
static void cross_two_cloths(PercaleAuditScene *scene, uint32_t a, uint32_t b, PercaleQuality *quality)
{
    Crossings crossings = {
        .a = &scene->trees[a],
        .b = &scene->trees[b],
        .points_a = scene->points + scene->first_vertex[a],
        .points_b = scene->points + scene->first_vertex[b],
        .is_sewn = scene->is_sewn,
        .here = {.cloth = a, .other = b},
        .deepest = &scene->deepest,
    };
    if (crossings.a->node_count == 0 || crossings.b->node_count == 0)
        return;
    if (a == b)
        cross_within(&crossings, 0);
    else
        cross_nodes(&crossings, 0, 0);
    quality->ef_cloth_cloth += (double)crossings.crossing_count;
    quality->ef_seam += (double)crossings.seam_count;
}

void percale_audit_cross_cloths(PercaleAuditScene *scene, PercaleQuality *quality)
{
    for (uint32_t a = 0; a < scene->cloth_count; a++) {
        cross_two_cloths(scene, a, a, quality);
        for (uint32_t b = a + 1; b < scene->cloth_count; b++) {
            if (scene->cloths[a].mask & scene->cloths[b].mask)
                cross_two_cloths(scene, a, b, quality);
        }
    }
}

void percale_audit_cross_obstacle(PercaleAuditScene *scene, const PercaleAuditSurface *obstacle,
                                  uint32_t index, PercaleQuality *quality)
{
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        Crossings crossings = {.a = &scene->trees[cloth],
                               .b = &obstacle->tree,
                               .here = {.cloth = cloth, .other = index, .is_obstacle = true},
                               .deepest = &scene->deepest};
        if (!(scene->cloths[cloth].mask & obstacle->mesh->mask) || crossings.a->node_count == 0 ||
            crossings.b->node_count == 0)
            continue;
        cross_nodes(&crossings, 0, 0);
        quality->ef_cloth_obstacle += (double)crossings.crossing_count;
    }
}
