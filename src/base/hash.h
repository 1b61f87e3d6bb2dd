// hash.h: a 64-bit digest of 32-bit words, order-dependent.

#ifndef PERCALE_HASH_H
#define PERCALE_HASH_H

#include <stdint.h>

static inline uint64_t hash_start(void)
{
    return 0x9e3779b97f4a7c15u;
}

/// One round of the splitmix64 finaliser (Steele et al. 2014) over the running state and the next word.
static inline uint64_t hash_add(uint64_t hash, uint32_t word)
{
    uint64_t z = (hash ^ word) + 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

#endif
