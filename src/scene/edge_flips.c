#include "edge_flips.h"

#include <math.h>
#include <stdlib.h>

static const int ROUNDS = 12;         // at most; each flip lowers a sum of squares, so that they die out
static const double FLATTEST = 0.7;   // cosine of the angle that a flip may put between old and new normals
static const int REGULAR_VALENCE = 6; // neighbours of a vertex in a regular mesh

// A half-edge is a corner of a triangle: index 3 t + k, it runs from that corner to the next one.
typedef struct HalfEdges {
    const double *positions;
    uint32_t *from; ///< [3 * triangle_count]: the triangles
    uint32_t *twin; ///< [3 * triangle_count]: the half-edge that runs back
    int *valence;   ///< [vertex_count]
    uint32_t count;
} HalfEdges;

typedef struct Key {
    uint32_t low, high, half_edge;
} Key;

static uint32_t next_of(uint32_t h)
{
    return h % 3 == 2 ? h - 2 : h + 1;
}

static uint32_t previous_of(uint32_t h)
{
    return h % 3 == 0 ? h + 2 : h - 1;
}

static int compare_keys(const void *left, const void *right)
{
    const Key *a = left;
    const Key *b = right;
    if (a->low != b->low) {
        return a->low < b->low ? -1 : 1;
    }
    if (a->high != b->high) {
        return a->high < b->high ? -1 : 1;
    }
    return (a->half_edge > b->half_edge) - (a->half_edge < b->half_edge);
}

// Both half-edges of an edge stand side by side once sorted.
static bool pair_twins(HalfEdges *mesh)
{
    Key *keys = malloc(mesh->count * sizeof *keys);
    if (!keys) {
        return false;
    }
    for (uint32_t h = 0; h < mesh->count; h++) {
        const uint32_t a = mesh->from[h];
        const uint32_t b = mesh->from[next_of(h)];
        keys[h] = (Key){a < b ? a : b, a < b ? b : a, h};
        mesh->valence[a]++;
    }
    qsort(keys, mesh->count, sizeof *keys, compare_keys);
    bool good = true;
    for (uint32_t i = 0; good && i + 1 < mesh->count; i += 2) {
        const Key *pair = keys + i;
        good = pair[0].low == pair[1].low && pair[0].high == pair[1].high &&
               mesh->from[pair[0].half_edge] != mesh->from[pair[1].half_edge] &&
               (i + 2 >= mesh->count || pair[2].low != pair[1].low || pair[2].high != pair[1].high);
        mesh->twin[pair[0].half_edge] = pair[1].half_edge;
        mesh->twin[pair[1].half_edge] = pair[0].half_edge;
    }
    free(keys);
    return good;
}

static void normal_of(const HalfEdges *mesh, uint32_t a, uint32_t b, uint32_t c, double normal[3])
{
    const double *p = mesh->positions + 3 * (size_t)a;
    const double *q = mesh->positions + 3 * (size_t)b;
    const double *r = mesh->positions + 3 * (size_t)c;
    const double u[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    const double v[3] = {r[0] - p[0], r[1] - p[1], r[2] - p[2]};
    normal[0] = u[1] * v[2] - u[2] * v[1];
    normal[1] = u[2] * v[0] - u[0] * v[2];
    normal[2] = u[0] * v[1] - u[1] * v[0];
}

static double cosine(const double a[3], const double b[3])
{
    const double aa = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
    const double bb = b[0] * b[0] + b[1] * b[1] + b[2] * b[2];
    const double ab = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    return aa > 0 && bb > 0 ? ab / sqrt(aa * bb) : -1.0;
}

static bool stays_flat(const HalfEdges *mesh, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    double left[3];
    double right[3];
    double before[3];
    normal_of(mesh, a, b, c, left);
    normal_of(mesh, b, a, d, right);
    for (int k = 0; k < 3; k++) {
        before[k] = left[k] + right[k];
    }
    normal_of(mesh, a, d, c, left);
    normal_of(mesh, d, b, c, right);
    return cosine(left, before) > FLATTEST && cosine(right, before) > FLATTEST;
}

static bool are_neighbours(const HalfEdges *mesh, uint32_t start, uint32_t other)
{
    uint32_t h = start;
    do {
        if (mesh->from[next_of(h)] == other) {
            return true;
        }
        h = mesh->twin[previous_of(h)];
    } while (h != start);
    return false;
}

static int excess(int valence)
{
    return (valence - REGULAR_VALENCE) * (valence - REGULAR_VALENCE);
}

static void link_twins(HalfEdges *mesh, uint32_t h, uint32_t g)
{
    mesh->twin[h] = g;
    mesh->twin[g] = h;
}

// Triangles abc and bad become dca and cdb.
static bool flip(HalfEdges *mesh, uint32_t h)
{
    const uint32_t g = mesh->twin[h];
    const uint32_t h_next = next_of(h);
    const uint32_t h_last = previous_of(h);
    const uint32_t g_next = next_of(g);
    const uint32_t g_last = previous_of(g);
    const uint32_t a = mesh->from[h];
    const uint32_t b = mesh->from[g];
    const uint32_t c = mesh->from[h_last];
    const uint32_t d = mesh->from[g_last];
    int *valence = mesh->valence;
    const int before = excess(valence[a]) + excess(valence[b]) + excess(valence[c]) + excess(valence[d]);
    const int after =
        excess(valence[a] - 1) + excess(valence[b] - 1) + excess(valence[c] + 1) + excess(valence[d] + 1);
    if (after >= before || are_neighbours(mesh, h_last, d) || !stays_flat(mesh, a, b, c, d)) {
        return false;
    }
    const uint32_t bc = mesh->twin[h_next];
    const uint32_t ca = mesh->twin[h_last];
    const uint32_t ad = mesh->twin[g_next];
    const uint32_t db = mesh->twin[g_last];
    mesh->from[h] = d;
    mesh->from[h_next] = c;
    mesh->from[h_last] = a;
    mesh->from[g] = c;
    mesh->from[g_next] = d;
    mesh->from[g_last] = b;
    link_twins(mesh, h_next, ca);
    link_twins(mesh, h_last, ad);
    link_twins(mesh, g_next, db);
    link_twins(mesh, g_last, bc);
    valence[a]--;
    valence[b]--;
    valence[c]++;
    valence[d]++;
    return true;
}

bool percale_flip_edges(const double *positions, uint32_t vertex_count, uint32_t *triangles,
                        uint32_t triangle_count)
{
    HalfEdges mesh = {.positions = positions, .from = triangles, .count = 3 * triangle_count};
    mesh.twin = calloc(mesh.count, sizeof *mesh.twin);
    mesh.valence = calloc(vertex_count, sizeof *mesh.valence);
    const bool good = mesh.twin && mesh.valence && pair_twins(&mesh);
    bool flipped = good;
    for (int round = 0; flipped && round < ROUNDS; round++) {
        flipped = false;
        for (uint32_t h = 0; h < mesh.count; h++) {
            flipped = flip(&mesh, h) || flipped;
        }
    }
    free(mesh.twin);
    free(mesh.valence);
    return good;
}
