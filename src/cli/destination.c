#include "cli/destination.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { REASON_SIZE = 128 }; // bytes; the C library's longest reason is about 50

static bool fail(PercaleSceneError *error, const char *option, const char *path, int reason)
{
    char text[REASON_SIZE] = "";
    (void)strerror_r(reason, text, sizeof text);
    (void)snprintf(error->text, sizeof error->text, "%s: %s: %s", option, path, text);
    return false;
}

static bool is_folder(const char *path)
{
    struct stat status;
    return stat(path, &status) == 0 && S_ISDIR(status.st_mode);
}

/// Cuts the last name off: "a/b" becomes "a", "/a" becomes "/", "a" becomes ".".
static void cut_name(char *path)
{
    size_t length = strlen(path);
    while (length > 1 && path[length - 1] == '/')
        --length;
    while (length > 0 && path[length - 1] != '/')
        --length;
    while (length > 1 && path[length - 1] == '/')
        --length;
    path[length] = '\0';
    if (length == 0) {
        path[0] = '.'; // every path given here has at least one character
        path[1] = '\0';
    }
}

/// Can something be made below the nearest folder that exists? `levels`: how many names may be missing.
static bool check_parent(const char *option, const char *path, int levels, PercaleSceneError *error)
{
    char *parent = strdup(path);
    if (!parent)
        return fail(error, option, path, ENOMEM);
    int reason = ENOENT;
    for (; levels > 0 && reason == ENOENT; --levels) {
        cut_name(parent);
        reason = access(parent, W_OK | X_OK) == 0 ? 0 : errno;
    }
    if (reason == 0 && !is_folder(parent))
        reason = ENOTDIR;
    free(parent);
    return reason == 0 || fail(error, option, path, reason);
}

bool percale_destination_file(const char *option, const char *path, PercaleSceneError *error)
{
    if (!path || strcmp(path, "-") == 0)
        return true;
    if (*path == '\0')
        return fail(error, option, path, ENOENT);
    struct stat status;
    if (stat(path, &status) != 0) {
        if (errno != ENOENT)
            return fail(error, option, path, errno);
        size_t length = strlen(path);
        return path[length - 1] == '/' ? fail(error, option, path, EISDIR)
                                       : check_parent(option, path, 1, error);
    }
    if (S_ISDIR(status.st_mode))
        return fail(error, option, path, EISDIR);
    if (access(path, W_OK) != 0)
        return fail(error, option, path, errno);
    return !S_ISREG(status.st_mode) || check_parent(option, path, 1, error);
}

bool percale_destination_folder(const char *option, const char *path, PercaleSceneError *error)
{
    if (!path)
        return true;
    if (*path == '\0')
        return fail(error, option, path, ENOENT);
    struct stat status;
    if (stat(path, &status) != 0)
        return errno == ENOENT ? check_parent(option, path, (int)strlen(path), error)
                               : fail(error, option, path, errno);
    if (!S_ISDIR(status.st_mode))
        return fail(error, option, path, ENOTDIR);
    return access(path, W_OK | X_OK) == 0 || fail(error, option, path, errno);
}

bool percale_destination_make(const char *path, PercaleSceneError *error)
{
    char *part = strdup(path);
    if (!part)
        return fail(error, "--out", path, ENOMEM);
    int reason = 0;
    for (size_t length = 1; length <= strlen(path) && reason == 0; ++length) {
        if (path[length] != '/' && path[length] != '\0')
            continue;
        part[length] = '\0';
        if (mkdir(part, 0777) != 0 && !is_folder(part))
            reason = errno;
        part[length] = path[length];
    }
    free(part);
    return reason == 0 || fail(error, "--out", path, reason);
}

char *percale_destination_join(const char *folder, const char *name)
{
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (path)
        (void)snprintf(path, size, "%s/%s", folder, name);
    return path;
}
