// batch.h: sorts the model's static constraints into colours, once per assembly.
//
//   in   edges, hinges of the model
//   out  the same arrays in colour order, and where each colour begins

#ifndef PERCALE_BATCH_H
#define PERCALE_BATCH_H

#include "color/coloring.h"
#include "model/model.h"

/// Constraints [first[c], first[c + 1]) of colour c may run in parallel; [first[color_count], count) one by
/// one.
typedef struct PercaleBatches {
    uint32_t color_count;
    uint32_t first[COLORS_MAX + 1];
    uint32_t count;
} PercaleBatches;

PercaleBatches percale_batches_of(const PercaleColoring *coloring);

/// Colours and reorders edges and hinges in place. False without memory.
bool percale_batch_edges(PercaleModel *model, PercaleColoring *coloring, PercaleMemory *memory,
                         PercaleBatches *batches);
bool percale_batch_hinges(PercaleModel *model, PercaleColoring *coloring, PercaleMemory *memory,
                          PercaleBatches *batches);

#endif
