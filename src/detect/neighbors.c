#include "detect/neighbors.h"

#include "base/wide.h"

// What float32 may be wrong by: of a distance, and of a place on an edge as a share of it.
static const float DISTANCE_SLACK = 0.01f;
static const float PLACE_SLACK = 0.01f;

// Squared sine below which float32 doesn't know where two edges are closest. Wherever it is on one of them,
// the distance is wrong by no more than this angle's share of their length.
static const float PARALLEL = 1e-4f;
static const float PARALLEL_SLACK = 2e-3f;

// Of the sum of some coordinates, what a few operations round away.
static const float ROUNDED = 1e-6f;

static const float TINY = 1e-30f; // keeps a quotient of two zeros finite

enum { EIGHT = 8 };

// ---- eight distances ----

static inline WidePoints minus(WidePoints a, WidePoints b)
{
    return (WidePoints){a.x - b.x, a.y - b.y, a.z - b.z};
}

/// a + s b.
static inline WidePoints plus(WidePoints a, f32x8 s, WidePoints b)
{
    return (WidePoints){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline f32x8 dot(WidePoints a, WidePoints b)
{
    return (a.x * b.x + a.y * b.y) + a.z * b.z;
}

static inline WidePoints cross(WidePoints a, WidePoints b)
{
    return (WidePoints){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Into [0, 1].
static inline f32x8 clamp8(f32x8 a)
{
    return min8(max8(a, all8(0.0f)), all8(1.0f));
}

/// Squared distance of the origin to the segments from a to b.
static inline f32x8 to_segment(WidePoints a, WidePoints b)
{
    WidePoints along = minus(b, a);
    f32x8 t = clamp8(-dot(a, along) / max8(dot(along, along), all8(TINY)));
    WidePoints foot = plus(a, t, along);
    return dot(foot, foot);
}

/// Squared distance of the origin to the triangles, or a little less.
static inline f32x8 to_triangle(WidePoints a, WidePoints b, WidePoints c)
{
    WidePoints normal = cross(minus(b, a), minus(c, a));
    f32x8 size2 = dot(normal, normal);
    f32x8 least = -PLACE_SLACK * size2;
    i32x8 above = greater8(dot(normal, cross(b, c)), least) & greater8(dot(normal, cross(c, a)), least) &
                  greater8(dot(normal, cross(a, b)), least);
    f32x8 across = dot(a, normal);
    f32x8 to_plane = across * across / max8(size2, all8(TINY));
    f32x8 to_rim = min8(min8(to_segment(a, b), to_segment(b, c)), to_segment(c, a));
    return select8(above & greater8(size2, all8(0.0f)), to_plane, to_rim);
}

/// How far eight primitives are from the query, at most this near.
typedef struct Distances {
    f32x8 distance; // m; what float32 may be wrong by is taken away
    i32x8 inside;   // of two edges, that both closest points may be inside them
} Distances;

/// `a` and `b` are the edges, `c` goes from the second's start to the first's.
static inline Distances between_edges(WidePoints a, WidePoints b, WidePoints c)
{
    f32x8 aa = max8(dot(a, a), all8(TINY));
    f32x8 bb = max8(dot(b, b), all8(TINY));
    f32x8 ab = dot(a, b);
    f32x8 ac = dot(a, c);
    f32x8 bc = dot(b, c);
    f32x8 sine2 = aa * bb - ab * ab;
    i32x8 parallel = at_most8(sine2, PARALLEL * aa * bb);
    sine2 = max8(sine2, all8(TINY));
    f32x8 s = (ab * bc - bb * ac) / sine2;
    f32x8 t = (aa * bc - ab * ac) / sine2;
    f32x8 low = all8(-PLACE_SLACK);
    f32x8 high = all8(1.0f + PLACE_SLACK);
    i32x8 inside = greater8(s, low) & greater8(high, s) & greater8(t, low) & greater8(high, t);
    s = clamp8(select8(parallel, all8(0.5f), s));
    for (int i = 0; i < 2; i++) { // of parallel edges any place will do, once the other's is found for it
        t = clamp8((ab * s + bc) / bb);
        s = clamp8((ab * t - ac) / aa);
    }
    WidePoints between = plus(plus(c, s, a), -t, b);
    f32x8 distance = (1.0f - DISTANCE_SLACK) * sqrt8(dot(between, between));
    return (Distances){distance - PARALLEL_SLACK * sqrt8(max8(aa, bb)), inside | parallel};
}

// ---- neighbours ----

/// The points of eight pairs.
typedef struct Eight {
    uint32_t own[2][EIGHT], corners[3][EIGHT];
    float reach[EIGHT];
} Eight;

/// Names the first `count` of some pairs; in the place of others it repeats the first.
static void name_eight(const PercaleNeighborhood *hood, const PercaleQueries *queries,
                       const PercaleItemPair *pairs, size_t count, Eight *eight)
{
    for (size_t k = 0; k < EIGHT; k++) {
        const PercaleItemPair *pair = &pairs[k < count ? k : 0];
        const PercaleQuery query = query_at(queries, pair->place);
        const uint32_t *corners = hood->primitives + (size_t)hood->arity * pair->primitive;
        eight->own[0][k] = query.points[0];
        eight->own[1][k] = query.points[1];
        eight->corners[0][k] = corners[0];
        eight->corners[1][k] = corners[1];
        eight->corners[2][k] = corners[hood->arity - 1];
        eight->reach[k] = hood->only_passing ? 0.0f : query.reach + hood->wider;
    }
}

static inline f32x8 size8(f32x8 a)
{
    return (f32x8)((i32x8)a & INT32_MAX);
}

static inline WidePoints least_of(WidePoints a, WidePoints b)
{
    return (WidePoints){min8(a.x, b.x), min8(a.y, b.y), min8(a.z, b.z)};
}

static inline WidePoints most_of(WidePoints a, WidePoints b)
{
    return (WidePoints){max8(a.x, b.x), max8(a.y, b.y), max8(a.z, b.z)};
}

/// Boxes of eight.
typedef struct Boxes {
    WidePoints low, high;
} Boxes;

/// Widens one axis by what float32 may have rounded away; returns that.
static inline f32x8 widen(f32x8 *low, f32x8 *high, f32x8 carried)
{
    f32x8 slack = ROUNDED * (size8(*low) + size8(*high) + size8(carried));
    *low -= slack;
    *high += slack;
    return slack;
}

static inline i32x8 overlap(const Boxes *a, const Boxes *b)
{
    return at_most8(a->low.x, b->high.x) & at_most8(b->low.x, a->high.x) & at_most8(a->low.y, b->high.y) &
           at_most8(b->low.y, a->high.y) & at_most8(a->low.z, b->high.z) & at_most8(b->low.z, a->high.z);
}

/// Whether the ways of the primitives come as near to those of the queries as is asked beyond their reach, as
/// boxes that move along with the query's first point: what all move together is no way. `own`, `corners` are
/// at the end. `moved`: how far any two points have moved against each other, at most: farther apart they
/// can't have met.
static inline i32x8 ways_touch(const PercaleNeighborhood *hood, const Eight *eight, uint32_t arity,
                               const WidePoints own[2], const WidePoints corners[3], f32x8 *moved)
{
    WidePoints starts[2];
    starts[0] = starts[1] = gather_points(hood->from, eight->own[0]);
    if (arity == 2) {
        starts[1] = gather_points(hood->from, eight->own[1]);
    }
    WidePoints carried = minus(own[0], starts[0]);
    WidePoints begin = plus(starts[1], all8(1.0f), carried);
    Boxes box = {least_of(least_of(own[0], own[1]), begin), most_of(most_of(own[0], own[1]), begin)};
    f32x8 rounded = widen(&box.low.x, &box.high.x, carried.x);
    rounded += widen(&box.low.y, &box.high.y, carried.y);
    rounded += widen(&box.low.z, &box.high.z, carried.z);
    f32x8 wider = all8(hood->wider);
    box = (Boxes){{box.low.x - wider, box.low.y - wider, box.low.z - wider},
                  {box.high.x + wider, box.high.y + wider, box.high.z + wider}};
    Boxes other = {corners[0], corners[0]};
    f32x8 farthest2 = all8(0.0f);
    for (uint32_t corner = 0; corner < arity; corner++) {
        WidePoints from = plus(gather_points(hood->from, eight->corners[corner]), all8(1.0f), carried);
        WidePoints way = minus(corners[corner], from);
        farthest2 = max8(farthest2, dot(way, way));
        other.low = least_of(other.low, least_of(corners[corner], from));
        other.high = most_of(other.high, most_of(corners[corner], from));
    }
    WidePoints turned = minus(own[1], begin);
    *moved =
        (1.0f + DISTANCE_SLACK) * (sqrt8(farthest2) + sqrt8(dot(turned, turned))) + 4.0f * rounded + wider;
    return overlap(&box, &other);
}

/// Of eight pairs: how far they are, which are within reach, and which may have been passed.
typedef struct Asked {
    float distance[EIGHT];
    uint32_t near, passing; // a bit for each
} Asked;

static inline void ask_eight(const PercaleNeighborhood *hood, const Eight *eight, uint32_t arity,
                             Asked *asked)
{
    WidePoints own[2];
    WidePoints corners[3];
    own[0] = own[1] = gather_points(hood->to, eight->own[0]);
    for (uint32_t corner = 0; corner < arity; corner++) {
        corners[corner] = gather_points(hood->to, eight->corners[corner]);
    }
    Distances distances;
    if (arity == 2) {
        own[1] = gather_points(hood->to, eight->own[1]);
        distances =
            between_edges(minus(own[1], own[0]), minus(corners[1], corners[0]), minus(own[0], corners[0]));
    } else {
        f32x8 distance2 =
            to_triangle(minus(corners[0], own[0]), minus(corners[1], own[0]), minus(corners[2], own[0]));
        distances = (Distances){(1.0f - DISTANCE_SLACK) * sqrt8(distance2), ~(i32x8){0}};
    }
    i32x8 within = at_most8(distances.distance, load8(eight->reach));
    asked->near = lane_bits(hood->ends_too ? within : within & distances.inside);
    f32x8 moved;
    i32x8 touching = ways_touch(hood, eight, arity, own, corners, &moved);
    store8(asked->distance, distances.distance);
    asked->passing = lane_bits(touching & at_most8(distances.distance, moved));
}

static void ask_faces(const PercaleNeighborhood *hood, const Eight *eight, Asked *asked)
{
    ask_eight(hood, eight, 3, asked);
}

static void ask_edges(const PercaleNeighborhood *hood, const Eight *eight, Asked *asked)
{
    ask_eight(hood, eight, 2, asked);
}

bool percale_neighbors_find(const PercaleNeighborhood *hood, const PercaleQueries *queries,
                            PercaleItemPair *pairs, size_t count, PercaleMemory *memory,
                            PercaleNeighborList *list)
{
    if (!percale_memory_reserve(memory, &list->items, &list->capacity, list->count + count,
                                sizeof(list->items[0]))) {
        return false;
    }
    for (size_t i = 0; i < count; i += EIGHT) {
        Eight eight;
        Asked asked;
        name_eight(hood, queries, pairs + i, count - i, &eight);
        if (hood->arity == 2) {
            ask_edges(hood, &eight, &asked);
        } else {
            ask_faces(hood, &eight, &asked);
        }
        for (size_t k = 0; k < EIGHT && i + k < count; k++) {
            pairs[i + k].distance = asked.distance[k];
        }
        uint32_t present = count - i < EIGHT ? (1u << (count - i)) - 1 : 0xff;
        uint32_t bits = present & (hood->all_near ? 0xff : asked.near | asked.passing);
        for (; bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            list->items[list->count++] =
                (PercaleNeighbor){pairs[i + k].place, pairs[i + k].primitive,        asked.distance[k],
                                  (uint32_t)(i + k),  (asked.passing >> k & 1) != 0, false};
        }
    }
    return true;
}
