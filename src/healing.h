// healing.h: what the solver remembers of crossings of cloth with cloth from step to step.

#ifndef PERCALE_HEALING_H
#define PERCALE_HEALING_H

#include "untangle/tangler.h"

typedef struct PercaleHealing {
    bool is_unknown;          // nobody has looked yet, or something was left crossed: all is looked at
    bool is_tangled;          // the tangler is open
    uint32_t look;            // which part of the edges is looked at next
    uint64_t known_crossed;   // what the stages had counted when the last step began
    uint64_t steps;           // done so far
    PercaleTangler tangler;   // its stencils are those of the running step
    PercaleReleases releases; // theirs
} PercaleHealing;

#endif
