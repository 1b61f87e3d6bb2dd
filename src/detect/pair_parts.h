// pair_parts.h: what pairs of a vertex and a face and pairs of edges have in common: for detect/pair*.c
// alone.

#ifndef PERCALE_PAIR_PARTS_H
#define PERCALE_PAIR_PARTS_H

#include "detect/contacts.h"
#include "detect/pairs.h"
#include "detect/passage.h"

// Below this share of the thickness the vector between two closest points has no direction left.
static const double NO_DIRECTION = 1e-3;

// Below this share of the thickness two features meet: what is between them is rounding.
static const double MEETS = 1e-9;

// A vertex is in a plane when its height is below this share of its distance: rounding.
static const double IN_PLANE = 1e-14;

// An obstacle's vertex or edge whose normal is nearly in the plane of the pair doesn't say which way is out.
static const double CLEAR_SIDE = 0.1;

// ---- what a pair is ----

/// What a pair of features keeps to.
typedef struct Keep {
    float thickness, friction;
} Keep;

/// False when the two don't collide.
static inline bool keep_of(const PercaleModel *model, uint32_t slot, uint32_t other, Keep *keep)
{
    const PercaleModelCloth *a = &model->cloths[model->cloth_of[slot]];
    const PercaleModelCloth *b = &model->cloths[model->cloth_of[other]];
    *keep = (Keep){0.5f * (a->thickness + b->thickness), sqrtf(a->friction * b->friction)};
    return (a->mask & b->mask) != 0;
}

static inline bool keep_of_obstacle(const PercaleModel *model, uint32_t slot,
                                    const PercaleModelSurface *obstacle, Keep *keep)
{
    const PercaleModelCloth *a = &model->cloths[model->cloth_of[slot]];
    *keep = (Keep){0.5f * (a->thickness + obstacle->thickness), sqrtf(a->friction * obstacle->friction)};
    return (a->mask & obstacle->mask) != 0;
}

static inline bool has_corner(const uint32_t *corners, uint32_t vertex)
{
    return corners[0] == vertex || corners[1] == vertex || corners[2] == vertex;
}

/// Sewn to a line: no face.
static inline bool is_line(const uint32_t *corners)
{
    return corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
}

// ---- where it is ----

static inline Vec3 start_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->model->position[point]);
}

static inline Vec3 end_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->end[point]);
}

/// Sum of weights times points, at the start (1) or the end (0) of the substep.
static inline Vec3 combine(const PercalePairStage *stage, const uint32_t points[4], const double weights[4],
                           bool at_start)
{
    Vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++) {
        Vec3 x = at_start ? start_of(stage, points[k]) : end_of(stage, points[k]);
        sum = vadd(sum, vscale(weights[k], x));
    }
    return sum;
}

/// Of the plane of a triangle: 1 on its normal's side, -1 on the other, 0 when the height is below this share
/// of the distance.
static inline int side_of_plane(Vec3 point, const Vec3 corners[3], double share)
{
    Vec3 u = vsub(corners[1], corners[0]);
    Vec3 v = vsub(corners[2], corners[0]);
    Vec3 w = vsub(point, corners[0]);
    double volume = vdot(vcross(u, v), w);
    double least2 = share * share * vdot(u, u) * vdot(v, v) * vdot(w, w);
    return volume * volume <= least2 ? 0 : volume > 0.0 ? 1 : -1;
}

// ---- what is looked for ----

/// Distance at which a pair gets a stencil, m: its thickness, half as much for what the solver moves it, and
/// what it moves until the next pass.
double percale_pair_reach(const PercalePairStage *stage, const Keep *keep, const uint32_t points[4],
                          const double weights[4]);

// ---- stencils and notes ----

/// What a stencil needs besides its points.
typedef struct Push {
    bool edges; // two of them; else a vertex and a face
    double weights[4];
    Vec3 normal;
    double start_gap; // m, along the normal's side
    float thickness;  // m
    float friction;
} Push;

/// Overlap at the start of a substep is undone at a limited speed (MATH.md, section 6).
void percale_pair_add(const PercalePairStage *stage, PercaleCollector *collector, const uint32_t points[4],
                      const Push *push);

static inline uint64_t face_key(uint32_t vertex, uint32_t triangle)
{
    return (uint64_t)vertex << 31 | triangle;
}

static inline uint64_t edge_key(uint32_t edge, uint32_t other)
{
    return (uint64_t)1 << 62 | (uint64_t)edge << 31 | other;
}

static inline uint64_t obstacle_edge_key(uint32_t edge, uint32_t other)
{
    return (uint64_t)2 << 62 | (uint64_t)edge << 31 | other;
}

/// NULL: nothing is known of the pair.
const PercalePairNote *percale_pair_find_note(const PercaleNoteList *known, uint64_t key);

/// The pair was born crossed: no side is known of it.
static inline bool is_free(const PercalePairNote *note)
{
    return note->normal[0] == 0.0f && note->normal[1] == 0.0f && note->normal[2] == 0.0f &&
           note->normal[3] == 0.0f;
}

/// It was born crossed, and still is: nothing says where it belongs.
static inline bool is_born_crossed(const PercalePairStage *stage, uint64_t key)
{
    return stage->born.count > 0 && percale_pair_find_note(&stage->born, key) != NULL;
}

/// What two features of the cloth keep to that are near each other on the rest shape. `a`, `b`: their
/// vertices.
static inline Keep keep_at_rest(const PercalePairStage *stage, Keep keep, const uint32_t *a, uint32_t a_count,
                                const uint32_t *b, uint32_t b_count)
{
    keep.thickness =
        allowed_thickness(keep.thickness, near_features(&stage->model->near, a, a_count, b, b_count));
    return keep;
}

// ---- obstacles ----

/// Whether an edge or a face of the cloth comes out of a pinch that this feature of an obstacle is a part of:
/// then it belongs outside, wherever it is.
static inline bool is_leaving(const PercalePairStage *stage, const uint32_t *slots, uint32_t count,
                              const PercaleModelSurface *obstacle, Vec3 outward)
{
    return stage->pinches != NULL &&
           percale_pinches_leave(stage->pinches, slots, count, (uint32_t)(obstacle - stage->model->obstacles),
                                 outward);
}

/// Outward normal of an obstacle's vertex or edge, from the faces around it at the end of the substep; zero
/// where they face each other.
Vec3 percale_pair_outward(const PercalePairStage *stage, const PercaleModelSurface *obstacle,
                          const uint32_t *faces, uint32_t count, uint32_t divisor);

/// An edge of the cloth against the faces that it crosses when the substep begins: notes of the pairs that
/// were born so.
void percale_pair_find_crossings(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge);

// ---- items, with what they may touch in the collector's list of neighbours ----

/// A vertex of the cloth against its faces, edges and vertices.
void percale_pair_find_vertex(const PercalePairStage *stage, PercaleCollector *collector, uint32_t vertex);
/// A vertex of an obstacle against the cloth's faces.
void percale_pair_find_obstacle_vertex(const PercalePairStage *stage, PercaleCollector *collector,
                                       const PercaleModelSurface *obstacle, uint32_t point);
/// An edge of the cloth against those after it.
void percale_pair_find_edge(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge);
/// An edge of an obstacle against those of the cloth.
void percale_pair_find_obstacle_edge(const PercalePairStage *stage, PercaleCollector *collector,
                                     const PercaleModelSurface *obstacle, uint32_t edge);

#endif
