// scene_model.h: what a scene holds between opening and closing. The makers of scenes and the JSON reader
// fill it, scene_build.c turns it into a solver.

#ifndef PERCALE_SCENE_MODEL_H
#define PERCALE_SCENE_MODEL_H

#include "scene/motion.h"
#include "scene/settings.h"

/// Values that an object may have for itself, else the setting of the same name counts.
typedef enum PercaleOwnValue {
    PERCALE_OWN_DENSITY = 0,
    PERCALE_OWN_STRETCH_COMPLIANCE,
    PERCALE_OWN_BENDING_STIFFNESS,
    PERCALE_OWN_THICKNESS,
    PERCALE_OWN_FRICTION,
    PERCALE_OWN_COUNT
} PercaleOwnValue;

typedef enum PercaleRest {
    PERCALE_REST_MESH = 0, ///< the start mesh
    PERCALE_REST_UV,       ///< its texture coordinates, m
    PERCALE_REST_POINTS    ///< rest_file
} PercaleRest;

/// Pins of one cloth that move together.
typedef struct PercalePinGroup {
    uint32_t *vertices; ///< [count]
    uint32_t count;
    PercaleMotion motion; ///< of `count` points, in the order of `vertices`
    float *targets;       ///< [3 * count]; NULL: they stay where they start
    PercalePin pin;
} PercalePinGroup;

/// A cloth or an obstacle.
typedef struct PercaleSceneItem {
    PercaleMesh mesh; ///< positions as the solver gets them; an obstacle's: at the last moved frame
    double *file;     ///< [3 * vertex_count] world coordinates from a file; NULL: mesh.positions are made
    PercaleTransform transform;
    float own[PERCALE_OWN_COUNT];
    bool has_own[PERCALE_OWN_COUNT];
    uint32_t mask;
    float thickness; ///< m, as the solver uses it

    // Cloths
    int32_t layer;
    PercaleRest rest;
    double *rest_file; ///< [3 * vertex_count] world coordinates of the rest shape; NULL: none
    PercalePinGroup *pins;
    uint32_t pin_count, pin_capacity;
    uint32_t (*seams)[2]; ///< [seam_count] pairs of vertices
    uint32_t seam_count;
    float *rest_positions; ///< [3 * vertex_count]; NULL: the texture coordinates are the rest shape
    float *rest_lengths;   ///< [3 * triangle_count] m
    uint32_t *weld;        ///< [vertex_count]; NULL: nothing is sewn
    PercaleCloth cloth;

    // Obstacles
    PercaleMotion motion;
    PercaleObstacle obstacle;
} PercaleSceneItem;

/// A built-in scene.
typedef struct PercaleSceneKind {
    const char *name;
    const char *summary;
    uint64_t default_size; ///< cloth vertices
    uint32_t default_frames;
    uint32_t extra_count;
    const PercaleSettingRow *extra; ///< [extra_count] settings of its own
    const char *const *defaults;    ///< key, value, key, value, ..., NULL: what it sets otherwise
    /// Fills cloths and obstacles; NULL: not in this version.
    bool (*make)(PercaleScene *scene, PercaleSceneError *error);
    /// Before pins and obstacles move to the next frame: what depends on where the cloth has gone looks at
    /// it. NULL: nothing does.
    bool (*follow)(PercaleScene *scene, PercaleSolver *solver, PercaleSceneError *error);
} PercaleSceneKind;

struct PercaleScene {
    const PercaleSceneKind *kind; ///< NULL: from a file
    uint64_t size;                ///< cloth vertices asked for
    uint32_t default_frames;
    PercaleSettings settings;
    PercaleSceneItem *cloths;
    uint32_t cloth_count, cloth_capacity;
    PercaleSceneItem *obstacles;
    uint32_t obstacle_count, obstacle_capacity;
    char solver_log[512]; ///< the last line that the solver logged
};

extern const PercaleSceneKind percale_scene_drape;
extern const PercaleSceneKind percale_scene_flag;
extern const PercaleSceneKind percale_scene_dress;
extern const PercaleSceneKind percale_scene_layers;
extern const PercaleSceneKind percale_scene_funnel;
extern const PercaleSceneKind percale_scene_twist;
extern const PercaleSceneKind percale_scene_cards;
extern const PercaleSceneKind percale_scene_incline;

/// A new cloth or obstacle at the end; NULL: no memory. Earlier pointers into the scene are no longer valid.
PercaleSceneItem *percale_scene_add_cloth(PercaleScene *scene, PercaleSceneError *error);
PercaleSceneItem *percale_scene_add_obstacle(PercaleScene *scene, PercaleSceneError *error);
/// A new group of pins with room for `count` vertices, still zero.
PercalePinGroup *percale_scene_add_pins(PercaleSceneItem *cloth, uint32_t count, PercaleSceneError *error);
/// Drops all cloths and obstacles.
void percale_scene_clear(PercaleScene *scene);

/// Rest lengths and weld numbers of a cloth; `first_weld` is added to the numbers.
bool percale_scene_measure(PercaleSceneItem *cloth, uint32_t first_weld, PercaleSceneError *error);
/// Median length of the unique edges, m, over rest_lengths; negative: no memory.
double percale_scene_median_edge(const PercaleSceneItem *cloth);

/// The thickness that cloths without one of their own get, m, when their median edge is so long.
double percale_scene_thickness(const PercaleScene *scene, double median_edge);

/// Opens a scene file: fills settings, cloths and obstacles.
bool percale_scene_read_json(PercaleScene *scene, const char *path, PercaleSceneError *error);

#endif
