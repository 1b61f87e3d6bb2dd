// neighbors.h: which of some triangles a vertex may touch, which of some edges an edge may: eight at a time.
//
//   in   points at the start and the end of their ways, queries, pairs of one and a primitive
//   out  those within the query's reach at the end, or that its way may have crossed
//
// The eight are pairs of any queries: an item has often but one or two. Distances are float32 and err on the
// near side: who asks decides in double.

#ifndef PERCALE_NEIGHBORS_H
#define PERCALE_NEIGHBORS_H

#include "base/memory.h"
#include "base/simd.h"

/// A primitive that a query may touch.
typedef struct PercaleNeighbor {
    uint32_t place; // of the query
    uint32_t index;
    float distance; // m, at the end; at most this near
    uint32_t pair;  // among those that were asked
    bool may_pass;  // the ways touch: one may have gone through the other
    bool watched;   // for who asks: it wants to see the pair again as long as it is within reach
} PercaleNeighbor;

typedef struct PercaleNeighborList {
    PercaleNeighbor *items;
    size_t count, capacity;
} PercaleNeighborList;

/// An item (a vertex or an edge, by its place in some order) and a primitive that it may come to touch. They
/// have no point in common.
typedef struct PercaleItemPair {
    uint32_t place, primitive;
    float distance; // m, when they were found or asked
} PercaleItemPair;

typedef struct PercaleItemPairList {
    PercaleItemPair *items;
    size_t count, capacity;
} PercaleItemPairList;

/// What is asked: triangles by vertices, or edges by edges.
typedef struct PercaleNeighborhood {
    const uint32_t *primitives; // [arity * count] points
    uint32_t arity;             // 3 or 2
    const f32x4 *from, *to;     // where the points' ways begin and end
    float wider;                // m, beyond the queries' reach
    bool only_passing;          // nothing is within reach but what overlaps
    bool all_near;              // distances aren't asked
    bool ends_too;              // else two edges are near only where both are closest inside
} PercaleNeighborhood;

/// A vertex (twice the same point) or an edge.
typedef struct PercaleQuery {
    uint32_t points[2];
    float reach; // m
} PercaleQuery;

/// All items of one kind as queries, by their places in an order.
typedef struct PercaleQueries {
    const uint32_t (*edges)[2]; // NULL: the items are vertices
    const uint32_t *order;      // item at each place; NULL: all, as they are
    uint32_t first_point;       // of the mesh
    const float *reaches;       // by place, m; NULL: that of all
    float reach;                // m, the largest
} PercaleQueries;

static inline uint32_t query_item(const PercaleQueries *queries, uint32_t place)
{
    return queries->order != NULL ? queries->order[place] : place;
}

static inline PercaleQuery query_at(const PercaleQueries *queries, uint32_t place)
{
    uint32_t item = query_item(queries, place);
    uint32_t ends[2] = {item, item};
    if (queries->edges != NULL) {
        ends[0] = queries->edges[item][0];
        ends[1] = queries->edges[item][1];
    }
    return (PercaleQuery){{queries->first_point + ends[0], queries->first_point + ends[1]},
                          queries->reaches != NULL ? queries->reaches[place] : queries->reach};
}

/// The neighbours among `count` pairs, in their order, appended to the list; each pair's distance becomes
/// that of now. False without memory.
bool percale_neighbors_find(const PercaleNeighborhood *hood, const PercaleQueries *queries,
                            PercaleItemPair *pairs, size_t count, PercaleMemory *memory,
                            PercaleNeighborList *list);

#endif
