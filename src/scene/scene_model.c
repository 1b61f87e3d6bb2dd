#include "scene/scene_model.h"

#include "scene/grow.h"
#include "scene/scene_error.h"

static void free_item(PercaleSceneItem *item)
{
    percale_mesh_free(&item->mesh);
    free(item->file);
    free(item->rest_file);
    for (uint32_t group = 0; group < item->pin_count; ++group) {
        free(item->pins[group].vertices);
        free(item->pins[group].targets);
        percale_motion_free(&item->pins[group].motion);
    }
    free(item->pins);
    free(item->seams);
    free(item->rest_positions);
    free(item->rest_lengths);
    free(item->weld);
    percale_motion_free(&item->motion);
}

static PercaleSceneItem *add_item(PercaleSceneItem **items, uint32_t *count, uint32_t *capacity,
                                  PercaleSceneError *error)
{
    PercaleSceneItem *grown = percale_grow(*items, capacity, (uint64_t)*count + 1, sizeof *grown);
    if (grown == NULL) {
        percale_scene_out_of_memory(error);
        return NULL;
    }
    *items = grown;
    grown[*count] = (PercaleSceneItem){.transform = percale_transform_identity()};
    return &grown[(*count)++];
}

PercaleSceneItem *percale_scene_add_cloth(PercaleScene *scene, PercaleSceneError *error)
{
    PercaleSceneItem *cloth = add_item(&scene->cloths, &scene->cloth_count, &scene->cloth_capacity, error);
    if (cloth != NULL) {
        const PercaleClothDef def = percale_cloth_def_default();
        cloth->mask = def.mask;
        cloth->layer = def.layer;
    }
    return cloth;
}

PercaleSceneItem *percale_scene_add_obstacle(PercaleScene *scene, PercaleSceneError *error)
{
    PercaleSceneItem *obstacle =
        add_item(&scene->obstacles, &scene->obstacle_count, &scene->obstacle_capacity, error);
    if (obstacle != NULL) {
        obstacle->mask = percale_obstacle_def_default().mask;
    }
    return obstacle;
}

PercalePinGroup *percale_scene_add_pins(PercaleSceneItem *cloth, uint32_t count, PercaleSceneError *error)
{
    uint32_t *vertices = percale_array_new(count, sizeof *vertices);
    PercalePinGroup *pins =
        percale_grow(cloth->pins, &cloth->pin_capacity, (uint64_t)cloth->pin_count + 1, sizeof *pins);
    cloth->pins = pins != NULL ? pins : cloth->pins;
    if (vertices == NULL || pins == NULL) {
        free(vertices);
        percale_scene_out_of_memory(error);
        return NULL;
    }
    pins[cloth->pin_count] = (PercalePinGroup){.vertices = vertices, .count = count};
    return &pins[cloth->pin_count++];
}

void percale_scene_clear(PercaleScene *scene)
{
    for (uint32_t index = 0; index < scene->cloth_count; ++index) {
        free_item(&scene->cloths[index]);
    }
    for (uint32_t index = 0; index < scene->obstacle_count; ++index) {
        free_item(&scene->obstacles[index]);
    }
    scene->cloth_count = 0;
    scene->obstacle_count = 0;
}
