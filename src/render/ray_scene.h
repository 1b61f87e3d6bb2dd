// ray_scene.h: the picture's meshes as one Embree scene that can be asked what a ray meets.
//
//   in   the picture's meshes; a triangle with a vertex that is not finite or too far away is left out
//   out  hits with point, normals, heat and object
//
// Embree's device runs with one thread of its own, so it starts no second pool beside OpenMP.

#ifndef PERCALE_RAY_SCENE_H
#define PERCALE_RAY_SCENE_H

#include "render/picture.h"
#include "render/vec3.h"

typedef struct PercaleRayScene PercaleRayScene;

typedef struct PercaleRayHit {
    PercaleVec3 point;
    PercaleVec3 normal; ///< smooth, unit, towards the ray's start
    PercaleVec3 facet;  ///< the triangle's own, unit, towards the ray's start
    const PercalePictureMesh *mesh;
    float heat;       ///< interpolated; 0 where the mesh has none
    bool from_behind; ///< the ray met the side that the winding calls back
} PercaleRayHit;

typedef struct PercaleRayBounds {
    PercaleVec3 low, high; ///< m; over the vertices of all triangles that are drawn
} PercaleRayBounds;

/// NULL on failure; the meshes' arrays are read until percale_ray_scene_free.
PercaleRayScene *percale_ray_scene_create(const PercalePictureMesh *meshes, uint32_t mesh_count,
                                          PercaleSceneError *error);
void percale_ray_scene_free(PercaleRayScene *scene); ///< NULL is allowed
PercaleRayBounds percale_ray_scene_bounds(const PercaleRayScene *scene);

/// Calls visit(user, point) for every vertex of every drawn triangle.
void percale_ray_scene_visit(const PercaleRayScene *scene, void (*visit)(void *user, PercaleVec3 point),
                             void *user);

/// What the ray meets first, if anything. Safe from several threads.
bool percale_ray_scene_hit(const PercaleRayScene *scene, PercaleVec3 start, PercaleVec3 direction,
                           PercaleRayHit *hit);
/// Is anything in the way? Safe from several threads.
bool percale_ray_scene_occluded(const PercaleRayScene *scene, PercaleVec3 start, PercaleVec3 direction);

#endif
