// What the audit needs to know about a cloth: the rest length of every triangle's edges, and which vertices
// are one point after sewing.

#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/scene_model.h"

#include <math.h>

static double rest_distance(const PercaleSceneItem *cloth, uint32_t a, uint32_t b)
{
    const bool flat = cloth->rest == PERCALE_REST_UV;
    const size_t dimension = flat ? 2 : 3;
    const float *points = flat ? cloth->mesh.uvs : cloth->rest_positions;
    double sum = 0.0;
    for (size_t axis = 0; axis < dimension; ++axis) {
        const double d = (double)points[dimension * b + axis] - (double)points[dimension * a + axis];
        sum += d * d;
    }
    return sqrt(sum);
}

static uint32_t find_root(uint32_t *parents, uint32_t vertex)
{
    while (parents[vertex] != vertex) {
        parents[vertex] = parents[parents[vertex]];
        vertex = parents[vertex];
    }
    return vertex;
}

// Union-find over all pairs: also those still open will be one point. The smallest vertex gives the number.
static void number_welds(PercaleSceneItem *cloth, uint32_t first_weld)
{
    uint32_t *parents = cloth->weld;
    for (uint32_t vertex = 0; vertex < cloth->mesh.vertex_count; ++vertex) {
        parents[vertex] = vertex;
    }
    for (uint32_t pair = 0; pair < cloth->seam_count; ++pair) {
        const uint32_t a = find_root(parents, cloth->seams[pair][0]);
        const uint32_t b = find_root(parents, cloth->seams[pair][1]);
        parents[a > b ? a : b] = a > b ? b : a;
    }
    // A parent is never larger than its child, so it already has its final number.
    for (uint32_t vertex = 0; vertex < cloth->mesh.vertex_count; ++vertex) {
        parents[vertex] = parents[vertex] == vertex ? vertex : parents[parents[vertex]];
    }
    for (uint32_t vertex = 0; vertex < cloth->mesh.vertex_count; ++vertex) {
        cloth->weld[vertex] += first_weld;
    }
}

bool percale_scene_measure(PercaleSceneItem *cloth, uint32_t first_weld, PercaleSceneError *error)
{
    const PercaleMesh *mesh = &cloth->mesh;
    free(cloth->rest_lengths);
    free(cloth->weld);
    cloth->rest_lengths = percale_array_new(3 * (uint64_t)mesh->triangle_count, sizeof *cloth->rest_lengths);
    cloth->weld = cloth->seam_count > 0 ? percale_array_new(mesh->vertex_count, sizeof *cloth->weld) : NULL;
    if (cloth->rest_lengths == NULL || (cloth->seam_count > 0 && cloth->weld == NULL)) {
        return percale_scene_out_of_memory(error);
    }
    for (size_t triangle = 0; triangle < mesh->triangle_count; ++triangle) {
        const uint32_t *corners = &mesh->triangles[3 * triangle];
        for (size_t k = 0; k < 3; ++k) {
            cloth->rest_lengths[3 * triangle + k] =
                (float)rest_distance(cloth, corners[k], corners[(k + 1) % 3]);
        }
    }
    if (cloth->weld != NULL) {
        number_welds(cloth, first_weld);
    }
    return true;
}

// ---- median ----

typedef struct Edge {
    uint32_t low, high;
    float length;
} Edge;

static int compare_ends(const void *a, const void *b)
{
    const Edge *left = a;
    const Edge *right = b;
    const int by_low = (left->low > right->low) - (left->low < right->low);
    return by_low != 0 ? by_low : (left->high > right->high) - (left->high < right->high);
}

static int compare_lengths(const void *a, const void *b)
{
    const Edge *left = a;
    const Edge *right = b;
    return (left->length > right->length) - (left->length < right->length);
}

double percale_scene_median_edge(const PercaleSceneItem *cloth)
{
    const size_t corner_count = 3 * (size_t)cloth->mesh.triangle_count;
    Edge *edges = percale_array_new(corner_count, sizeof *edges);
    if (edges == NULL) {
        return -1.0;
    }
    for (size_t corner = 0; corner < corner_count; ++corner) {
        const uint32_t a = cloth->mesh.triangles[corner];
        const uint32_t b = cloth->mesh.triangles[corner % 3 == 2 ? corner - 2 : corner + 1];
        edges[corner] = (Edge){a < b ? a : b, a < b ? b : a, cloth->rest_lengths[corner]};
    }
    qsort(edges, corner_count, sizeof *edges, compare_ends);
    size_t count = 0;
    for (size_t k = 0; k < corner_count; ++k) {
        if (k == 0 || compare_ends(&edges[k], &edges[k - 1]) != 0) {
            edges[count++] = edges[k];
        }
    }
    qsort(edges, count, sizeof *edges, compare_lengths);
    const double median = (double)edges[count / 2].length;
    free(edges);
    return median;
}
