// digest.h: the state hash.
//
//   in   positions and velocities, caller's order
//   out  64 bits that change with any bit of them

#ifndef PERCALE_DIGEST_H
#define PERCALE_DIGEST_H

#include "model/model.h"

uint64_t percale_digest(const PercaleModel *model);

#endif
