// seam_file.h: who is sewn to whom, from a file.
//
//   in   a JSON file: a list of pairs [vertex, vertex] of the first cloth, or of [cloth, vertex, cloth,
//   vertex],
//        all numbered from 0
//   out  the pairs

#ifndef PERCALE_SEAM_FILE_H
#define PERCALE_SEAM_FILE_H

#include "percale/scene.h"

typedef struct PercaleSeamPair {
    uint32_t cloth[2], vertex[2];
} PercaleSeamPair;

typedef struct PercaleSeamPairs {
    PercaleSeamPair *items;
    size_t count;
} PercaleSeamPairs;

/// The caller frees items. Refuses what is no such list and vertices that the meshes don't have.
bool percale_seam_file_read(const char *path, const PercaleMesh *cloths, size_t cloth_count,
                            PercaleSeamPairs *pairs, PercaleSceneError *error);

/// Adds those vertices of one mesh that lie at the very same place: a file that has no shared vertices along
/// a seam still means one surface. False without memory.
bool percale_seam_pairs_add_coincident(const PercaleMesh *mesh, uint32_t cloth, PercaleSeamPairs *pairs);

#endif
