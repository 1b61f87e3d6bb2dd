#include "untangle/clusters.h"

#include <string.h>

// A part is worse with so many times the pairs it had, and so many more: on the way out there may be more for
// a while.
static const double WORSE_TIMES = 3.0;
static const double WORSE_PAIRS = 30.0;

bool percale_tangle_clusters_open(PercaleTangleClusters *clusters, uint32_t point_count,
                                  PercaleMemory *memory)
{
    *clusters = (PercaleTangleClusters){0};
    clusters->parents = percale_memory_new(memory, point_count, sizeof(uint32_t));
    clusters->before = percale_memory_new(memory, point_count, sizeof(uint32_t));
    clusters->now = percale_memory_new(memory, point_count, sizeof(uint32_t));
    return clusters->parents != NULL && clusters->before != NULL && clusters->now != NULL;
}

void percale_tangle_clusters_free(PercaleTangleClusters *clusters, PercaleMemory *memory)
{
    percale_memory_free(memory, clusters->parents);
    percale_memory_free(memory, clusters->before);
    percale_memory_free(memory, clusters->now);
    percale_memory_free(memory, clusters->pairs.items);
    *clusters = (PercaleTangleClusters){0};
}

static bool does_count(const PercaleTangleStage *stage, const PercaleContourPiece *piece)
{
    return !do_triangles_meet(stage->mesh, piece->triangles[0], piece->triangles[1]);
}

bool percale_tangle_clusters_begin(PercaleTangleClusters *clusters, const PercaleTangleStage *stage)
{
    const PercaleContours *contours = stage->contours;
    PercaleTanglePairs *pairs = &clusters->pairs;
    if (!percale_memory_reserve(stage->memory, &pairs->items, &pairs->capacity, contours->piece_count,
                                sizeof(pairs->items[0]))) {
        return false;
    }
    pairs->count = 0;
    for (size_t i = 0; i < contours->piece_count; i++) {
        if (does_count(stage, &contours->pieces[i])) {
            memcpy(pairs->items[pairs->count++], contours->pieces[i].triangles, sizeof(pairs->items[0]));
        }
    }
    return true;
}

// ---- union-find ----

static uint32_t root_of(uint32_t *parents, uint32_t point)
{
    while (parents[point] != point) {
        parents[point] = parents[parents[point]];
        point = parents[point];
    }
    return point;
}

static void join(PercaleTangleClusters *clusters, uint32_t a, uint32_t b)
{
    uint32_t root_a = root_of(clusters->parents, a);
    uint32_t root_b = root_of(clusters->parents, b);
    clusters->parents[root_a > root_b ? root_a : root_b] = root_a > root_b ? root_b : root_a;
}

/// Joins the points of cloth; what stands still joins nothing.
static void join_pair(PercaleTangleClusters *clusters, const PercaleTangleMesh *mesh,
                      const uint32_t triangles[2])
{
    uint32_t first = NO_INDEX;
    for (uint32_t k = 0; k < 6; k++) {
        uint32_t point = corners_of_triangle(mesh, triangles[k / 3])[k % 3];
        if (point >= mesh->model->slot_count) {
            continue;
        }
        if (first != NO_INDEX) {
            join(clusters, first, point);
        }
        first = point;
    }
}

/// A point of cloth of the pair.
static uint32_t point_of_pair(const PercaleTangleMesh *mesh, const uint32_t triangles[2])
{
    uint32_t first = corners_of_triangle(mesh, triangles[0])[0];
    return first < mesh->model->slot_count ? first : corners_of_triangle(mesh, triangles[1])[0];
}

static void join_stencils(PercaleTangleClusters *clusters, const PercaleTangleStage *stage)
{
    for (size_t i = 0; i < stage->stencils->count; i++) {
        const PercaleStencil *stencil = &stage->stencils->items[i];
        uint32_t first = NO_INDEX;
        for (int k = 0; k < 4; k++) {
            if (stencil->points[k] >= stage->mesh->model->slot_count) {
                continue;
            }
            if (first != NO_INDEX) {
                join(clusters, first, stencil->points[k]);
            }
            first = stencil->points[k];
        }
    }
}

bool percale_tangle_clusters_judge(PercaleTangleClusters *clusters, const PercaleTangleStage *stage)
{
    const PercaleTangleMesh *mesh = stage->mesh;
    const PercaleContours *contours = stage->contours;
    uint32_t count = mesh->model->point_count;
    for (uint32_t p = 0; p < count; p++) {
        clusters->parents[p] = p;
        clusters->before[p] = clusters->now[p] = 0;
    }
    join_stencils(clusters, stage);
    for (size_t i = 0; i < clusters->pairs.count; i++) {
        join_pair(clusters, mesh, clusters->pairs.items[i]);
    }
    for (size_t i = 0; i < contours->piece_count; i++) {
        join_pair(clusters, mesh, contours->pieces[i].triangles);
    }
    for (size_t i = 0; i < clusters->pairs.count; i++) {
        clusters->before[root_of(clusters->parents, point_of_pair(mesh, clusters->pairs.items[i]))]++;
    }
    for (size_t i = 0; i < contours->piece_count; i++) {
        if (does_count(stage, &contours->pieces[i])) {
            clusters->now[root_of(clusters->parents, point_of_pair(mesh, contours->pieces[i].triangles))]++;
        }
    }
    bool any = false;
    for (uint32_t p = 0; p < count; p++) {
        clusters->parents[p] = root_of(clusters->parents, p);
        any = any || percale_tangle_cluster_is_worse(clusters, p);
    }
    return any;
}

bool percale_tangle_cluster_is_worse(const PercaleTangleClusters *clusters, uint32_t point)
{
    uint32_t root = clusters->parents[point];
    return (double)clusters->now[root] > WORSE_TIMES * (double)clusters->before[root] + WORSE_PAIRS;
}
