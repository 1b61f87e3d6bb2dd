#include "audit/audit_memory.h"

#include <stdlib.h>
#include <string.h>

static const size_t ALIGNMENT = 16; // bytes; what malloc promises, and more than any array here needs

void *percale_audit_allocate(const PercaleAuditMemory *memory, size_t count, size_t size)
{
    if (count == 0)
        count = 1;
    if (count > SIZE_MAX / size)
        return NULL;
    if (!memory->allocate)
        return calloc(count, size);
    void *block = memory->allocate(memory->user, count * size, ALIGNMENT);
    if (block)
        memset(block, 0, count * size);
    return block;
}

void percale_audit_release(const PercaleAuditMemory *memory, void *block)
{
    if (!block)
        return;
    if (memory->release)
        memory->release(memory->user, block);
    else
        free(block);
}
