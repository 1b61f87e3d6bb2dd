// Stretch of the edges. An edge is a pair of welded points; where several triangles have it, also two panels
// sewn along it with rest lengths of their own, the longest stretch counts. Left out: edges between the two
// sides of a seam (they are one point), and edges whose rest length is not a positive number.

#include <math.h>

#include "audit/audit.h"
#include "audit/audit_pairs.h"
#include "audit/audit_vector.h"

typedef struct Edges {
    PercaleAuditPair *pairs; // the item is the index of a stretch
    double *stretches;
    size_t count;
} Edges;

static void list_edges_of_triangle(const PercaleAuditScene *scene, uint32_t cloth, size_t triangle,
                                   Edges *edges)
{
    const PercaleAuditMesh *mesh = &scene->cloths[cloth];
    const uint32_t *points = scene->points + scene->first_vertex[cloth];
    for (size_t k = 0; k < 3; k++) {
        uint32_t a = mesh->triangles[3 * triangle + k];
        uint32_t b = mesh->triangles[3 * triangle + (k + 1) % 3];
        double rest_length = (double)mesh->rest_lengths[3 * triangle + k];
        if (points[a] == points[b] || !(rest_length > 0.0) || isinf(rest_length))
            continue;
        double x[2][3];
        double edge[3];
        load_point(mesh->positions, a, x[0]);
        load_point(mesh->positions, b, x[1]);
        subtract(x[1], x[0], edge);
        PercaleAuditPair *pair = &edges->pairs[edges->count];
        pair->first = points[a] < points[b] ? points[a] : points[b];
        pair->second = points[a] < points[b] ? points[b] : points[a];
        pair->item = (uint32_t)edges->count;
        edges->stretches[edges->count++] = sqrt(dot(edge, edge)) / rest_length - 1.0;
    }
}

static void list_edges(const PercaleAuditScene *scene, Edges *edges)
{
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        const PercaleAuditTree *tree = &scene->trees[cloth];
        for (size_t i = 0; scene->cloths[cloth].rest_lengths && i < tree->triangle_count; i++)
            list_edges_of_triangle(scene, cloth, tree->triangles[i], edges);
    }
}

// One stretch per edge: the largest of its copies. Answers how many there are.
static size_t merge_edges(const Edges *edges, double *unique)
{
    size_t count = 0;
    size_t end = 0;
    for (size_t begin = 0; begin < edges->count; begin = end) {
        end = percale_audit_run_end(edges->pairs, edges->count, begin);
        double largest = edges->stretches[edges->pairs[begin].item];
        for (size_t i = begin + 1; i < end; i++)
            largest = fmax(largest, edges->stretches[edges->pairs[i].item]);
        unique[count++] = largest;
    }
    return count;
}

static void summarise(double *stretches, size_t count, PercaleQuality *quality)
{
    quality->stretch_max = count > 0 ? stretches[0] : 0.0;
    for (size_t i = 1; i < count; i++)
        quality->stretch_max = fmax(quality->stretch_max, stretches[i]);
    quality->stretch_p99 = percale_audit_percentile_99(stretches, count);
}

bool percale_audit_strain(const PercaleAuditScene *scene, PercaleQuality *quality)
{
    size_t side_count = 0;
    for (uint32_t cloth = 0; cloth < scene->cloth_count; cloth++) {
        if (scene->cloths[cloth].rest_lengths)
            side_count += 3 * (size_t)scene->trees[cloth].triangle_count;
    }
    const PercaleAuditMemory *memory = &scene->memory;
    Edges edges = {.count = 0};
    edges.pairs = percale_audit_allocate(memory, side_count, sizeof *edges.pairs);
    edges.stretches = percale_audit_allocate(memory, side_count, sizeof *edges.stretches);
    double *unique = percale_audit_allocate(memory, side_count, sizeof *unique);
    bool has_memory = edges.pairs && edges.stretches && unique;
    if (has_memory) {
        list_edges(scene, &edges);
        has_memory = percale_audit_sort_pairs(memory, edges.pairs, edges.count, scene->point_count);
        if (has_memory)
            summarise(unique, merge_edges(&edges, unique), quality);
    }
    percale_audit_release(memory, unique);
    percale_audit_release(memory, edges.stretches);
    percale_audit_release(memory, edges.pairs);
    return has_memory;
}
