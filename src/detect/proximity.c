#include "detect/proximity.h"

#include "base/wide.h"

#include <stdatomic.h>
#include <string.h>

// How far beyond the reach a search looks, so that a vertex found far is not searched for again at once: a
// share of the reach, and substeps of the present motion.
static const float LOOKAHEAD_REACH = 4.0f;
static const float LOOKAHEAD_SUBSTEPS = 8.0f;

// Between two collision passes a vertex that is outside is left alone as long as its clearance, after its
// motion, is this many times that motion: as far again the solver may lead it astray, and the path test may
// be wrong by twice the obstacle's motion.
static const float PATH_ROOM = 2.0f;

// Thicknesses within which a surface is looked at around each triangle: twice as many as a vertex at rest
// reaches.
static const double CONVEX = 8.0;

static const float FARTHEST = 1e8f; // m; more than any two points of a scene are apart

bool percale_proximity_create(PercaleProximity *proximity, const PercaleModel *model,
                              const PercaleModelSurface *obstacle, bool exact, PercaleMemory *memory)
{
    *proximity = (PercaleProximity){0};
    proximity->clearance = percale_memory_new(memory, model->slot_count, sizeof(float));
    proximity->nearest = percale_memory_new(memory, model->slot_count, sizeof(uint32_t));
    proximity->side = percale_memory_new(memory, model->slot_count, sizeof(int8_t));
    proximity->is_active = percale_memory_new(memory, model->slot_count, sizeof(uint8_t));
    proximity->active = percale_memory_new(memory, model->slot_count, sizeof(uint32_t));
    if (proximity->clearance == NULL || proximity->nearest == NULL || proximity->side == NULL ||
        proximity->is_active == NULL || proximity->active == NULL ||
        !percale_nearby_create(&proximity->nearby, model->slot_count, memory) ||
        !percale_tree_build(&proximity->tree, obstacle->triangles, 3, obstacle->triangle_count,
                            model->position, memory) ||
        (exact && !percale_tree_build(&proximity->swept, obstacle->triangles, 3, obstacle->triangle_count,
                                      model->position, memory))) {
        percale_proximity_free(proximity, memory);
        return false;
    }
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        proximity->nearest[slot] = NO_TRIANGLE;
    }
    return true;
}

bool percale_proximity_begin(PercaleProximity *proximity, const PercaleModel *model,
                             const PercaleModelSurface *obstacle, PercaleMemory *memory)
{
    PercaleSurface surface = {obstacle, &proximity->tree, model->position, NULL};
    percale_tree_refit(&proximity->tree, obstacle->triangles, model->position, percale_team_alone());
    double thickest = 0.5 * (double)(thickest_cloth(model) + obstacle->thickness);
    return !obstacle->still || percale_convex_find(&proximity->convex, &surface, CONVEX * thickest, memory);
}

void percale_proximity_free(PercaleProximity *proximity, PercaleMemory *memory)
{
    percale_convex_free(&proximity->convex, memory);
    percale_tree_free(&proximity->tree, memory);
    percale_tree_free(&proximity->swept, memory);
    percale_memory_free(memory, proximity->clearance);
    percale_memory_free(memory, proximity->nearest);
    percale_memory_free(memory, proximity->side);
    percale_memory_free(memory, proximity->is_active);
    percale_memory_free(memory, proximity->active);
    percale_nearby_free(&proximity->nearby, memory);
    *proximity = (PercaleProximity){0};
}

static bool can_collide(const PercalePair *pair, uint32_t slot)
{
    const PercaleModel *model = pair->model;
    return model->position[slot][3] > 0.0f &&
           (model->cloths[model->cloth_of[slot]].mask & pair->obstacle->mask) != 0;
}

/// Whether the point is within the bounds of the whole surface: else it can't be inside a closed one.
static bool is_in_bounds(const PercaleTree *tree, f32x4 point)
{
    const PercaleTreeNode *root = tree_node(tree, tree_root(tree));
    bool within = true;
    for (int axis = 0; axis < 3; axis++) {
        float low = INFINITY;
        float high = -INFINITY;
        for (int k = 0; k < TREE_WIDTH; k++) {
            low = root->low[axis][k] < low ? root->low[axis][k] : low;
            high = root->high[axis][k] > high ? root->high[axis][k] : high;
        }
        within = within && point[axis] >= low && point[axis] <= high;
    }
    return within;
}

typedef enum Answer {
    IDLE,
    ACTIVE_KNOWN,
    ACTIVE_SEARCHED,
    IDLE_SEARCHED,
    ACTIVE_MISSED // its bound said that it was idle
} Answer;

/// The search that a bound saves: of a vertex that the bound says is farther away than that. As long as the
/// bound is right, what is known stays as it is.
static Answer doubt_bound(PercaleProximity *proximity, const PercalePair *pair, const PercaleSurface *surface,
                          uint32_t slot, float distance)
{
    const double ROUNDING = 1e-5; // share of the distance
    Vec3 point = vec3_of(pair->model->position[slot]);
    PercaleNearest nearest = percale_surface_nearest(surface, point, (double)distance * (1.0 - ROUNDING),
                                                     proximity->nearest[slot]);
    if (nearest.triangle == NO_TRIANGLE) {
        return IDLE_SEARCHED;
    }
    proximity->clearance[slot] = (float)sqrt(nearest.closest.distance2);
    proximity->nearest[slot] = nearest.triangle;
    proximity->side[slot] = (int8_t)percale_surface_side(surface, point, &nearest);
    return ACTIVE_MISSED;
}

/// Whether the slot can touch the obstacle in this substep; computes its distance when the bound doesn't
/// tell.
static Answer examine(PercaleProximity *proximity, const PercalePair *pair, const PercaleSurface *surface,
                      uint32_t slot)
{
    if (!can_collide(pair, slot)) {
        return IDLE;
    }
    const PercaleModel *model = pair->model;
    bool closed = pair->obstacle->closed;
    if (closed && proximity->side[slot] < 0) {
        return ACTIVE_KNOWN; // however deep: it has to come out
    }
    float motion = length3(model->predicted[slot] - model->position[slot]) + proximity->motion;
    float reach = pair_reach(pair, slot, motion);
    float room = proximity->clearance[slot] - motion;
    int8_t side = proximity->side[slot];
    if (room > reach || (!pair->is_pass_due && side > 0 && room > PATH_ROOM * motion)) {
        return pair->is_found_anew ? doubt_bound(proximity, pair, surface, slot, reach + motion) : IDLE;
    }
    if (side != 0 && (side != OUTSIDE_BY_BOUND || !pair->is_pass_due)) {
        return ACTIVE_KNOWN;
    }
    Vec3 point = vec3_of(model->position[slot]);
    float radius = LOOKAHEAD_REACH * reach + LOOKAHEAD_SUBSTEPS * motion;
    if (closed && proximity->nearest[slot] == NO_TRIANGLE &&
        is_in_bounds(&proximity->tree, model->position[slot])) {
        radius = FARTHEST; // it may be deep inside
    }
    PercaleNearbyQuery query = {surface, proximity->traveled - (double)proximity->motion, point,
                                (double)radius};
    PercaleNearest nearest;
    if (pair->is_found_anew || (!percale_convex_nearest(&proximity->convex, surface, point, query.radius,
                                                        proximity->nearest[slot], &nearest) &&
                                !percale_nearby_nearest(&proximity->nearby, slot, &query, &nearest))) {
        nearest = percale_surface_nearest(surface, point, query.radius, proximity->nearest[slot]);
    }
    proximity->clearance[slot] = (float)sqrt(nearest.closest.distance2);
    if (nearest.triangle == NO_TRIANGLE) {
        return IDLE_SEARCHED;
    }
    proximity->nearest[slot] = nearest.triangle;
    proximity->side[slot] = (int8_t)percale_surface_side(surface, point, &nearest);
    bool near = proximity->clearance[slot] - motion <= reach || (closed && proximity->side[slot] < 0);
    return near ? ACTIVE_SEARCHED : IDLE_SEARCHED;
}

/// What the chunks of a selection share.
typedef struct Selection {
    PercaleProximity *proximity;
    const PercalePair *pair;
    const PercaleSurface *surface;
    float thickest; // m; no cloth keeps a greater distance to the obstacle
    atomic_uint_fast64_t searches, missed;
} Selection;

/// Whether none of the eight slots can touch the obstacle, whatever its cloth: most of the time most can't.
static bool are_idle(const Selection *selection, uint32_t slot)
{
    const PercaleProximity *proximity = selection->proximity;
    const PercaleModel *model = selection->pair->model;
    f32x8 motion = distances8(model->predicted + slot, model->position + slot) + proximity->motion;
    f32x8 reach = motion * selection->pair->later_substeps + 2.0f * selection->thickest;
    f32x8 room = load8(proximity->clearance + slot) - motion;
    ByteSigns signs = signs_of(load_bytes8(proximity->side + slot));
    uint32_t idle = lane_bits(greater8(room, reach));
    if (!selection->pair->is_pass_due) {
        idle |= lane_bits(greater8(room, motion * PATH_ROOM)) & byte_bits(signs.positive);
    }
    return signs.negative == 0 && idle == 0xff;
}

static PercaleSelectionCounts examine_slots(const Selection *selection, uint32_t first, uint32_t end)
{
    PercaleProximity *proximity = selection->proximity;
    PercaleSelectionCounts counts = {0, 0};
    for (uint32_t slot = first; slot < end; slot++) {
        Answer answer = examine(proximity, selection->pair, selection->surface, slot);
        bool is_active = answer != IDLE && answer != IDLE_SEARCHED;
        proximity->is_active[slot] = is_active;
        if (!is_active && selection->pair->is_pass_due && proximity->side[slot] > 0) {
            proximity->side[slot] = 0;
        }
        counts.searches += answer != IDLE && answer != ACTIVE_KNOWN;
        counts.missed += answer == ACTIVE_MISSED;
    }
    return counts;
}

static void add_counts(PercaleSelectionCounts *sum, PercaleSelectionCounts counts)
{
    sum->searches += counts.searches;
    sum->missed += counts.missed;
}

static void examine_range(void *context, uint32_t first, uint32_t end)
{
    Selection *selection = context;
    PercaleSelectionCounts counts = {0, 0};
    uint32_t slot = first;
    for (; slot + WIDE <= end; slot += WIDE) {
        if (!selection->pair->is_found_anew && are_idle(selection, slot)) {
            memset(selection->proximity->is_active + slot, 0, WIDE);
            if (selection->pair->is_pass_due) {
                memset(selection->proximity->side + slot, 0, WIDE);
            }
        } else {
            add_counts(&counts, examine_slots(selection, slot, slot + WIDE));
        }
    }
    add_counts(&counts, examine_slots(selection, slot, end));
    atomic_fetch_add_explicit(&selection->searches, counts.searches, memory_order_relaxed);
    atomic_fetch_add_explicit(&selection->missed, counts.missed, memory_order_relaxed);
}

/// Lists the active slots.
static void list_active(PercaleProximity *proximity, uint32_t slot_count)
{
    uint32_t count = 0;
    uint32_t slot = 0;
    while (slot < slot_count) {
        if (slot + WIDE <= slot_count && load_bytes8(proximity->is_active + slot) == 0) {
            slot += WIDE;
            continue;
        }
        proximity->active[count] = slot;
        count += proximity->is_active[slot];
        slot++;
    }
    proximity->active_count = count;
}

PercaleSelectionCounts percale_proximity_select(PercaleProximity *proximity, const PercalePair *pair,
                                                const PercaleSurface *surface, PercaleTeam *team)
{
    enum { GRAIN_SLOTS = 512 };
    uint32_t slot_count = pair->model->slot_count;
    Selection selection = {
        proximity, pair, surface, 0.5f * (thickest_cloth(pair->model) + pair->obstacle->thickness), 0, 0};
    percale_team_for(team, slot_count, GRAIN_SLOTS, examine_range, &selection);
    list_active(proximity, slot_count);
    return (PercaleSelectionCounts){selection.searches, selection.missed};
}
