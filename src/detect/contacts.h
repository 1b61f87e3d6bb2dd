// contacts.h: stencils between cloth vertices and an obstacle's surface.
//
//   in   active vertices, their crossings, predicted positions, the obstacle at the end pose
//   out  stencils, ordered by vertex and feature
//
// A vertex gets a stencil from every feature whose region it is in: faces above it, convex edges and corners
// by the direction to their closest point (so there is no false contact beside a convex edge, and both walls
// of a concave one). Below the surface it gets one, out through the nearest feature. Open surfaces act from
// their front only.

#ifndef PERCALE_CONTACTS_H
#define PERCALE_CONTACTS_H

#include "detect/collect.h"
#include "detect/proximity.h"

/// Overlap that exists when a substep begins is undone no faster than this, m/s (MATH.md, section 6.8): a
/// start inside the body or a pinch doesn't become a shot.
static const float EXIT_SPEED = 0.5f;

/// Share of the thickness at which a vertex is put back: outside beyond rounding, well inside the contact's
/// reach.
static const double GAP = 0.1;

typedef struct PercaleContactStage {
    const PercalePair *pair;
    PercaleProximity *proximity;
    const PercaleSurface *surface;    // end pose
    const PercaleCrossing *crossings; // [active_count]; NULL without CCD
    bool crossings_only;              // between two passes: only vertices that have crossed
    float dt;                         // s, of a substep
    uint64_t source;                  // of its stencils, with the vertex
    PercaleTeam *team;
} PercaleContactStage;

/// Appends to `list`; adds the triangles looked at to *candidate_count. False without memory.
bool percale_contacts_find(const PercaleContactStage *stage, PercaleCollectors *collectors,
                           PercaleMemory *memory, PercaleStencilList *list, uint64_t *candidate_count);

/// Whether a vertex that was in front of an open surface and is now this deep behind it, though its path was
/// not seen to pass through, has passed through it. Else it went around the rim.
static inline bool has_slipped_through(const PercalePair *pair, const PercaleProximity *proximity,
                                       uint32_t slot, double depth)
{
    return depth <= (double)proximity->doubt + GAP * (double)pair_thickness(pair, slot);
}

/// Direction from a surface's feature to the free side of it at `point`, unit.
Vec3 percale_contact_normal(const PercaleSurface *surface, Vec3 point, uint32_t triangle,
                            const PercaleClosest *closest, int side);

#endif
