// renew.h: stencils of the last collision pass that are still good, and those that have slid too far.
//
//   in   stencils, ascending by source; where the points are now
//   out  sources whose stencils have to be found anew; the list with those replaced
//
// A stencil keeps weights and normal while its two features have slid against each other by less than a fifth
// of an edge, or where its normal goes through an edge or a vertex and so turns with the slip, by less than a
// tenth of the distance that it keeps (MATH.md, section 7, rule 12). Stencils of cloth vertices and obstacles
// know no limit.

#ifndef PERCALE_RENEW_H
#define PERCALE_RENEW_H

#include "base/arena.h"
#include "detect/collect.h"

/// Sources of stencils, ascending.
typedef struct PercaleSources {
    const uint64_t *items;
    size_t count;
} PercaleSources;

bool percale_sources_contain(const PercaleSources *sources, uint64_t source);

/// Sources of stencils that have slid too far. False without memory.
bool percale_renew_find(const PercaleStencilList *list, const f32x4 *x, PercaleArena *arena,
                        PercaleTeam *team, PercaleSources *sources);

/// Adds to `found` the known ones that haven't slid too far, in place of those of the same four points; keeps
/// it ascending by source. `same_substep`: also those that have pushed, as nobody else can take that back,
/// and of the others only those that know a limit. False without memory.
bool percale_renew_merge(const PercaleStencilList *known, bool same_substep, const f32x4 *x,
                         PercaleArena *arena, PercaleMemory *memory, PercaleTeam *team,
                         PercaleStencilList *found);

#endif
