// tangle_random.h: tangles drawn at random, each from a seed of its own.

#ifndef PERCALE_TANGLE_RANDOM_H
#define PERCALE_TANGLE_RANDOM_H

#include "tangle_cases.h"

/// Fills in the cloths and the body of the tangle's kind. False without memory.
bool tangle_random_make(uint32_t seed, TangleCase *tangle);

#endif
