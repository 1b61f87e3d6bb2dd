#include "detect/nearby.h"

// Of a distance, more than rounding in float32 and double can take from it.
static const double SLACK = 1e-5;

bool percale_nearby_create(PercaleNearbyLists *lists, uint32_t slot_count, PercaleMemory *memory)
{
    *lists = (PercaleNearbyLists){.number = percale_memory_new(memory, slot_count, sizeof(uint32_t))};
    for (uint32_t slot = 0; lists->number != NULL && slot < slot_count; slot++) {
        lists->number[slot] = NO_LIST;
    }
    return lists->number != NULL;
}

void percale_nearby_free(PercaleNearbyLists *lists, PercaleMemory *memory)
{
    percale_memory_free(memory, lists->number);
    percale_memory_free(memory, lists->items);
    *lists = (PercaleNearbyLists){0};
}

bool percale_nearby_reserve(PercaleNearbyLists *lists, const uint32_t *slots, uint32_t slot_count,
                            PercaleMemory *memory)
{
    size_t needed = lists->count;
    for (uint32_t i = 0; i < slot_count; i++) {
        needed += lists->number[slots[i]] == NO_LIST;
    }
    if (!percale_memory_reserve(memory, &lists->items, &lists->capacity, needed, sizeof(lists->items[0]))) {
        return false;
    }
    for (uint32_t i = 0; lists->count < needed && i < slot_count; i++) {
        if (lists->number[slots[i]] == NO_LIST) {
            lists->items[lists->count] = (PercaleNearby){.count = 0};
            lists->number[slots[i]] = (uint32_t)lists->count++;
        }
    }
    return true;
}

/// How far the vertex and the obstacle have moved since the list was made, m.
static double moved_since(const PercaleNearby *nearby, const PercaleNearbyQuery *query)
{
    double moved = vlength(vsub(query->point, vec3_of(nearby->place)));
    return (1.0 + SLACK) * (moved + fabs(query->traveled - nearby->traveled));
}

/// Of the list, how many can be within the radius now that so much has moved.
static uint32_t count_within(const PercaleNearby *nearby, double radius, double moved)
{
    uint32_t count = 0;
    while (count < nearby->count && (double)nearby->distances[count] <= radius + moved) {
        count++;
    }
    return count;
}

bool percale_nearby_nearest(const PercaleNearbyLists *lists, uint32_t slot, const PercaleNearbyQuery *query,
                            PercaleNearest *nearest)
{
    if (lists->number[slot] == NO_LIST) {
        return false;
    }
    const PercaleNearby *nearby = &lists->items[lists->number[slot]];
    double moved = moved_since(nearby, query);
    double reach = (double)nearby->place[3] - moved; // within it every triangle is listed
    if (!(reach > 0.0)) {
        return false;
    }
    double radius = fmin(query->radius, reach);
    uint32_t few = nearby->count < CLOSEST_FOUR ? nearby->count
                                                : CLOSEST_FOUR; // usually the nearest is one of the first
    *nearest = percale_surface_nearest_of(query->surface, query->point, radius, nearby->triangles, few);
    double farthest = nearest->triangle == NO_TRIANGLE ? radius : sqrt(nearest->closest.distance2);
    uint32_t count = count_within(nearby, farthest, moved);
    if (count > few) {
        *nearest = percale_surface_nearest_of(query->surface, query->point, radius, nearby->triangles, count);
    }
    if (nearest->triangle == NO_TRIANGLE) { // nor is any other nearer
        nearest->closest.distance2 = radius * radius;
    }
    return nearest->triangle != NO_TRIANGLE || query->radius <= reach;
}

/// Puts a feature where it belongs in the order of distance. Returns the distance of what there is no room
/// for, infinite for nothing.
static double insert(PercaleNearby *nearby, const PercaleFeature *feature)
{
    double distance = (1.0 - SLACK) * sqrt(feature->closest.distance2);
    double dropped = HUGE_VAL;
    uint32_t at = nearby->count;
    if (at == NEARBY_MOST) {
        dropped = fmax(distance, (double)nearby->distances[--at]);
        if (dropped <= distance) {
            return dropped;
        }
    } else {
        nearby->count++;
    }
    for (; at > 0 && (double)nearby->distances[at - 1] > distance; at--) {
        nearby->distances[at] = nearby->distances[at - 1];
        nearby->triangles[at] = nearby->triangles[at - 1];
    }
    nearby->distances[at] = (float)distance;
    nearby->triangles[at] = feature->triangle;
    return dropped;
}

/// Lists all features within the radius, or as far as there is room for.
static void fill(PercaleNearby *nearby, const PercaleNearbyQuery *query, double radius,
                 const PercaleFeatureList *features)
{
    double complete = radius;
    nearby->count = 0;
    for (size_t i = 0; i < features->count; i++) {
        complete = fmin(complete, insert(nearby, &features->items[i]));
    }
    nearby->place = f32x4_of(query->point, (float)((1.0 - SLACK) * complete));
    nearby->traveled = query->traveled;
}

/// Drops what is beyond the radius.
static void cut(PercaleFeatureList *list, double radius)
{
    size_t kept = 0;
    for (size_t i = 0; i < list->count; i++) {
        if (list->items[i].closest.distance2 <= radius * radius) {
            list->items[kept++] = list->items[i];
        }
    }
    list->count = kept;
}

bool percale_nearby_gather(PercaleNearby *nearby, const PercaleNearbyQuery *query, double room,
                           PercaleMemory *memory, PercaleFeatureList *list)
{
    double moved = moved_since(nearby, query);
    if ((double)nearby->place[3] - moved >= query->radius) {
        return percale_surface_gather_of(query->surface, query->point, query->radius, nearby->triangles,
                                         count_within(nearby, query->radius, moved), memory, list);
    }
    if (nearby->place[3] < 0.0f && moved < room) {
        return percale_surface_gather(query->surface, query->point, query->radius, memory, list);
    }
    if (!percale_surface_gather(query->surface, query->point, query->radius + room, memory, list)) {
        return false;
    }
    fill(nearby, query, query->radius + room, list);
    cut(list, query->radius);
    if ((double)nearby->place[3] < query->radius) {
        nearby->place[3] = -1.0f;
        nearby->count = 0;
    }
    return true;
}
