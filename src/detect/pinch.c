#include "detect/pinch.h"

#include <string.h>

// Share of the room that two contacts need below which they are a pinch: what weight and tension press
// together stays above.
static const double PINCHED = 0.75;

// Share of that room that a place between the surfaces is at least a share of: layers of cloth keep apart
// what float32 can tell.
static const double SQUEEZED = 0.25;

// Cosine of the angle between the normals below which two surfaces oppose each other: out of a wedge that is
// wider than 60 degrees a vertex is pushed by contact.
static const float OPPOSING = -0.5f;

// Cosine of the angle to the direction across below which a triangle belongs to the back of a body, not to
// the surface that pinches.
static const double FACING = 0.3;

// For so long, s, what was held comes out of the obstacles that it is in.
static const float LEAVING_TIME = 0.25f;

static const double FARTHEST_PLACE = 0.45; // from the middle, in gaps

bool percale_pinches_create(PercalePinches *pinches, const PercaleModel *model, PercaleMemory *memory)
{
    *pinches = (PercalePinches){.states = percale_memory_new(memory, model->slot_count, sizeof(uint8_t)),
                                .number = percale_memory_new(memory, model->slot_count, sizeof(uint32_t))};
    return pinches->states != NULL && pinches->number != NULL;
}

void percale_pinches_free(PercalePinches *pinches, PercaleMemory *memory)
{
    percale_memory_free(memory, pinches->states);
    percale_memory_free(memory, pinches->number);
    percale_memory_free(memory, pinches->items);
    *pinches = (PercalePinches){0};
}

static double thickness_of(const PercaleModel *model, uint32_t slot, uint32_t obstacle)
{
    const PercalePair pair = {.model = model, .obstacle = &model->obstacles[obstacle]};
    return (double)pair_thickness(&pair, slot);
}

// ---- ride ----

static Vec3 place_of(const PercalePinchFoot *foot, const f32x4 *x)
{
    Vec3 place = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++) {
        place = vadd(place, vscale(foot->weights[k], vec3_of(x[foot->corners[k]])));
    }
    return place;
}

/// What is looked for: the nearest place of a surface that faces a direction.
typedef struct FootSearch {
    PercaleSurface surface;
    Vec3 point, direction;
    double nearest2; // m^2; nothing beyond
    PercalePinchFoot *foot;
    Vec3 normal; // of the triangle found; zero: none
} FootSearch;

static void ask_triangle(FootSearch *search, uint32_t triangle)
{
    const uint32_t *corners = search->surface.mesh->triangles + 3 * (size_t)triangle;
    const f32x4 *x = search->surface.points;
    PercaleClosest closest = percale_closest_on_triangle(search->point, vec3_of(x[corners[0]]),
                                                         vec3_of(x[corners[1]]), vec3_of(x[corners[2]]));
    if (!(closest.distance2 < search->nearest2)) {
        return;
    }
    Vec3 normal = percale_surface_face_normal(&search->surface, triangle);
    if (vdot(normal, search->direction) > FACING) {
        search->nearest2 = closest.distance2;
        search->normal = normal;
        memcpy(search->foot->corners, corners, sizeof(search->foot->corners));
        memcpy(search->foot->weights, closest.weights, sizeof(search->foot->weights));
    }
}

static void find_foot(FootSearch *search)
{
    const float SLACK = 1.0f + 1e-5f; // boxes are float32
    const PercaleTree *tree = search->surface.tree;
    f32x4 at = f32x4_of(search->point, 0.0f);
    PercaleTreeEntry stack[TREE_STACK];
    uint32_t size = 0;
    stack[size++] = tree_root(tree);
    while (size > 0) {
        PercaleTreeEntry entry = stack[--size];
        f32x8 distance2 = tree_box_distance2(tree_node(tree, entry), at);
        i32x8 near = at_most8(distance2, all8((float)search->nearest2 * SLACK));
        for (uint32_t bits = lane_bits(near); bits != 0; bits &= bits - 1) {
            uint32_t k = (uint32_t)__builtin_ctz(bits);
            if (entry.level > 0) {
                stack[size++] = (PercaleTreeEntry){entry.level - 1, TREE_WIDTH * entry.node + k};
            } else {
                ask_triangle(search, tree->order[TREE_WIDTH * entry.node + k]);
            }
        }
    }
}

/// Whether the point has left the surface over its rim: it is beside the foot, not above or below it.
static bool is_beside(Vec3 point, Vec3 foot, Vec3 normal, double most)
{
    Vec3 offset = vsub(point, foot);
    return vlength(vsub(offset, vscale(vdot(offset, normal), normal))) > most;
}

/// Finds the feet anew from a point. False where a surface is no longer there.
static bool follow_feet(const PercalePinchStage *stage, PercalePinch *pinch, Vec3 point)
{
    const PercaleModel *model = stage->model;
    Vec3 normals[2];
    for (int k = 0; k < 2; k++) {
        PercalePinchFoot *foot = &pinch->feet[k];
        double radius = vlength(vsub(point, place_of(foot, model->predicted))) * (1.0 + 1e-6) + 1e-9;
        FootSearch search = {
            .surface = {&model->obstacles[foot->obstacle], &stage->proximities[foot->obstacle].tree,
                        model->predicted, NULL},
            .point = point,
            .direction = vscale(k == 0 ? 1.0 : -1.0, pinch->across),
            .nearest2 = radius * radius,
            .foot = foot,
            .normal = {0.0, 0.0, 0.0},
        };
        find_foot(&search);
        normals[k] = search.normal;
        if (!(vdot(search.normal, search.normal) > 0.0) ||
            is_beside(point, place_of(foot, model->predicted), search.normal,
                      thickness_of(model, pinch->slot, foot->obstacle))) {
            return false;
        }
    }
    pinch->across = vunit(vsub(normals[0], normals[1]));
    return true;
}

/// The room that both contacts need, m.
static double room_of(const PercaleModel *model, const PercalePinch *pinch)
{
    return thickness_of(model, pinch->slot, pinch->feet[0].obstacle) +
           thickness_of(model, pinch->slot, pinch->feet[1].obstacle);
}

static void ride(const PercalePinchStage *stage, PercalePinch *pinch)
{
    PercaleModel *model = stage->model;
    Vec3 carried = {0.0, 0.0, 0.0};
    for (int k = 0; k < 2; k++) {
        Vec3 moved =
            vsub(place_of(&pinch->feet[k], model->predicted), place_of(&pinch->feet[k], model->position));
        carried = vadd(carried, vscale(0.5, moved));
    }
    Vec3 point = vadd(vec3_of(model->position[pinch->slot]), carried);
    bool is_between = follow_feet(stage, pinch, point);
    Vec3 first = place_of(&pinch->feet[0], model->predicted);
    Vec3 second = place_of(&pinch->feet[1], model->predicted);
    double room = room_of(model, pinch);
    double gap = vdot(pinch->across, vsub(second, first));
    double span = fmax(gap, SQUEEZED * room);
    double drift = vdot(pinch->across, vsub(vscale(0.5, vadd(first, second)), point)) + pinch->place * span;
    double most = (double)(EXIT_SPEED * stage->dt);
    drift = is_between ? fmax(-most, fmin(drift, most)) : 0.0;
    pinch->has_room = pinch->has_room || !is_between || gap >= room;
    pinch->velocity = f32x4_of(vscale(1.0 / (double)stage->dt, carried), 0.0f);
    model->predicted[pinch->slot] = f32x4_of(vadd(point, vscale(drift, pinch->across)), 0.0f);
}

static void ride_range(void *context, uint32_t first, uint32_t end)
{
    const PercalePinchStage *stage = context;
    for (uint32_t i = first; i < end; i++) {
        PercalePinch *pinch = &stage->pinches->items[i];
        if (pinch->is_leaving) {
            pinch->left += stage->dt;
        } else {
            ride(stage, pinch);
        }
    }
}

void percale_pinches_ride(const PercalePinchStage *stage)
{
    enum { GRAIN_PINCHES = 64 };
    PercalePinchStage shared = *stage;
    percale_team_for(stage->team, (uint32_t)stage->pinches->count, GRAIN_PINCHES, ride_range, &shared);
}

void percale_pinches_loosen(const PercalePinchStage *stage)
{
    for (size_t i = 0; i < stage->pinches->count; i++) {
        const PercalePinch *pinch = &stage->pinches->items[i];
        if (!pinch->is_leaving) {
            stage->model->predicted[pinch->slot][3] = pinch->inverse_mass;
        }
    }
}

void percale_pinches_end(const PercalePinchStage *stage)
{
    for (size_t i = 0; i < stage->pinches->count; i++) {
        const PercalePinch *pinch = &stage->pinches->items[i];
        if (!pinch->is_leaving) {
            stage->model->predicted[pinch->slot][3] = 0.0f;
            stage->model->next_velocity[pinch->slot] = pinch->velocity;
        }
    }
}

// ---- who is pinched ----

static const uint32_t NO_STENCIL = UINT32_MAX;

/// Two stencils of a vertex that oppose each other.
typedef struct Opposed {
    uint32_t stencils[2]; // NO_STENCIL: none
    double gap;           // m
} Opposed;

/// What the chunks of a search share.
typedef struct Search {
    const PercalePinchStage *stage;
    const PercaleStencilList *stencils;
    uint32_t obstacle;
    uint32_t (*found)[2]; // [active_count] stencils
} Search;

/// Whether the vertex is nearer to the obstacle than it should be by more than contact allows.
static bool is_pressed(const Search *search, uint32_t index)
{
    const PercaleProximity *proximity = &search->stage->proximities[search->obstacle];
    const PercaleCrossing *crossings = search->stage->crossings[search->obstacle];
    const PercaleSighting *sighting = &proximity->sightings[index];
    double thickness = thickness_of(search->stage->model, proximity->active[index], search->obstacle);
    return (crossings != NULL && crossings[index].triangle != NO_TRIANGLE) ||
           (sighting->nearest != NO_TRIANGLE && (double)sighting->distance < PINCHED * thickness);
}

/// The first stencil whose source is not before this one.
static uint32_t find_source(const PercaleStencilList *list, uint64_t source)
{
    size_t low = 0;
    size_t high = list->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (list->items[middle].source < source) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return (uint32_t)low;
}

static uint32_t obstacle_of(const PercaleStencil *stencil)
{
    return (uint32_t)(stencil->source >> 32);
}

/// Height of the vertex above the surface, m, where the points are at x.
static double height_at(const PercaleStencil *stencil, const f32x4 *x)
{
    return (double)dot3(stencil->normal, stencil_offset(stencil, x));
}

/// How far the surface moves towards the vertex in the substep, m.
static double advance_of(const PercaleStencil *stencil, const PercaleModel *model)
{
    f32x4 moved = {0};
    for (int k = 1; k < 4; k++) {
        uint32_t corner = stencil->points[k];
        moved -= (model->predicted[corner] - model->position[corner]) * stencil->weights[k];
    }
    return (double)dot3(stencil->normal, moved);
}

/// Keeps the pair if it is a pinch, and narrower than what was found. Surfaces that don't close in on each
/// other leave what room they have: there contact does what it can.
static void try_pair(const Search *search, uint32_t a, uint32_t b, Opposed *best)
{
    const PercaleModel *model = search->stage->model;
    const PercaleStencil *first = &search->stencils->items[a];
    const PercaleStencil *second = &search->stencils->items[b];
    double gap = height_at(first, model->predicted) + height_at(second, model->predicted);
    double room = thickness_of(model, first->points[0], obstacle_of(first)) +
                  thickness_of(model, first->points[0], obstacle_of(second));
    bool opposing = dot3(first->normal, second->normal) < OPPOSING;
    bool closing = advance_of(first, model) + advance_of(second, model) > 0.0;
    if (gap < PINCHED * room && gap < best->gap && opposing && (gap < 0.0 || closing)) {
        *best = (Opposed){{a, b}, gap};
    }
}

static void search_vertex(const Search *search, uint32_t index)
{
    const PercaleStencilList *list = search->stencils;
    uint32_t slot = search->stage->proximities[search->obstacle].active[index];
    Opposed best = {{NO_STENCIL, NO_STENCIL}, HUGE_VAL};
    uint64_t source = (uint64_t)search->obstacle << 32 | slot;
    for (uint32_t a = find_source(list, source); a < list->count && list->items[a].source == source; a++) {
        for (uint32_t o = 0; o < search->stage->model->obstacle_count; o++) {
            if (!search->stage->proximities[o].is_active[slot]) {
                continue;
            }
            uint64_t other = (uint64_t)o << 32 | slot;
            for (uint32_t b = find_source(list, other); b < list->count && list->items[b].source == other;
                 b++) {
                try_pair(search, a, b, &best);
            }
        }
    }
    memcpy(search->found[index], best.stencils, sizeof(best.stencils));
}

static void search_range(void *context, uint32_t first, uint32_t end)
{
    const Search *search = context;
    for (uint32_t i = first; i < end; i++) {
        search->found[i][0] = NO_STENCIL;
        if (is_pressed(search, i)) {
            search_vertex(search, i);
        }
    }
}

// ---- held, and let go ----

static void hold(const PercalePinchStage *stage, const PercaleStencil *const stencils[2], PercalePinch *pinch)
{
    PercaleModel *model = stage->model;
    uint32_t slot = stencils[0]->points[0];
    *pinch = (PercalePinch){.slot = slot, .inverse_mass = model->position[slot][3]};
    for (int k = 0; k < 2; k++) {
        PercalePinchFoot *foot = &pinch->feet[k];
        foot->obstacle = obstacle_of(stencils[k]);
        memcpy(foot->corners, stencils[k]->points + 1, sizeof(foot->corners));
        for (int i = 0; i < 3; i++) {
            foot->weights[i] = -(double)stencils[k]->weights[1 + i];
        }
    }
    pinch->across = vunit(vec3_of(stencils[0]->normal - stencils[1]->normal));
    double low = height_at(stencils[0], model->position);
    double high = height_at(stencils[1], model->position);
    double place = 0.5 * (low - high) / fmax(low + high, SQUEEZED * room_of(model, pinch));
    pinch->place = fmax(-FARTHEST_PLACE, fmin(place, FARTHEST_PLACE));
    model->position[slot][3] = 0.0f;
    stage->pinches->states[slot] = PINCH_HELD;
    stage->pinches->held_count++;
    ride(stage, pinch);
}

/// Whether a vertex that leaves has left, or is held again by another pinch.
static bool is_done(PercalePinches *pinches, const PercalePinch *pinch)
{
    uint8_t *state = &pinches->states[pinch->slot];
    if (*state == PINCH_LEAVING && pinch->left >= LEAVING_TIME) {
        *state = PINCH_NONE;
    }
    return *state != PINCH_LEAVING;
}

static void let_go(const PercalePinchStage *stage)
{
    PercalePinches *pinches = stage->pinches;
    size_t kept = 0;
    for (size_t i = 0; i < pinches->count; i++) {
        PercalePinch *pinch = &pinches->items[i];
        if (pinch->is_leaving && is_done(pinches, pinch)) {
            continue;
        }
        if (pinch->has_room && !pinch->is_leaving) {
            pinch->is_leaving = true;
            pinches->states[pinch->slot] = PINCH_LEAVING;
            pinches->held_count--;
            stage->model->position[pinch->slot][3] = pinch->inverse_mass;
            stage->model->predicted[pinch->slot][3] = pinch->inverse_mass;
        }
        pinches->number[pinch->slot] = (uint32_t)kept;
        pinches->items[kept++] = *pinch;
    }
    pinches->count = kept;
}

/// Holds those that were found at an obstacle, unless they are held already.
static bool hold_found(const Search *search, uint32_t count, PercaleMemory *memory)
{
    const PercalePinchStage *stage = search->stage;
    PercalePinches *pinches = stage->pinches;
    for (uint32_t i = 0; i < count; i++) {
        if (search->found[i][0] == NO_STENCIL) {
            continue;
        }
        const PercaleStencil *stencils[2] = {&search->stencils->items[search->found[i][0]],
                                             &search->stencils->items[search->found[i][1]]};
        if (pinches->states[stencils[0]->points[0]] == PINCH_HELD) {
            continue;
        }
        if (!percale_memory_reserve(memory, &pinches->items, &pinches->capacity, pinches->count + 1,
                                    sizeof(pinches->items[0]))) {
            return false;
        }
        pinches->number[stencils[0]->points[0]] = (uint32_t)pinches->count;
        hold(stage, stencils, &pinches->items[pinches->count++]);
    }
    return true;
}

bool percale_pinches_find(const PercalePinchStage *stage, const PercaleStencilList *stencils,
                          PercaleArena *arena, PercaleMemory *memory)
{
    enum { GRAIN_ACTIVE = 512 };
    let_go(stage);
    for (uint32_t o = 0; o < stage->model->obstacle_count; o++) {
        uint32_t count = stage->proximities[o].active_count;
        Search search = {stage, stencils, o, percale_arena_new(arena, count, sizeof(search.found[0]))};
        if (search.found == NULL) {
            return false;
        }
        percale_team_for(stage->team, count, GRAIN_ACTIVE, search_range, &search);
        if (!hold_found(&search, count, memory)) {
            return false;
        }
    }
    return true;
}

bool percale_pinches_leave(const PercalePinches *pinches, const uint32_t *slots, uint32_t count,
                           uint32_t obstacle, Vec3 outward)
{
    bool any = false;
    for (uint32_t i = 0; i < count; i++) {
        if (pinches->states[slots[i]] == PINCH_LEAVING) {
            const PercalePinch *pinch = &pinches->items[pinches->number[slots[i]]];
            double across = vdot(pinch->across, outward);
            any = any || (pinch->feet[0].obstacle == obstacle && across > FACING) ||
                  (pinch->feet[1].obstacle == obstacle && across < -FACING);
        }
    }
    return any;
}
