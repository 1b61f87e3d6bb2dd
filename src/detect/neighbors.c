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

static inline WidePoints spread_point(f32x4 point)
{
    return (WidePoints){all8(point[0]), all8(point[1]), all8(point[2])};
}

/// Eight points by number.
static inline WidePoints load_points(const f32x4 *x, const uint32_t points[EIGHT])
{
    f32x8 pairs[4];
    for (uint32_t k = 0; k < 4; k++) {
        pairs[k] = pair_of_points(x[points[k]], x[points[k + 4]]);
    }
    return transpose_pairs(pairs);
}

static inline f32x8 min8(f32x8 a, f32x8 b)
{
    return select8(greater8(b, a), a, b);
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

/// The points of eight primitives, by corner.
typedef struct Eight {
    uint32_t corners[3][EIGHT];
    uint32_t own; // a bit for each that has a point of the query
} Eight;

static Eight name_eight(const PercaleNeighborhood *hood, const PercaleQuery *query,
                        const uint32_t primitives[EIGHT])
{
    Eight eight = {.own = 0};
    for (uint32_t k = 0; k < EIGHT; k++) {
        bool own = false;
        for (uint32_t corner = 0; corner < hood->arity; corner++) {
            uint32_t point = hood->primitives[(size_t)hood->arity * primitives[k] + corner];
            eight.corners[corner][k] = point;
            own = own || point == query->points[0] || point == query->points[1];
        }
        eight.own |= (uint32_t)own << k;
    }
    return eight;
}

/// Whether the ways of the primitives touch that of the query, as boxes that move along with the query's
/// first point: what all move together is no way. `corners` are at the end. `moved`: how far any two points
/// have moved against each other, at most: farther apart they can't have met.
static i32x8 ways_touch(const PercaleNeighborhood *hood, const Eight *eight, const PercaleQuery *query,
                        const WidePoints corners[3], f32x8 *moved)
{
    f32x4 carried = hood->to[query->points[0]] - hood->from[query->points[0]];
    f32x4 ends[2] = {hood->to[query->points[0]], hood->to[query->points[1]]};
    f32x4 begin = hood->from[query->points[1]] + carried;
    f32x4 low = min4(min4(ends[0], ends[1]), begin);
    f32x4 high = max4(max4(ends[0], ends[1]), begin);
    float rounded = 0.0f; // what float32 has rounded away
    for (int axis = 0; axis < 3; axis++) {
        float slack = ROUNDED * (fabsf(low[axis]) + fabsf(high[axis]) + fabsf(carried[axis]));
        low[axis] -= slack;
        high[axis] += slack;
        rounded += slack;
    }
    WidePoints along = spread_point(carried);
    WidePoints least = corners[0];
    WidePoints most = corners[0];
    f32x8 farthest2 = all8(0.0f);
    for (uint32_t corner = 0; corner < hood->arity; corner++) {
        WidePoints from = plus(load_points(hood->from, eight->corners[corner]), all8(1.0f), along);
        WidePoints way = minus(corners[corner], from);
        farthest2 = max8(farthest2, dot(way, way));
        WidePoints places[2] = {corners[corner], from};
        for (int i = 0; i < 2; i++) {
            least = (WidePoints){min8(least.x, places[i].x), min8(least.y, places[i].y),
                                 min8(least.z, places[i].z)};
            most =
                (WidePoints){max8(most.x, places[i].x), max8(most.y, places[i].y), max8(most.z, places[i].z)};
        }
    }
    *moved = (1.0f + DISTANCE_SLACK) * (sqrt8(farthest2) + length3(ends[1] - begin)) + 4.0f * rounded;
    return at_most8(least.x, all8(high[0])) & at_most8(all8(low[0]), most.x) &
           at_most8(least.y, all8(high[1])) & at_most8(all8(low[1]), most.y) &
           at_most8(least.z, all8(high[2])) & at_most8(all8(low[2]), most.z);
}

static Distances measure_eight(const PercaleNeighborhood *hood, const PercaleQuery *query,
                               const WidePoints corners[3])
{
    WidePoints from = spread_point(hood->to[query->points[0]]);
    if (hood->arity == 2) {
        WidePoints own = minus(spread_point(hood->to[query->points[1]]), from);
        return between_edges(own, minus(corners[1], corners[0]), minus(from, corners[0]));
    }
    f32x8 distance2 = to_triangle(minus(corners[0], from), minus(corners[1], from), minus(corners[2], from));
    return (Distances){(1.0f - DISTANCE_SLACK) * sqrt8(distance2), ~(i32x8){0}};
}

/// Of eight primitives: how far they are, which are within reach, and which may have been passed.
typedef struct Asked {
    float distance[EIGHT];
    uint32_t near, passing; // a bit for each
} Asked;

static void ask_eight(const PercaleNeighborhood *hood, const PercaleQuery *query, const Eight *eight,
                      Asked *asked)
{
    WidePoints corners[3];
    for (uint32_t corner = 0; corner < hood->arity; corner++) {
        corners[corner] = load_points(hood->to, eight->corners[corner]);
    }
    Distances distances = measure_eight(hood, query, corners);
    i32x8 within = at_most8(distances.distance, all8(query->reach));
    asked->near = lane_bits(hood->ends_too ? within : within & distances.inside);
    f32x8 moved;
    i32x8 touching = ways_touch(hood, eight, query, corners, &moved);
    store8(asked->distance, distances.distance);
    asked->passing = lane_bits(touching & at_most8(distances.distance, moved));
}

bool percale_neighbors_find(const PercaleNeighborhood *hood, const PercaleQuery *query,
                            const PercaleItemPair *pairs, size_t count, PercaleMemory *memory,
                            PercaleNeighborList *list)
{
    if (!percale_memory_reserve(memory, &list->items, &list->capacity, list->count + count,
                                sizeof(list->items[0]))) {
        return false;
    }
    for (size_t i = 0; i < count; i += EIGHT) {
        uint32_t numbers[EIGHT];
        for (size_t k = 0; k < EIGHT; k++) {
            numbers[k] = pairs[i + k < count ? i + k : i].primitive;
        }
        Eight eight = name_eight(hood, query, numbers);
        uint32_t present = count - i < EIGHT ? (1u << (count - i)) - 1 : 0xff;
        uint32_t bits = present & ~eight.own;
        if (bits == 0) {
            continue;
        }
        Asked asked;
        ask_eight(hood, query, &eight, &asked);
        bits &= hood->all_near ? 0xff : asked.near | asked.passing;
        for (; bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            list->items[list->count++] =
                (PercaleNeighbor){numbers[k], asked.distance[k], (asked.passing >> k & 1) != 0};
        }
    }
    return true;
}
