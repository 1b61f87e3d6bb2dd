// proximity.h: which cloth vertices can touch an obstacle in this substep.
//
//   in   start and predicted positions, the obstacle at the substep's start pose
//   out  the active vertices, each with a nearby triangle, a bound of its distance and its side at the start
//
// Every vertex has a clearance, a lower bound of its distance to the obstacle. It shrinks by what the vertex
// and the obstacle move; only when it is spent is the distance computed anew. A vertex with enough clearance
// costs one subtraction per substep.
//
// In a substep with a collision pass all vertices are active that can come within reach before the next one;
// in the others those whose path may lead to the surface, and those whose side is not known.

#ifndef PERCALE_PROXIMITY_H
#define PERCALE_PROXIMITY_H

#include "detect/convex.h"
#include "detect/nearby.h"

/// A side: outside for certain, though clearance is only a bound. Enough where no contacts are made.
enum { OUTSIDE_BY_BOUND = 2 };

/// What the search for contacts saw of the obstacle from an active vertex's predicted position, at the end
/// pose.
typedef struct PercaleSighting {
    f32x4 point;      // where the vertex was then
    float distance;   // m, signed by the side
    uint32_t nearest; // NO_TRIANGLE: not looked for, or nothing within the reach
} PercaleSighting;

typedef struct PercaleProximity {
    PercaleTree tree;
    PercaleTree
        swept; // boxes over start and end of the substep, while the obstacle moves; only with ccd=exact
    float *clearance;  // [slot_count] m; distance or a lower bound of it
    uint32_t *nearest; // [slot_count] nearest triangle when last computed, NO_TRIANGLE
    int8_t *side; // [slot_count] at the start of this substep: +1, -1; 0: not known, clearance is a bound;
                  // OUTSIDE_BY_BOUND. A vertex that is idle in a collision pass forgets it.
    uint8_t *is_active; // [slot_count] in this substep
    uint32_t *active;   // [active_count] the same as a list of slots, ascending
    uint32_t active_count;
    PercaleNearbyLists nearby;
    PercaleConvex convex;       // of an obstacle that stands still
    PercaleSighting *sightings; // [active_count] of this substep, in the step's arena
    float motion;               // m; the farthest that one of the obstacle's vertices moves in this substep
    double traveled;            // m; sum of the motions, this substep's too
    double guarded;             // m; of it, until cloth was last guarded from the obstacle's features
    float doubt; // m; what the path test may be wrong by: nothing seen on a path, a vertex that is this deep
                 // behind an open surface has passed through it all the same, a deeper one went around the
                 // rim; below 0: it can't be wrong
} PercaleProximity;

/// What the stages of detection share about one obstacle and the cloth.
typedef struct PercalePair {
    const PercaleModel *model;
    const PercaleModelSurface *obstacle;
    float later_substeps; // after this one, until contacts are found anew; 0 when they are not in this one
    bool is_pass_due;     // in this substep
    bool is_found_anew;   // in a pass: nothing that was known of distances saves a search (reuse=always)
} PercalePair;

/// `exact`: with a swept tree.
bool percale_proximity_create(PercaleProximity *proximity, const PercaleModel *model,
                              const PercaleModelSurface *obstacle, bool exact, PercaleMemory *memory);
/// Looks over the obstacle at its start. False without memory.
bool percale_proximity_begin(PercaleProximity *proximity, const PercaleModel *model,
                             const PercaleModelSurface *obstacle, PercaleMemory *memory);
void percale_proximity_free(PercaleProximity *proximity, PercaleMemory *memory);

typedef struct PercaleSelectionCounts {
    uint64_t searches; // exact distance queries
    uint64_t missed;   // vertices near the obstacle whose bounds deny it: only who looks anew sees them
} PercaleSelectionCounts;

/// Finds the active vertices. The tree is at the start pose; surface->points are the committed positions.
PercaleSelectionCounts percale_proximity_select(PercaleProximity *proximity, const PercalePair *pair,
                                                const PercaleSurface *surface, PercaleTeam *team);

/// Distance that the pair of the slot's cloth and the obstacle keeps: the mean of the two thicknesses, m.
static inline float pair_thickness(const PercalePair *pair, uint32_t slot)
{
    const PercaleModelCloth *cloth = &pair->model->cloths[pair->model->cloth_of[slot]];
    return 0.5f * (cloth->thickness + pair->obstacle->thickness);
}

/// Farthest distance at which a vertex gets a contact, m: its thickness, as much again for what the solver
/// moves it, and the motion of the substeps after this one until contacts are found anew.
static inline float pair_reach(const PercalePair *pair, uint32_t slot, float motion)
{
    return 2.0f * pair_thickness(pair, slot) + motion * pair->later_substeps;
}

#endif
