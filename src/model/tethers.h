// tethers.h: how far a vertex may be from the pins that hold its cloth.
//
//   in   pinned slots, edges (still slots), triangles and their rest lengths
//   out  for each slot its anchors and the distances along the cloth to them
//
// Long range attachments (Kim, Chentanez and Mueller 2012): an inextensible cloth can't be farther from a pin
// than the way along it. A limit like this acts at once over the whole cloth, where the constraints of its
// edges need a sweep for every ring. Pins that touch along edges make one island; each of up to TETHER_LAYERS
// islands gives every vertex a tether to its nearest pin, more islands together one. A cloth that may stretch
// has none.

#ifndef PERCALE_TETHERS_H
#define PERCALE_TETHERS_H

#include "model/geodesic.h"
#include "model/model.h"

enum { TETHER_LAYERS = 4 };

/// Fills the model's tethers; without pins, or where an edge has a compliance, there are none. mesh: the
/// cloth's triangles. False without memory.
bool percale_tethers_build(PercaleModel *model, const PercaleGeodesicMesh *mesh, PercaleMemory *memory);

#endif
