// arena.h: temporary arrays that die together.
//
// Blocks are kept between resets, so that after a few steps nothing calls the allocator any more.

#ifndef PERCALE_ARENA_H
#define PERCALE_ARENA_H

#include "base/memory.h"

typedef struct PercaleArena {
    PercaleMemory memory;
    char *block;     // the newest block
    size_t capacity; // bytes of it
    size_t used;
    size_t total; // bytes asked for since the last reset
    char **full;  // older blocks, freed at the next reset
    size_t full_count, full_capacity;
} PercaleArena;

/// Uninitialised array, aligned to 64 bytes; NULL without memory.
void *percale_arena_new(PercaleArena *arena, size_t count, size_t element_size);

/// Forgets everything and merges the blocks into one that would have held it all.
void percale_arena_reset(PercaleArena *arena);
void percale_arena_free(PercaleArena *arena);

#endif
