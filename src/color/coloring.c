#include "color/coloring.h"

#include <string.h>

typedef struct Constraint {
    const uint32_t *vertices;
    const float *weights; // NULL: all non-zero
    uint32_t arity;
    bool all_take_part;
} Constraint;

static Constraint constraint_at(const PercaleConstraints *constraints, uint32_t index)
{
    return (Constraint){
        constraints->vertices + index * constraints->vertex_stride,
        constraints->weights == NULL ? NULL : constraints->weights + index * constraints->weight_stride,
        constraints->arity, constraints->all_take_part};
}

static bool takes_part(Constraint constraint, uint32_t corner, const f32x4 *points)
{
    return constraint.all_take_part || (points[constraint.vertices[corner]][3] > 0.0f &&
                                        (constraint.weights == NULL || constraint.weights[corner] != 0.0f));
}

/// First colour that none of the constraint's vertices has yet, COLORS_MAX for none.
static uint32_t pick_color(Constraint constraint, const f32x4 *points, uint64_t *used)
{
    uint64_t taken = 0;
    for (uint32_t k = 0; k < constraint.arity; k++) {
        if (takes_part(constraint, k, points)) {
            taken |= used[constraint.vertices[k]];
        }
    }
    if (taken == UINT64_MAX) {
        return COLORS_MAX;
    }
    uint32_t color = (uint32_t)__builtin_ctzll(~taken);
    for (uint32_t k = 0; k < constraint.arity; k++) {
        if (takes_part(constraint, k, points)) {
            used[constraint.vertices[k]] |= (uint64_t)1 << color;
        }
    }
    return color;
}

/// Colours of all that wait (1) or of all others (0).
static void pick_colors(PercaleColoring *coloring, const PercaleConstraints *constraints, const f32x4 *points,
                        uint8_t waits, uint32_t population[])
{
    for (uint32_t i = 0; i < constraints->count; i++) {
        if (constraints->waits == NULL || constraints->waits[i] == waits) {
            uint32_t color = pick_color(constraint_at(constraints, i), points, coloring->used);
            coloring->color_of[i] = (uint8_t)color;
            population[color]++;
        }
    }
}

static void sort_by_color(PercaleColoring *coloring, const uint32_t *population)
{
    uint32_t start[COLORS_MAX + 1];
    uint32_t sum = 0;
    coloring->color_count = 0;
    for (uint32_t color = 0; color <= COLORS_MAX; color++) {
        start[color] = sum;
        if (color < COLORS_MAX && population[color] > 0) {
            coloring->color_count = color + 1;
        }
        sum += population[color];
    }
    memcpy(coloring->first, start, sizeof(start));
    for (uint32_t color = coloring->color_count; color <= COLORS_MAX; color++) {
        coloring->first[color] = start[COLORS_MAX]; // past the last colour begins the remainder
    }
    for (uint32_t i = 0; i < coloring->count; i++) {
        coloring->order[start[coloring->color_of[i]]++] = i;
    }
}

static bool reserve(PercaleColoring *coloring, PercaleMemory *memory, uint32_t count, uint32_t point_count)
{
    return percale_memory_reserve(memory, &coloring->order, &coloring->order_capacity, count,
                                  sizeof(uint32_t)) &&
           percale_memory_reserve(memory, &coloring->color_of, &coloring->color_of_capacity, count, 1) &&
           percale_memory_reserve(memory, &coloring->used, &coloring->used_capacity, point_count,
                                  sizeof(uint64_t));
}

bool percale_coloring_run(PercaleColoring *coloring, PercaleMemory *memory,
                          const PercaleConstraints *constraints, const f32x4 *points, uint32_t point_count)
{
    coloring->count = 0;
    coloring->color_count = 0;
    memset(coloring->first, 0, sizeof(coloring->first));
    if (!reserve(coloring, memory, constraints->count, point_count)) {
        return false;
    }
    uint32_t population[COLORS_MAX + 1] = {0};
    pick_colors(coloring, constraints, points, 0, population);
    if (constraints->waits != NULL) {
        pick_colors(coloring, constraints, points, 1, population);
    }
    for (uint32_t i = 0; i < constraints->count; i++) {
        for (uint32_t k = 0; k < constraints->arity; k++) {
            coloring->used[constraint_at(constraints, i).vertices[k]] = 0;
        }
    }
    coloring->count = constraints->count;
    sort_by_color(coloring, population);
    return true;
}

void percale_coloring_free(PercaleColoring *coloring, PercaleMemory *memory)
{
    percale_memory_free(memory, coloring->order);
    percale_memory_free(memory, coloring->color_of);
    percale_memory_free(memory, coloring->used);
    *coloring = (PercaleColoring){0};
}
