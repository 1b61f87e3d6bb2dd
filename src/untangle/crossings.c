#include "untangle/crossings.h"

#include "base/parallel.h"
#include "untangle/exact_sign.h"

#include <stdlib.h>
#include <string.h>

// ---- one edge and one face ----

bool percale_does_edge_cross(const f32x4 *x, const uint32_t edge[2], const uint32_t face[3])
{
    const uint32_t first[4] = {face[0], face[1], face[2], edge[0]};
    const uint32_t second[4] = {face[0], face[1], face[2], edge[1]};
    if (percale_plane_side(x, first) == percale_plane_side(x, second)) {
        return false;
    }
    int turns = 0;
    for (int k = 0; k < 3; k++) {
        const uint32_t half[4] = {edge[0], edge[1], face[k], face[(k + 1) % 3]};
        turns += percale_plane_side(x, half);
    }
    return turns == 3 || turns == -3;
}

/// Six times the volume, by rounded arithmetic.
static double volume_of(Vec3 a, Vec3 b, Vec3 c, Vec3 d)
{
    return vdot(vsub(b, a), vcross(vsub(c, a), vsub(d, a)));
}

/// a / (a + b), a and b being at least 0; in the middle of nothing.
static double share_of(double a, double b)
{
    return a + b > 0.0 ? a / (a + b) : 0.5;
}

/// Where they meet. The signs are known, so sizes are enough; what lies in a plane meets somewhere on it.
static void place(const f32x4 *x, const uint32_t edge[2], const uint32_t face[3],
                  PercaleTangleCrossing *crossing)
{
    Vec3 p = vec3_of(x[edge[0]]);
    Vec3 q = vec3_of(x[edge[1]]);
    Vec3 c[3];
    for (int k = 0; k < 3; k++) {
        c[k] = vec3_of(x[face[k]]);
    }
    crossing->along = share_of(fabs(volume_of(c[0], c[1], c[2], p)), fabs(volume_of(c[0], c[1], c[2], q)));
    double sum = 0.0;
    for (int k = 0; k < 3; k++) {
        crossing->weights[k] = fabs(volume_of(p, q, c[(k + 1) % 3], c[(k + 2) % 3]));
        sum += crossing->weights[k];
    }
    for (int k = 0; k < 3; k++) {
        crossing->weights[k] = sum > 0.0 ? crossing->weights[k] / sum : 1.0 / 3.0;
    }
}

Vec3 percale_crossing_point(const PercaleTangleMesh *mesh, const PercaleTangleCrossing *crossing,
                            const f32x4 *x)
{
    const uint32_t *ends = mesh->edges.vertices[crossing->edge];
    return vadd(vscale(1.0 - crossing->along, vec3_of(x[ends[0]])),
                vscale(crossing->along, vec3_of(x[ends[1]])));
}

// ---- all ----

/// What the chunks share.
typedef struct Search {
    PercaleCrossingSearch *search;
    const f32x4 *x;
} Search;

static bool may_meet(const PercaleTangleMesh *mesh, uint32_t edge, uint32_t face)
{
    const uint32_t *ends = mesh->edges.vertices[edge];
    const uint32_t *corners = corners_of_triangle(mesh, face);
    const PercaleTangleObject *a = object_of_triangle(mesh, triangle_of_edge(mesh, edge, 0));
    const PercaleTangleObject *b = object_of_triangle(mesh, face);
    bool collide = (a->mask & b->mask) != 0;
    for (int k = 0; k < 3; k++) {
        collide = collide && !are_sewn_together(mesh, ends[0], corners[k]) &&
                  !are_sewn_together(mesh, ends[1], corners[k]);
    }
    return collide;
}

static void ask_face(const Search *search, PercaleCrossingShare *share, uint32_t edge, uint32_t face)
{
    const PercaleTangleMesh *mesh = search->search->mesh;
    const uint32_t *ends = mesh->edges.vertices[edge];
    const uint32_t *corners = corners_of_triangle(mesh, face);
    if (!may_meet(mesh, edge, face) || !percale_does_edge_cross(search->x, ends, corners)) {
        return;
    }
    PercaleTangleCrossings *found = &share->found;
    if (!percale_memory_reserve(&share->memory, &found->items, &found->capacity, found->count + 1,
                                sizeof(found->items[0]))) {
        share->complete = false;
        return;
    }
    PercaleTangleCrossing *crossing = &found->items[found->count++];
    crossing->edge = edge;
    crossing->face = face;
    place(search->x, ends, corners, crossing);
}

/// first_face: of the tree's triangles among all.
static void ask_tree(const Search *search, PercaleCrossingShare *share, uint32_t edge,
                     const PercaleTree *tree, uint32_t first_face)
{
    const uint32_t *ends = search->search->mesh->edges.vertices[edge];
    f32x4 low = min4(search->x[ends[0]], search->x[ends[1]]);
    f32x4 high = max4(search->x[ends[0]], search->x[ends[1]]);
    if (tree->primitive_count == 0) {
        return;
    }
    if (!percale_tree_overlap(tree, low, high, &share->memory, &share->nodes)) {
        share->complete = false;
        return;
    }
    for (size_t i = 0; i < share->nodes.count; i++) {
        uint32_t node = share->nodes.items[i];
        uint32_t bits = lane_bits(tree_box_overlaps(&tree->nodes[node], low, high));
        for (; bits != 0; bits &= bits - 1) {
            uint32_t place = TREE_WIDTH * node + (uint32_t)__builtin_ctz(bits);
            ask_face(search, share, edge, first_face + tree->order[place]);
        }
    }
}

static int compare_faces(const void *a, const void *b)
{
    uint32_t x = ((const PercaleTangleCrossing *)a)->face;
    uint32_t y = ((const PercaleTangleCrossing *)b)->face;
    return (x > y) - (x < y);
}

/// The tree's order depends on where things were when it was built: an edge's faces are brought into their
/// own.
static void sort_from(PercaleTangleCrossings *found, size_t first)
{
    if (found->count > first + 1) {
        qsort(found->items + first, found->count - first, sizeof(found->items[0]), compare_faces);
    }
}

static void ask_share(const Search *search, uint32_t index)
{
    PercaleCrossingSearch *all = search->search;
    const PercaleTangleMesh *mesh = all->mesh;
    PercaleCrossingShare *share = &all->shares[index];
    uint64_t edge_count = mesh->edges.edge_count;
    uint32_t edge = (uint32_t)(edge_count * index / TANGLE_SHARES);
    uint32_t end = (uint32_t)(edge_count * (index + 1) / TANGLE_SHARES);
    share->found.count = 0;
    share->complete = true;
    for (; edge < end; edge++) {
        size_t first = share->found.count;
        ask_tree(search, share, edge, &all->cloth, 0);
        if (edge < mesh->cloth_edge_count) {
            ask_tree(search, share, edge, &all->obstacles, mesh->cloth_triangle_count);
        }
        sort_from(&share->found, first);
    }
}

static void ask_shares(void *context, uint32_t first, uint32_t end)
{
    for (uint32_t index = first; index < end; index++) {
        ask_share(context, index);
    }
}

/// What the share holds counts as the memory's.
static void take_over(PercaleCrossingShare *share, PercaleMemory *memory)
{
    memory->bytes += share->memory.bytes;
    share->memory.bytes = 0;
}

bool percale_crossing_search_run(PercaleCrossingSearch *search, const f32x4 *x, PercaleTeam *team,
                                 PercaleMemory *memory, PercaleTangleCrossings *crossings)
{
    Search context = {search, x};
    if (search->cloth.primitive_count > 0) {
        percale_tree_refit(&search->cloth, search->mesh->triangles, x, team);
    }
    percale_team_for(team, TANGLE_SHARES, 1, ask_shares, &context);
    size_t count = 0;
    bool complete = true;
    for (uint32_t i = 0; i < TANGLE_SHARES; i++) {
        count += search->shares[i].found.count;
        complete = complete && search->shares[i].complete;
        take_over(&search->shares[i], memory);
    }
    if (!complete || !percale_memory_reserve(memory, &crossings->items, &crossings->capacity, count,
                                             sizeof(crossings->items[0]))) {
        return false;
    }
    crossings->count = 0;
    for (uint32_t i = 0; i < TANGLE_SHARES; i++) {
        const PercaleTangleCrossings *found = &search->shares[i].found;
        if (found->count > 0) {
            memcpy(crossings->items + crossings->count, found->items, found->count * sizeof(found->items[0]));
            crossings->count += found->count;
        }
    }
    return true;
}

bool percale_crossing_search_open(PercaleCrossingSearch *search, const PercaleTangleMesh *mesh,
                                  const f32x4 *x, PercaleTeam *team, PercaleMemory *memory)
{
    memset(search, 0, sizeof(*search));
    search->mesh = mesh;
    for (uint32_t i = 0; i < TANGLE_SHARES; i++) {
        search->shares[i].memory = (PercaleMemory){memory->allocator, 0};
    }
    uint32_t obstacle_count = mesh->triangle_count - mesh->cloth_triangle_count;
    const uint32_t *obstacles = mesh->triangles + 3 * (size_t)mesh->cloth_triangle_count;
    bool complete =
        (mesh->cloth_triangle_count == 0 ||
         percale_tree_build(&search->cloth, mesh->triangles, 3, mesh->cloth_triangle_count, x, memory)) &&
        (obstacle_count == 0 ||
         percale_tree_build(&search->obstacles, obstacles, 3, obstacle_count, x, memory));
    if (!complete) {
        percale_crossing_search_close(search, memory);
        return false;
    }
    if (obstacle_count > 0) {
        percale_tree_refit(&search->obstacles, obstacles, x, team);
    }
    return true;
}

void percale_crossing_search_close(PercaleCrossingSearch *search, PercaleMemory *memory)
{
    percale_tree_free(&search->cloth, memory);
    percale_tree_free(&search->obstacles, memory);
    for (uint32_t i = 0; i < TANGLE_SHARES; i++) {
        PercaleCrossingShare *share = &search->shares[i];
        take_over(share, memory);
        percale_memory_free(memory, share->found.items);
        percale_memory_free(memory, share->nodes.items);
    }
    memset(search, 0, sizeof(*search));
}
