#include "detect/convex.h"

#include <math.h>

// Of a coordinate, by which a point may be above a plane that it was meant to lie in: its place is rounded to
// float32.
static const double ROUNDED = 5e-7;

// Of that, what only the heights of common corners are computed wrong by.
static const double EXACT = 1e-6;

/// A triangle's plane, and how far a point may be above it, m.
typedef struct Plane {
    Vec3 corners[3];
    Vec3 normal; // unit; zero of a triangle without area
    double slack;
} Plane;

static double largest(Vec3 a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

static Plane plane_of(const PercaleSurface *surface, uint32_t triangle)
{
    const uint32_t *indices = surface->mesh->triangles + 3 * (size_t)triangle;
    Plane plane;
    double farthest = 0.0;
    for (int k = 0; k < 3; k++) {
        plane.corners[k] = vec3_of(surface->points[indices[k]]);
        farthest = fmax(farthest, largest(plane.corners[k]));
    }
    plane.normal = percale_surface_face_normal(surface, triangle);
    plane.slack = ROUNDED * farthest;
    return plane;
}

/// How far a point has to stand inside a triangle's sides so that what is above its plane by no more than the
/// slack is farther away.
static double margin_of(const PercaleConvex *convex, const Plane *plane)
{
    return sqrt(2.0 * convex->radius * plane->slack);
}

/// How far the highest corner of one is above the other.
static double height_above(const Plane *plane, const Plane *other)
{
    double highest = -HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        highest = fmax(highest, vdot(plane->normal, vsub(other->corners[k], plane->corners[0])));
    }
    return highest;
}

/// In the plane, across a side.
static Vec3 inward_of(const Plane *plane, int side)
{
    return vunit(vcross(plane->normal, vsub(plane->corners[(side + 1) % 3], plane->corners[side])));
}

/// Whether one lies wholly outside of a side of the other.
static bool is_beside(const Plane *plane, const Plane *other)
{
    bool beside = false;
    for (int side = 0; side < 3 && !beside; side++) {
        beside = true;
        for (int k = 0; k < 3; k++) {
            Vec3 from_side = vsub(other->corners[k], plane->corners[side]);
            beside = beside && vdot(inward_of(plane, side), from_side) <= plane->slack;
        }
    }
    return beside;
}

/// Whether two triangles are part of one convex surface: each is behind the other's plane, and beside it or
/// turned away. What is above a plane by rounding must not be seen from above the other.
static bool are_convex(const PercaleConvex *convex, const Plane *a, const Plane *b)
{
    double height = fmax(height_above(a, b), height_above(b, a));
    double turn = vlength(vcross(a->normal, b->normal));
    bool has_areas = vdot(a->normal, a->normal) > 0.0 && vdot(b->normal, b->normal) > 0.0;
    bool are_beside = vdot(a->normal, b->normal) <= 0.0 || is_beside(a, b) || is_beside(b, a);
    return has_areas && height <= a->slack && are_beside &&
           (height <= EXACT * a->slack || turn * convex->radius <= margin_of(convex, a));
}

/// Whether the faces beyond a triangle's sides, one each, are convex with it.
static bool are_sides_convex(const PercaleConvex *convex, const PercaleSurface *surface, uint32_t triangle)
{
    const PercaleEdges *edges = &surface->mesh->edges;
    Plane plane = plane_of(surface, triangle);
    bool are = true;
    for (uint32_t side = 3 * triangle; are && side < 3 * triangle + 3; side++) {
        uint32_t edge = edges->edge_of_side[side];
        are = edge != UINT32_MAX && edges->first_side[edge + 1] - edges->first_side[edge] == 2;
        for (uint32_t i = 0; are && i < 2; i++) {
            uint32_t other = edges->sides[edges->first_side[edge] + i] / 3;
            Plane beyond = plane_of(surface, other);
            are = other == triangle || are_convex(convex, &plane, &beyond);
        }
    }
    return are;
}

/// What of an obstacle is looked at.
typedef struct Search {
    const PercaleConvex *convex;
    const PercaleSurface *surface;
    const uint8_t *sides; // [triangle_count] 1: those of the triangle are convex
    PercaleNodeList near;
} Search;

/// Whether all that is near a triangle is one convex surface with it. False without memory in `complete`.
static bool is_convex(Search *search, uint32_t triangle, PercaleMemory *memory, bool *complete)
{
    const PercaleTree *tree = search->surface->tree;
    Plane plane = plane_of(search->surface, triangle);
    f32x4 corners[3];
    for (int k = 0; k < 3; k++) {
        corners[k] = f32x4_of(plane.corners[k], 0.0f);
    }
    f32x4 low = min4(corners[0], min4(corners[1], corners[2])) - (float)search->convex->radius;
    f32x4 high = max4(corners[0], max4(corners[1], corners[2])) + (float)search->convex->radius;
    *complete = percale_tree_overlap(tree, low, high, memory, &search->near);
    bool is = *complete;
    for (size_t i = 0; is && i < search->near.count; i++) {
        uint32_t node = search->near.items[i];
        uint32_t bits = lane_bits(tree_box_overlaps(&tree->nodes[node], low, high));
        for (; is && bits != 0; bits &= bits - 1) {
            uint32_t other = tree->order[TREE_WIDTH * node + (uint32_t)__builtin_ctz(bits)];
            Plane beyond = plane_of(search->surface, other);
            is = search->sides[other] != 0 &&
                 (other == triangle || are_convex(search->convex, &plane, &beyond));
        }
    }
    return is;
}

static PercaleConvexFace face_of(const Search *search, uint32_t triangle, bool is_convex)
{
    Plane plane = plane_of(search->surface, triangle);
    double margin = is_convex ? margin_of(search->convex, &plane) : -1.0;
    PercaleConvexFace face = {.normal = f32x4_of(plane.normal, (float)margin)};
    for (int side = 0; side < 3; side++) {
        Vec3 inward = inward_of(&plane, side);
        double offset = vdot(inward, vsub(plane.corners[side], plane.corners[0]));
        face.sides[side] = f32x4_of(inward, (float)offset);
    }
    return face;
}

bool percale_convex_find(PercaleConvex *convex, const PercaleSurface *surface, double radius,
                         PercaleMemory *memory)
{
    uint32_t count = surface->mesh->triangle_count;
    uint8_t *sides = percale_memory_new(memory, count, 1);
    convex->radius = radius;
    convex->faces = percale_memory_new(memory, count, sizeof(convex->faces[0]));
    convex->normals = percale_memory_new(memory, count, sizeof(convex->normals[0]));
    bool complete = sides != NULL && convex->faces != NULL && convex->normals != NULL;
    for (uint32_t t = 0; complete && t < count; t++) {
        sides[t] = are_sides_convex(convex, surface, t);
        convex->normals[t] = percale_surface_face_normal(surface, t);
    }
    Search search = {convex, surface, sides, {0}};
    for (uint32_t t = 0; complete && t < count; t++) {
        convex->faces[t] = face_of(&search, t, is_convex(&search, t, memory, &complete));
    }
    percale_memory_free(memory, search.near.items);
    percale_memory_free(memory, sides);
    return complete;
}

void percale_convex_free(PercaleConvex *convex, PercaleMemory *memory)
{
    percale_memory_free(memory, convex->faces);
    percale_memory_free(memory, convex->normals);
    *convex = (PercaleConvex){0};
}

/// The side of a triangle that a place is farthest outside of, or not inside of by the margin. False: none.
static bool find_side_outside(const PercaleConvexFace *face, f32x4 place, uint32_t *side)
{
    float least = face->normal[3];
    bool outside = false;
    for (uint32_t k = 0; k < 3; k++) {
        float inside = dot3(face->sides[k], place) - face->sides[k][3];
        if (inside <= least) {
            least = inside;
            *side = k;
            outside = true;
        }
    }
    return outside;
}

uint32_t percale_convex_face(const PercaleConvex *convex, const PercaleSurface *surface, Vec3 point,
                             double reach, uint32_t seed)
{
    enum { STEPS = 4 };
    const PercaleEdges *edges = &surface->mesh->edges;
    for (int step = 0; convex->faces != NULL && step < STEPS && seed != NO_TRIANGLE; step++) {
        const PercaleConvexFace *face = &convex->faces[seed];
        if (face->normal[3] < 0.0f) {
            return NO_TRIANGLE;
        }
        Vec3 corner = vec3_of(surface->points[surface->mesh->triangles[3 * (size_t)seed]]);
        f32x4 place = f32x4_of(vsub(point, corner), 0.0f);
        uint32_t outside = 0;
        if (!find_side_outside(face, place, &outside)) {
            double height = (double)dot3(face->normal, place);
            return height > 0.0 && height + fmax(reach, height) <= convex->radius ? seed : NO_TRIANGLE;
        }
        const uint32_t *sides = edges->sides + edges->first_side[edges->edge_of_side[3 * seed + outside]];
        seed = sides[sides[0] / 3 == seed ? 1 : 0] / 3;
    }
    return NO_TRIANGLE;
}

bool percale_convex_nearest(const PercaleConvex *convex, const PercaleSurface *surface, Vec3 point,
                            double radius, uint32_t seed, PercaleNearest *nearest)
{
    uint32_t face = percale_convex_face(convex, surface, point, 0.0, seed);
    if (face != NO_TRIANGLE) {
        *nearest = percale_surface_nearest_of(surface, point, radius, &face, 1);
    }
    return face != NO_TRIANGLE;
}
