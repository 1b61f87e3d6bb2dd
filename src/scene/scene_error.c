#include "scene/scene_error.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

bool percale_scene_fail(PercaleSceneError *error, const char *format, ...)
{
    va_list values;
    va_start(values, format);
    (void)vsnprintf(error->text, sizeof error->text, format, values);
    va_end(values);
    return false;
}

bool percale_scene_out_of_memory(PercaleSceneError *error)
{
    return percale_scene_fail(error, "out of memory");
}

bool percale_scene_fail_system(PercaleSceneError *error, const char *what, const char *path, int errno_value)
{
    char reason[128];
    if (strerror_r(errno_value, reason, sizeof reason) != 0) {
        (void)snprintf(reason, sizeof reason, "error %d", errno_value);
    }
    return percale_scene_fail(error, "%s %s: %s", what, path, reason);
}
