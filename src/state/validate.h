// validate.h: checks that the model's arrays fit together.
//
//   in   model, colour batches
//   out  PERCALE_OK, or the first violation by name

#ifndef PERCALE_VALIDATE_H
#define PERCALE_VALIDATE_H

#include "color/batch.h"
#include "model/model.h"

PercaleResult percale_validate_model(const PercaleModel *model, const PercaleBatches *edges,
                                     const PercaleBatches *hinges, PercaleMemory *memory,
                                     PercaleMessage *message);

#endif
