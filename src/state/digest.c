#include "state/digest.h"

#include "base/hash.h"

#include <string.h>

static uint64_t add_vector(uint64_t hash, f32x4 a)
{
    uint32_t words[4];
    memcpy(words, &a, sizeof(words));
    return hash_add(hash_add(hash_add(hash, words[0]), words[1]), words[2]);
}

uint64_t percale_digest(const PercaleModel *model)
{
    uint64_t hash = hash_start();
    for (uint32_t c = 0; c < model->cloth_count; c++) {
        for (uint32_t i = 0; i < model->cloths[c].vertex_count; i++) {
            uint32_t slot = model->cloths[c].slots[i];
            hash = add_vector(add_vector(hash, model->position[slot]), model->velocity[slot]);
        }
    }
    return hash;
}
