#include "model/coarse.h"

#include "model/geodesic.h"

#include <string.h>

static const uint32_t NO_NODE = UINT32_MAX;
static const float REACH = 3.0f; // of links, and of what a point follows, in spacings

/// The nodes nearest to a point, by distance; one more than it follows tells where their pull ends.
enum { NEAREST = COARSE_LEADERS + 1 };
typedef struct Nearest {
    uint32_t nodes[NEAREST];
    float distances[NEAREST];
    uint32_t count;
} Nearest;

/// What building a level shares.
typedef struct Builder {
    PercaleGeodesicFront front;
    const f32x4 *points;
    float spacing;               // m, of the level's nodes
    const uint32_t *followers;   // [follower_count] slots of the level below
    const float *inverse_masses; // [follower_count] theirs; NULL: the points' own
    uint32_t *node_of;           // [slots] NO_NODE: none of this level
    uint8_t *is_covered;         // [slots] nearer than the spacing to a node
    Nearest *nearest;            // [slots]
    size_t slot_capacity;        // room of the level's arrays
    size_t link_capacity, length_capacity;
    PercaleMemory *memory;
} Builder;

static float inverse_mass_of(const Builder *builder, uint32_t follower)
{
    return builder->inverse_masses != NULL ? builder->inverse_masses[follower]
                                           : builder->points[builder->followers[follower]][3];
}

static void keep_nearest(Nearest *nearest, uint32_t node, float distance)
{
    uint32_t place = nearest->count < NEAREST ? nearest->count++ : NEAREST;
    while (place > 0 && distance < nearest->distances[place - 1]) {
        if (place < NEAREST) {
            nearest->nodes[place] = nearest->nodes[place - 1];
            nearest->distances[place] = nearest->distances[place - 1];
        }
        place--;
    }
    if (place < NEAREST) {
        nearest->nodes[place] = node;
        nearest->distances[place] = distance;
    }
}

// ---- nodes and links ----

static bool add_link(Builder *builder, PercaleCoarseLevel *level, uint32_t a, uint32_t b, float length)
{
    size_t needed = (size_t)level->link_count + 1;
    if (!percale_memory_reserve(builder->memory, &level->links, &builder->link_capacity, needed,
                                sizeof(level->links[0])) ||
        !percale_memory_reserve(builder->memory, &level->link_lengths, &builder->length_capacity, needed,
                                sizeof(float))) {
        return false;
    }
    level->links[level->link_count][0] = a;
    level->links[level->link_count][1] = b;
    level->link_lengths[level->link_count++] = length;
    return true;
}

/// A new node, which covers what is near, is followed from farther off, and is linked to those before it.
static bool add_node(Builder *builder, PercaleCoarseLevel *level, uint32_t slot)
{
    uint32_t node = level->node_count;
    if (!percale_memory_reserve(builder->memory, &level->slots, &builder->slot_capacity, (size_t)node + 1,
                                sizeof(uint32_t))) {
        return false;
    }
    level->slots[level->node_count++] = slot;
    builder->node_of[slot] = node;
    percale_geodesic_near(&builder->front, slot, REACH * builder->spacing);
    bool complete = true;
    for (uint32_t i = 0; complete && i < builder->front.reached_count; i++) {
        uint32_t reached = builder->front.reached[i];
        float distance = builder->front.distances[reached];
        builder->is_covered[reached] |= distance < builder->spacing;
        keep_nearest(&builder->nearest[reached], node, distance);
        uint32_t other = builder->node_of[reached];
        bool held = builder->points[slot][3] <= 0.0f && builder->points[reached][3] <= 0.0f;
        if (other != NO_NODE && other != node && !held) {
            complete = add_link(builder, level, other, node, distance);
        }
    }
    return complete;
}

/// Pins first: what hangs from them has to follow a node that stays.
static bool choose_nodes(Builder *builder, PercaleCoarseLevel *level)
{
    bool complete = true;
    for (int free = 0; free < 2; free++) {
        for (uint32_t i = 0; complete && i < level->follower_count; i++) {
            uint32_t slot = builder->followers[i];
            bool is_free = builder->points[slot][3] > 0.0f;
            if (is_free == (free == 1) && !builder->is_covered[slot]) {
                complete = add_node(builder, level, slot);
            }
        }
    }
    return complete;
}

// ---- who follows ----

/// Shares fall off with the distance, to nothing where one node more begins to count: along a line between
/// two nodes they are linear.
static f32x4 shares_of(const Nearest *nearest, float reach)
{
    f32x4 shares = {0.0f, 0.0f, 0.0f, 0.0f};
    if (nearest->count > 0 && nearest->distances[0] <= 0.0f) {
        shares[0] = 1.0f;
        return shares;
    }
    float end = nearest->count == NEAREST ? nearest->distances[NEAREST - 1] : reach;
    float sum = 0.0f;
    for (uint32_t k = 0; k < COARSE_LEADERS && k < nearest->count; k++) {
        float distance = nearest->distances[k];
        shares[k] = distance < end ? 1.0f / distance - 1.0f / end : 0.0f;
        sum += shares[k];
    }
    if (sum <= 0.0f) { // all at the same distance
        shares[0] = nearest->count > 0 ? 1.0f : 0.0f;
        return shares;
    }
    return shares / sum;
}

static bool lead(Builder *builder, PercaleCoarseLevel *level)
{
    PercaleMemory *memory = builder->memory;
    level->leaders = percale_memory_new(memory, level->follower_count, sizeof(level->leaders[0]));
    level->shares = percale_memory_new(memory, level->follower_count, sizeof(f32x4));
    level->inverse_masses = percale_memory_new(memory, level->node_count, sizeof(float));
    double *masses = percale_memory_new(memory, level->node_count, sizeof(double));
    bool complete =
        level->leaders != NULL && level->shares != NULL && level->inverse_masses != NULL && masses != NULL;
    for (uint32_t i = 0; complete && i < level->follower_count; i++) {
        const Nearest *nearest = &builder->nearest[builder->followers[i]];
        float inverse_mass = inverse_mass_of(builder, i);
        level->shares[i] = shares_of(nearest, REACH * builder->spacing);
        for (uint32_t k = 0; k < COARSE_LEADERS; k++) {
            level->leaders[i][k] = k < nearest->count ? nearest->nodes[k] : 0;
            if (inverse_mass > 0.0f) {
                masses[level->leaders[i][k]] += (double)level->shares[i][k] / (double)inverse_mass;
            }
        }
    }
    for (uint32_t n = 0; complete && n < level->node_count; n++) {
        bool moves = builder->points[level->slots[n]][3] > 0.0f && masses[n] > 0.0;
        level->inverse_masses[n] = moves ? (float)(1.0 / masses[n]) : 0.0f;
    }
    percale_memory_free(memory, masses);
    return complete;
}

// ---- levels ----

static bool build_level(Builder *builder, PercaleCoarseLevel *level)
{
    uint32_t slot_count = builder->front.mesh->vertex_count;
    memset(builder->is_covered, 0, slot_count);
    for (uint32_t slot = 0; slot < slot_count; slot++) {
        builder->node_of[slot] = NO_NODE;
        builder->nearest[slot].count = 0;
    }
    builder->slot_capacity = builder->link_capacity = builder->length_capacity = 0;
    return choose_nodes(builder, level) && lead(builder, level);
}

static void free_level(PercaleCoarseLevel *level, PercaleMemory *memory)
{
    void *arrays[] = {level->slots,  level->inverse_masses, level->leaders,
                      level->shares, level->links,          level->link_lengths};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); i++) {
        percale_memory_free(memory, arrays[i]);
    }
    *level = (PercaleCoarseLevel){0};
}

static bool build_levels(PercaleCoarse *coarse, Builder *builder, uint32_t level_count)
{
    while (coarse->level_count < level_count) {
        PercaleCoarseLevel *level = &coarse->levels[coarse->level_count++];
        const PercaleCoarseLevel *below = coarse->level_count > 1 ? level - 1 : NULL;
        level->follower_count = below != NULL ? below->node_count : builder->front.mesh->vertex_count;
        builder->spacing *= COARSE_SPACING;
        if (!build_level(builder, level)) {
            return false;
        }
        if (level->link_count == 0) { // nothing that could pull
            free_level(level, builder->memory);
            coarse->level_count--;
            return true;
        }
        builder->followers = level->slots;
        builder->inverse_masses = level->inverse_masses;
    }
    return true;
}

bool percale_coarse_build(PercaleCoarse *coarse, const PercaleGeodesicMesh *mesh, const f32x4 *points,
                          float spacing, uint32_t level_count, PercaleMemory *memory)
{
    uint32_t slot_count = mesh->vertex_count;
    uint32_t *slots = percale_memory_new(memory, slot_count, sizeof(uint32_t));
    Builder builder = {.points = points, .spacing = spacing, .followers = slots, .memory = memory};
    builder.node_of = percale_memory_new(memory, slot_count, sizeof(uint32_t));
    builder.is_covered = percale_memory_new(memory, slot_count, 1);
    builder.nearest = percale_memory_new(memory, slot_count, sizeof(Nearest));
    bool complete = slots != NULL && builder.node_of != NULL && builder.is_covered != NULL &&
                    builder.nearest != NULL && percale_geodesic_open(&builder.front, mesh, memory);
    for (uint32_t slot = 0; complete && slot < slot_count; slot++) {
        slots[slot] = slot;
    }
    complete = complete && build_levels(coarse, &builder, level_count);
    percale_geodesic_close(&builder.front, memory);
    percale_memory_free(memory, builder.nearest);
    percale_memory_free(memory, builder.is_covered);
    percale_memory_free(memory, builder.node_of);
    percale_memory_free(memory, slots);
    return complete;
}

void percale_coarse_free(PercaleCoarse *coarse, PercaleMemory *memory)
{
    for (uint32_t i = 0; i < coarse->level_count; i++) {
        free_level(&coarse->levels[i], memory);
    }
    coarse->level_count = 0;
}
