// nearby.h: the triangles of an obstacle that are near a vertex, kept while neither has moved much.
//
//   in   a vertex, the obstacle's surface, how far it has traveled
//   out  the vertex's nearest feature and all features within a radius: the same bits as by the tree
//
// A list holds every triangle within some radius of the place where it was made. Elsewhere it holds every
// triangle within that radius less what vertex and obstacle have moved since: no distance shrinks faster than
// its two ends move. A vertex that rests on a body, or slides along, is so answered from a few triangles.

#ifndef PERCALE_NEARBY_H
#define PERCALE_NEARBY_H

#include "detect/surface.h"

enum { NEARBY_MOST = 12 }; // triangles; where there are more, the list reaches less far

typedef struct PercaleNearby {
    f32x4 place;     // where it was made; [3] is the radius, m: below zero, the triangles are too dense here
    double traveled; // by the obstacle until then, m
    uint32_t count;
    uint32_t triangles[NEARBY_MOST]; // the nearest first
    float distances[NEARBY_MOST];    // m, or a little less
} PercaleNearby;

/// What is asked at a place.
typedef struct PercaleNearbyQuery {
    const PercaleSurface *surface;
    double traveled; // by the obstacle until now, m: since the model was assembled no point of it has moved
                     // farther
    Vec3 point;
    double radius; // m
} PercaleNearbyQuery;

/// One for each vertex that has ever been active.
typedef struct PercaleNearbyLists {
    uint32_t *number; // [slot_count] of the slot's list, NO_LIST
    PercaleNearby *items;
    size_t count, capacity;
} PercaleNearbyLists;

static const uint32_t NO_LIST = UINT32_MAX;

bool percale_nearby_create(PercaleNearbyLists *lists, uint32_t slot_count, PercaleMemory *memory);
void percale_nearby_free(PercaleNearbyLists *lists, PercaleMemory *memory);

/// Gives each of these slots a list, empty at first. False without memory.
bool percale_nearby_reserve(PercaleNearbyLists *lists, const uint32_t *slots, uint32_t slot_count,
                            PercaleMemory *memory);

/// What percale_surface_nearest would say; false when the list doesn't reach far enough to tell.
bool percale_nearby_nearest(const PercaleNearbyLists *lists, uint32_t slot, const PercaleNearbyQuery *query,
                            PercaleNearest *nearest);

/// What percale_surface_gather would find, in any order, at a place that float32 can name. A list that
/// doesn't reach far enough is made anew, with that much `room` beyond the radius. False without memory.
bool percale_nearby_gather(PercaleNearby *nearby, const PercaleNearbyQuery *query, double room,
                           PercaleMemory *memory, PercaleFeatureList *list);

#endif
