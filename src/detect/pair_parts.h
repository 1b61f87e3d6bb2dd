// pair_parts.h: what pairs of a vertex and a face and pairs of edges have in common: for detect/pair*.c
// alone.

#ifndef PERCALE_PAIR_PARTS_H
#define PERCALE_PAIR_PARTS_H

#include "detect/contacts.h"
#include "detect/pairs.h"

// Below this share of the thickness the vector between two closest points has no direction left.
static const double NO_DIRECTION = 1e-3;

// A path this share of a triangle's size beside it still goes through it: neighbours leave no gap.
static const double SEAMLESS = 1e-6;

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

// ---- where it is ----

static inline Vec3 start_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->model->position[point]);
}

static inline Vec3 earlier_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->earlier[point]);
}

static inline Vec3 end_of(const PercalePairStage *stage, uint32_t point)
{
    return vec3_of(stage->model->predicted[point]);
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

/// Weights of two features where four points lie in a plane. False when they don't meet there.
typedef bool PercalePairWeigh(const Vec3 *x, double weights[4]);

/// Whether two features have gone through each other, on straight paths, and not come back; the weights where
/// they last met.
bool percale_pair_has_passed(const Vec3 *from, const Vec3 *to, PercalePairWeigh *weigh, double weights[4]);

typedef struct Box {
    f32x4 low, high;
} Box;

/// Around the way of two points from the last pass to the next.
static inline Box box_of(const PercalePairStage *stage, uint32_t a, uint32_t b)
{
    const f32x4 *places[3] = {stage->earlier, stage->model->position, stage->ahead};
    Box box = {min4(places[0][a], places[0][b]), max4(places[0][a], places[0][b])};
    for (int i = 1; i < 3; i++) {
        box.low = min4(box.low, min4(places[i][a], places[i][b]));
        box.high = max4(box.high, max4(places[i][a], places[i][b]));
    }
    return box;
}

/// Wider by the radius, and by what float32 may have rounded away.
static inline Box widen(Box box, float radius)
{
    for (int axis = 0; axis < 3; axis++) {
        float slack = radius + 1e-6f * (fabsf(box.low[axis]) + fabsf(box.high[axis]));
        box.low[axis] -= slack;
        box.high[axis] += slack;
    }
    return box;
}

static inline bool overlap(const Box *a, const Box *b)
{
    f32x4 apart = max4(a->low - b->high, b->low - a->high);
    return apart[0] <= 0.0f && apart[1] <= 0.0f && apart[2] <= 0.0f;
}

// ---- what is looked for ----

/// Triangles whose way touches the box.
bool percale_pair_gather(const PercalePairStage *stage, PercaleCollector *collector, const Box *box);

/// Widest distance at which a feature of this thickness gets a stencil with the cloth, m.
float percale_pair_widest_reach(const PercalePairStage *stage, float thickness);

/// Distance at which a pair gets a stencil, m: its thickness, as much again for what the solver moves it, and
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

/// Shortest way on the rest shape between the vertices of two features, m; a lower bound.
float percale_pair_rest_distance(const PercalePairStage *stage, const uint32_t *a, int a_count,
                                 const uint32_t *b, int b_count);

/// The thickness that a pair with this way between its features can keep, m: half of it at most.
static inline float allowed(float thickness, float rest)
{
    float most = 0.5f * rest;
    return most < thickness ? most : thickness;
}

// ---- obstacles ----

/// Outward normal of an obstacle's vertex or edge, from the faces around it at the end of the substep; zero
/// where they face each other.
Vec3 percale_pair_outward(const PercalePairStage *stage, const PercaleModelSurface *obstacle,
                          const uint32_t *faces, uint32_t count, uint32_t divisor);

// ---- items ----

/// A vertex of the cloth against its faces, edges and vertices.
void percale_pair_find_vertex(const PercalePairStage *stage, PercaleCollector *collector, uint32_t vertex);
/// A vertex of an obstacle against the cloth's faces.
void percale_pair_find_obstacle_vertex(const PercalePairStage *stage, PercaleCollector *collector,
                                       uint32_t point);
/// An edge of the cloth against those after it.
void percale_pair_find_edge(const PercalePairStage *stage, PercaleCollector *collector, uint32_t edge);
/// An edge of an obstacle against those of the cloth.
void percale_pair_find_obstacle_edge(const PercalePairStage *stage, PercaleCollector *collector,
                                     const PercaleModelSurface *obstacle, uint32_t edge);

#endif
