#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum { ALIGNMENT = 64 }; // bytes; one cache line, and what the widest vector load wants

typedef struct BlockHeader {
    size_t size; // bytes after the header
} BlockHeader;

static void *allocate_from_libc(void *user, size_t size, size_t alignment)
{
    (void)user;
    return aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
}

static void release_to_libc(void *user, void *memory)
{
    (void)user;
    free(memory);
}

PercaleAllocator percale_allocator_default(void)
{
    return (PercaleAllocator){allocate_from_libc, release_to_libc, NULL};
}

void *percale_memory_new(PercaleMemory *memory, size_t count, size_t element_size)
{
    if (element_size != 0 && count > (SIZE_MAX - ALIGNMENT) / element_size) {
        return NULL;
    }
    size_t size = count * element_size;
    char *block = memory->allocator->allocate(memory->allocator->user, size + ALIGNMENT, ALIGNMENT);
    if (block == NULL) {
        return NULL;
    }
    ((BlockHeader *)(void *)block)->size = size;
    memory->bytes += size + ALIGNMENT;
    return memset(block + ALIGNMENT, 0, size);
}

static BlockHeader *header_of(void *block)
{
    return (BlockHeader *)(void *)((char *)block - ALIGNMENT);
}

void percale_memory_free(PercaleMemory *memory, void *block)
{
    if (block == NULL) {
        return;
    }
    BlockHeader *header = header_of(block);
    memory->bytes -= header->size + ALIGNMENT;
    memory->allocator->release(memory->allocator->user, header);
}

bool percale_memory_reserve(PercaleMemory *memory, void *array, size_t *capacity, size_t needed,
                            size_t element_size)
{
    if (needed <= *capacity) {
        return true;
    }
    size_t roomy = *capacity + *capacity / 2;
    size_t count = needed > roomy ? needed : roomy;
    void *block = percale_memory_new(memory, count, element_size);
    if (block == NULL) {
        return false;
    }
    void *old;
    memcpy(&old, array, sizeof(old));
    if (old != NULL) {
        memcpy(block, old, *capacity * element_size);
        percale_memory_free(memory, old);
    }
    memcpy(array, &block, sizeof(block));
    *capacity = count;
    return true;
}
