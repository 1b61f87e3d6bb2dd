#include "scene/output_file.h"

#include "scene/scene_error.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum {
    NAME_ATTEMPTS = 1000, // temporary names tried; one is taken only by a killed run's leftover
    TEMPORARY_SUFFIX = 48 // bytes for ".<process>.<attempt>.part"
};

static void release(PercaleOutputFile *file)
{
    free(file->path);
    free(file->temporary);
    *file = (PercaleOutputFile){0};
}

static bool create_temporary(PercaleOutputFile *file, PercaleSceneError *error)
{
    const size_t size = strlen(file->path) + TEMPORARY_SUFFIX;
    file->temporary = malloc(size);
    if (file->temporary == NULL) {
        return percale_scene_out_of_memory(error);
    }
    int descriptor = -1;
    errno = EEXIST;
    for (int attempt = 0; attempt < NAME_ATTEMPTS && descriptor < 0 && errno == EEXIST; ++attempt) {
        (void)snprintf(file->temporary, size, "%s.%ld.%d.part", file->path, (long)getpid(), attempt);
        descriptor = open(file->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    }
    if (descriptor < 0) {
        return percale_scene_fail_system(error, "cannot write", file->path, errno);
    }
    file->stream = fdopen(descriptor, "wb");
    if (file->stream == NULL) {
        const int reason = errno;
        (void)close(descriptor);
        (void)unlink(file->temporary);
        return percale_scene_fail_system(error, "cannot write", file->path, reason);
    }
    return true;
}

static bool open_in_place(PercaleOutputFile *file, PercaleSceneError *error)
{
    file->stream = fopen(file->path, "wbe");
    return file->stream != NULL || percale_scene_fail_system(error, "cannot write", file->path, errno);
}

bool percale_output_open(PercaleOutputFile *file, const char *path, PercaleSceneError *error)
{
    *file = (PercaleOutputFile){0};
    file->path = strdup(path);
    if (file->path == NULL) {
        return percale_scene_out_of_memory(error);
    }
    struct stat status;
    const bool in_place = lstat(path, &status) == 0 && !S_ISREG(status.st_mode);
    const bool opened = in_place ? open_in_place(file, error) : create_temporary(file, error);
    if (!opened) {
        release(file);
    }
    return opened;
}

bool percale_output_commit(PercaleOutputFile *file, PercaleSceneError *error)
{
    errno = 0;
    const bool complete = fflush(file->stream) == 0 && ferror(file->stream) == 0;
    int reason = errno;
    bool done = fclose(file->stream) == 0 && complete;
    if (done && file->temporary != NULL) {
        done = rename(file->temporary, file->path) == 0;
    }
    if (!done) {
        reason = reason != 0 ? reason : errno;
        percale_scene_fail_system(error, "cannot write", file->path, reason != 0 ? reason : EIO);
        if (file->temporary != NULL) {
            (void)unlink(file->temporary);
        }
    }
    release(file);
    return done;
}

void percale_output_discard(PercaleOutputFile *file)
{
    if (file->stream != NULL) {
        (void)fclose(file->stream);
    }
    if (file->temporary != NULL) {
        (void)unlink(file->temporary);
    }
    release(file);
}
