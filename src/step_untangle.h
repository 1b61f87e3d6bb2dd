// step_untangle.h: takes a tangled state apart: steps of a world in which nothing else moves, each of which
// looks for crossings and lets what has to move come out by an edge's length, while all else collides.
//
//   in   the model, of a solver that stands still: committed positions
//   out  the model's committed positions, moved, and with fewer crossings or as they were; no velocity

#ifndef PERCALE_STEP_UNTANGLE_H
#define PERCALE_STEP_UNTANGLE_H

#include "base/team.h"
#include "percale/types.h"

struct PercaleSolver;

typedef struct PercaleUntangling {
    struct PercaleSolver *solver;
    PercaleUntangleDef def;
    PercaleUntangleReport report;
    PercaleResult result;
} PercaleUntangling;

/// The context is a PercaleUntangling.
PercaleLead percale_run_untangling;

#endif
