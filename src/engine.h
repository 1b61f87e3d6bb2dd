// engine.h: the pipeline, compiled once for each instruction set.
//
// step.c and the folders of its stages are built several times from the same source, each time for another
// instruction set; of each build only one of these tables is seen from outside (see CMakeLists.txt). The
// arithmetic is the same, so the bits are. Everything else is compiled once, for any processor of the
// architecture.

#ifndef PERCALE_ENGINE_H
#define PERCALE_ENGINE_H

#include "base/team.h"
#include "percale/types.h"
#include "solve/sweep.h"

typedef struct PercaleEngine {
    PercaleIsa isa;
    PercaleLead *run_substeps;   // of a step; the context is a PercaleSubsteps
    PercaleLead *run_untangling; // the context is a PercaleUntangling (step_untangle.h)
    bool (*run_sweep)(const PercaleSweepPlan *plan, PercaleTeam *team, PercaleArena *arena);
} PercaleEngine;

/// All substeps of a step.
typedef struct PercaleSubsteps {
    struct PercaleSolver *solver;
    double seconds; // of the step
    int good;       // substeps that are done
    PercaleResult result;
} PercaleSubsteps;

/// The widest that this machine and this build have for AUTO, else the one asked for; NULL when there is
/// none.
const PercaleEngine *percale_engine_for(PercaleIsa isa);

/// What engine.c puts into its table.
PercaleLead percale_run_substeps;

#endif
