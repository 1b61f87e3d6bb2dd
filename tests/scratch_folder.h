// scratch_folder.h: a folder of a test's own, for files to read and to write; gone with everything in it when
// the test is over.

#ifndef PERCALE_SCRATCH_FOLDER_H
#define PERCALE_SCRATCH_FOLDER_H

#include <check.h>
#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { SCRATCH_PATH_SIZE = 320 };

static char scratch_folder[32];

typedef struct ScratchPath {
    char text[SCRATCH_PATH_SIZE];
} ScratchPath;

static inline ScratchPath scratch_path(const char *name)
{
    ScratchPath path;
    (void)snprintf(path.text, sizeof path.text, "%s/%s", scratch_folder, name);
    return path;
}

static inline int is_listed(const struct dirent *entry)
{
    return strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0;
}

/// How many files there are; `remove`: removes them.
static inline int scratch_count(bool remove_them)
{
    struct dirent **entries;
    const int count = scandir(scratch_folder, &entries, is_listed, NULL);
    ck_assert_int_ge(count, 0);
    for (int k = 0; k < count; ++k) {
        const ScratchPath path = scratch_path(entries[k]->d_name);
        if (remove_them) {
            (void)unlink(path.text);
        }
        free(entries[k]);
    }
    free(entries);
    return count;
}

static inline void make_scratch(void)
{
    memcpy(scratch_folder, "scratch_XXXXXX", sizeof "scratch_XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(scratch_folder));
}

static inline void remove_scratch(void)
{
    (void)scratch_count(true);
    ck_assert_int_eq(rmdir(scratch_folder), 0);
}

static inline void scratch_write_bytes(const char *name, const void *bytes, size_t size)
{
    const ScratchPath path = scratch_path(name);
    FILE *stream = fopen(path.text, "wb");
    ck_assert_ptr_nonnull(stream);
    ck_assert_uint_eq(fwrite(bytes, 1, size, stream), size);
    ck_assert_int_eq(fclose(stream), 0);
}

static inline void scratch_write(const char *name, const char *text)
{
    scratch_write_bytes(name, text, strlen(text));
}

static inline bool scratch_exists(const char *name)
{
    return access(scratch_path(name).text, F_OK) == 0;
}

#endif
