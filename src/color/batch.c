#include "color/batch.h"

#include <string.h>

enum {
    TILES_JOINED = 4, // by a tile of the next level: along the curve, four squares of a sheet make a square
    FEWEST_TILES = 4  // of a level after the first: fewer would leave threads idle
};

/// Columns of a constraint table that are sorted together.
typedef struct Column {
    void *array;
    size_t element_size;
} Column;

typedef struct Table {
    uint32_t arity, count; // vertices per constraint, constraints
    Column columns[3];     // the vertices first
    int column_count;
    uint32_t point_count; // that the vertices are numbers of
} Table;

static const uint32_t *vertices_at(const Table *table, uint32_t index)
{
    return (const uint32_t *)table->columns[0].array + (size_t)index * table->arity;
}

// ---- tiles ----

static uint32_t tiles_of(uint32_t slot_count, uint64_t points)
{
    return points > 0 ? (uint32_t)((slot_count + points - 1) / points) : 0;
}

static PercaleTiling tiling_of(uint32_t slot_count, uint32_t tile_points)
{
    PercaleTiling tiling = {0};
    uint64_t points = tile_points;
    uint32_t fewest = 1;
    uint32_t count = tiles_of(slot_count, points);
    while (count >= fewest) {
        uint32_t level = tiling.level_count++;
        tiling.tile_points[level] = (uint32_t)points;
        tiling.first_tile[level + 1] = tiling.first_tile[level] + count;
        points *= TILES_JOINED;
        count = tiles_of(slot_count, points);
        fewest = FEWEST_TILES;
    }
    return tiling;
}

static bool is_in_tile(const Table *table, uint32_t index, uint32_t tile_points, uint32_t tile)
{
    const uint32_t *vertices = vertices_at(table, index);
    bool is_inside = true;
    for (uint32_t k = 0; k < table->arity; k++) {
        is_inside = is_inside && vertices[k] / tile_points == tile;
    }
    return is_inside;
}

/// The smallest tile that holds all of the constraint's vertices, the number of all tiles for none.
static uint32_t tile_of(const Table *table, uint32_t index, const PercaleTiling *tiling)
{
    for (uint32_t level = 0; level < tiling->level_count; level++) {
        uint32_t points = tiling->tile_points[level];
        uint32_t tile = vertices_at(table, index)[0] / points;
        if (is_in_tile(table, index, points, tile)) {
            return tiling->first_tile[level] + tile;
        }
    }
    return tiling->first_tile[tiling->level_count];
}

/// array[i] = old array[order[i]]; scratch has room for the array.
static void permute(const Column *column, void *scratch, const uint32_t *order, uint32_t count)
{
    char *array = column->array;
    size_t size = column->element_size;
    memcpy(scratch, array, count * size);
    for (uint32_t i = 0; i < count; i++) {
        memcpy(array + i * size, (const char *)scratch + order[i] * size, size);
    }
}

static void permute_all(const Table *table, void *scratch, const uint32_t *order)
{
    for (int c = 0; table->count > 0 && c < table->column_count; c++) {
        permute(&table->columns[c], scratch, order, table->count);
    }
}

/// Sorts the table by tile, stably; tile_first gets the first constraint of each, [tile_count + 2].
static void sort_by_tile(const Table *table, const PercaleTiling *tiling, uint32_t *tile_first,
                         uint32_t *order)
{
    uint32_t tile_count = tiling->first_tile[tiling->level_count];
    memset(tile_first, 0, (tile_count + 2) * sizeof(tile_first[0]));
    for (uint32_t i = 0; i < table->count; i++) {
        tile_first[tile_of(table, i, tiling) + 1]++;
    }
    for (uint32_t t = 0; t <= tile_count; t++) {
        tile_first[t + 1] += tile_first[t];
    }
    for (uint32_t i = 0; i < table->count; i++) {
        order[tile_first[tile_of(table, i, tiling)]++] = i;
    }
    for (uint32_t t = tile_count + 1; t > 0; t--) {
        tile_first[t] = tile_first[t - 1];
    }
    tile_first[0] = 0;
}

// ---- runs ----

static bool add_run(PercaleBatches *batches, PercaleMemory *memory, uint32_t first)
{
    if (!percale_memory_reserve(memory, &batches->run_first, &batches->run_capacity,
                                (size_t)batches->run_count + 2, sizeof(uint32_t))) {
        return false;
    }
    batches->run_first[batches->run_count++] = first;
    return true;
}

/// One run per colour and one per constraint of the remainder; `first` is the coloring's place in the table.
static bool add_runs(PercaleBatches *batches, PercaleMemory *memory, const PercaleColoring *coloring,
                     uint32_t first)
{
    bool complete = true;
    for (uint32_t color = 0; complete && color < coloring->color_count; color++) {
        complete = add_run(batches, memory, first + coloring->first[color]);
    }
    for (uint32_t i = coloring->first[coloring->color_count]; complete && i < coloring->count; i++) {
        complete = add_run(batches, memory, first + i);
    }
    if (coloring->color_count > batches->color_count) {
        batches->color_count = coloring->color_count;
    }
    return complete;
}

static void begin_batches(PercaleBatches *batches, uint32_t count)
{
    batches->count = count;
    batches->tiling = (PercaleTiling){0};
    batches->tile_count = 0;
    batches->run_count = 0;
    batches->color_count = 0;
}

static bool end_batches(PercaleBatches *batches, PercaleMemory *memory)
{
    bool complete = add_run(batches, memory, batches->count);
    batches->run_count -= complete; // only where the last one ends
    return complete;
}

/// Colours the constraints [first, end) of the table among themselves, adds their runs and writes their
/// order.
static bool color_group(const Table *table, uint32_t first, uint32_t end, PercaleColoring *coloring,
                        PercaleMemory *memory, PercaleBatches *batches, uint32_t *order)
{
    PercaleConstraints constraints = {.vertices = vertices_at(table, first),
                                      .vertex_stride = table->arity,
                                      .arity = table->arity,
                                      .count = end - first,
                                      .all_take_part = true};
    if (!percale_coloring_run(coloring, memory, &constraints, NULL, table->point_count) ||
        !add_runs(batches, memory, coloring, first)) {
        return false;
    }
    for (uint32_t i = 0; i < end - first; i++) {
        order[first + i] = first + coloring->order[i];
    }
    return true;
}

/// From here on the constraints name byte offsets.
static void hold_offsets(const Table *table)
{
    uint32_t *vertices = table->columns[0].array;
    for (size_t i = 0; i < (size_t)table->arity * table->count; i++) {
        vertices[i] *= POINT_BYTES;
    }
}

static bool batch_table(const Table *table, uint32_t tile_points, PercaleColoring *coloring,
                        PercaleMemory *memory, PercaleBatches *batches)
{
    size_t widest = 0;
    for (int c = 0; c < table->column_count; c++) {
        widest = table->columns[c].element_size > widest ? table->columns[c].element_size : widest;
    }
    PercaleTiling tiling = tiling_of(table->point_count, tile_points);
    uint32_t tile_count = tiling.first_tile[tiling.level_count];
    uint32_t *order = percale_memory_new(memory, table->count, sizeof(uint32_t));
    uint32_t *tile_first = percale_memory_new(memory, (size_t)tile_count + 2, sizeof(uint32_t));
    void *scratch = percale_memory_new(memory, table->count, widest);
    begin_batches(batches, table->count);
    bool complete = order != NULL && tile_first != NULL && scratch != NULL &&
                    percale_memory_reserve(memory, &batches->tile_first_run, &batches->tile_capacity,
                                           (size_t)tile_count + 1, sizeof(uint32_t));
    if (complete) {
        sort_by_tile(table, &tiling, tile_first, order);
        permute_all(table, scratch, order);
    }
    for (uint32_t t = 0; complete && t <= tile_count; t++) {
        batches->tile_first_run[t] = batches->run_count;
        complete = color_group(table, tile_first[t], tile_first[t + 1], coloring, memory, batches, order);
    }
    if (complete && end_batches(batches, memory)) {
        batches->tiling = tiling;
        batches->tile_count = tile_count;
        permute_all(table, scratch, order);
        hold_offsets(table);
    } else {
        complete = false;
    }
    percale_memory_free(memory, order);
    percale_memory_free(memory, tile_first);
    percale_memory_free(memory, scratch);
    return complete;
}

// ---- the kinds ----

bool percale_batch_edges(PercaleModel *model, uint32_t tile_points, PercaleColoring *coloring,
                         PercaleMemory *memory, PercaleBatches *batches)
{
    Table table = {2,
                   model->edge_count,
                   {{model->edges, sizeof(model->edges[0])},
                    {model->edge_lengths, sizeof(float)},
                    {model->edge_compliances, sizeof(float)}},
                   model->edge_compliances != NULL ? 3 : 2,
                   model->slot_count};
    return batch_table(&table, tile_points, coloring, memory, batches);
}

bool percale_batch_hinges(PercaleModel *model, uint32_t tile_points, PercaleColoring *coloring,
                          PercaleMemory *memory, PercaleBatches *batches)
{
    Table table = {4,
                   model->hinge_count,
                   {{model->hinges, sizeof(model->hinges[0])},
                    {model->hinge_weights, sizeof(f32x4)},
                    {model->hinge_stiffnesses, sizeof(float)}},
                   3,
                   model->slot_count};
    return batch_table(&table, tile_points, coloring, memory, batches);
}

bool percale_batch_links(PercaleCoarseLevel *level, PercaleColoring *coloring, PercaleMemory *memory,
                         PercaleBatches *batches)
{
    Table table = {2,
                   level->link_count,
                   {{level->links, sizeof(level->links[0])}, {level->link_lengths, sizeof(float)}},
                   2,
                   level->node_count};
    return batch_table(&table, 0, coloring, memory, batches);
}

bool percale_batch_coloring(const PercaleColoring *coloring, PercaleMemory *memory, PercaleBatches *batches)
{
    begin_batches(batches, coloring->count);
    return percale_memory_reserve(memory, &batches->tile_first_run, &batches->tile_capacity, 1,
                                  sizeof(uint32_t)) &&
           add_runs(batches, memory, coloring, 0) && end_batches(batches, memory);
}

void percale_batches_free(PercaleBatches *batches, PercaleMemory *memory)
{
    percale_memory_free(memory, batches->tile_first_run);
    percale_memory_free(memory, batches->run_first);
    *batches = (PercaleBatches){0};
}
