#include "state/validate.h"

static PercaleResult check_points(const PercaleModel *model, PercaleMessage *message)
{
    for (uint32_t i = 0; i < model->point_count; i++) {
        f32x4 x = model->position[i];
        if (!isfinite(x[0]) || !isfinite(x[1]) || !isfinite(x[2]) || !isfinite(x[3]) || x[3] < 0.0f) {
            return percale_fail(message, PERCALE_NOT_FINITE, "point %u is not finite or has a negative mass",
                                i);
        }
        if (i >= model->slot_count && x[3] > 0.0f) {
            return percale_fail(message, PERCALE_INVALID_ARGUMENT, "obstacle point %u can move", i);
        }
    }
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        for (uint32_t i = 0; i < model->cloths[c].vertex_count; i++) {
            if (model->cloths[c].slots[i] >= model->slot_count) {
                return percale_fail(message, PERCALE_INVALID_ARGUMENT, "cloth %u: vertex %u has no slot", c,
                                    i);
            }
        }
    }
    return PERCALE_OK;
}

/// One kind of constraint in run order.
typedef struct Constraints {
    const PercaleBatches *batches;
    const uint32_t *offsets; // [arity * count] of points
    uint32_t arity;
    const char *kind;
} Constraints;

/// No two constraints of a run may name the same vertex. met[v]: 1 + the last run in which v was named.
static PercaleResult check_constraint(const PercaleModel *model, const Constraints *constraints,
                                      uint32_t index, uint32_t run, uint32_t *met, PercaleMessage *message)
{
    const uint32_t *offsets = constraints->offsets + (size_t)index * constraints->arity;
    for (uint32_t k = 0; k < constraints->arity; k++) {
        uint32_t slot = slot_at(offsets[k]);
        if (slot >= model->slot_count || offsets[k] % POINT_BYTES != 0) {
            return percale_fail(message, PERCALE_INVALID_ARGUMENT, "%s %u names point %u", constraints->kind,
                                index, slot);
        }
        if (met[slot] == run + 1) {
            return percale_fail(message, PERCALE_INVALID_ARGUMENT, "%s %u shares point %u within run %u",
                                constraints->kind, index, slot, run);
        }
        met[slot] = run + 1;
    }
    return PERCALE_OK;
}

static PercaleResult check_batches(const PercaleModel *model, const Constraints *constraints,
                                   PercaleMemory *memory, PercaleMessage *message)
{
    const PercaleBatches *batches = constraints->batches;
    uint32_t *met = percale_memory_new(memory, model->slot_count, sizeof(uint32_t));
    if (met == NULL) {
        return percale_fail_memory(message);
    }
    PercaleResult result = PERCALE_OK;
    for (uint32_t run = 0; constraints->offsets != NULL && run < batches->run_count; run++) {
        for (uint32_t i = batches->run_first[run]; result == PERCALE_OK && i < batches->run_first[run + 1];
             i++) {
            result = check_constraint(model, constraints, i, run, met, message);
        }
    }
    percale_memory_free(memory, met);
    return result;
}

PercaleResult percale_validate_model(const PercaleModel *model, const PercaleBatches *edges,
                                     const PercaleBatches *hinges, PercaleMemory *memory,
                                     PercaleMessage *message)
{
    PercaleResult result = check_points(model, message);
    Constraints kinds[] = {
        {edges, model->edge_count > 0 ? model->edges[0] : NULL, 2, "edge"},
        {hinges, model->hinge_count > 0 ? model->hinges[0] : NULL, 4, "hinge"},
    };
    for (size_t i = 0; i < sizeof(kinds) / sizeof(kinds[0]) && result == PERCALE_OK; i++) {
        result = check_batches(model, &kinds[i], memory, message);
    }
    return result;
}
