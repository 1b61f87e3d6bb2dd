#include "detect/paths.h"

#include "detect/swept.h"

/// v + 2 w (u x v) + 2 u x (u x v) for the quaternion (u, w); sign = -1 turns back.
static Vec3 rotate(const double rotation[4], double sign, Vec3 v)
{
    Vec3 u = vscale(sign, vec3(rotation[0], rotation[1], rotation[2]));
    Vec3 t = vscale(2.0, vcross(u, v));
    return vadd(vadd(v, vscale(rotation[3], t)), vcross(u, t));
}

Vec3 percale_pose_apply(const PercalePose *pose, Vec3 point)
{
    return vadd(rotate(pose->rotation, 1.0, point),
                vec3(pose->translation[0], pose->translation[1], pose->translation[2]));
}

Vec3 percale_pose_invert(const PercalePose *pose, Vec3 point)
{
    return rotate(pose->rotation, -1.0,
                  vsub(point, vec3(pose->translation[0], pose->translation[1], pose->translation[2])));
}

Vec3 percale_path_start(const PercalePair *pair, const PercaleFrame *frame, uint32_t slot, uint32_t nearest)
{
    const PercaleModel *model = pair->model;
    Vec3 start = vec3_of(model->position[slot]);
    if (frame->motion == MOTION_RIGID) {
        return percale_pose_apply(&frame->end, percale_pose_invert(&frame->start, start));
    }
    if (frame->motion == MOTION_STATIC || nearest == NO_TRIANGLE) {
        return start;
    }
    const uint32_t *corners = pair->obstacle->triangles + 3 * (size_t)nearest;
    PercaleClosest closest = percale_closest_on_triangle(start, vec3_of(model->position[corners[0]]),
                                                         vec3_of(model->position[corners[1]]),
                                                         vec3_of(model->position[corners[2]]));
    for (int k = 0; k < 3; k++) {
        Vec3 moved = vsub(vec3_of(model->predicted[corners[k]]), vec3_of(model->position[corners[k]]));
        start = vadd(start, vscale(closest.weights[k], moved));
    }
    return start;
}

/// A path shorter than the distance it would have to cover can't reach the surface. Rigid obstacles keep
/// their distances in their own frame; a deforming one may have moved against the nearest triangle by twice
/// its motion.
static bool may_reach(const PercalePathStage *stage, uint32_t slot, Vec3 from, Vec3 to)
{
    double slack = stage->frame->motion == MOTION_DEFORMING ? 2.0 * (double)stage->proximity->motion : 0.0;
    return vlength(vsub(to, from)) + slack >= (double)stage->proximity->clearance[slot];
}

/// Collects the paths that may reach the surface; returns their number.
static uint32_t collect(const PercalePathStage *stage, f32x4 *from, f32x4 *to, uint32_t *index)
{
    const PercaleModel *model = stage->pair->model;
    uint32_t count = 0;
    for (uint32_t i = 0; i < stage->proximity->active_count; i++) {
        uint32_t slot = stage->proximity->active[i];
        Vec3 end = vec3_of(model->predicted[slot]);
        Vec3 start = percale_path_start(stage->pair, stage->frame, slot, stage->proximity->nearest[slot]);
        if (!may_reach(stage, slot, start, end)) {
            continue;
        }
        bool turned = stage->frame->is_in_own_space;
        from[count] = f32x4_of(turned ? percale_pose_invert(&stage->frame->end, start) : start, 0.0f);
        to[count] = f32x4_of(turned ? percale_pose_invert(&stage->frame->end, end) : end, 0.0f);
        index[count++] = i;
    }
    return count;
}

static PercaleCrossing find_crossing(const PercalePathStage *stage, uint32_t slot)
{
    Vec3 start = percale_path_start(stage->pair, stage->frame, slot, stage->proximity->nearest[slot]);
    return percale_surface_first_crossing(stage->surface, start,
                                          vec3_of(stage->pair->model->predicted[slot]));
}

/// What the chunks of the search share.
typedef struct Search {
    const PercalePathStage *stage;
    const uint8_t *flags;
    const uint32_t *index; // of the active vertex whose path it is
    PercaleCrossing *crossings;
} Search;

static void search_range(void *context, uint32_t first, uint32_t end)
{
    const Search *search = context;
    for (uint32_t i = first; i < end; i++) {
        if (search->flags[i] != 0) {
            uint32_t active = search->index[i];
            search->crossings[active] =
                find_crossing(search->stage, search->stage->proximity->active[active]);
        }
    }
}

/// Against the obstacle as it moves.
static void sweep_range(void *context, uint32_t first, uint32_t end)
{
    const Search *search = context;
    const PercalePathStage *stage = search->stage;
    for (uint32_t i = first; i < end; i++) {
        uint32_t slot = stage->proximity->active[i];
        search->crossings[i] = NO_CROSSING;
        if (may_meet(stage->pair, stage->proximity, slot)) {
            search->crossings[i] = percale_swept_crossing(stage->pair, stage->proximity, slot);
        }
    }
}

bool percale_paths_cast(const PercalePathStage *stage, PercaleArena *arena, PercaleCrossing *crossings,
                        uint64_t *ray_count)
{
    enum { GRAIN_PATHS = 512 };
    uint32_t active_count = stage->proximity->active_count;
    if (stage->rays == NULL) {
        Search search = {stage, NULL, NULL, crossings};
        percale_team_for(stage->team, active_count, GRAIN_PATHS, sweep_range, &search);
        return true;
    }
    f32x4 *from = percale_arena_new(arena, active_count, sizeof(f32x4));
    f32x4 *to = percale_arena_new(arena, active_count, sizeof(f32x4));
    uint32_t *index = percale_arena_new(arena, active_count, sizeof(uint32_t));
    uint8_t *flags = percale_arena_new(arena, active_count, 1);
    if (from == NULL || to == NULL || index == NULL || flags == NULL) {
        return false;
    }
    for (uint32_t i = 0; i < active_count; i++) {
        crossings[i] = NO_CROSSING;
    }
    uint32_t count = collect(stage, from, to, index);
    percale_rays_cast(stage->rays, stage->obstacle_index, from, to, count, flags, stage->team);
    *ray_count += count;
    Search search = {stage, flags, index, crossings};
    percale_team_for(stage->team, count, GRAIN_PATHS, search_range, &search);
    return true;
}
