// Depths of cloth vertices, and how far obstacle vertices stand out through the cloths.

#include <math.h>

#include "audit/audit.h"
#include "audit/audit_vector.h"

static const double CONTACT_THICKNESSES =
    1.5;                                     // a vertex this near, in thicknesses of the pair, is in contact
static const double STAND_OUT_REACH = 20e-3; // m along the inward normal
// m; hits this near each other are one edge or vertex hit twice, and one this near the start is the start.
static const double SAME_HIT = 1e-9;
static const double EDGE_SLACK = 1e-9; // of a barycentric coordinate, so that no ray slips between triangles

void percale_audit_penetrate(PercaleAuditScene *scene, const PercaleAuditSurface *obstacle)
{
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        const PercaleAuditMesh *mesh = &scene->cloths[cloth];
        if (!(mesh->mask & obstacle->mesh->mask))
            continue;
        double thickness = 0.5 * ((double)mesh->thickness + (double)obstacle->mesh->thickness);
        double reach = CONTACT_THICKNESSES * thickness;
        for (uint32_t vertex = 0; vertex < mesh->vertex_count; vertex++) {
            if (!percale_audit_is_finite(mesh, vertex))
                continue;
            size_t i = scene->first_vertex[cloth] + vertex;
            PercaleAuditPlace place =
                percale_audit_place(obstacle, mesh->positions + 3 * (size_t)vertex, reach);
            scene->depths[i] = fmax(scene->depths[i], place.depth);
            scene->in_contact[i] |= place.distance <= reach;
        }
    }
}

typedef struct Ray {
    double start[3];     // m
    double direction[3]; // of length 1
} Ray;

// What a ray meets first after `after`.
typedef struct Hit {
    double time; // m along the ray
    bool enters; // through a front
    bool leaves; // through a back
} Hit;

// Moeller and Trumbore 1997. Answers 1 through a front, -1 through a back, 0 for a miss.
static int meet_triangle(const Ray *ray, double x[3][3], double *time)
{
    double edge[3];
    double other[3];
    double away[3];
    double across[3];
    double turned[3];
    subtract(x[1], x[0], edge);
    subtract(x[2], x[0], other);
    subtract(ray->start, x[0], away);
    cross(ray->direction, other, across);
    cross(away, edge, turned);
    double determinant = dot(edge, across);
    if (determinant == 0.0)
        return 0;
    double u = dot(away, across) / determinant;
    double v = dot(ray->direction, turned) / determinant;
    *time = dot(other, turned) / determinant;
    bool is_within = u >= -EDGE_SLACK && v >= -EDGE_SLACK && u + v <= 1.0 + EDGE_SLACK;
    if (!is_within)
        return 0;
    return determinant > 0.0 ? 1 : -1;
}

static bool may_meet_box(const Ray *ray, const PercaleAuditNode *node, double reach)
{
    for (size_t axis = 0; axis < 3; axis++) {
        double end = ray->start[axis] + reach * ray->direction[axis];
        if (fmin(ray->start[axis], end) > (double)node->high[axis] + SAME_HIT ||
            fmax(ray->start[axis], end) < (double)node->low[axis] - SAME_HIT)
            return false;
    }
    return true;
}

static void add_hit(Hit *hit, double time, int side)
{
    bool is_first = !hit->enters && !hit->leaves;
    if (time > hit->time + (is_first ? 0.0 : SAME_HIT))
        return;
    if (is_first || time < hit->time - SAME_HIT)
        *hit = (Hit){.time = time};
    hit->time = fmin(hit->time, time);
    hit->enters |= side > 0;
    hit->leaves |= side < 0;
}

static void meet_leaf(const PercaleAuditTree *tree, const PercaleAuditNode *leaf, const Ray *ray,
                      double after, Hit *hit)
{
    for (size_t i = leaf->first; i < leaf->first + leaf->count; i++) {
        const uint32_t *corners = tree->corners + 3 * i;
        double x[3][3];
        double time = 0.0;
        for (size_t k = 0; k < 3; k++)
            load_point(tree->positions, corners[k], x[k]);
        int side = meet_triangle(ray, x, &time);
        if (side != 0 && time >= after)
            add_hit(hit, time, side);
    }
}

// The first hit in [after, hit->time]. False: there is none.
static bool meet_tree(const PercaleAuditTree *tree, const Ray *ray, double after, Hit *hit)
{
    uint32_t stack[PERCALE_AUDIT_STACK];
    size_t waiting = 0;
    if (tree->node_count > 0)
        stack[waiting++] = 0;
    while (waiting > 0) {
        uint32_t index = stack[--waiting];
        const PercaleAuditNode *node = &tree->nodes[index];
        if (!may_meet_box(ray, node, hit->time + SAME_HIT))
            continue;
        if (node->count > 0) {
            meet_leaf(tree, node, ray, after, hit);
            continue;
        }
        stack[waiting++] = node->first;
        stack[waiting++] = index + 1;
    }
    return hit->enters || hit->leaves;
}

// Does the ray, which starts inward at a vertex of the obstacle, come out of the obstacle before `reach`?
// Each front on the way leads into one body more, each back out of one.
static bool comes_out(const PercaleAuditSurface *obstacle, const Ray *ray, double reach)
{
    int bodies = 1;
    double after = SAME_HIT;
    for (;;) {
        Hit hit = {.time = reach};
        if (!meet_tree(&obstacle->tree, ray, after, &hit))
            return false;
        bodies += hit.enters - hit.leaves;
        if (bodies <= 0)
            return true;
        after = hit.time + 2.0 * SAME_HIT;
    }
}

static double vertex_stands_out(const PercaleAuditScene *scene, const PercaleAuditSurface *obstacle,
                                uint32_t vertex)
{
    const double *normal = obstacle->vertex_normals + 3 * (size_t)vertex;
    double length = sqrt(dot(normal, normal));
    if (!(length > 0.0))
        return 0.0;
    Ray ray;
    load_point(obstacle->mesh->positions, vertex, ray.start);
    for (size_t axis = 0; axis < 3; axis++)
        ray.direction[axis] = -normal[axis] / length;
    Hit hit = {.time = STAND_OUT_REACH};
    bool is_met = false;
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        if (scene->cloths[cloth].mask & obstacle->mesh->mask)
            is_met |= meet_tree(&scene->trees[cloth], &ray, 0.0, &hit);
    }
    if (!is_met || comes_out(obstacle, &ray, hit.time))
        return 0.0;
    return hit.time;
}

double percale_audit_stand_out(const PercaleAuditScene *scene, const PercaleAuditSurface *obstacle)
{
    double largest = 0.0;
    for (uint32_t vertex = 0; vertex < obstacle->mesh->vertex_count; vertex++)
        largest = fmax(largest, vertex_stands_out(scene, obstacle, vertex));
    return largest;
}
