// scene_walk.h: what the scenes of garments on the walking mannequin share.

#ifndef PERCALE_SCENE_WALK_H
#define PERCALE_SCENE_WALK_H

#include "scene/garment.h"
#include "scene/scene_model.h"

/// The row of the scene's own settings that says how fast she walks.
#define PERCALE_WALK_SPEED_ROW                                                                            \
    {                                                                                                     \
        {"speed", PERCALE_SETTING_NUMBER, {1}, 0, 10, "", NULL, "of the walk; 2: twice as fast"}, NULL, 0 \
    }

/// The mannequin as the obstacle "body", walking as fast as the setting says. jump: as
/// percale_mannequin_make's.
bool percale_scene_add_walker(PercaleScene *scene, double jump, PercaleSceneError *error);

/// A new cloth, sewn from panels (percale_garment_make); NULL on failure. Earlier pointers into the scene are
/// no longer valid.
PercaleSceneItem *percale_scene_add_garment(PercaleScene *scene, const PercaleGarmentCut *cut, uint64_t size,
                                            double outwards, PercaleSceneError *error);

#endif
