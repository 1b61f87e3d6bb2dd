#include "untangle/tangle_mesh.h"

#include <string.h>

static void list_triangles(PercaleTangleMesh *mesh)
{
    const PercaleModel *model = mesh->model;
    uint32_t count = model->cloth.triangle_count;
    memcpy(mesh->triangles, model->cloth.triangles, 3 * (size_t)count * sizeof(uint32_t));
    for (uint32_t t = 0; t < count; t++) {
        mesh->object_of[t] = model->cloth_of[model->cloth.triangles[3 * (size_t)t]];
    }
    for (uint32_t o = 0; count < mesh->triangle_count; o++) {
        const PercaleModelSurface *obstacle = &model->obstacles[o];
        memcpy(mesh->triangles + 3 * (size_t)count, obstacle->triangles,
               3 * (size_t)obstacle->triangle_count * sizeof(uint32_t));
        for (uint32_t t = 0; t < obstacle->triangle_count; t++) {
            mesh->object_of[count++] = model->cloth_count + o;
        }
    }
    for (uint32_t t = 0; t < mesh->triangle_count; t++) {
        mesh->turns[t] = 1;
    }
}

static void list_objects(PercaleTangleMesh *mesh)
{
    const PercaleModel *model = mesh->model;
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        const PercaleModelCloth *cloth = &model->cloths[c];
        mesh->objects[c] = (PercaleTangleObject){cloth->thickness, cloth->mask, cloth->rank, false, false};
    }
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        const PercaleModelSurface *obstacle = &model->obstacles[o];
        mesh->objects[model->cloth_count + o] =
            (PercaleTangleObject){obstacle->thickness, obstacle->mask, 0, true, obstacle->closed};
    }
}

static uint32_t root_of(const uint32_t *parents, uint32_t point)
{
    while (parents[point] != point) {
        point = parents[point];
    }
    return point;
}

static void join_seams(PercaleTangleMesh *mesh)
{
    const PercaleModel *model = mesh->model;
    for (uint32_t p = 0; p < model->point_count; p++) {
        mesh->seam_of[p] = p;
    }
    for (uint32_t s = 0; s < model->open_seam_count; s++) {
        uint32_t a = root_of(mesh->seam_of, model->open_seams[s].slots[0]);
        uint32_t b = root_of(mesh->seam_of, model->open_seams[s].slots[1]);
        mesh->seam_of[a > b ? a : b] = a > b ? b : a;
    }
    for (uint32_t p = 0; p < model->point_count; p++) {
        mesh->seam_of[p] = root_of(mesh->seam_of, p);
    }
}

static void list_edges_of_points(PercaleTangleMesh *mesh)
{
    const PercaleEdges *edges = &mesh->edges;
    uint32_t *cursor = mesh->first_edge + 1; // becomes the end of each point's list
    for (uint32_t i = 0; i < 2 * edges->edge_count; i++) {
        cursor[edges->vertices[i / 2][i % 2] + 1]++;
    }
    for (uint32_t p = 0; p < mesh->model->point_count; p++) {
        cursor[p + 1] += cursor[p];
    }
    for (uint32_t i = 0; i < 2 * edges->edge_count; i++) {
        mesh->point_edges[cursor[edges->vertices[i / 2][i % 2]]++] = i / 2;
    }
    while (mesh->cloth_edge_count < edges->edge_count &&
           edges->vertices[mesh->cloth_edge_count][0] < mesh->model->slot_count) {
        mesh->cloth_edge_count++;
    }
}

/// Whether the two sides of an edge run along it in the same direction.
static bool do_sides_agree(const PercaleTangleMesh *mesh, uint32_t edge)
{
    const uint32_t *sides = mesh->edges.sides + mesh->edges.first_side[edge];
    return mesh->triangles[sides[0]] == mesh->triangles[sides[1]];
}

/// Turns the unseen neighbours of a triangle as it is turned, and adds them to the stack; returns its size.
static uint32_t turn_neighbors(PercaleTangleMesh *mesh, uint32_t triangle, uint32_t *stack, uint32_t size,
                               uint8_t *is_seen)
{
    for (size_t side = 3 * (size_t)triangle; side < 3 * (size_t)triangle + 3; side++) {
        uint32_t edge = mesh->edges.edge_of_side[side];
        uint32_t beyond = edge == NO_INDEX ? NO_INDEX : triangle_beyond(mesh, edge, triangle);
        if (beyond != NO_INDEX && !is_seen[beyond]) {
            bool is_turned = (mesh->turns[triangle] < 0) != do_sides_agree(mesh, edge);
            is_seen[beyond] = 1;
            mesh->turns[beyond] = is_turned ? -1 : 1;
            stack[size++] = beyond;
        }
    }
    return size;
}

/// Goes from triangle to triangle through each piece of cloth and notes which are turned over. `stack` has
/// room for all triangles, `is_seen` is zero.
static void orient_cloth(PercaleTangleMesh *mesh, uint32_t *stack, uint8_t *is_seen)
{
    for (uint32_t seed = 0; seed < mesh->cloth_triangle_count; seed++) {
        uint32_t size = 0;
        if (!is_seen[seed]) {
            is_seen[seed] = 1;
            stack[size++] = seed;
        }
        while (size > 0) {
            uint32_t triangle = stack[--size];
            size = turn_neighbors(mesh, triangle, stack, size, is_seen);
        }
    }
}

static bool allocate(PercaleTangleMesh *mesh, PercaleMemory *memory)
{
    const PercaleModel *model = mesh->model;
    uint32_t count = mesh->triangle_count;
    mesh->triangles = percale_memory_new(memory, 3 * (size_t)count, sizeof(uint32_t));
    mesh->object_of = percale_memory_new(memory, count, sizeof(uint32_t));
    mesh->turns = percale_memory_new(memory, count, sizeof(int8_t));
    mesh->objects = percale_memory_new(memory, (size_t)model->cloth_count + model->obstacle_count,
                                       sizeof(PercaleTangleObject));
    mesh->seam_of = percale_memory_new(memory, model->point_count, sizeof(uint32_t));
    mesh->first_edge = percale_memory_new(memory, (size_t)model->point_count + 2, sizeof(uint32_t));
    mesh->point_edges = percale_memory_new(memory, 6 * (size_t)count, sizeof(uint32_t));
    return mesh->triangles != NULL && mesh->object_of != NULL && mesh->turns != NULL &&
           mesh->objects != NULL && mesh->seam_of != NULL && mesh->first_edge != NULL &&
           mesh->point_edges != NULL;
}

bool percale_tangle_mesh_build(PercaleTangleMesh *mesh, const PercaleModel *model, bool obstacles,
                               PercaleMemory *memory)
{
    *mesh = (PercaleTangleMesh){.model = model,
                                .triangle_count = model->cloth.triangle_count,
                                .cloth_triangle_count = model->cloth.triangle_count};
    for (uint32_t o = 0; obstacles && o < model->obstacle_count; o++) {
        mesh->triangle_count += model->obstacles[o].triangle_count;
    }
    uint32_t *stack = percale_memory_new(memory, mesh->triangle_count, sizeof(uint32_t));
    uint8_t *is_seen = percale_memory_new(memory, mesh->triangle_count, sizeof(uint8_t));
    bool complete = stack != NULL && is_seen != NULL && allocate(mesh, memory);
    if (complete) {
        list_triangles(mesh);
        list_objects(mesh);
        join_seams(mesh);
        complete = percale_edges_build(mesh->triangles, mesh->triangle_count, memory, &mesh->edges);
    }
    if (complete) {
        list_edges_of_points(mesh);
        orient_cloth(mesh, stack, is_seen);
    } else {
        percale_tangle_mesh_free(mesh, memory);
    }
    percale_memory_free(memory, stack);
    percale_memory_free(memory, is_seen);
    return complete;
}

void percale_tangle_mesh_free(PercaleTangleMesh *mesh, PercaleMemory *memory)
{
    percale_edges_free(&mesh->edges, memory);
    void *arrays[] = {mesh->triangles, mesh->object_of,  mesh->turns,      mesh->objects,
                      mesh->seam_of,   mesh->first_edge, mesh->point_edges};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); i++) {
        percale_memory_free(memory, arrays[i]);
    }
    *mesh = (PercaleTangleMesh){0};
}
