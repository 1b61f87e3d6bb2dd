#include "base/radix_sort.h"

#include <string.h>

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS };

static uint64_t used_bits(const PercaleKeyed *items, size_t count)
{
    uint64_t bits = 0;
    for (size_t i = 0; i < count; i++) {
        bits |= items[i].key;
    }
    return bits;
}

void percale_radix_sort(PercaleKeyed *items, PercaleKeyed *scratch, size_t count)
{
    uint64_t bits = used_bits(items, count);
    PercaleKeyed *from = items;
    PercaleKeyed *to = scratch;
    for (int shift = 0; shift < 64 && (bits >> shift) != 0; shift += DIGIT_BITS) {
        size_t start[DIGITS] = {0};
        for (size_t i = 0; i < count; i++) {
            start[(from[i].key >> shift) & (DIGITS - 1)]++;
        }
        size_t sum = 0;
        for (size_t d = 0; d < DIGITS; d++) {
            size_t n = start[d];
            start[d] = sum;
            sum += n;
        }
        for (size_t i = 0; i < count; i++) {
            to[start[(from[i].key >> shift) & (DIGITS - 1)]++] = from[i];
        }
        PercaleKeyed *swap = from;
        from = to;
        to = swap;
    }
    if (from != items) {
        memcpy(items, from, count * sizeof(items[0]));
    }
}
