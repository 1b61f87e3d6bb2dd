#include "scene/text_file.h"

#include "scene/scene_error.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { FIRST_READ = 65536 }; // bytes

static bool reserve(PercaleText *text, size_t *capacity)
{
    if (text->size + 1 < *capacity) {
        return true;
    }
    const size_t larger = *capacity == 0 ? (size_t)FIRST_READ : 2 * *capacity;
    char *bytes = larger > *capacity ? realloc(text->bytes, larger) : NULL;
    if (bytes == NULL) {
        return false;
    }
    text->bytes = bytes;
    *capacity = larger;
    return true;
}

static bool read_stream(FILE *stream, const char *path, PercaleText *text, PercaleSceneError *error)
{
    size_t capacity = 0;
    for (;;) {
        if (!reserve(text, &capacity)) {
            return percale_scene_out_of_memory(error);
        }
        errno = 0;
        const size_t count = fread(text->bytes + text->size, 1, capacity - text->size - 1, stream);
        text->size += count;
        if (count == 0) {
            break;
        }
    }
    if (ferror(stream) != 0) {
        return percale_scene_fail_system(error, "cannot read", path, errno != 0 ? errno : EIO);
    }
    text->bytes[text->size] = '\0';
    return true;
}

bool percale_text_read(const char *path, PercaleText *text, PercaleSceneError *error)
{
    *text = (PercaleText){0};
    FILE *stream = fopen(path, "rbe");
    if (stream == NULL) {
        return percale_scene_fail_system(error, "cannot read", path, errno);
    }
    const bool done = read_stream(stream, path, text, error);
    (void)fclose(stream);
    if (!done) {
        percale_text_free(text);
    }
    return done;
}

void percale_text_free(PercaleText *text)
{
    free(text->bytes);
    *text = (PercaleText){0};
}

char *percale_base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *name = strdup(slash != NULL ? slash + 1 : path);
    char *dot = name != NULL ? strrchr(name, '.') : NULL;
    if (dot != NULL && dot != name) {
        *dot = '\0';
    }
    return name;
}
