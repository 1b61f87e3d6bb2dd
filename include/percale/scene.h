// scene.h: the optional scene library: meshes from files, built-in scenes, settings by name, output files.
//
// It stands on percale.h alone. Errors are a PercaleSceneError with one line that names the culprit (file,
// line, column, key or vertex).

#ifndef PERCALE_SCENE_H
#define PERCALE_SCENE_H

#include "percale/percale.h"

#include <stdbool.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct PercaleSceneError {
    char text[512];
} PercaleSceneError;

/// A triangle mesh in memory; owns its arrays. Free with percale_mesh_free.
typedef struct PercaleMesh {
    char *name;       ///< base name without folder and suffix
    float *positions; ///< [3 * vertex_count] m, relative to the origin it was read with
    float *uvs; ///< [2 * vertex_count], NULL: none; a vertex with several texture coordinates keeps the first
    uint32_t vertex_count;
    uint32_t *triangles; ///< [3 * triangle_count]
    uint32_t triangle_count;
} PercaleMesh;

PERCALE_API void percale_mesh_free(PercaleMesh *mesh); ///< leaves it zeroed; a zeroed mesh is allowed

// ---- files ----

/// Reads a Wavefront OBJ: vertex order kept, polygons triangulated as fans, positions in double minus origin
/// (NULL: zero). Refuses NaN, bad indices, no vertices and unreadable numbers, with file and line.
PERCALE_API bool percale_obj_read(const char *path, const double origin[3], PercaleMesh *mesh,
                                  PercaleSceneError *error);
/// Writes positions plus origin with 9 significant digits, under a temporary name that is renamed at the end.
PERCALE_API bool percale_obj_write(const char *path, const float *positions, uint32_t vertex_count,
                                   const uint32_t *triangles, uint32_t triangle_count, const double origin[3],
                                   PercaleSceneError *error);

/// A PC2 point cache in memory: [sample_count][3 * vertex_count] float32.
typedef struct PercalePointCache {
    float *samples;
    uint32_t vertex_count;
    uint32_t sample_count;
} PercalePointCache;

PERCALE_API bool percale_pc2_read(const char *path, PercalePointCache *cache, PercaleSceneError *error);
PERCALE_API void percale_point_cache_free(PercalePointCache *cache);

/// Streams a PC2 file: open, one call per sample, close. Until close succeeds only a temporary name exists.
typedef struct PercalePc2Writer PercalePc2Writer;
PERCALE_API PercalePc2Writer *percale_pc2_open(const char *path, uint32_t vertex_count, uint32_t sample_count,
                                               float sample_rate, PercaleSceneError *error);
PERCALE_API bool percale_pc2_append(PercalePc2Writer *writer, const float *positions,
                                    PercaleSceneError *error);
/// Finishes and renames when every sample has come, else removes the temporary file; frees the writer.
PERCALE_API bool percale_pc2_close(PercalePc2Writer *writer, PercaleSceneError *error);

// ---- settings ----

typedef enum PercaleSettingKind {
    PERCALE_SETTING_SWITCH, ///< on / off
    PERCALE_SETTING_INTEGER,
    PERCALE_SETTING_NUMBER,
    PERCALE_SETTING_VECTOR, ///< three numbers, "x,y,z"
    PERCALE_SETTING_CHOICE  ///< one of `choices`
} PercaleSettingKind;

/// One setting of a scene, with the value that it has now.
typedef struct PercaleSetting {
    const char *name;
    PercaleSettingKind kind;
    double value[3]; ///< switch 0 / 1; integer; number; vector; index into choices
    double minimum, maximum;
    const char *unit;    ///< "" for none
    const char *choices; ///< "auto|always"; NULL unless CHOICE
    const char *help;
} PercaleSetting;

// ---- scenes ----

typedef struct PercaleScene PercaleScene;

/// Names and one-line descriptions of the built-in scenes; NULL past the last.
PERCALE_API const char *percale_scene_name(uint32_t index);
PERCALE_API const char *percale_scene_summary(uint32_t index);

/// Opens a built-in scene or a JSON scene file. `size`: approximate cloth vertex count, 0: the scene's
/// default. Files are read at once; built-in meshes are made by percale_scene_build.
PERCALE_API PercaleScene *percale_scene_open(const char *name_or_path, uint64_t size,
                                             PercaleSceneError *error);
PERCALE_API void percale_scene_close(PercaleScene *scene);

/// "swift", "balanced" or "accurate": sets several settings at once; later percale_scene_set calls win.
PERCALE_API bool percale_scene_set_preset(PercaleScene *scene, const char *preset, PercaleSceneError *error);
/// Sets one setting from text; the error names an unknown key (and the nearest known one) or the range.
PERCALE_API bool percale_scene_set(PercaleScene *scene, const char *key, const char *value,
                                   PercaleSceneError *error);
PERCALE_API const PercaleSetting *percale_scene_settings(const PercaleScene *scene, uint32_t *count);
PERCALE_API const char *percale_scene_preset(const PercaleScene *scene);
/// The last line that the built solver has logged, "" without one.
PERCALE_API const char *percale_scene_log(const PercaleScene *scene);
PERCALE_API uint32_t percale_scene_default_frames(const PercaleScene *scene);
PERCALE_API double percale_scene_frame_rate(const PercaleScene *scene);
PERCALE_API void percale_scene_origin(const PercaleScene *scene, double origin[3]);

/// Makes the meshes, creates the solver and adds everything. The solver is the caller's to destroy, before
/// the scene.
PERCALE_API PercaleSolver *percale_scene_build(PercaleScene *scene, int thread_count,
                                               PercaleSceneError *error);
/// Moves obstacles and pins to where they are to be at frame `frame` (1: end of the first step).
PERCALE_API bool percale_scene_move(PercaleScene *scene, PercaleSolver *solver, uint32_t frame,
                                    PercaleSceneError *error);

/// What a built scene holds; arrays are the scene's, valid until it is closed.
typedef struct PercaleSceneObject {
    const char *name;
    const float
        *positions; ///< [3 * vertex_count]: a cloth's start, an obstacle's pose at the last moved frame
    uint32_t vertex_count;
    const uint32_t *triangles;
    uint32_t triangle_count;
    const float *rest_lengths; ///< [3 * triangle_count] as in PercaleAuditMesh; NULL for obstacles
    const uint32_t *weld; ///< [vertex_count] as in PercaleAuditMesh; NULL: nothing sewn, and for obstacles
    float thickness;      ///< m, as the solver uses it
    uint32_t mask;
    PercaleCloth cloth;       ///< id 0 for obstacles
    PercaleObstacle obstacle; ///< id 0 for cloths
} PercaleSceneObject;

PERCALE_API uint32_t percale_scene_cloth_count(const PercaleScene *scene);
PERCALE_API uint32_t percale_scene_obstacle_count(const PercaleScene *scene);
PERCALE_API PercaleSceneObject percale_scene_cloth(const PercaleScene *scene, uint32_t index);
PERCALE_API PercaleSceneObject percale_scene_obstacle(const PercaleScene *scene, uint32_t index);

#ifdef __cplusplus
}
#endif

#endif
