// output_file.h: files that exist under their final name only when they are complete.
//
//   in   a path
//   out  a stream on a temporary name in the same folder; commit renames it, discard removes it
//
// Anything but a regular file (a terminal, a pipe, /dev/null, a symbolic link) is written in place: renaming
// would put a file where it was.

#ifndef PERCALE_OUTPUT_FILE_H
#define PERCALE_OUTPUT_FILE_H

#include "percale/scene.h"

/// Zeroed: closed. `stream` is for writing, by whoever opened it.
typedef struct PercaleOutputFile {
    FILE *stream;
    char *path;      ///< final name
    char *temporary; ///< name until commit; NULL: written in place
} PercaleOutputFile;

/// On failure `file` is zeroed and nothing has been created.
bool percale_output_open(PercaleOutputFile *file, const char *path, PercaleSceneError *error);
/// Flushes, closes and renames. After a failed write, also an earlier one, removes the temporary file and
/// fails. `file` is zeroed in either case.
bool percale_output_commit(PercaleOutputFile *file, PercaleSceneError *error);
/// Closes and removes; a zeroed file is allowed.
void percale_output_discard(PercaleOutputFile *file);

#endif
