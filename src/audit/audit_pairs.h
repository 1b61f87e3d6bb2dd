// audit_pairs.h: sorts pairs of small numbers, which is how the audit finds equal edges and equal welds.

#ifndef PERCALE_AUDIT_AUDIT_PAIRS_H
#define PERCALE_AUDIT_AUDIT_PAIRS_H

#include "audit/audit_memory.h"

typedef struct PercaleAuditPair {
    uint32_t first;
    uint32_t second;
    uint32_t item; ///< whose pair this is
} PercaleAuditPair;

/// Sorts by first, then second, equal ones in their old order; both are below `limit`. False without memory.
bool percale_audit_sort_pairs(const PercaleAuditMemory *memory, PercaleAuditPair *pairs, size_t count,
                              size_t limit);

/// Where the run of pairs equal to pairs[begin] ends.
size_t percale_audit_run_end(const PercaleAuditPair *pairs, size_t count, size_t begin);

#endif
