// pinch.h: cloth vertices between two surfaces of obstacles that leave them no room.
//
//   in   start positions, the obstacles at both poses, stencils of a collision pass
//   out  pinched vertices, where they go in this substep, and how fast
//
// Where a body touches itself, or another, contact with the one surface asks for what contact with the other
// forbids. Such a vertex is held instead, as a pin is: it goes with the mean motion of the two surfaces and
// drifts, no faster than EXIT_SPEED, to its place between them (flypapering: Baraff, Witkin and Kass 2003,
// "Untangling Cloth"). That place is a share of the gap. Where the gap is closed, or below zero, the share is
// of a small rest of it, so that layers of cloth keep their order. It is let go when the surfaces leave room
// again; edges and faces that were pierced meanwhile come out (MATH.md, section 6, rule 15).

#ifndef PERCALE_PINCH_H
#define PERCALE_PINCH_H

#include "base/arena.h"
#include "detect/contacts.h"

/// A point of an obstacle's surface.
typedef struct PercalePinchFoot {
    uint32_t obstacle;
    uint32_t corners[3]; // of its triangle
    double weights[3];
} PercalePinchFoot;

typedef struct PercalePinch {
    uint32_t slot;
    float inverse_mass; // 1/kg; it has none as long as it is held
    bool has_room;      // it is let go at the next collision pass
    bool is_leaving;    // it has been
    float left;         // s ago
    PercalePinchFoot feet[2];
    Vec3 across;    // unit, from the first surface to the second
    double place;   // from the middle, in gaps: -1/2 at the first surface, 1/2 at the second
    f32x4 velocity; // m/s; mean of the two surfaces
} PercalePinch;

/// Of a vertex. Edges and faces that were held may still be pierced when they are let go: for a while they
/// come out of the obstacles, wherever they are.
typedef enum PercalePinchState { PINCH_NONE, PINCH_HELD, PINCH_LEAVING } PercalePinchState;

typedef struct PercalePinches {
    uint8_t *states;  // [slot_count] PercalePinchState
    uint32_t *number; // [slot_count] of its item, unless its state is PINCH_NONE
    PercalePinch *items;
    size_t count, capacity;
    size_t held_count; // of the items
} PercalePinches;

typedef struct PercalePinchStage {
    PercaleModel *model; // inverse masses of both poses are written, and predicted positions
    const PercaleProximity *proximities;
    PercaleCrossing *const *crossings; // [obstacle_count][active_count]; NULL without CCD
    PercalePinches *pinches;
    float dt; // s, of a substep
    PercaleTeam *team;
} PercalePinchStage;

/// Whether one of these vertices of the cloth is held, or leaves.
static inline bool percale_pinched_any(const uint8_t *states, PercalePinchState state, const uint32_t *slots,
                                       uint32_t count)
{
    bool any = false;
    for (uint32_t k = 0; k < count; k++) {
        any = any || states[slots[k]] == (uint8_t)state;
    }
    return any;
}

/// Whether all of these vertices are held.
static inline bool percale_pinched_all(const uint8_t *states, const uint32_t *slots, uint32_t count)
{
    bool all = true;
    for (uint32_t k = 0; k < count; k++) {
        all = all && states[slots[k]] == (uint8_t)PINCH_HELD;
    }
    return all;
}

/// Whether one of these vertices leaves a pinch of which this is a surface: a feature of that obstacle, with
/// this outward normal.
bool percale_pinches_leave(const PercalePinches *pinches, const uint32_t *slots, uint32_t count,
                           uint32_t obstacle, Vec3 outward);

bool percale_pinches_create(PercalePinches *pinches, const PercaleModel *model, PercaleMemory *memory);
void percale_pinches_free(PercalePinches *pinches, PercaleMemory *memory);

/// Takes those that are held along with the surfaces. The trees are at the end pose.
void percale_pinches_ride(const PercalePinchStage *stage);

/// In a collision pass: lets go who has room, and holds who is pinched, as the stencils of vertices and
/// obstacles tell: they ascend by source. False without memory.
bool percale_pinches_find(const PercalePinchStage *stage, const PercaleStencilList *stencils,
                          PercaleArena *arena, PercaleMemory *memory);

/// For the guard of pairs, who is held is cloth like any other: between closed surfaces it may have to stay
/// behind, so that layers don't go through each other.
void percale_pinches_loosen(const PercalePinchStage *stage);

/// Holds them again. The new velocities of those that are held are those of the surfaces: what moves them to
/// their place is none.
void percale_pinches_end(const PercalePinchStage *stage);

#endif
