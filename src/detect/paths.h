// paths.h: vertex CCD: does the path of a vertex pass through an obstacle within the substep?
//
//   in   committed and predicted positions, the obstacle's motion, the active vertices
//   out  for each active vertex the first crossing from the front, at the end pose
//
// With ccd=ray a path is taken in the frame of the obstacle: the start point moves along, rigidly or with the
// nearest triangle. Embree flags paths; the crossing itself is decided by our own search in double. With
// ccd=exact the way is tested against the obstacle as it moves (swept.h).

#ifndef PERCALE_PATHS_H
#define PERCALE_PATHS_H

#include "base/arena.h"
#include "detect/proximity.h"
#include "detect/rays.h"

/// How an obstacle moves within the substep.
typedef struct PercaleFrame {
    PercaleMotion motion;   // in this substep
    PercalePose start, end; // rigid poses of the substep
    bool is_in_own_space;   // its rays are cast in the space that it was added in: once rigid, also at rest
} PercaleFrame;

/// x -> R x + t and back, in double.
Vec3 percale_pose_apply(const PercalePose *pose, Vec3 point);
Vec3 percale_pose_invert(const PercalePose *pose, Vec3 point);

/// Where the slot's start point would be, had it moved along with the obstacle to the end pose.
Vec3 percale_path_start(const PercalePair *pair, const PercaleFrame *frame, uint32_t slot, uint32_t nearest);

typedef struct PercalePathStage {
    const PercalePair *pair;
    const PercaleProximity *proximity;
    const PercaleSurface *surface; // end pose
    const PercaleFrame *frame;
    const PercaleRays *rays; // NULL: ccd=exact
    uint32_t obstacle_index;
    PercaleTeam *team;
} PercalePathStage;

/// crossings: [active_count]. False without memory; adds the number of rays to *ray_count.
bool percale_paths_cast(const PercalePathStage *stage, PercaleArena *arena, PercaleCrossing *crossings,
                        uint64_t *ray_count);

#endif
