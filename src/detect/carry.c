#include "detect/carry.h"

#include <string.h>

// Cosine between two normals above which what is owed along one surface is owed along the other.
static const float SAME_SURFACE = 0.9f;

/// Stencils of one source: [first, end).
typedef struct Group {
    size_t first, end;
} Group;

/// The first known stencil whose source is not before this one.
static size_t find_source(const PercaleStencilList *known, uint64_t source)
{
    size_t low = 0;
    size_t high = known->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (known->items[middle].source < source) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/// The stencils of a source, from `first` on.
static Group group_at(const PercaleStencilList *list, size_t first, uint64_t source)
{
    Group group = {first, first};
    while (group.end < list->count && list->items[group.end].source == source) {
        group.end++;
    }
    return group;
}

/// v without its part along the normal, and without a fourth component.
static f32x4 along_surface(f32x4 v, f32x4 normal)
{
    return with_w(v - normal * dot3(v, normal), 0.0f);
}

/// Continues what was known of these four points; else of the same surface.
static void carry(const PercaleCarryStage *stage, Group known, PercaleStencil *stencil)
{
    const PercaleStencil *alike = NULL;
    float best = SAME_SURFACE;
    for (size_t i = known.first; i < known.end; i++) {
        const PercaleStencil *other = &stage->known->items[i];
        if (memcmp(other->points, stencil->points, sizeof(stencil->points)) == 0) {
            stencil->owed = along_surface(other->owed, stencil->normal);
            if (stage->same_substep) {
                stencil->multiplier =
                    with_w(along_surface(other->multiplier, stencil->normal), other->multiplier[3]);
            }
            return;
        }
        float cosine = dot3(other->normal, stencil->normal);
        if (cosine > best) {
            best = cosine;
            alike = other;
        }
    }
    if (alike != NULL) {
        stencil->owed = along_surface(alike->owed, stencil->normal);
    }
}

static void carry_range(void *context, uint32_t first, uint32_t end)
{
    const PercaleCarryStage *stage = context;
    PercaleStencil *found = stage->found->items;
    Group known = {0, 0};
    for (uint32_t i = first; i < end; i++) {
        uint64_t source = found[i].source;
        if (i == first) {
            known = group_at(stage->known, find_source(stage->known, source), source);
        } else if (source != found[i - 1].source) {
            while (known.end < stage->known->count && stage->known->items[known.end].source < source) {
                known.end++;
            }
            known = group_at(stage->known, known.end, source);
        }
        carry(stage, known, &found[i]);
    }
}

void percale_carry_run(PercaleCarryStage *stage)
{
    enum { GRAIN_STENCILS = 512 };
    percale_team_for(stage->team, (uint32_t)stage->found->count, GRAIN_STENCILS, carry_range, stage);
}
