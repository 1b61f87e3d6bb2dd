#include "cli/run_picture.h"

#include "render/picture.h"

#include <math.h>
#include <stdlib.h>

enum { PICTURE_WIDTH = 900, PICTURE_HEIGHT = 1200 }; // pixels

static const float STRETCH_FULL = 0.1f;       // l / l0 - 1 that gets the scale's last colour
static const float PENETRATION_FULL = 0.002f; // m; the built-in scenes' thickness

typedef struct Drawing {
    PercalePictureMesh *meshes; // [mesh_count] cloths first
    PercaleAuditMesh *audit;    // [mesh_count] the same
    float **owned;              // [2 * cloth_count] the cloths' positions, then their heats
    uint32_t cloth_count, obstacle_count;
} Drawing;

static bool out_of_memory(PercaleSceneError *error)
{
    (void)snprintf(error->text, sizeof error->text, "picture: out of memory");
    return false;
}

static void take_object(Drawing *drawing, uint32_t index, const PercaleSceneObject *object,
                        const float *positions)
{
    bool cloth = index < drawing->cloth_count;
    drawing->meshes[index] = (PercalePictureMesh){.positions = positions,
                                                  .vertex_count = object->vertex_count,
                                                  .triangles = object->triangles,
                                                  .triangle_count = object->triangle_count,
                                                  .cloth = cloth,
                                                  .index = cloth ? index : index - drawing->cloth_count};
    drawing->audit[index] = (PercaleAuditMesh){.positions = positions,
                                               .vertex_count = object->vertex_count,
                                               .triangles = object->triangles,
                                               .triangle_count = object->triangle_count,
                                               .rest_lengths = object->rest_lengths,
                                               .weld = object->weld,
                                               .thickness = object->thickness,
                                               .mask = object->mask};
}

/// Largest stretch of the edges at each vertex, m/m; 0 without rest lengths.
static void measure_stretch(const PercaleAuditMesh *mesh, float *stretch)
{
    for (size_t corner = 0; mesh->rest_lengths && corner < 3 * (size_t)mesh->triangle_count; ++corner) {
        uint32_t a = mesh->triangles[corner];
        uint32_t b = mesh->triangles[corner - corner % 3 + (corner + 1) % 3];
        const float *x = mesh->positions + 3 * (size_t)a;
        const float *y = mesh->positions + 3 * (size_t)b;
        float length = sqrtf((x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
                             (x[2] - y[2]) * (x[2] - y[2]));
        float strain = fabsf(length / mesh->rest_lengths[corner] - 1.0f);
        stretch[a] = fmaxf(stretch[a], strain);
        stretch[b] = fmaxf(stretch[b], strain);
    }
}

static bool add_heat(const Drawing *drawing, uint32_t index, PercaleHeat heat, PercaleSceneError *error)
{
    const PercaleAuditMesh *cloth = &drawing->audit[index];
    float *values = calloc((size_t)cloth->vertex_count + 1, sizeof *values);
    drawing->owned[drawing->cloth_count + index] = values;
    drawing->meshes[index].heat = values;
    if (!values)
        return out_of_memory(error);
    float full = STRETCH_FULL;
    if (heat == PERCALE_HEAT_STRETCH) {
        measure_stretch(cloth, values);
    } else {
        full = PENETRATION_FULL;
        const PercaleAuditMesh *obstacles = drawing->audit + drawing->cloth_count;
        if (percale_audit_penetration(cloth, obstacles, drawing->obstacle_count, values) != PERCALE_OK)
            return out_of_memory(error);
    }
    for (uint32_t vertex = 0; vertex < cloth->vertex_count; ++vertex)
        values[vertex] = values[vertex] / full;
    return true;
}

/// Adds cloth `index` where it is now.
static bool add_cloth(Drawing *drawing, const PercaleScene *scene, PercaleSolver *solver, uint32_t index,
                      PercaleSceneError *error)
{
    PercaleSceneObject cloth = percale_scene_cloth(scene, index);
    float *positions = malloc((3 * (size_t)cloth.vertex_count + 1) * sizeof *positions);
    drawing->owned[index] = positions;
    if (!positions)
        return out_of_memory(error);
    take_object(drawing, index, &cloth, positions);
    if (percale_cloth_get_positions(solver, cloth.cloth, positions, 0) == PERCALE_OK)
        return true;
    (void)snprintf(error->text, sizeof error->text, "picture: %s", percale_solver_last_error(solver));
    return false;
}

static const char *legend_of(PercaleHeat heat)
{
    switch (heat) {
    case PERCALE_HEAT_NONE:
        break;
    case PERCALE_HEAT_STRETCH:
        return "cloth colour: largest stretch or squeeze of a vertex's edges, dark 0 %, yellow 10 % or more";
    case PERCALE_HEAT_PENETRATION:
        return "cloth colour: depth below the obstacles' surfaces, dark 0 mm, yellow 2 mm or more";
    }
    return NULL;
}

static bool draw(Drawing *drawing, const char *path, const PercaleScene *scene, PercaleSolver *solver,
                 PercaleHeat heat, PercaleSceneError *error)
{
    uint32_t mesh_count = drawing->cloth_count + drawing->obstacle_count;
    for (uint32_t index = 0; index < drawing->cloth_count; ++index)
        if (!add_cloth(drawing, scene, solver, index, error))
            return false;
    for (uint32_t index = 0; index < drawing->obstacle_count; ++index) {
        PercaleSceneObject obstacle = percale_scene_obstacle(scene, index);
        take_object(drawing, drawing->cloth_count + index, &obstacle, obstacle.positions);
    }
    for (uint32_t index = 0; heat != PERCALE_HEAT_NONE && index < drawing->cloth_count; ++index)
        if (!add_heat(drawing, index, heat, error))
            return false;
    PercalePictureDef def = {.width = PICTURE_WIDTH, .height = PICTURE_HEIGHT, .legend = legend_of(heat)};
    return percale_picture_write(path, drawing->meshes, mesh_count, def, error);
}

bool percale_run_picture(const char *path, const PercaleScene *scene, PercaleSolver *solver, PercaleHeat heat,
                         PercaleSceneError *error)
{
    Drawing drawing = {.cloth_count = percale_scene_cloth_count(scene),
                       .obstacle_count = percale_scene_obstacle_count(scene)};
    size_t mesh_count = (size_t)drawing.cloth_count + drawing.obstacle_count;
    drawing.meshes = calloc(mesh_count + 1, sizeof *drawing.meshes);
    drawing.audit = calloc(mesh_count + 1, sizeof *drawing.audit);
    drawing.owned = calloc(2 * (size_t)drawing.cloth_count + 1, sizeof(float *));
    bool drawn = drawing.meshes && drawing.audit && drawing.owned
                     ? draw(&drawing, path, scene, solver, heat, error)
                     : out_of_memory(error);
    for (size_t index = 0; drawing.owned && index < 2 * (size_t)drawing.cloth_count; ++index)
        free(drawing.owned[index]);
    free(drawing.owned);
    free(drawing.meshes);
    free(drawing.audit);
    return drawn;
}
