#include "finish/zones.h"

bool percale_zones_create(PercaleZones *zones, const PercaleModel *model, PercaleArena *arena)
{
    uint32_t count = model->slot_count;
    *zones = (PercaleZones){percale_arena_new(arena, count, sizeof(uint32_t)),
                            percale_arena_new(arena, count, sizeof(f32x4)),
                            percale_arena_new(arena, count, sizeof(f32x4))};
    bool complete = zones->parent != NULL && zones->pins != NULL && zones->obstacles != NULL;
    for (uint32_t slot = 0; complete && slot < count; slot++) {
        zones->parent[slot] = NO_ZONE;
        zones->pins[slot] = zones->obstacles[slot] = (f32x4){0};
    }
    return complete;
}

static uint32_t first_of(PercaleZones *zones, uint32_t slot)
{
    while (zones->parent[slot] != slot) {
        zones->parent[slot] = zones->parent[zones->parent[slot]]; // a shorter way for the next
        slot = zones->parent[slot];
    }
    return slot;
}

/// Joins a slot to a zone (NO_ZONE: to none). Returns the zone of both.
static uint32_t join(PercaleZones *zones, uint32_t slot, uint32_t zone)
{
    if (zones->parent[slot] == NO_ZONE) {
        zones->parent[slot] = slot;
    }
    uint32_t own = first_of(zones, slot);
    if (zone == NO_ZONE || own == zone) {
        return own;
    }
    uint32_t first = own < zone ? own : zone;
    uint32_t other = own < zone ? zone : own;
    zones->parent[other] = first;
    zones->pins[first] += zones->pins[other];
    zones->obstacles[first] += zones->obstacles[other];
    return first;
}

void percale_zones_add(PercaleZones *zones, const PercaleModel *model, const PercaleStencil *stencil)
{
    uint32_t zone = NO_ZONE;
    for (int k = 0; k < 4; k++) {
        if (model->predicted[stencil->points[k]][3] > 0.0f) {
            zone = join(zones, stencil->points[k], zone);
        }
    }
    for (int k = 0; zone != NO_ZONE && k < 4; k++) {
        uint32_t point = stencil->points[k];
        if (!(model->predicted[point][3] > 0.0f)) {
            f32x4 motion = with_w(model->predicted[point] - model->position[point], 1.0f);
            (point < model->slot_count ? zones->pins : zones->obstacles)[zone] += motion;
        }
    }
}

f32x4 percale_zones_motion(PercaleZones *zones, uint32_t slot)
{
    uint32_t zone = first_of(zones, slot);
    f32x4 sum = zones->pins[zone][3] > 0.0f ? zones->pins[zone] : zones->obstacles[zone];
    return sum[3] > 0.0f ? with_w(sum / sum[3], 0.0f) : (f32x4){0};
}
