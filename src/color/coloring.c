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

/// First colour of a round that none of the constraint's vertices has yet, COLORS_OF_ROUND for none.
static uint32_t pick_color(Constraint constraint, const f32x4 *points, uint64_t *used)
{
    uint64_t taken = 0;
    for (uint32_t k = 0; k < constraint.arity; k++) {
        if (takes_part(constraint, k, points)) {
            taken |= used[constraint.vertices[k]];
        }
    }
    if (taken == UINT64_MAX) {
        return COLORS_OF_ROUND;
    }
    uint32_t color = (uint32_t)__builtin_ctzll(~taken);
    for (uint32_t k = 0; k < constraint.arity; k++) {
        if (takes_part(constraint, k, points)) {
            used[constraint.vertices[k]] |= (uint64_t)1 << color;
        }
    }
    return color;
}

/// Those that a round colours.
typedef struct Round {
    const PercaleConstraints *constraints;
    const f32x4 *points;
    const uint32_t *items; // [count] ascending; NULL: all
    uint32_t count;
    uint32_t first_color;
} Round;

static uint32_t item_at(const Round *round, uint32_t i)
{
    return round->items == NULL ? i : round->items[i];
}

/// Colours of all that wait (1) or of all others (0). What finds none gets the first of the next round.
static void pick_colors(PercaleColoring *coloring, const Round *round, uint8_t waits, uint32_t population[])
{
    const PercaleConstraints *constraints = round->constraints;
    for (uint32_t i = 0; i < round->count; i++) {
        uint32_t item = item_at(round, i);
        if (constraints->waits == NULL || constraints->waits[item] == waits) {
            uint32_t color = round->first_color +
                             pick_color(constraint_at(constraints, item), round->points, coloring->used);
            coloring->color_of[item] = (uint16_t)color;
            population[color]++;
        }
    }
}

/// population: of each colour of the round, and behind them those that are left.
static void run_round(PercaleColoring *coloring, const Round *round, uint32_t population[])
{
    const PercaleConstraints *constraints = round->constraints;
    memset(population + round->first_color, 0, (COLORS_OF_ROUND + 1) * sizeof(population[0]));
    pick_colors(coloring, round, 0, population);
    if (constraints->waits != NULL) {
        pick_colors(coloring, round, 1, population);
    }
    for (uint32_t i = 0; i < round->count; i++) {
        for (uint32_t k = 0; k < constraints->arity; k++) {
            coloring->used[constraint_at(constraints, item_at(round, i)).vertices[k]] = 0;
        }
    }
}

/// Lists those of a round that found no colour in it, in `left`, which may be the round's own list.
static uint32_t list_left(const PercaleColoring *coloring, const Round *round, uint32_t *left)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < round->count; i++) {
        uint32_t item = item_at(round, i);
        if (coloring->color_of[item] == round->first_color + COLORS_OF_ROUND) {
            left[count++] = item;
        }
    }
    return count;
}

/// population: [limit + 1], the last of the remainder.
static void sort_by_color(PercaleColoring *coloring, const uint32_t *population, uint32_t limit)
{
    uint32_t start[COLORS_MAX + 1];
    uint32_t sum = 0;
    for (uint32_t color = 0; color <= limit; color++) {
        start[color] = sum;
        if (color < limit && population[color] > 0) {
            coloring->color_count = color + 1;
        }
        sum += population[color];
    }
    memcpy(coloring->first, start, coloring->color_count * sizeof(start[0]));
    coloring->first[coloring->color_count] = start[limit]; // past the last colour begins the remainder
    for (uint32_t i = 0; i < coloring->count; i++) {
        coloring->order[start[coloring->color_of[i]]++] = i;
    }
}

static bool reserve(PercaleColoring *coloring, PercaleMemory *memory, uint32_t count, uint32_t point_count)
{
    return percale_memory_reserve(memory, &coloring->order, &coloring->order_capacity, count,
                                  sizeof(uint32_t)) &&
           percale_memory_reserve(memory, &coloring->color_of, &coloring->color_of_capacity, count,
                                  sizeof(uint16_t)) &&
           percale_memory_reserve(memory, &coloring->used, &coloring->used_capacity, point_count,
                                  sizeof(uint64_t));
}

bool percale_coloring_run(PercaleColoring *coloring, PercaleMemory *memory,
                          const PercaleConstraints *constraints, const f32x4 *points, uint32_t point_count)
{
    coloring->count = 0;
    coloring->color_count = 0;
    coloring->first[0] = 0;
    if (!reserve(coloring, memory, constraints->count, point_count)) {
        return false;
    }
    uint32_t population[COLORS_MAX + 1];
    Round round = {constraints, points, NULL, constraints->count, 0};
    run_round(coloring, &round, population);
    uint32_t limit = COLORS_OF_ROUND;
    while (population[limit] > 0 && limit < COLORS_MAX) {
        round.count = list_left(coloring, &round, coloring->order); // there is no order yet
        round.items = coloring->order;
        round.first_color = limit;
        run_round(coloring, &round, population);
        limit += COLORS_OF_ROUND;
    }
    coloring->count = constraints->count;
    sort_by_color(coloring, population, limit);
    return true;
}

void percale_coloring_free(PercaleColoring *coloring, PercaleMemory *memory)
{
    percale_memory_free(memory, coloring->order);
    percale_memory_free(memory, coloring->color_of);
    percale_memory_free(memory, coloring->used);
    *coloring = (PercaleColoring){0};
}
