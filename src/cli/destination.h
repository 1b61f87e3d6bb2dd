// destination.h: may results be written there? Asked before anything is computed; nothing is created.

#ifndef PERCALE_DESTINATION_H
#define PERCALE_DESTINATION_H

#include "percale/scene.h"

/// A file that exists and may be replaced, or a new one in a folder that exists; "-" and NULL are allowed.
/// The error begins with `option`.
bool percale_destination_file(const char *option, const char *path, PercaleSceneError *error);
/// A folder that exists, or one that percale_destination_make can make; NULL is allowed.
bool percale_destination_folder(const char *option, const char *path, PercaleSceneError *error);
/// Makes the folder and those above it.
bool percale_destination_make(const char *path, PercaleSceneError *error);

/// "folder/name" in new memory; NULL: out of memory.
char *percale_destination_join(const char *folder, const char *name);

#endif
