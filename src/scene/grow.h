// grow.h: arrays of the scene library: zeroed ones, and ones that grow one element at a time.

#ifndef PERCALE_GROW_H
#define PERCALE_GROW_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/// A zeroed array; NULL only without memory, also for count 0.
static inline void *percale_array_new(uint64_t count, size_t element_size)
{
    return count < SIZE_MAX ? calloc((size_t)count + 1, element_size) : NULL;
}

/// Returns `array` with room for at least `needed` elements (grown by half) and updates *capacity; NULL
/// without memory, and then `array` is as before.
static inline void *percale_grow(void *array, uint32_t *capacity, uint64_t needed, size_t element_size)
{
    if (needed <= *capacity && array != NULL) {
        return array;
    }
    uint64_t larger = (uint64_t)*capacity + *capacity / 2 + 16;
    larger = larger < needed ? needed : larger;
    larger = larger > UINT32_MAX ? UINT32_MAX : larger;
    if (needed > UINT32_MAX || larger > SIZE_MAX / element_size) {
        return NULL;
    }
    void *grown = realloc(array, (size_t)larger * element_size);
    if (grown != NULL) {
        *capacity = (uint32_t)larger;
    }
    return grown;
}

#endif
