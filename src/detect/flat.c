#include "detect/flat.h"

#include <math.h>

// Faces that are looked at around a point: where an obstacle is so much finer than the cloth, it isn't told.
enum { MOST_FACES = 256 };

// Lengths below which an edge between two flat vertices is as flat as these.
static const double SHORT = 0.5;

// Of the farthest that a flat place falls off, below which vertices don't keep the rest away from it; and of
// the drop, at least so much of it.
static const double LOW = 3.0;
static const double LEAST_LOW = 0.3;

/// What is looked at around one point after the other.
typedef struct Walk {
    const PercaleModelSurface *surface;
    const f32x4 *x;
    double length, drop; // m
    double fall;         // m, by which it falls off within half the length, a quarter of that beyond it
    uint64_t *seen;      // [triangle_count] number, over all points, under which it was last looked at
    uint64_t first;      // faces of earlier points
    uint32_t faces[MOST_FACES];
    uint32_t count;
    bool told; // there is room for all faces
} Walk;

static void add_face(Walk *walk, uint32_t face)
{
    if (walk->seen[face] > walk->first) {
        return;
    }
    if (walk->count == MOST_FACES) {
        walk->told = false;
        return;
    }
    walk->faces[walk->count++] = face;
    walk->seen[face] = walk->first + walk->count;
}

static Vec3 place_of(const Walk *walk, uint32_t vertex)
{
    return vec3_of(walk->x[walk->surface->first_point + vertex]);
}

/// Twice its area along its normal.
static Vec3 area_of(const Walk *walk, uint32_t face)
{
    const uint32_t *corners = walk->surface->triangles + 3 * (size_t)face;
    Vec3 a = vec3_of(walk->x[corners[0]]);
    return vcross(vsub(vec3_of(walk->x[corners[1]]), a), vsub(vec3_of(walk->x[corners[2]]), a));
}

/// A place on the surface and its normal there.
typedef struct Point {
    Vec3 place, normal;
} Point;

/// How far what lies on an edge, within the length of the point, falls off. `near`: some does.
static double fall_of(const Walk *walk, uint32_t edge, const Point *point, bool *near)
{
    enum { SAMPLES = 4 };
    const uint32_t *ends = walk->surface->edges.vertices[edge];
    Vec3 start = vsub(place_of(walk, ends[0]), point->place);
    Vec3 along = vsub(place_of(walk, ends[1]), place_of(walk, ends[0]));
    double along2 = vdot(along, along);
    double middle = -vdot(start, along) / along2; // the nearest place on the edge's line
    Vec3 nearest = vadd(start, vscale(middle, along));
    double half2 = (walk->length * walk->length - vdot(nearest, nearest)) / along2;
    double half = half2 > 0.0 ? sqrt(half2) : 0.0;
    double low = fmax(middle - half, 0.0);
    double high = fmin(middle + half, 1.0);
    *near = half2 > 0.0 && low < high;
    double fall = along2 > 0.0 ? 0.0 : HUGE_VAL;
    for (int i = 0; *near && i <= SAMPLES; i++) {
        Vec3 place = vadd(start, vscale(low + (high - low) * i / SAMPLES, along));
        double halves2 = 4.0 * vdot(place, place) / (walk->length * walk->length);
        fall = fmax(fall, -vdot(place, point->normal) / fmax(1.0, halves2));
    }
    return fall;
}

/// Whether a side of the i-th face is no rim and falls off by little; the face beyond it is added if it is
/// near.
static bool is_flat_side(Walk *walk, uint32_t i, uint32_t side, const Point *point)
{
    const PercaleEdges *edges = &walk->surface->edges;
    uint32_t edge = edges->edge_of_side[side];
    if (edge == UINT32_MAX) {
        return false;
    }
    const uint32_t *sides = edges->sides + edges->first_side[edge];
    uint32_t count = edges->first_side[edge + 1] - edges->first_side[edge];
    uint32_t beyond = sides[sides[0] == side && count > 1 ? 1 : 0] / 3;
    if (walk->seen[beyond] > walk->first && walk->seen[beyond] <= walk->first + i) {
        return true; // as seen from there
    }
    bool near = false;
    walk->fall = fmax(walk->fall, fall_of(walk, edge, point, &near));
    if (near && count == 2) {
        add_face(walk, beyond);
    }
    return walk->fall <= walk->drop && (!near || count == 2);
}

/// Whether the surface around a place, from the faces on that have been added, falls off by little and has no
/// rim.
static bool is_flat(Walk *walk, Vec3 place)
{
    Point point = {place, {0.0, 0.0, 0.0}};
    for (uint32_t i = 0; i < walk->count; i++) {
        point.normal = vadd(point.normal, area_of(walk, walk->faces[i]));
    }
    bool flat = vlength(point.normal) > 0.0;
    point.normal = vunit(point.normal);
    for (uint32_t i = 0; flat && i < walk->count; i++) {
        uint32_t first = 3 * walk->faces[i];
        flat = vdot(area_of(walk, walk->faces[i]), point.normal) > 0.0 &&
               is_flat_side(walk, i, first, &point) && is_flat_side(walk, i, first + 1, &point) &&
               is_flat_side(walk, i, first + 2, &point);
    }
    return flat && walk->told;
}

static void begin_walk(Walk *walk)
{
    walk->first += walk->count;
    walk->count = 0;
    walk->told = true;
    walk->fall = 0.0;
}

static bool is_flat_vertex(Walk *walk, uint32_t vertex)
{
    const PercaleModelSurface *surface = walk->surface;
    begin_walk(walk);
    for (uint32_t i = surface->vertex_first_face[vertex]; i < surface->vertex_first_face[vertex + 1]; i++) {
        add_face(walk, surface->vertex_faces[i]);
    }
    return is_flat(walk, place_of(walk, vertex));
}

/// An edge between flat vertices: in its middle, too.
static bool is_flat_edge(Walk *walk, uint32_t edge)
{
    const PercaleEdges *edges = &walk->surface->edges;
    Vec3 start = place_of(walk, edges->vertices[edge][0]);
    Vec3 end = place_of(walk, edges->vertices[edge][1]);
    if (vlength(vsub(end, start)) < SHORT * walk->length) {
        return true;
    }
    begin_walk(walk);
    for (uint32_t side = edges->first_side[edge]; side < edges->first_side[edge + 1]; side++) {
        add_face(walk, edges->sides[side] / 3);
    }
    return is_flat(walk, vscale(0.5, vadd(start, end)));
}

bool percale_flat_find(const PercaleModelSurface *surface, const f32x4 *x, double length, double drop,
                       PercaleFlat *flat, PercaleMemory *memory)
{
    uint32_t edge_count = surface->edges.edge_count;
    double farthest = LEAST_LOW * drop;
    Walk walk = {.surface = surface, .x = x, .length = length, .drop = drop};
    walk.seen = percale_memory_new(memory, surface->triangle_count, sizeof(walk.seen[0]));
    flat->vertices = percale_memory_new(memory, surface->vertex_count, 1);
    flat->edges = percale_memory_new(memory, edge_count, 1);
    bool complete = walk.seen != NULL && flat->vertices != NULL && flat->edges != NULL;
    for (uint32_t v = 0; complete && v < surface->vertex_count; v++) {
        flat->vertices[v] = is_flat_vertex(&walk, v);
        farthest = fmax(farthest, flat->vertices[v] ? walk.fall : 0.0);
    }
    for (uint32_t e = 0; complete && e < edge_count; e++) {
        const uint32_t *ends = surface->edges.vertices[e];
        flat->edges[e] = flat->vertices[ends[0]] && flat->vertices[ends[1]] && is_flat_edge(&walk, e);
        farthest = fmax(farthest, flat->edges[e] ? walk.fall : 0.0);
    }
    flat->low = (float)(LOW * farthest);
    flat->length = (float)length;
    percale_memory_free(memory, walk.seen);
    return complete;
}

void percale_flat_free(PercaleFlat *flat, PercaleMemory *memory)
{
    percale_memory_free(memory, flat->vertices);
    percale_memory_free(memory, flat->edges);
    *flat = (PercaleFlat){0};
}
