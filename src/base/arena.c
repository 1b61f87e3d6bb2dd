#include "base/arena.h"

enum { ALIGNMENT = 64, FIRST_BLOCK = 1 << 16 }; // bytes

static bool add_block(PercaleArena *arena, size_t size)
{
    if (arena->block != NULL) {
        if (!percale_memory_reserve(&arena->memory, &arena->full, &arena->full_capacity,
                                    arena->full_count + 1, sizeof(arena->full[0]))) {
            return false;
        }
    }
    size_t capacity = size > 2 * arena->capacity ? size : 2 * arena->capacity;
    capacity = capacity > FIRST_BLOCK ? capacity : FIRST_BLOCK;
    char *block = percale_memory_new(&arena->memory, capacity, 1);
    if (block == NULL) {
        return false;
    }
    if (arena->block != NULL) {
        arena->full[arena->full_count++] = arena->block;
    }
    arena->block = block;
    arena->capacity = capacity;
    arena->used = 0;
    return true;
}

void *percale_arena_new(PercaleArena *arena, size_t count, size_t element_size)
{
    if (element_size != 0 && count > SIZE_MAX / 4 / element_size) {
        return NULL;
    }
    size_t size = (count * element_size + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if (arena->used + size > arena->capacity && !add_block(arena, size)) {
        return NULL;
    }
    if (arena->block == NULL && !add_block(arena, size)) { // an empty array in an empty arena
        return NULL;
    }
    void *array = arena->block + arena->used;
    arena->used += size;
    arena->total += size;
    return array;
}

void percale_arena_reset(PercaleArena *arena)
{
    if (arena->full_count > 0) {
        size_t total = arena->total;
        for (size_t i = 0; i < arena->full_count; i++) {
            percale_memory_free(&arena->memory, arena->full[i]);
        }
        arena->full_count = 0;
        percale_memory_free(&arena->memory, arena->block);
        arena->block = NULL;
        arena->capacity = 0;
        (void)add_block(arena, total); // without memory the next request asks again
    }
    arena->used = 0;
    arena->total = 0;
}

void percale_arena_free(PercaleArena *arena)
{
    for (size_t i = 0; i < arena->full_count; i++) {
        percale_memory_free(&arena->memory, arena->full[i]);
    }
    percale_memory_free(&arena->memory, arena->full);
    percale_memory_free(&arena->memory, arena->block);
    PercaleMemory memory = arena->memory;
    *arena = (PercaleArena){.memory = memory};
}
