#include "model/tethers.h"

static const float SLACK = 1.0002f; // of a tether's length: what the way along the mesh may be too short by

/// The pinned slots, island after island.
typedef struct Islands {
    uint32_t *slots;  // [pinned_count]
    uint32_t *island; // [slot_count] 1 + the slot's, 0 for what is not pinned
    uint32_t *first;  // [count + 1] into slots
    uint32_t count, slot_count;
} Islands;

/// Joins pinned slots that share an edge: each takes over the smaller mark until nothing changes.
static void join_neighbours(const PercaleModel *model, uint32_t *mark)
{
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t e = 0; e < model->edge_count; e++) {
            uint32_t *a = &mark[model->edges[e][0]];
            uint32_t *b = &mark[model->edges[e][1]];
            if (*a != 0 && *b != 0 && *a != *b) {
                *a = *b = *a < *b ? *a : *b;
                changed = true;
            }
        }
    }
}

static bool find_islands(const PercaleModel *model, PercaleMemory *memory, Islands *islands)
{
    islands->slots = percale_memory_new(memory, model->pinned_count, sizeof(uint32_t));
    islands->island = percale_memory_new(memory, model->slot_count, sizeof(uint32_t));
    islands->first = percale_memory_new(memory, (size_t)model->pinned_count + 1, sizeof(uint32_t));
    if (islands->slots == NULL || islands->island == NULL || islands->first == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < model->pinned_count; i++) {
        islands->island[model->pinned_slots[i]] = 1 + model->pinned_slots[i];
    }
    join_neighbours(model, islands->island);
    for (uint32_t slot = 0; slot < model->slot_count; slot++) { // marks are the islands' first slots
        if (islands->island[slot] != 1 + slot) {
            continue;
        }
        for (uint32_t other = slot; other < model->slot_count; other++) {
            if (islands->island[other] == 1 + slot) {
                islands->slots[islands->slot_count++] = other;
            }
        }
        islands->first[++islands->count] = islands->slot_count;
    }
    return true;
}

static void free_islands(Islands *islands, PercaleMemory *memory)
{
    percale_memory_free(memory, islands->slots);
    percale_memory_free(memory, islands->island);
    percale_memory_free(memory, islands->first);
}

/// One layer: tethers to the nearest of some pinned slots.
static bool add_layer(PercaleModel *model, const PercaleGeodesicMesh *mesh, const uint32_t *sources,
                      uint32_t source_count, PercaleMemory *memory)
{
    size_t first = (size_t)model->tether_layers * model->slot_count;
    float *lengths = model->tether_lengths + first;
    uint32_t *anchors = model->tether_anchors + first;
    if (!percale_geodesic_run(mesh, sources, source_count, memory, lengths, anchors)) {
        return false;
    }
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        bool held = anchors[slot] != UINT32_MAX;
        anchors[slot] = POINT_BYTES * (held ? sources[anchors[slot]] : slot);
        lengths[slot] *= SLACK;
        model->tether_count += held && model->position[slot][3] > 0.0f;
    }
    model->tether_layers++;
    return true;
}

static bool add_layers(PercaleModel *model, const PercaleGeodesicMesh *mesh, const Islands *islands,
                       PercaleMemory *memory)
{
    bool apart = islands->count <= TETHER_LAYERS;
    uint32_t layer_count = apart ? islands->count : 1;
    size_t total = (size_t)layer_count * model->slot_count;
    model->tether_anchors = percale_memory_new(memory, total, sizeof(uint32_t));
    model->tether_lengths = percale_memory_new(memory, total, sizeof(float));
    bool complete = model->tether_anchors != NULL && model->tether_lengths != NULL;
    for (uint32_t i = 0; complete && i < layer_count; i++) {
        uint32_t first = apart ? islands->first[i] : 0;
        uint32_t end = apart ? islands->first[i + 1] : islands->slot_count;
        complete = add_layer(model, mesh, islands->slots + first, end - first, memory);
    }
    return complete;
}

bool percale_tethers_build(PercaleModel *model, const PercaleGeodesicMesh *mesh, PercaleMemory *memory)
{
    if (model->pinned_count == 0 || model->edge_compliances != NULL) {
        return true;
    }
    Islands islands = {0};
    bool complete = find_islands(model, memory, &islands) && add_layers(model, mesh, &islands, memory);
    free_islands(&islands, memory);
    return complete;
}
