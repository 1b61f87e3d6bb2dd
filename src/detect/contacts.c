#include "detect/contacts.h"

// Below this share of the thickness a closest-point vector has no direction left, and the (pseudo)normal
// stands in.
static const double NO_DIRECTION = 1e-3;

// Thicknesses that vertex and obstacle may move before the triangles near it are listed anew.
static const double NEARBY_ROOM = 4.0;

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
    uint32_t only; // triangle that alone is near, NO_TRIANGLE: that isn't known
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
    Visitor visitor = {slot,
                       vec3_of(model->predicted[slot]),
                       risen < thickness ? risen : thickness,
                       pair_reach(stage->pair, slot, motion),
                       stage->proximity->side[slot] > 0,
                       NO_TRIANGLE};
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
        if (visitor->only != NO_TRIANGLE) {
            return percale_surface_nearest_of(stage->surface, visitor->point, radius * (1.0 + 1e-6),
                                              &visitor->only, 1);
        }
        return percale_surface_nearest(stage->surface, visitor->point, radius * (1.0 + 1e-6),
                                       stage->proximity->nearest[visitor->slot]);
    }
    best.foot = percale_surface_point(stage->surface, best.triangle, best.closest.weights);
    return best;
}

/// The point is in the region of an edge or a vertex when each triangle around it says so. It is in front of
/// the nearest.
static void add_features_in_front(const PercaleContactStage *stage, const Visitor *visitor,
                                  const PercaleNearest *nearest, PercaleCollector *collector)
{
    const PercaleSurface *surface = stage->surface;
    const PercaleFeatureList *list = &collector->features;
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
        bool is_same = feature->triangle == nearest->triangle; // whose side is known
        if (is_same || percale_surface_side(surface, visitor->point, &here) > 0) {
            PercaleStencil stencil = make_stencil(stage, visitor, feature, 1);
            percale_collect_stencil(collector, &stencil);
        }
    }
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

/// All features within the visitor's reach. False without memory.
static bool gather(const PercaleContactStage *stage, uint32_t index, Visitor *visitor,
                   PercaleCollector *collector)
{
    if (has_crossed(stage, index) || stage->pair->is_found_anew) { // the former: from where it isn't
        return percale_surface_gather(stage->surface, visitor->point, (double)visitor->reach,
                                      &collector->memory, &collector->features);
    }
    visitor->only = percale_convex_face(&stage->proximity->convex, stage->surface, visitor->point,
                                        (double)visitor->reach, stage->proximity->nearest[visitor->slot]);
    if (visitor->only != NO_TRIANGLE) {
        return percale_surface_gather_of(stage->surface, visitor->point, (double)visitor->reach,
                                         &visitor->only, 1, &collector->memory, &collector->features);
    }
    PercaleNearbyLists *nearby = &stage->proximity->nearby;
    PercaleNearbyQuery query = {stage->surface, stage->proximity->traveled, visitor->point,
                                (double)visitor->reach};
    double room = NEARBY_ROOM * (double)pair_thickness(stage->pair, visitor->slot);
    return percale_nearby_gather(&nearby->items[nearby->number[visitor->slot]], &query, room,
                                 &collector->memory, &collector->features);
}

static void add_contacts(const PercaleContactStage *stage, uint32_t index, PercaleCollector *collector)
{
    Visitor visitor = visit(stage, index);
    bool closed = stage->pair->obstacle->closed;
    if (!closed && !visitor.in_front) {
        return;
    }
    PercaleFeatureList *features = &collector->features;
    if (!gather(stage, index, &visitor, collector)) {
        collector->complete = false;
        return;
    }
    collector->candidates += features->count;
    percale_surface_sort(stage->surface, features);
    PercaleNearest nearest = nearest_of(stage, &visitor, features);
    if (nearest.triangle == NO_TRIANGLE) {
        return;
    }
    int side = percale_surface_side(stage->surface, visitor.point, &nearest);
    remember(stage, index, &nearest, side);
    if (side > 0) {
        add_features_in_front(stage, &visitor, &nearest, collector);
        return;
    }
    if (!closed &&
        (percale_surface_on_rim(stage->surface, nearest.triangle, nearest.closest.region) ||
         (!has_crossed(stage, index) && !has_slipped_through(stage->pair, stage->proximity, visitor.slot,
                                                             sqrt(nearest.closest.distance2))))) {
        return; // it went around the rim
    }
    PercaleFeature feature = {nearest.triangle, nearest.closest};
    PercaleStencil stencil = make_stencil(stage, &visitor, &feature, -1);
    percale_collect_stencil(collector, &stencil);
}

// ---- all vertices ----

static void find_range(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    enum { AHEAD = 8 };
    const PercaleContactStage *stage = context;
    const PercaleProximity *proximity = stage->proximity;
    for (uint64_t i = first; collector->complete && i < end; i++) {
        if (i + AHEAD < end) {
            percale_convex_prefetch(&proximity->convex, stage->surface->mesh,
                                    proximity->nearest[proximity->active[i + AHEAD]]);
        }
        if (!stage->crossings_only || has_crossed(stage, (uint32_t)i)) {
            collector->source = stage->source | stage->proximity->active[i];
            add_contacts(stage, (uint32_t)i, collector);
        }
    }
}

bool percale_contacts_find(const PercaleContactStage *stage, PercaleCollectors *collectors,
                           PercaleMemory *memory, PercaleStencilList *list, uint64_t *candidate_count)
{
    PercaleProximity *proximity = stage->proximity;
    bool complete = stage->crossings_only || percale_nearby_reserve(&proximity->nearby, proximity->active,
                                                                    proximity->active_count, memory);
    complete = complete && percale_collect(stage->team, proximity->active_count, find_range, stage,
                                           collectors, memory, &(PercaleCollected){.stencils = list});
    *candidate_count += collectors->candidates;
    return complete;
}
