// scene_error.h: how the scene library says what went wrong: one line that names the culprit.
//
//   in   a format and its values
//   out  error->text; the functions return false, to be passed on

#ifndef PERCALE_SCENE_ERROR_H
#define PERCALE_SCENE_ERROR_H

#include "percale/scene.h"

bool percale_scene_fail(PercaleSceneError *error, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

bool percale_scene_out_of_memory(PercaleSceneError *error);

/// "what path: the system's reason for errno_value".
bool percale_scene_fail_system(PercaleSceneError *error, const char *what, const char *path, int errno_value);

#endif
