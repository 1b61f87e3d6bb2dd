#include "scene/grow.h"
#include "scene/scene_error.h"
#include "scene/shapes.h"

#include <string.h>

enum { CORNERS = 8, FACES = 12 };

// The bits of a corner's number say whether it is at the far end along, up and across.
static const uint32_t faces[3 * FACES] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                          2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};

bool percale_box_make(const char *name, const double corner[3], const double along[3], const double up[3],
                      const double across[3], PercaleMesh *mesh, PercaleSceneError *error)
{
    *mesh = (PercaleMesh){.name = strdup(name),
                          .positions = percale_array_new((uint64_t)3 * CORNERS, sizeof *mesh->positions),
                          .vertex_count = CORNERS,
                          .triangles = percale_array_new((uint64_t)3 * FACES, sizeof *mesh->triangles),
                          .triangle_count = FACES};
    if (mesh->name == NULL || mesh->positions == NULL || mesh->triangles == NULL) {
        percale_mesh_free(mesh);
        return percale_scene_out_of_memory(error);
    }
    for (size_t k = 0; k < CORNERS; ++k) {
        for (size_t axis = 0; axis < 3; ++axis) {
            const double at = corner[axis] + ((k & 1) != 0 ? along[axis] : 0.0) +
                              ((k & 2) != 0 ? up[axis] : 0.0) + ((k & 4) != 0 ? across[axis] : 0.0);
            mesh->positions[3 * k + axis] = (float)at;
        }
    }
    memcpy(mesh->triangles, faces, sizeof faces);
    return true;
}
