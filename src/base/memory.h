// memory.h: counted allocations through the host's allocator.
//
// Each owner (model, detect, color, solve) has a PercaleMemory, which knows how many bytes it holds. Blocks
// are aligned to 64 bytes and zeroed.

#ifndef PERCALE_MEMORY_H
#define PERCALE_MEMORY_H

#include "percale/types.h"

#include <stdbool.h>

typedef struct PercaleAllocator {
    PercaleAllocateFunction *allocate;
    PercaleReleaseFunction *release;
    void *user;
} PercaleAllocator;

typedef struct PercaleMemory {
    const PercaleAllocator *allocator;
    uint64_t bytes;
} PercaleMemory;

/// The C library's allocator.
PercaleAllocator percale_allocator_default(void);

/// Zeroed array of count elements; NULL without memory (never for count 0: that gives a valid, empty block).
void *percale_memory_new(PercaleMemory *memory, size_t count, size_t element_size);
void percale_memory_free(PercaleMemory *memory, void *block); ///< NULL is allowed

/// Makes room for `needed` elements in *(void **)array; grows by half, keeps the content. False without
/// memory, and then nothing has changed.
bool percale_memory_reserve(PercaleMemory *memory, void *array, size_t *capacity, size_t needed,
                            size_t element_size);

#endif
