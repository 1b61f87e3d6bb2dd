#include "audit/audit_pairs.h"

#include <string.h>

static uint32_t key_of(const PercaleAuditPair *pair, bool by_first)
{
    return by_first ? pair->first : pair->second;
}

// Stable counting sort by one of the two keys; starts is [limit + 1].
static void sort_by_key(const PercaleAuditPair *from, PercaleAuditPair *to, size_t count, bool by_first,
                        size_t *starts, size_t limit)
{
    memset(starts, 0, (limit + 1) * sizeof *starts);
    for (size_t i = 0; i < count; i++)
        starts[key_of(&from[i], by_first) + 1]++;
    for (size_t key = 0; key < limit; key++)
        starts[key + 1] += starts[key];
    for (size_t i = 0; i < count; i++)
        to[starts[key_of(&from[i], by_first)]++] = from[i];
}

bool percale_audit_sort_pairs(const PercaleAuditMemory *memory, PercaleAuditPair *pairs, size_t count,
                              size_t limit)
{
    size_t *starts = percale_audit_allocate(memory, limit + 1, sizeof *starts);
    PercaleAuditPair *other = percale_audit_allocate(memory, count, sizeof *other);
    bool has_memory = starts && other;
    if (has_memory) {
        sort_by_key(pairs, other, count, 0, starts, limit);
        sort_by_key(other, pairs, count, 1, starts, limit);
    }
    percale_audit_release(memory, other);
    percale_audit_release(memory, starts);
    return has_memory;
}

size_t percale_audit_run_end(const PercaleAuditPair *pairs, size_t count, size_t begin)
{
    size_t end = begin + 1;
    while (end < count && pairs[end].first == pairs[begin].first && pairs[end].second == pairs[begin].second)
        end++;
    return end;
}
