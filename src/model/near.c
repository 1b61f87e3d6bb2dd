#include "model/near.h"

#include <string.h>

/// Edges at each slot.
typedef struct Ways {
    uint32_t *first; // [slot_count + 1]
    uint32_t *to;
    float *lengths;
} Ways;

/// A slot on the way outward from one.
typedef struct Place {
    uint32_t slot;
    float distance; // m
    bool settled;   // no shorter way is left
} Place;

typedef struct Places {
    Place items[NEAR_MOST + 1];
    uint32_t count;
    float radius;
} Places;

static void free_ways(Ways *ways, PercaleMemory *memory)
{
    percale_memory_free(memory, ways->first);
    percale_memory_free(memory, ways->to);
    percale_memory_free(memory, ways->lengths);
}

static bool build_ways(Ways *ways, uint32_t slot_count, const uint32_t (*edges)[2], const float *edge_lengths,
                       uint32_t edge_count, PercaleMemory *memory)
{
    ways->first = percale_memory_new(memory, (size_t)slot_count + 2, sizeof(uint32_t));
    ways->to = percale_memory_new(memory, 2 * (size_t)edge_count, sizeof(uint32_t));
    ways->lengths = percale_memory_new(memory, 2 * (size_t)edge_count, sizeof(float));
    if (ways->first == NULL || ways->to == NULL || ways->lengths == NULL) {
        return false;
    }
    uint32_t *cursor = ways->first + 1;
    for (uint32_t e = 0; e < edge_count; e++) {
        cursor[edges[e][0] + 1]++;
        cursor[edges[e][1] + 1]++;
    }
    for (uint32_t slot = 0; slot < slot_count; slot++) {
        cursor[slot + 1] += cursor[slot];
    }
    for (uint32_t e = 0; e < edge_count; e++) {
        for (int end = 0; end < 2; end++) {
            uint32_t at = cursor[edges[e][end]]++;
            ways->to[at] = edges[e][1 - end];
            ways->lengths[at] = edge_lengths[e];
        }
    }
    return true;
}

/// Keeps a way of this length; when there is no room it is the radius that shrinks.
static void reach_slot(Places *places, uint32_t slot, float distance)
{
    if (!(distance < places->radius)) {
        return;
    }
    for (uint32_t i = 0; i < places->count; i++) {
        if (places->items[i].slot == slot) {
            if (distance < places->items[i].distance) {
                places->items[i].distance = distance;
            }
            return;
        }
    }
    if (places->count <= NEAR_MOST) {
        places->items[places->count++] = (Place){slot, distance, false};
    } else {
        places->radius = distance;
    }
}

/// Dijkstra (1959) from one slot; places[0] is the slot itself. Ascending by slot at the end, itself and what
/// the shrunk radius has left outside dropped.
static void spread_from(const Ways *ways, uint32_t slot, float radius, Places *places)
{
    places->radius = radius;
    places->count = 1;
    places->items[0] = (Place){slot, 0.0f, false};
    for (;;) {
        Place *next = NULL;
        for (uint32_t i = 0; i < places->count; i++) {
            Place *place = &places->items[i];
            if (!place->settled && (next == NULL || place->distance < next->distance)) {
                next = place;
            }
        }
        if (next == NULL || !(next->distance < places->radius)) {
            break;
        }
        next->settled = true;
        uint32_t from = next->slot;
        float distance = next->distance;
        for (uint32_t i = ways->first[from]; i < ways->first[from + 1]; i++) {
            reach_slot(places, ways->to[i], distance + ways->lengths[i]);
        }
    }
    uint32_t count = 0;
    for (uint32_t i = 1; i < places->count; i++) {
        Place place = places->items[i];
        if (!(place.distance < places->radius)) {
            continue;
        }
        uint32_t at = count++;
        for (; at > 0 && places->items[at - 1].slot > place.slot; at--) {
            places->items[at] = places->items[at - 1];
        }
        places->items[at] = place;
    }
    places->count = count;
}

/// Gives back what a list that has grown doesn't need.
static bool trim(void *array, size_t count, size_t element_size, PercaleMemory *memory)
{
    void *list;
    memcpy(&list, array, sizeof(list));
    void *block = percale_memory_new(memory, count, element_size);
    if (block == NULL) {
        return false;
    }
    memcpy(block, list, count * element_size);
    percale_memory_free(memory, list);
    memcpy(array, &block, sizeof(block));
    return true;
}

static bool list_places(PercaleNear *near, uint32_t slot_count, const Ways *ways, float radius,
                        PercaleMemory *memory)
{
    size_t slot_capacity = 0;
    size_t distance_capacity = 0;
    uint32_t count = 0;
    Places places;
    for (uint32_t slot = 0; slot < slot_count; slot++) {
        spread_from(ways, slot, radius, &places);
        size_t needed = (size_t)count + places.count + 1; // one more: an empty list has an address too
        if (!percale_memory_reserve(memory, &near->slots, &slot_capacity, needed, sizeof(uint32_t)) ||
            !percale_memory_reserve(memory, &near->distances, &distance_capacity, needed, sizeof(float))) {
            return false;
        }
        for (uint32_t i = 0; i < places.count; i++) {
            near->slots[count + i] = places.items[i].slot;
            near->distances[count + i] = places.items[i].distance;
        }
        count += places.count;
        near->first[slot + 1] = count;
        near->radius[slot] = places.radius;
    }
    return slot_count == 0 || (trim(&near->slots, count, sizeof(uint32_t), memory) &&
                               trim(&near->distances, count, sizeof(float), memory));
}

bool percale_near_build(PercaleNear *near, uint32_t slot_count, const uint32_t (*edges)[2],
                        const float *edge_lengths, uint32_t edge_count, float radius, PercaleMemory *memory)
{
    *near = (PercaleNear){0};
    near->first = percale_memory_new(memory, (size_t)slot_count + 1, sizeof(uint32_t));
    near->radius = percale_memory_new(memory, slot_count, sizeof(float));
    Ways ways = {0};
    bool complete = near->first != NULL && near->radius != NULL &&
                    build_ways(&ways, slot_count, edges, edge_lengths, edge_count, memory) &&
                    list_places(near, slot_count, &ways, radius, memory);
    free_ways(&ways, memory);
    if (!complete) {
        percale_near_free(near, memory);
    }
    return complete;
}

void percale_near_free(PercaleNear *near, PercaleMemory *memory)
{
    percale_memory_free(memory, near->first);
    percale_memory_free(memory, near->slots);
    percale_memory_free(memory, near->distances);
    percale_memory_free(memory, near->radius);
    *near = (PercaleNear){0};
}
