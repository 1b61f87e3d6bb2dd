#include "finish/guard.h"

#include "base/wide.h"

#include <stdatomic.h>
#include <string.h>

enum { ATTEMPTS = 3 }; // a second or third one is needed where the surface is folded

/// State of one vertex at the end of the substep.
typedef struct Judgement {
    PercaleNearest nearest;
    int side;
} Judgement;

static Judgement judge(const PercaleGuardStage *stage, Vec3 point, double radius, uint32_t seed)
{
    Judgement judgement = {percale_surface_nearest(stage->surface, point, radius, seed), 1};
    if (judgement.nearest.triangle != NO_TRIANGLE) {
        judgement.side = percale_surface_side(stage->surface, point, &judgement.nearest);
    }
    return judgement;
}

/// Below the surface and not by way of an open surface's rim.
static bool is_below(const PercaleGuardStage *stage, const Judgement *judgement)
{
    return judgement->side < 0 && !percale_surface_on_rim(stage->surface, judgement->nearest.triangle,
                                                          judgement->nearest.closest.region);
}

/// The way out: along the normal of the nearest feature.
static Vec3 outward_at(const PercaleGuardStage *stage, Vec3 point, const PercaleNearest *nearest)
{
    return percale_contact_normal(stage->surface, point, nearest->triangle, &nearest->closest, -1);
}

void percale_guard_stop_approach(const PercalePair *pair, uint32_t slot, const PercaleCrossing *at,
                                 Vec3 normal, float dt, f32x4 *velocity)
{
    const PercaleModel *model = pair->model;
    Vec3 carried = {0.0, 0.0, 0.0}; // how the surface moved there
    const uint32_t *corners = pair->obstacle->triangles + 3 * (size_t)at->triangle;
    for (int k = 0; k < 3; k++) {
        Vec3 moved = vsub(vec3_of(model->predicted[corners[k]]), vec3_of(model->position[corners[k]]));
        carried = vadd(carried, vscale(at->weights[k], moved));
    }
    double approach = vdot(normal, vsub(vec3_of(velocity[slot]), vscale(1.0 / (double)dt, carried)));
    if (approach < 0.0) {
        velocity[slot] -= f32x4_of(vscale(approach, normal), 0.0f);
    }
}

/// Moves the vertex without giving it velocity; what it still had against the surface is taken away.
static void put_back(const PercaleGuardStage *stage, uint32_t slot, Vec3 position, const PercaleCrossing *at,
                     Vec3 normal)
{
    f32x4 before = stage->predicted[slot];
    f32x4 after = f32x4_of(position, before[3]);
    percale_guard_stop_approach(stage->pair, slot, at, normal, stage->dt, stage->velocity);
    stage->predicted[slot] = after;
    for (uint32_t o = 0; o < stage->judged_count;
         o++) { // it may be deep inside those: nothing is known any more
        stage->judged[o].clearance[slot] -= length3(after - before);
        stage->judged[o].side[slot] = 0;
        stage->judged[o].nearest[slot] = NO_TRIANGLE;
    }
}

/// A path through the surface ends at its point of impact, which the obstacle has carried to the end pose.
static bool stop_at_crossing(const PercaleGuardStage *stage, uint32_t slot, double gap, uint32_t nearest)
{
    Vec3 from = percale_path_start(stage->pair, stage->frame, slot, nearest);
    PercaleCrossing crossing =
        percale_surface_first_crossing(stage->surface, from, vec3_of(stage->predicted[slot]));
    if (crossing.triangle == NO_TRIANGLE) {
        return false;
    }
    Vec3 normal = percale_surface_face_normal(stage->surface, crossing.triangle);
    Vec3 impact = percale_surface_point(stage->surface, crossing.triangle, crossing.weights);
    put_back(stage, slot, vadd(impact, vscale(gap, normal)), &crossing, normal);
    return true;
}

/// Out through the nearest feature. From inside at the start it goes no faster than EXIT_SPEED, of which the
/// contact has used up its part.
static void lift_out(const PercaleGuardStage *stage, uint32_t slot, double gap, bool was_in_front,
                     const PercaleNearest *nearest)
{
    Vec3 point = vec3_of(stage->predicted[slot]);
    Vec3 outward = outward_at(stage, point, nearest);
    Vec3 position = vadd(nearest->foot, vscale(gap, outward));
    double rise = vlength(vsub(position, point));
    double risen = (double)stage->proximity->clearance[slot] - sqrt(nearest->closest.distance2);
    double most = fmax((double)(EXIT_SPEED * stage->dt) - risen, 0.0);
    if (!was_in_front && rise > most) {
        position = vadd(point, vscale(most / rise, vsub(position, point)));
    }
    const double *weights = nearest->closest.weights;
    PercaleCrossing at = {nearest->triangle, 1.0, {weights[0], weights[1], weights[2]}};
    put_back(stage, slot, position, &at, outward);
}

static void remember(const PercaleGuardStage *stage, uint32_t slot, const Judgement *judgement)
{
    PercaleProximity *proximity = stage->proximity;
    bool found = judgement->nearest.triangle != NO_TRIANGLE;
    proximity->clearance[slot] = (float)sqrt(judgement->nearest.closest.distance2);
    proximity->side[slot] = (int8_t)(found ? judgement->side : 0);
    proximity->nearest[slot] = found ? judgement->nearest.triangle : proximity->nearest[slot];
}

/// How far the vertex and the obstacle together have moved in the substep, m.
static float motion_of(const PercaleGuardStage *stage, uint32_t slot)
{
    return length3(stage->predicted[slot] - stage->pair->model->position[slot]) + stage->proximity->motion;
}

/// A vertex that was outside and has not moved as far as the surface is outside still: the usual case, which
/// costs no search. The bound comes from what the search for contacts saw, or from the substep's start.
static bool pass_by_bound(const PercaleGuardStage *stage, uint32_t slot, const PercaleSighting *sighting)
{
    PercaleProximity *proximity = stage->proximity;
    float clearance = proximity->clearance[slot] - motion_of(stage, slot);
    bool seen = sighting->nearest != NO_TRIANGLE;
    if (seen) {
        float since = sighting->distance - length3(stage->predicted[slot] - sighting->point);
        clearance = since > clearance ? since : clearance;
    }
    if (proximity->side[slot] <= 0 || !(clearance > 0.0f)) {
        return false;
    }
    proximity->clearance[slot] = clearance;
    proximity->nearest[slot] = seen ? sighting->nearest : proximity->nearest[slot];
    proximity->side[slot] = seen ? 1 : OUTSIDE_BY_BOUND;
    return true;
}

/// Judges the vertex by exact search and puts it back where it must not be.
static PercaleGuardCounts guard_vertex(const PercaleGuardStage *stage, uint32_t slot)
{
    PercaleProximity *proximity = stage->proximity;
    const double gap = GAP * (double)pair_thickness(stage->pair, slot);
    const bool closed = stage->pair->obstacle->closed;
    const bool was_below = proximity->side[slot] < 0;
    const bool was_above = proximity->side[slot] > 0;
    double motion = (double)motion_of(stage, slot);
    double radius =
        ((double)proximity->clearance[slot] + motion) * (1.0 + 1e-6) + gap; // the surface is within it
    PercaleGuardCounts counts = {0, 0, 1};
    // an idle vertex is farther away than the obstacle moves: the obstacle passes first, without taking it
    // along
    uint32_t along_with = was_below || was_above ? proximity->nearest[slot] : NO_TRIANGLE;
    bool crossed = stage->corrects && stage->test_paths && motion >= (double)proximity->clearance[slot] &&
                   !was_below && stop_at_crossing(stage, slot, gap, along_with);
    bool in_front = crossed || was_above || (!was_below && closed); // of an idle vertex the side is not known
    Judgement judgement = judge(stage, vec3_of(stage->predicted[slot]), radius, proximity->nearest[slot]);
    bool is_held = closed || crossed ||
                   (in_front && has_slipped_through(stage->pair, proximity, slot,
                                                    sqrt(judgement.nearest.closest.distance2)));
    for (int i = 0; i < (stage->corrects ? ATTEMPTS : 0) && is_below(stage, &judgement) && is_held; i++) {
        lift_out(stage, slot, gap, in_front, &judgement.nearest);
        judgement = judge(stage, vec3_of(stage->predicted[slot]), 2.0 * radius, judgement.nearest.triangle);
        crossed = true;
        if (!in_front) {
            break; // one capped move per substep
        }
    }
    counts.truncated = crossed;
    counts.left_inside = is_below(stage, &judgement) && is_held;
    remember(stage, slot, &judgement);
    return counts;
}

/// Vertices that were not active have used up some of their clearance; their distance is a bound again, and
/// what was outside still is.
static void spend_clearance(const PercaleGuardStage *stage, uint32_t slot)
{
    PercaleProximity *proximity = stage->proximity;
    float motion = motion_of(stage, slot);
    if (motion > 0.0f) {
        // the last factor keeps a bound a bound: of a hundred metres float32 could not take small motions
        // away
        proximity->clearance[slot] = (proximity->clearance[slot] - motion) * (1.0f - 1e-6f);
        bool outside = proximity->side[slot] > 0 && proximity->clearance[slot] > 0.0f;
        proximity->side[slot] = outside ? OUTSIDE_BY_BOUND : 0;
    }
}

static bool can_collide(const PercaleGuardStage *stage, uint32_t slot)
{
    const PercaleModel *model = stage->pair->model;
    uint32_t mask = model->cloths[model->cloth_of[slot]].mask & stage->pair->obstacle->mask;
    return mask != 0 && stage->predicted[slot][3] > 0.0f;
}

/// An idle vertex that the solver has moved farther than its clearance is judged like an active one.
static bool is_spent(const PercaleGuardStage *stage, uint32_t slot)
{
    return can_collide(stage, slot) && stage->proximity->clearance[slot] <= motion_of(stage, slot);
}

static void add_counts(PercaleGuardCounts *sum, PercaleGuardCounts counts)
{
    sum->left_inside += counts.left_inside;
    sum->truncated += counts.truncated;
    sum->searches += counts.searches;
}

static PercaleGuardCounts guard_idle(const PercaleGuardStage *stage, uint32_t slot)
{
    if (is_spent(stage, slot)) {
        return guard_vertex(stage, slot);
    }
    spend_clearance(stage, slot);
    return (PercaleGuardCounts){0, 0, 0};
}

static PercaleGuardCounts guard_active(const PercaleGuardStage *stage, uint32_t index)
{
    uint32_t slot = stage->proximity->active[index];
    if (!(stage->predicted[slot][3] > 0.0f)) { // it has been pinched since (pinch.h)
        spend_clearance(stage, slot);
        return (PercaleGuardCounts){0, 0, 0};
    }
    if (pass_by_bound(stage, slot, &stage->proximity->sightings[index])) {
        return (PercaleGuardCounts){0, 0, 0};
    }
    return guard_vertex(stage, slot);
}

/// What the chunks of the guard share.
typedef struct Guard {
    const PercaleGuardStage *stage;
    atomic_uint_fast64_t left_inside, truncated, searches;
} Guard;

static void add_to_guard(Guard *guard, PercaleGuardCounts counts)
{
    atomic_fetch_add_explicit(&guard->left_inside, counts.left_inside, memory_order_relaxed);
    atomic_fetch_add_explicit(&guard->truncated, counts.truncated, memory_order_relaxed);
    atomic_fetch_add_explicit(&guard->searches, counts.searches, memory_order_relaxed);
}

/// Eight idle slots that have all moved, none as far as its clearance: the usual case. False when it isn't.
static bool spend_clearances(const PercaleGuardStage *stage, uint32_t slot)
{
    PercaleProximity *proximity = stage->proximity;
    if (load_bytes8(proximity->is_active + slot) != 0) {
        return false;
    }
    f32x8 motion =
        distances8(stage->predicted + slot, stage->pair->model->position + slot) + proximity->motion;
    f32x8 clearance = load8(proximity->clearance + slot);
    if (lane_bits(greater8(clearance, motion) & greater8(motion, all8(0.0f))) != 0xff) {
        return false;
    }
    store8(proximity->clearance + slot, (clearance - motion) * (1.0f - 1e-6f));
    uint64_t outside = signs_of(load_bytes8(proximity->side + slot)).positive * OUTSIDE_BY_BOUND;
    memcpy(proximity->side + slot, &outside, sizeof(outside));
    return true;
}

static void guard_idle_range(void *context, uint32_t first, uint32_t end)
{
    Guard *guard = context;
    PercaleGuardCounts counts = {0, 0, 0};
    uint32_t slot = first;
    while (slot < end) {
        if (slot % WIDE == 0 && slot + WIDE <= end && spend_clearances(guard->stage, slot)) {
            slot += WIDE;
            continue;
        }
        if (guard->stage->proximity->is_active[slot] == 0) {
            add_counts(&counts, guard_idle(guard->stage, slot));
        }
        slot++;
    }
    add_to_guard(guard, counts);
}

static void guard_active_range(void *context, uint32_t first, uint32_t end)
{
    Guard *guard = context;
    PercaleGuardCounts counts = {0, 0, 0};
    for (uint32_t i = first; i < end; i++) {
        add_counts(&counts, guard_active(guard->stage, i));
    }
    add_to_guard(guard, counts);
}

/// A vertex that has been moved since it was judged, as far as a closed surface or farther: it may be as deep
/// as its clearance is below 0.
static PercaleGuardCounts lift_vertex(const PercaleGuardStage *stage, uint32_t slot)
{
    const double gap = GAP * (double)pair_thickness(stage->pair, slot);
    double radius = gap - (double)stage->proximity->clearance[slot];
    Judgement judgement = judge(stage, vec3_of(stage->predicted[slot]), radius, NO_TRIANGLE);
    PercaleGuardCounts counts = {0, is_below(stage, &judgement), 1};
    for (int i = 0; i < ATTEMPTS && is_below(stage, &judgement); i++) {
        lift_out(stage, slot, gap, true, &judgement.nearest);
        judgement = judge(stage, vec3_of(stage->predicted[slot]), 2.0 * radius, judgement.nearest.triangle);
    }
    remember(stage, slot, &judgement);
    return counts;
}

static void lift_range(void *context, uint32_t first, uint32_t end)
{
    Guard *guard = context;
    const PercaleGuardStage *stage = guard->stage;
    PercaleGuardCounts counts = {0, 0, 0};
    for (uint32_t slot = first; slot < end; slot++) {
        if (!(stage->proximity->clearance[slot] > 0.0f) && can_collide(stage, slot)) {
            add_counts(&counts, lift_vertex(stage, slot));
        }
    }
    add_to_guard(guard, counts);
}

PercaleGuardCounts percale_guard_lift(const PercaleGuardStage *stage)
{
    enum { GRAIN_SLOTS = 1024 };
    Guard guard = {stage, 0, 0, 0};
    if (stage->pair->obstacle->closed) {
        percale_team_for(stage->team, stage->pair->model->slot_count, GRAIN_SLOTS, lift_range, &guard);
    }
    return (PercaleGuardCounts){guard.left_inside, guard.truncated, guard.searches};
}

PercaleGuardCounts percale_guard_run(const PercaleGuardStage *stage)
{
    enum { GRAIN_IDLE = 1024, GRAIN_ACTIVE = 128 };
    Guard guard = {stage, 0, 0, 0};
    PercalePhase phases[] = {
        {guard_idle_range, &guard, 0, stage->pair->model->slot_count, GRAIN_IDLE},
        {guard_active_range, &guard, 0, stage->proximity->active_count, GRAIN_ACTIVE},
    };
    percale_team_run(stage->team, phases, 2);
    return (PercaleGuardCounts){guard.left_inside, guard.truncated, guard.searches};
}
