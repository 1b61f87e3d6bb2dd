#include "scene/scene_walk.h"

#include "scene/mannequin.h"
#include "scene/scene_error.h"

#include <stdlib.h>
#include <string.h>

static void pose(const void *figure, double seconds, float *positions)
{
    percale_mannequin_pose(figure, seconds, positions);
}

static void release(void *figure)
{
    percale_mannequin_free(figure);
}

bool percale_scene_add_walker(PercaleScene *scene, double jump, PercaleSceneError *error)
{
    PercaleSceneItem *body = percale_scene_add_obstacle(scene, error);
    if (body == NULL) {
        return false;
    }
    PercaleMotion *motion = &body->motion;
    const double speed = percale_settings_extra(&scene->settings, "speed");
    motion->figure = percale_mannequin_make(jump, speed, &body->mesh, error);
    if (motion->figure == NULL) {
        return false;
    }
    motion->release = release;
    motion->pose = pose;
    free(body->mesh.name);
    body->mesh.name = strdup("body");
    return body->mesh.name != NULL || percale_scene_out_of_memory(error);
}

PercaleSceneItem *percale_scene_add_garment(PercaleScene *scene, const PercaleGarmentCut *cut, uint64_t size,
                                            double outwards, PercaleSceneError *error)
{
    const double thickness = percale_settings_number(&scene->settings, PERCALE_SET_THICKNESS);
    PercaleSceneItem *garment = percale_scene_add_cloth(scene, error);
    const bool made =
        garment != NULL && percale_garment_make(cut, size, (float)thickness, outwards, &garment->mesh,
                                                &garment->seams, &garment->seam_count, error);
    return made ? garment : NULL;
}
