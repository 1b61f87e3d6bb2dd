// radix_sort.h: stable sort of 64-bit keys with a 32-bit payload.

#ifndef PERCALE_RADIX_SORT_H
#define PERCALE_RADIX_SORT_H

#include <stddef.h>
#include <stdint.h>

typedef struct PercaleKeyed {
    uint64_t key;
    uint32_t value;
} PercaleKeyed;

/// Sorts items by key, equal keys in their old order. `scratch` has room for as many.
void percale_radix_sort(PercaleKeyed *items, PercaleKeyed *scratch, size_t count);

#endif
