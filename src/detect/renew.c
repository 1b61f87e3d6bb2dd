#include "detect/renew.h"

#include <string.h>

/// What the chunks of a check share.
typedef struct Check {
    const PercaleStencil *stencils;
    const f32x4 *x;
    uint8_t *has_slid;
} Check;

static void check_range(void *context, uint32_t first, uint32_t end)
{
    const Check *check = context;
    for (uint32_t i = first; i < end; i++) {
        const PercaleStencil *stencil = &check->stencils[i];
        f32x4 slip = stencil_offset(stencil, check->x) - stencil->seen;
        slip -= stencil->normal * dot3(slip, stencil->normal);
        check->has_slid[i] = stencil->seen[3] > 0.0f && !(length3(slip) <= stencil->seen[3]);
    }
}

/// NULL without memory.
static const uint8_t *check_all(const PercaleStencilList *list, const f32x4 *x, PercaleArena *arena,
                                PercaleTeam *team)
{
    enum { GRAIN_STENCILS = 512 };
    Check check = {list->items, x, percale_arena_new(arena, list->count, sizeof(uint8_t))};
    if (check.has_slid != NULL) {
        percale_team_for(team, (uint32_t)list->count, GRAIN_STENCILS, check_range, &check);
    }
    return check.has_slid;
}

bool percale_sources_contain(const PercaleSources *sources, uint64_t source)
{
    size_t low = 0;
    size_t high = sources->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (sources->items[middle] < source) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < sources->count && sources->items[low] == source;
}

bool percale_renew_find(const PercaleStencilList *list, const f32x4 *x, PercaleArena *arena,
                        PercaleTeam *team, PercaleSources *sources)
{
    const uint8_t *has_slid = check_all(list, x, arena, team);
    uint64_t *items = percale_arena_new(arena, list->count, sizeof(uint64_t));
    *sources = (PercaleSources){items, 0};
    if (has_slid == NULL || items == NULL) {
        return false;
    }
    for (size_t i = 0; i < list->count; i++) {
        uint64_t source = list->items[i].source;
        if (has_slid[i] && (sources->count == 0 || items[sources->count - 1] != source)) {
            items[sources->count++] = source;
        }
    }
    return true;
}

/// Stencils of one source: [first, end).
typedef struct Run {
    const PercaleStencil *items;
    size_t first, end;
} Run;

/// Those of a source, from where the last run has ended.
static Run run_of(const PercaleStencil *items, size_t count, size_t first, uint64_t source)
{
    Run run = {items, first, first};
    while (run.end < count && items[run.end].source == source) {
        run.end++;
    }
    return run;
}

/// Whether one of them names these four points.
static bool is_among(const PercaleStencil *stencil, Run run)
{
    for (size_t i = run.first; i < run.end; i++) {
        if (memcmp(run.items[i].points, stencil->points, sizeof(stencil->points)) == 0) {
            return true;
        }
    }
    return false;
}

bool percale_renew_merge(const PercaleStencilList *known, bool same_substep, const f32x4 *x,
                         PercaleArena *arena, PercaleMemory *memory, PercaleTeam *team,
                         PercaleStencilList *found)
{
    const uint8_t *has_slid = check_all(known, x, arena, team);
    size_t new_count = found->count;
    PercaleStencil *added = percale_arena_new(arena, new_count, sizeof(*added));
    if (has_slid == NULL || added == NULL ||
        !percale_memory_reserve(memory, &found->items, &found->capacity, known->count + new_count,
                                sizeof(*added))) {
        return false;
    }
    if (new_count > 0) {
        memcpy(added, found->items, new_count * sizeof(*added));
    }
    PercaleStencil *to = found->items;
    size_t count = 0;
    Run old = {known->items, 0, 0};
    Run new = {added, 0, 0};
    while (old.end < known->count || new.end < new_count) {
        uint64_t source = old.end < known->count ? known->items[old.end].source : UINT64_MAX;
        uint64_t other = new.end < new_count ? added[new.end].source : UINT64_MAX;
        source = other < source ? other : source;
        old = run_of(known->items, known->count, old.end, source);
        new = run_of(added, new_count, new.end, source);
        Run kept = {to, count, count};
        for (size_t i = old.first; i < old.end; i++) {
            const PercaleStencil *stencil = &known->items[i];
            bool fits = !has_slid[i] && (stencil->seen[3] > 0.0f || !same_substep);
            bool pushes = same_substep && stencil->multiplier[3] > 0.0f;
            if (fits || (pushes && !is_among(stencil, new))) {
                to[count++] = *stencil;
            }
        }
        kept.end = count;
        for (size_t i = new.first; i < new.end; i++) {
            if (!is_among(&added[i], kept)) {
                to[count++] = added[i];
            }
        }
    }
    found->count = count;
    return true;
}
