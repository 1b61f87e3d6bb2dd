// pair_guard.h: cloth stays free of crossings: after the last sweep no vertex has gone through a face of the
// cloth, and no edge through an edge, or it is counted.
//
//   in   the substep's start, final predicted positions, new velocities, candidates
//   out  both corrected, candidates that cover all ways
//
// Whoever has passed is pushed back to the side it came from, by the same stencil that contact uses, so
// momentum is kept (Bridson 2002, section 7.4, without its averaging). Where pushing doesn't end, all that
// still pass go only half their ways, then together as zones (zones.h), which stand still or go with the pins
// and obstacles that push them; at last all the rest stands still: a start without crossings is an end
// without. What pins and obstacles that part or meet force through even so is counted. What passes an
// obstacle's feature from behind is let through, as its vertices are.
//
// Who has passed is asked of a cubic in double, without a bound of its error, and motion in one plane is no
// passage for it. With `exact` what may have touched at any time has passed (impact_time.h): no rounding and
// no degenerate motion leads through.

#ifndef PERCALE_PAIR_GUARD_H
#define PERCALE_PAIR_GUARD_H

#include "detect/pairs.h"
#include "detect/proximity.h"

typedef struct PercalePairGuardStage {
    PercaleModel *model; // predicted and next_velocity are corrected in place
    PercaleCandidates *candidates;
    PercaleProximity *proximities; // [obstacle_count] whose clearances what moves here is taken from
    bool obstacles;                // proximities are in use
    bool measures; // no contacts were found in this substep: clearances are bounds that need be known better
    const PercaleNoteList *known;    // of the last pass: what was born crossed may pass; NULL: nothing was
    const PercaleReleases *releases; // what may pass, too; NULL: nothing
    const uint8_t *is_pinched; // [slot_count] states; obstacles pass through what is held; NULL: nothing is
    bool exact;                // conservative tests: ccd=exact
    float dt;                  // s, that the ways take
    PercaleCollectors *collectors;
    PercaleStencilList *passing; // scratch
    PercaleMemory *memory;
    PercaleArena *arena;
    PercaleTeam *team;
} PercalePairGuardStage;

typedef struct PercalePairGuardCounts {
    uint64_t candidates; // pairs looked at
    uint64_t pushed;     // passages found
    uint64_t left;       // passages that remain
} PercalePairGuardCounts;

/// False without memory.
bool percale_pair_guard_run(const PercalePairGuardStage *stage, PercalePairGuardCounts *counts);

#endif
