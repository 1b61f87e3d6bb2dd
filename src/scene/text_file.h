// text_file.h: a whole file in memory.

#ifndef PERCALE_TEXT_FILE_H
#define PERCALE_TEXT_FILE_H

#include "percale/scene.h"

typedef struct PercaleText {
    char *bytes; ///< [size + 1], a zero byte behind the last
    size_t size;
} PercaleText;

bool percale_text_read(const char *path, PercaleText *text, PercaleSceneError *error);
void percale_text_free(PercaleText *text);

/// Base name of a path without folder and suffix, to be freed; NULL: no memory.
char *percale_base_name(const char *path);

#endif
