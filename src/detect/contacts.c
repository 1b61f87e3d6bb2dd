#include "detect/contacts.h"

#include "base/parallel.h"

#include <string.h>

// Below this share of the thickness a closest-point vector has no direction left, and the (pseudo)normal
// stands in.
static const double NO_DIRECTION = 1e-3;

Vec3 percale_contact_normal(const PercaleSurface *surface, Vec3 point, uint32_t triangle,
                            const PercaleClosest *closest, int side)
{
    double shortest = NO_DIRECTION * (double)surface->mesh->thickness;
    if (closest->region == REGION_FACE || closest->distance2 <= shortest * shortest) {
        return percale_surface_normal(surface, triangle, closest->region);
    }
    Vec3 foot = percale_surface_point(surface, triangle, closest->weights);
    return vscale((double)side, vunit(vsub(point, foot)));
}

// ---- one vertex ----

/// What is known of a vertex when its contacts are looked for.
typedef struct Visitor {
    uint32_t slot;
    Vec3 point;    // where contacts are looked for: the predicted position, or just before the crossing
    float target;  // m; distance to keep
    float reach;   // m
    bool in_front; // it came from the surface's outer side
} Visitor;

static bool has_crossed(const PercaleContactStage *stage, uint32_t index)
{
    return stage->crossings != NULL && stage->crossings[index].triangle != NO_TRIANGLE;
}

static Visitor visit(const PercaleContactStage *stage, uint32_t index)
{
    const PercaleModel *model = stage->pair->model;
    uint32_t slot = stage->proximity->active[index];
    float thickness = pair_thickness(stage->pair, slot);
    float motion = length3(model->predicted[slot] - model->position[slot]) + stage->proximity->motion;
    float distance = (float)stage->proximity->side[slot] * stage->proximity->clearance[slot];
    float risen = distance + EXIT_SPEED * stage->dt;
    Visitor visitor = {slot, vec3_of(model->predicted[slot]), risen < thickness ? risen : thickness,
                       pair_reach(stage->pair, slot, motion), stage->proximity->side[slot] > 0};
    if (has_crossed(stage, index)) {
        const PercaleCrossing *crossing = &stage->crossings[index];
        Vec3 normal = percale_surface_face_normal(stage->surface, crossing->triangle);
        Vec3 impact = percale_surface_point(stage->surface, crossing->triangle, crossing->weights);
        visitor.point = vadd(impact, vscale((double)thickness, normal));
        visitor.reach = 2.0f * thickness;
        visitor.target = thickness;
        visitor.in_front = true;
    }
    return visitor;
}

static bool append(PercaleStencilList *list, PercaleMemory *memory, PercaleStencil stencil)
{
    if (!percale_memory_reserve(memory, &list->items, &list->capacity, list->count + 1, sizeof(stencil))) {
        return false;
    }
    list->items[list->count++] = stencil;
    return true;
}

static PercaleStencil make_stencil(const PercaleContactStage *stage, const Visitor *visitor,
                                   const PercaleFeature *feature, int side)
{
    const PercalePair *pair = stage->pair;
    const uint32_t *corners = pair->obstacle->triangles + 3 * (size_t)feature->triangle;
    Vec3 normal =
        percale_contact_normal(stage->surface, visitor->point, feature->triangle, &feature->closest, side);
    const PercaleModelCloth *cloth = &pair->model->cloths[pair->model->cloth_of[visitor->slot]];
    PercaleStencil stencil = {.points = {visitor->slot, corners[0], corners[1], corners[2]},
                              .weights = {1.0f},
                              .normal = f32x4_of(normal, visitor->target),
                              .friction = sqrtf(cloth->friction * pair->obstacle->friction)};
    float weights[3];
    quantize_weights(feature->closest.weights, weights);
    for (int k = 0; k < 3; k++) {
        stencil.weights[1 + k] = -weights[k];
    }
    return stencil;
}

static void sort_by_feature(const PercaleSurface *surface, PercaleFeatureList *list)
{
    for (size_t i = 1; i < list->count; i++) { // short lists, nearly always below ten
        PercaleFeature item = list->items[i];
        uint64_t key = percale_surface_feature_key(surface, item.triangle, item.closest.region);
        size_t at = i;
        for (; at > 0; at--) {
            const PercaleFeature *before = &list->items[at - 1];
            uint64_t other = percale_surface_feature_key(surface, before->triangle, before->closest.region);
            if (other < key || (other == key && before->triangle < item.triangle)) {
                break;
            }
            list->items[at] = *before;
        }
        list->items[at] = item;
    }
}

static PercaleNearest nearest_of(const PercaleContactStage *stage, const Visitor *visitor,
                                 const PercaleFeatureList *list)
{
    PercaleNearest best = {NO_TRIANGLE, {HUGE_VAL, {0.0, 0.0, 0.0}, REGION_FACE}, {0.0, 0.0, 0.0}};
    for (size_t i = 0; i < list->count; i++) {
        const PercaleFeature *item = &list->items[i];
        if (item->closest.distance2 < best.closest.distance2 ||
            (item->closest.distance2 <= best.closest.distance2 && item->triangle < best.triangle)) {
            best.triangle = item->triangle;
            best.closest = item->closest;
        }
    }
    if (best.triangle ==
        NO_TRIANGLE) { // far away, or deep inside: the surface is within what both have moved
        double motion = vlength(vsub(visitor->point, vec3_of(stage->pair->model->position[visitor->slot]))) +
                        (double)stage->proximity->motion;
        double radius = (double)stage->proximity->clearance[visitor->slot] + motion;
        return percale_surface_nearest(stage->surface, visitor->point, radius * (1.0 + 1e-6),
                                       stage->proximity->nearest[visitor->slot]);
    }
    best.foot = percale_surface_point(stage->surface, best.triangle, best.closest.weights);
    return best;
}

/// The point is in the region of an edge or a vertex when each triangle around it says so.
static bool add_features_in_front(const PercaleContactStage *stage, const Visitor *visitor,
                                  const PercaleFeatureList *list, const PercaleNearest *nearest,
                                  PercaleMemory *memory, PercaleStencilList *output)
{
    const PercaleSurface *surface = stage->surface;
    for (size_t first = 0, end; first < list->count; first = end) {
        const PercaleFeature *feature = &list->items[first];
        uint64_t key = percale_surface_feature_key(surface, feature->triangle, feature->closest.region);
        bool is_nearest = false;
        for (end = first;
             end < list->count && percale_surface_feature_key(surface, list->items[end].triangle,
                                                              list->items[end].closest.region) == key;
             end++) {
            is_nearest = is_nearest || list->items[end].triangle == nearest->triangle;
        }
        uint32_t around = percale_surface_face_count(surface, feature->triangle, feature->closest.region);
        if (!is_nearest && end - first != around) {
            continue;
        }
        PercaleNearest here = {feature->triangle, feature->closest,
                               percale_surface_point(surface, feature->triangle, feature->closest.weights)};
        if (percale_surface_side(surface, visitor->point, &here) > 0 &&
            !append(output, memory, make_stencil(stage, visitor, feature, 1))) {
            return false;
        }
    }
    return true;
}

/// Keeps what was seen from the predicted position; from just before a crossing it would say nothing of the
/// end.
static void remember(const PercaleContactStage *stage, uint32_t index, const PercaleNearest *nearest,
                     int side)
{
    if (!has_crossed(stage, index)) {
        uint32_t slot = stage->proximity->active[index];
        float distance = (float)sqrt(nearest->closest.distance2);
        stage->proximity->sightings[index] = (PercaleSighting){
            stage->pair->model->predicted[slot], side > 0 ? distance : -distance, nearest->triangle};
    }
}

static bool add_contacts(const PercaleContactStage *stage, uint32_t index, PercaleFeatureList *features,
                         PercaleMemory *memory, PercaleStencilList *output, uint64_t *candidates)
{
    Visitor visitor = visit(stage, index);
    bool closed = stage->pair->obstacle->closed;
    if (!closed && !visitor.in_front) {
        return true;
    }
    if (!percale_surface_gather(stage->surface, visitor.point, (double)visitor.reach, memory, features)) {
        return false;
    }
    *candidates += features->count;
    sort_by_feature(stage->surface, features);
    PercaleNearest nearest = nearest_of(stage, &visitor, features);
    if (nearest.triangle == NO_TRIANGLE) {
        return true;
    }
    int side = percale_surface_side(stage->surface, visitor.point, &nearest);
    remember(stage, index, &nearest, side);
    if (side > 0) {
        return add_features_in_front(stage, &visitor, features, &nearest, memory, output);
    }
    if (!closed &&
        (percale_surface_on_rim(stage->surface, nearest.triangle, nearest.closest.region) ||
         (!has_crossed(stage, index) && !has_slipped_through(stage->pair, stage->proximity, visitor.slot,
                                                             sqrt(nearest.closest.distance2))))) {
        return true; // it went around the rim
    }
    PercaleFeature feature = {nearest.triangle, nearest.closest};
    return append(output, memory, make_stencil(stage, &visitor, &feature, -1));
}

// ---- all vertices ----

/// Appends the threads' lists in thread order, which is vertex order.
static bool merge(PercaleContactScratch *scratch, int thread_count, PercaleMemory *memory,
                  PercaleStencilList *list)
{
    size_t total = list->count;
    for (int t = 0; t < thread_count; t++) {
        total += scratch->threads[t].stencils.count;
    }
    if (!percale_memory_reserve(memory, &list->items, &list->capacity, total, sizeof(list->items[0]))) {
        return false;
    }
    for (int t = 0; t < thread_count; t++) {
        if (scratch->threads[t].stencils.count > 0) {
            memcpy(list->items + list->count, scratch->threads[t].stencils.items,
                   scratch->threads[t].stencils.count * sizeof(list->items[0]));
        }
        list->count += scratch->threads[t].stencils.count;
    }
    return true;
}

enum { SHARES_PER_THREAD = 8 }; // contact is dense here and sparse there

/// The share of one list: vertices are divided by the number of lists, not by the team, which the host may
/// make smaller.
typedef struct Share {
    _Alignas(64) PercaleContactThread *thread;
    PercaleMemory memory;
    uint64_t first, end; // indices of active vertices
    uint64_t candidates;
    bool complete;
} Share;

/// What the chunks of a search share.
typedef struct Search {
    const PercaleContactStage *stage;
    Share *shares;
} Search;

static void find_share(const PercaleContactStage *stage, Share *share)
{
    share->thread->stencils.count = 0;
    for (uint64_t i = share->first; share->complete && i < share->end; i++) {
        if (!stage->crossings_only || has_crossed(stage, (uint32_t)i)) {
            share->complete = add_contacts(stage, (uint32_t)i, &share->thread->features, &share->memory,
                                           &share->thread->stencils, &share->candidates);
        }
    }
}

static void find_shares(void *context, uint32_t first, uint32_t end)
{
    const Search *search = context;
    for (uint32_t i = first; i < end; i++) {
        find_share(search->stage, &search->shares[i]);
    }
}

bool percale_contacts_find(const PercaleContactStage *stage, PercaleContactScratch *scratch,
                           PercaleMemory *memory, PercaleStencilList *list, uint64_t *candidate_count)
{
    uint64_t active_count = stage->proximity->active_count;
    uint64_t work = active_count * 16; // a vertex is some 16 small items
    int thread_count = threads_for(work, percale_team_size(stage->team));
    int share_count = thread_count > 1 ? SHARES_PER_THREAD * thread_count : 1;
    share_count = share_count < PERCALE_MAX_THREADS ? share_count : PERCALE_MAX_THREADS;
    Share shares[PERCALE_MAX_THREADS];
    for (int t = 0; t < share_count; t++) {
        shares[t] = (Share){&scratch->threads[t],
                            {memory->allocator, 0},
                            active_count * (uint64_t)t / (uint64_t)share_count,
                            active_count * ((uint64_t)t + 1) / (uint64_t)share_count,
                            0,
                            true};
    }
    Search search = {stage, shares};
    percale_team_for(stage->team, (uint32_t)share_count, 1, find_shares, &search);
    bool complete = true;
    for (int t = 0; t < share_count; t++) {
        memory->bytes += shares[t].memory.bytes;
        *candidate_count += shares[t].candidates;
        complete = complete && shares[t].complete;
    }
    return complete && merge(scratch, share_count, memory, list);
}

void percale_contacts_free(PercaleContactScratch *scratch, PercaleMemory *memory)
{
    for (int t = 0; t < PERCALE_MAX_THREADS; t++) {
        percale_memory_free(memory, scratch->threads[t].features.items);
        percale_memory_free(memory, scratch->threads[t].stencils.items);
        scratch->threads[t].features = (PercaleFeatureList){0};
        scratch->threads[t].stencils = (PercaleStencilList){0};
    }
}
