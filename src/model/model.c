#include "model/model.h"

#include <string.h>

// ---- welding: union-find over all cloth vertices, numbered cloth after cloth ----

typedef struct Weld {
    uint32_t *parent;       // [vertex_total]
    uint32_t *first_vertex; // [cloth_count + 1]
    uint32_t vertex_total;
} Weld;

static uint32_t root_of(uint32_t *parent, uint32_t vertex)
{
    while (parent[vertex] != vertex) {
        parent[vertex] = parent[parent[vertex]];
        vertex = parent[vertex];
    }
    return vertex;
}

/// The smaller number becomes the root, so that the result doesn't depend on the order of the pairs.
static void unite(uint32_t *parent, uint32_t a, uint32_t b)
{
    uint32_t root_a = root_of(parent, a);
    uint32_t root_b = root_of(parent, b);
    parent[root_a > root_b ? root_a : root_b] = root_a > root_b ? root_b : root_a;
}

static float gap_between(const PercaleClothObject *a, uint32_t i, const PercaleClothObject *b, uint32_t j)
{
    f32x4 d = {a->positions[3 * (size_t)i] - b->positions[3 * (size_t)j],
               a->positions[3 * (size_t)i + 1] - b->positions[3 * (size_t)j + 1],
               a->positions[3 * (size_t)i + 2] - b->positions[3 * (size_t)j + 2], 0.0f};
    return length3(d);
}

static bool weld_closed_seams(Weld *weld, PercaleObjects *objects, PercaleMemory *memory)
{
    weld->first_vertex = percale_memory_new(memory, objects->cloth_count + 1, sizeof(uint32_t));
    if (weld->first_vertex == NULL) {
        return false;
    }
    for (size_t c = 0; c < objects->cloth_count; c++) {
        weld->first_vertex[c + 1] = weld->first_vertex[c] + objects->cloths[c].vertex_count;
    }
    weld->vertex_total = weld->first_vertex[objects->cloth_count];
    weld->parent = percale_memory_new(memory, weld->vertex_total, sizeof(uint32_t));
    if (weld->parent == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < weld->vertex_total; i++) {
        weld->parent[i] = i;
    }
    for (size_t s = 0; s < objects->seam_count; s++) {
        PercaleSeamObject *seam = &objects->seams[s];
        size_t a = percale_find_cloth(objects, seam->cloth_a);
        size_t b = percale_find_cloth(objects, seam->cloth_b);
        for (uint32_t i = 0; i < seam->pair_count; i++) {
            uint32_t va = seam->vertices_a[i];
            uint32_t vb = seam->vertices_b[i];
            seam->welded[i] = seam->welded[i] ||
                              gap_between(&objects->cloths[a], va, &objects->cloths[b], vb) <= SEAM_CLOSED;
            if (seam->welded[i]) {
                unite(weld->parent, weld->first_vertex[a] + va, weld->first_vertex[b] + vb);
            }
        }
    }
    return true;
}

// ---- slots ----

/// How many layers of other cloths are below this one.
static uint32_t rank_of(const PercaleObjects *objects, int32_t layer)
{
    uint32_t rank = 0;
    for (size_t c = 0; c < objects->cloth_count; c++) {
        int32_t below = objects->cloths[c].layer;
        bool is_first = below < layer;
        for (size_t other = 0; is_first && other < c; other++) {
            is_first = objects->cloths[other].layer != below;
        }
        rank += is_first;
    }
    return rank;
}

/// Gives every welded group a slot, in the order in which the curves of the cloths meet it.
static bool number_slots(PercaleModel *model, const PercaleObjects *objects, Weld *weld,
                         PercaleMemory *memory)
{
    uint32_t *slot_of_root = percale_memory_new(memory, weld->vertex_total, sizeof(uint32_t));
    model->cloth_count = (uint32_t)objects->cloth_count;
    model->cloths = percale_memory_new(memory, objects->cloth_count, sizeof(model->cloths[0]));
    model->cloth_of = percale_memory_new(memory, weld->vertex_total, sizeof(uint32_t));
    bool complete = slot_of_root != NULL && model->cloths != NULL && model->cloth_of != NULL;
    for (uint32_t i = 0; complete && i < weld->vertex_total; i++) {
        slot_of_root[i] = UINT32_MAX;
    }
    for (uint32_t c = 0; complete && c < model->cloth_count; c++) {
        const PercaleClothObject *object = &objects->cloths[c];
        PercaleModelCloth *cloth = &model->cloths[c];
        *cloth = (PercaleModelCloth){percale_memory_new(memory, object->vertex_count, sizeof(uint32_t)),
                                     object->vertex_count,
                                     object->material.thickness,
                                     object->material.friction,
                                     object->mask,
                                     rank_of(objects, object->layer)};
        model->rank_count = cloth->rank < model->rank_count ? model->rank_count : cloth->rank + 1;
        complete = cloth->slots != NULL;
        for (uint32_t i = 0; complete && i < object->vertex_count; i++) {
            uint32_t vertex = object->curve[i];
            uint32_t root = root_of(weld->parent, weld->first_vertex[c] + vertex);
            if (slot_of_root[root] == UINT32_MAX) {
                model->cloth_of[model->slot_count] = c;
                slot_of_root[root] = model->slot_count++;
            }
            cloth->slots[vertex] = slot_of_root[root];
        }
    }
    percale_memory_free(memory, slot_of_root);
    return complete;
}

/// Adds a third of a triangle to its corner's slot: mass, mass x position, mass x velocity.
static void add_share(double sums[7], double mass, const float *position, const float *velocity)
{
    sums[0] += mass;
    for (int axis = 0; axis < 3; axis++) {
        sums[1 + axis] += mass * (double)position[axis];
        sums[4 + axis] += mass * (double)velocity[axis];
    }
}

/// Triangles of the welded cloth and their areas; sums, in double, what each slot gets from them.
static void gather_triangles(PercaleModel *model, const PercaleObjects *objects, double (*sums)[7])
{
    for (uint32_t c = 0, triangle = 0; c < model->cloth_count; c++) {
        const PercaleClothObject *object = &objects->cloths[c];
        for (uint32_t t = 0; t < object->triangle_count; t++, triangle++) {
            double area = object->rest_areas[t];
            model->triangle_areas[triangle] = (float)area;
            for (uint32_t k = 0; k < 3; k++) {
                uint32_t vertex = object->triangles[3 * (size_t)t + k];
                uint32_t slot = model->cloths[c].slots[vertex];
                model->cloth.triangles[3 * (size_t)triangle + k] = slot;
                add_share(sums[slot], area * (double)object->material.density / 3.0,
                          object->positions + 3 * (size_t)vertex, object->velocities + 3 * (size_t)vertex);
            }
        }
    }
}

/// A vertex starts where it is.
static void copy_state(PercaleModel *model, const PercaleObjects *objects)
{
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        const PercaleClothObject *object = &objects->cloths[c];
        for (uint32_t i = 0; i < object->vertex_count; i++) {
            const float *x = object->positions + 3 * (size_t)i;
            const float *v = object->velocities + 3 * (size_t)i;
            uint32_t slot = model->cloths[c].slots[i];
            model->position[slot] = (f32x4){x[0], x[1], x[2], 0.0f};
            model->velocity[slot] = (f32x4){v[0], v[1], v[2], 0.0f};
        }
    }
}

/// A slot of one vertex keeps that vertex's bits; a welded one takes the mean.
static void set_slot_states(PercaleModel *model, const double (*sums)[7], const uint32_t *vertices_per_slot)
{
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        double mass = sums[slot][0];
        if (mass > 0.0 && vertices_per_slot[slot] > 1) {
            for (int axis = 0; axis < 3; axis++) {
                model->position[slot][axis] = (float)(sums[slot][1 + axis] / mass);
                model->velocity[slot][axis] = (float)(sums[slot][4 + axis] / mass);
            }
        }
        model->position[slot][3] = mass > 0.0 ? (float)(1.0 / mass) : 0.0f; // in no triangle: it stays put
    }
}

static bool build_points(PercaleModel *model, const PercaleObjects *objects, PercaleMemory *memory)
{
    for (size_t c = 0; c < objects->cloth_count; c++) {
        model->cloth.triangle_count += objects->cloths[c].triangle_count;
    }
    model->point_count = model->slot_count;
    for (size_t o = 0; o < objects->obstacle_count; o++) {
        model->point_count += objects->obstacles[o].vertex_count;
    }
    model->position = percale_memory_new(memory, model->point_count, sizeof(f32x4));
    model->velocity = percale_memory_new(memory, model->slot_count, sizeof(f32x4));
    model->predicted = percale_memory_new(memory, model->point_count, sizeof(f32x4));
    model->next_velocity = percale_memory_new(memory, model->slot_count, sizeof(f32x4));
    uint32_t triangle_count = model->cloth.triangle_count;
    model->cloth.vertex_count = model->slot_count;
    model->cloth.triangles = percale_memory_new(memory, 3 * (size_t)triangle_count, sizeof(uint32_t));
    model->triangle_areas = percale_memory_new(memory, triangle_count, sizeof(float));
    double(*sums)[7] = percale_memory_new(memory, model->slot_count, sizeof(sums[0]));
    uint32_t *vertices_per_slot = percale_memory_new(memory, model->slot_count, sizeof(uint32_t));
    bool complete = model->position != NULL && model->velocity != NULL && model->predicted != NULL &&
                    model->next_velocity != NULL && model->cloth.triangles != NULL &&
                    model->triangle_areas != NULL && sums != NULL && vertices_per_slot != NULL;
    if (complete) {
        for (uint32_t c = 0; c < model->cloth_count; c++) {
            for (uint32_t i = 0; i < model->cloths[c].vertex_count; i++) {
                vertices_per_slot[model->cloths[c].slots[i]]++;
            }
        }
        gather_triangles(model, objects, sums);
        copy_state(model, objects);
        set_slot_states(model, (const double(*)[7])sums, vertices_per_slot);
    }
    percale_memory_free(memory, sums);
    percale_memory_free(memory, vertices_per_slot);
    return complete;
}

/// `triangles`: by the surface's own vertex numbers.
static bool build_vertex_faces(PercaleModelSurface *surface, const uint32_t *triangles, PercaleMemory *memory)
{
    surface->vertex_first_face =
        percale_memory_new(memory, (size_t)surface->vertex_count + 2, sizeof(uint32_t));
    surface->vertex_faces = percale_memory_new(memory, 3 * (size_t)surface->triangle_count, sizeof(uint32_t));
    if (surface->vertex_first_face == NULL || surface->vertex_faces == NULL) {
        return false;
    }
    uint32_t *cursor = surface->vertex_first_face + 1;
    for (uint32_t side = 0; side < 3 * surface->triangle_count; side++) {
        cursor[triangles[side] + 1]++;
    }
    for (uint32_t v = 0; v < surface->vertex_count; v++) {
        cursor[v + 1] += cursor[v];
    }
    for (uint32_t side = 0; side < 3 * surface->triangle_count; side++) {
        surface->vertex_faces[cursor[triangles[side]]++] = side / 3;
    }
    return true;
}

// ---- pins and open seams ----

static bool build_pins(PercaleModel *model, const PercaleObjects *objects, PercaleMemory *memory)
{
    size_t total = 0;
    for (size_t p = 0; p < objects->pin_count; p++) {
        total += objects->pins[p].vertex_count;
    }
    model->pinned_slots = percale_memory_new(memory, total, sizeof(uint32_t));
    model->pinned_sources = percale_memory_new(memory, total, sizeof(model->pinned_sources[0]));
    if (model->pinned_slots == NULL || model->pinned_sources == NULL) {
        return false;
    }
    for (uint32_t p = 0; p < objects->pin_count; p++) {
        const PercalePinObject *pin = &objects->pins[p];
        size_t c = percale_find_cloth(objects, pin->cloth);
        for (uint32_t i = 0; i < pin->vertex_count; i++) {
            uint32_t slot = model->cloths[c].slots[pin->vertices[i]];
            model->position[slot][3] = 0.0f;
            model->pinned_slots[model->pinned_count] = slot;
            model->pinned_sources[model->pinned_count][0] = p;
            model->pinned_sources[model->pinned_count++][1] = i;
        }
    }
    return true;
}

static bool build_open_seams(PercaleModel *model, const PercaleObjects *objects, PercaleMemory *memory)
{
    size_t total = 0;
    for (size_t s = 0; s < objects->seam_count; s++) {
        total += objects->seams[s].pair_count;
    }
    model->open_seams = percale_memory_new(memory, total, sizeof(model->open_seams[0]));
    if (model->open_seams == NULL) {
        return false;
    }
    for (uint32_t s = 0; s < objects->seam_count; s++) {
        const PercaleSeamObject *seam = &objects->seams[s];
        const PercaleModelCloth *a = &model->cloths[percale_find_cloth(objects, seam->cloth_a)];
        const PercaleModelCloth *b = &model->cloths[percale_find_cloth(objects, seam->cloth_b)];
        for (uint32_t i = 0; i < seam->pair_count; i++) {
            uint32_t slot_a = a->slots[seam->vertices_a[i]];
            uint32_t slot_b = b->slots[seam->vertices_b[i]];
            if (slot_a != slot_b) {
                model->open_seams[model->open_seam_count++] = (PercaleOpenSeam){{slot_a, slot_b}, s, i};
            }
        }
    }
    return true;
}

// ---- obstacles ----

static bool is_closed(const PercaleEdges *edges, const uint32_t *triangles)
{
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        uint32_t first = edges->first_side[e];
        if (edges->first_side[e + 1] - first != 2 ||
            triangles[edges->sides[first]] == triangles[edges->sides[first + 1]]) {
            return false;
        }
    }
    return true;
}

/// Edges, and after them the pairs of open seams, which will be one point: ways of no length.
static void list_ways(const PercaleModel *model, uint32_t (*ways)[2], float *lengths)
{
    memcpy(ways, model->edges, model->edge_count * sizeof(ways[0]));
    memcpy(lengths, model->edge_lengths, model->edge_count * sizeof(lengths[0]));
    for (uint32_t s = 0; s < model->open_seam_count; s++) {
        uint32_t way = model->edge_count + s;
        memcpy(ways[way], model->open_seams[s].slots, sizeof(ways[0]));
        lengths[way] = 0.0f;
    }
}

/// Twice the greatest thickness: farther apart two vertices can always keep theirs.
static bool build_near(PercaleModel *model, PercaleMemory *memory)
{
    uint32_t count = model->edge_count + model->open_seam_count;
    uint32_t(*ways)[2] = percale_memory_new(memory, count, sizeof(ways[0]));
    float *lengths = percale_memory_new(memory, count, sizeof(float));
    bool complete = ways != NULL && lengths != NULL;
    if (complete) {
        list_ways(model, ways, lengths);
        complete = percale_near_build(&model->near, model->slot_count, (const uint32_t(*)[2])ways, lengths,
                                      count, 2.0f * thickest_cloth(model), memory);
    }
    percale_memory_free(memory, ways);
    percale_memory_free(memory, lengths);
    return complete;
}

static Vec3 area_of(const float *x, const uint32_t *corners)
{
    Vec3 p[3];
    for (int k = 0; k < 3; k++) {
        const float *corner = x + 3 * (size_t)corners[k];
        p[k] = (Vec3){(double)corner[0], (double)corner[1], (double)corner[2]};
    }
    return vcross(vsub(p[1], p[0]), vsub(p[2], p[0]));
}

/// Finds the edges at whose sides lie two faces that turn by less than 45 degrees as added, and the vertices
/// that have no other edges.
static bool find_smooth(PercaleModelSurface *obstacle, const PercaleObstacleObject *object,
                        PercaleMemory *memory)
{
    const double SMOOTH = 0.7; // least cosine between the faces
    const PercaleEdges *edges = &obstacle->edges;
    obstacle->smooth_edges = percale_memory_new(memory, edges->edge_count, 1);
    obstacle->smooth_vertices = percale_memory_new(memory, obstacle->vertex_count, 1);
    if (obstacle->smooth_edges == NULL || obstacle->smooth_vertices == NULL) {
        return false;
    }
    memset(obstacle->smooth_vertices, 1, obstacle->vertex_count);
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        uint32_t first = edges->first_side[e];
        if (edges->first_side[e + 1] - first == 2) {
            Vec3 a = area_of(object->base, object->triangles + 3 * (size_t)(edges->sides[first] / 3));
            Vec3 b = area_of(object->base, object->triangles + 3 * (size_t)(edges->sides[first + 1] / 3));
            obstacle->smooth_edges[e] = vdot(a, b) > SMOOTH * vlength(a) * vlength(b);
        }
        for (int k = 0; k < 2; k++) {
            obstacle->smooth_vertices[edges->vertices[e][k]] &= obstacle->smooth_edges[e];
        }
    }
    return true;
}

static bool build_obstacle(PercaleModelSurface *obstacle, const PercaleObstacleObject *object,
                           uint32_t first_point, PercaleMemory *memory)
{
    *obstacle = (PercaleModelSurface){.first_point = first_point,
                                      .vertex_count = object->vertex_count,
                                      .triangle_count = object->triangle_count,
                                      .thickness = object->thickness,
                                      .friction = object->friction,
                                      .mask = object->mask,
                                      .rigid = object->motion != MOTION_DEFORMING,
                                      .still = object->motion == MOTION_STATIC};
    obstacle->triangles = percale_memory_new(memory, 3 * (size_t)object->triangle_count, sizeof(uint32_t));
    if (obstacle->triangles == NULL ||
        !percale_edges_build(object->triangles, object->triangle_count, memory, &obstacle->edges) ||
        !build_vertex_faces(obstacle, object->triangles, memory) || !find_smooth(obstacle, object, memory)) {
        return false;
    }
    for (size_t side = 0; side < 3 * (size_t)object->triangle_count; side++) {
        obstacle->triangles[side] = first_point + object->triangles[side];
    }
    obstacle->closed = is_closed(&obstacle->edges, object->triangles);
    return true;
}

static bool build_obstacles(PercaleModel *model, const PercaleObjects *objects, PercaleMemory *memory)
{
    model->obstacles = percale_memory_new(memory, objects->obstacle_count, sizeof(model->obstacles[0]));
    if (model->obstacles == NULL) {
        return false;
    }
    model->obstacle_count = (uint32_t)objects->obstacle_count;
    uint32_t first_point = model->slot_count;
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        if (!build_obstacle(&model->obstacles[o], &objects->obstacles[o], first_point, memory)) {
            return false;
        }
        first_point += objects->obstacles[o].vertex_count;
    }
    return true;
}

// ---- entry points ----

PercaleResult percale_model_assemble(PercaleModel *model, PercaleObjects *objects, PercaleParts parts,
                                     PercaleMemory *memory, PercaleMessage *message)
{
    *model = (PercaleModel){0};
    Weld weld = {0};
    bool complete = weld_closed_seams(&weld, objects, memory) &&
                    number_slots(model, objects, &weld, memory) && build_points(model, objects, memory) &&
                    build_vertex_faces(&model->cloth, model->cloth.triangles, memory) &&
                    build_pins(model, objects, memory) && build_open_seams(model, objects, memory) &&
                    build_obstacles(model, objects, memory) &&
                    percale_model_build_constraints(model, objects, parts, memory) &&
                    (!parts.pairs || build_near(model, memory));
    percale_memory_free(memory, weld.parent);
    percale_memory_free(memory, weld.first_vertex);
    if (!complete) {
        percale_model_free(model, memory);
        return percale_fail_memory(message);
    }
    return PERCALE_OK;
}

static void free_surface(PercaleModelSurface *surface, PercaleMemory *memory)
{
    percale_memory_free(memory, surface->triangles);
    percale_edges_free(&surface->edges, memory);
    percale_memory_free(memory, surface->vertex_first_face);
    percale_memory_free(memory, surface->smooth_edges);
    percale_memory_free(memory, surface->smooth_vertices);
    percale_memory_free(memory, surface->vertex_faces);
}

void percale_model_free(PercaleModel *model, PercaleMemory *memory)
{
    for (uint32_t c = 0; model->cloths != NULL && c < model->cloth_count; c++) {
        percale_memory_free(memory, model->cloths[c].slots);
    }
    for (uint32_t o = 0; o < model->obstacle_count; o++) {
        free_surface(&model->obstacles[o], memory);
    }
    free_surface(&model->cloth, memory);
    percale_near_free(&model->near, memory);
    percale_coarse_free(&model->coarse, memory);
    void *arrays[] = {
        model->cloths,        model->obstacles,         model->position,         model->velocity,
        model->predicted,     model->next_velocity,     model->cloth_of,         model->triangle_areas,
        model->edges,         model->edge_lengths,      model->edge_compliances, model->hinges,
        model->hinge_weights, model->hinge_stiffnesses, model->tether_anchors,   model->tether_lengths,
        model->open_seams,    model->pinned_slots,      model->pinned_sources};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); i++) {
        percale_memory_free(memory, arrays[i]);
    }
    *model = (PercaleModel){0};
}

void percale_model_store(const PercaleModel *model, PercaleObjects *objects)
{
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        for (uint32_t i = 0; i < model->cloths[c].vertex_count; i++) {
            uint32_t slot = model->cloths[c].slots[i];
            for (int axis = 0; axis < 3; axis++) {
                objects->cloths[c].positions[3 * (size_t)i + (size_t)axis] = model->position[slot][axis];
                objects->cloths[c].velocities[3 * (size_t)i + (size_t)axis] = model->velocity[slot][axis];
            }
        }
    }
}
