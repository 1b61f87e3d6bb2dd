#include "model/object.h"

void percale_cloth_object_free(PercaleClothObject *cloth, PercaleMemory *memory)
{
    percale_memory_free(memory, cloth->positions);
    percale_memory_free(memory, cloth->velocities);
    percale_memory_free(memory, cloth->triangles);
    percale_memory_free(memory, cloth->rest_lengths);
    percale_memory_free(memory, cloth->rest_areas);
    percale_memory_free(memory, cloth->curve);
}

void percale_obstacle_object_free(PercaleObstacleObject *obstacle, PercaleMemory *memory)
{
    percale_memory_free(memory, obstacle->base);
    percale_memory_free(memory, obstacle->from);
    percale_memory_free(memory, obstacle->to);
    percale_memory_free(memory, obstacle->velocity_from);
    percale_memory_free(memory, obstacle->velocity_to);
    percale_memory_free(memory, obstacle->triangles);
}

void percale_obstacle_object_arrive(PercaleObstacleObject *obstacle, bool arrived, PercaleMemory *memory)
{
    percale_memory_free(memory, obstacle->velocity_from);
    obstacle->velocity_from = arrived ? obstacle->velocity_to : NULL;
    if (!arrived) {
        percale_memory_free(memory, obstacle->velocity_to);
    }
    obstacle->velocity_to = NULL;
}

void percale_pin_object_free(PercalePinObject *pin, PercaleMemory *memory)
{
    percale_memory_free(memory, pin->vertices);
    percale_memory_free(memory, pin->to);
}

void percale_seam_object_free(PercaleSeamObject *seam, PercaleMemory *memory)
{
    percale_memory_free(memory, seam->vertices_a);
    percale_memory_free(memory, seam->vertices_b);
    percale_memory_free(memory, seam->welded);
}

void percale_objects_free(PercaleObjects *objects, PercaleMemory *memory)
{
    for (size_t i = 0; i < objects->cloth_count; i++) {
        percale_cloth_object_free(&objects->cloths[i], memory);
    }
    for (size_t i = 0; i < objects->obstacle_count; i++) {
        percale_obstacle_object_free(&objects->obstacles[i], memory);
    }
    for (size_t i = 0; i < objects->pin_count; i++) {
        percale_pin_object_free(&objects->pins[i], memory);
    }
    for (size_t i = 0; i < objects->seam_count; i++) {
        percale_seam_object_free(&objects->seams[i], memory);
    }
    percale_memory_free(memory, objects->cloths);
    percale_memory_free(memory, objects->obstacles);
    percale_memory_free(memory, objects->pins);
    percale_memory_free(memory, objects->seams);
    *objects = (PercaleObjects){0};
}

size_t percale_find_cloth(const PercaleObjects *objects, PercaleCloth cloth)
{
    for (size_t i = 0; i < objects->cloth_count; i++) {
        if (objects->cloths[i].id == cloth.id) {
            return i;
        }
    }
    return SIZE_MAX;
}

size_t percale_find_obstacle(const PercaleObjects *objects, PercaleObstacle obstacle)
{
    for (size_t i = 0; i < objects->obstacle_count; i++) {
        if (objects->obstacles[i].id == obstacle.id) {
            return i;
        }
    }
    return SIZE_MAX;
}
