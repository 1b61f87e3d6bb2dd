#include "cli/seam_file.h"

#include <jansson.h>
#include <stdlib.h>
#include <string.h>

static bool take_pair(const json_t *item, const PercaleMesh *cloths, size_t cloth_count,
                      PercaleSeamPair *pair)
{
    size_t size = json_array_size(item); // 0 for what is no list
    json_int_t numbers[4] = {0, 0, 0, 0};
    for (size_t k = 0; k < size && k < 4; ++k) {
        const json_t *number = json_array_get(item, k);
        size_t place = size == 2 ? 2 * k + 1 : k;
        numbers[place] = json_is_integer(number) ? json_integer_value(number) : -1;
    }
    for (int side = 0; side < 2; ++side) {
        json_int_t cloth = numbers[2 * side];
        json_int_t vertex = numbers[2 * side + 1];
        if ((size != 2 && size != 4) || cloth < 0 || cloth >= (json_int_t)cloth_count || vertex < 0 ||
            vertex >= (json_int_t)cloths[cloth].vertex_count)
            return false;
        pair->cloth[side] = (uint32_t)cloth;
        pair->vertex[side] = (uint32_t)vertex;
    }
    return true;
}

bool percale_seam_file_read(const char *path, const PercaleMesh *cloths, size_t cloth_count,
                            PercaleSeamPairs *pairs, PercaleSceneError *error)
{
    json_error_t problem;
    json_t *list = json_load_file(path, JSON_REJECT_DUPLICATES, &problem);
    if (!list) {
        (void)snprintf(error->text, sizeof error->text, "%s: line %d: %s", path, problem.line, problem.text);
        return false;
    }
    bool read = json_is_array(list);
    if (!read)
        (void)snprintf(error->text, sizeof error->text, "%s: no list of pairs", path);
    pairs->items = calloc(json_array_size(list) + 1, sizeof *pairs->items);
    for (size_t index = 0; read && index < json_array_size(list); ++index) {
        read = pairs->items &&
               take_pair(json_array_get(list, index), cloths, cloth_count, &pairs->items[pairs->count++]);
        if (!read)
            (void)snprintf(
                error->text, sizeof error->text,
                "%s: pair %zu: not [vertex, vertex] or [cloth, vertex, cloth, vertex] of the meshes", path,
                index);
    }
    json_decref(list);
    return read;
}

/// A vertex and where it is.
typedef struct Spot {
    float x[3];
    uint32_t vertex;
} Spot;

static int compare_places(const Spot *a, const Spot *b)
{
    for (int axis = 0; axis < 3; ++axis)
        if (a->x[axis] != b->x[axis])
            return a->x[axis] < b->x[axis] ? -1 : 1;
    return 0;
}

static int compare_spots(const void *a, const void *b)
{
    const Spot *spot = a;
    const Spot *other = b;
    int place = compare_places(spot, other);
    return place != 0 ? place : (spot->vertex > other->vertex) - (spot->vertex < other->vertex);
}

bool percale_seam_pairs_add_coincident(const PercaleMesh *mesh, uint32_t cloth, PercaleSeamPairs *pairs)
{
    Spot *spots = calloc((size_t)mesh->vertex_count + 1, sizeof *spots);
    PercaleSeamPair *items =
        realloc(pairs->items, (pairs->count + mesh->vertex_count + 1) * sizeof *pairs->items);
    if (items)
        pairs->items = items;
    if (!spots || !items) {
        free(spots);
        return false;
    }
    for (uint32_t vertex = 0; vertex < mesh->vertex_count; ++vertex) {
        memcpy(spots[vertex].x, mesh->positions + 3 * (size_t)vertex, sizeof spots[vertex].x);
        spots[vertex].vertex = vertex;
    }
    qsort(spots, mesh->vertex_count, sizeof *spots, compare_spots);
    for (uint32_t k = 1; k < mesh->vertex_count; ++k)
        if (compare_places(&spots[k - 1], &spots[k]) == 0)
            pairs->items[pairs->count++] =
                (PercaleSeamPair){{cloth, cloth}, {spots[k - 1].vertex, spots[k].vertex}};
    free(spots);
    return true;
}
