// audit_memory.h: where the audit's arrays come from; each is released by the one who asked for it.

#ifndef PERCALE_AUDIT_AUDIT_MEMORY_H
#define PERCALE_AUDIT_AUDIT_MEMORY_H

#include "percale/types.h"

#include <stdbool.h>

/// An allocator pair as in PercaleSolverDef; both NULL: the C library's.
typedef struct PercaleAuditMemory {
    PercaleAllocateFunction *allocate;
    PercaleReleaseFunction *release;
    void *user;
} PercaleAuditMemory;

/// Zeroed array of count > 0 or none: never NULL but without memory.
void *percale_audit_allocate(const PercaleAuditMemory *memory, size_t count, size_t size);
void percale_audit_release(const PercaleAuditMemory *memory, void *block); ///< NULL is allowed

#endif
