// batch.h: sorts constraints into runs that may be projected side by side.
//
//   in   constraints, in an order along the space-filling curve
//   out  the same in run order, and where each run begins
//
// A *run* is a range of constraints that share no vertex. Points are cut into *tiles* of consecutive
// slots: a tile's own constraints stand together, colour after colour, so that one thread takes them through
// its cache while others take other tiles. What joins tiles belongs to a tile of the next level, which is as
// long as several of them, and so on while there are tiles enough for some threads; what joins the last
// level's comes after, in colours of its own. The tiles depend on the mesh alone, so the bits don't depend on
// the threads. Without tiles (contacts) there are only the latter. What fits into no colour makes runs of
// one.

#ifndef PERCALE_BATCH_H
#define PERCALE_BATCH_H

#include "color/coloring.h"
#include "model/model.h"

enum { TILE_LEVELS_MAX = 16 }; // as many as 2^32 slots have, from tiles of one on

typedef struct PercaleTiling {
    uint32_t level_count;
    uint32_t tile_points[TILE_LEVELS_MAX];    // of a tile, at each level
    uint32_t first_tile[TILE_LEVELS_MAX + 1]; // [level_count + 1]; tiles are numbered level after level
} PercaleTiling;

typedef struct PercaleBatches {
    uint32_t count; // constraints
    PercaleTiling tiling;
    uint32_t tile_count;      // of all levels
    uint32_t *tile_first_run; // [tile_count + 1]; runs from tile_first_run[tile_count] on join tiles
    uint32_t run_count;
    uint32_t *run_first; // [run_count + 1] constraints
    size_t tile_capacity, run_capacity;
    uint32_t color_count; // the most that a tile, or what joins them, has
} PercaleBatches;

/// Sorts the model's edges and hinges in place, and makes byte offsets of their slots; tile_points: of the
/// first level, 0: no tiles. False without memory.
bool percale_batch_edges(PercaleModel *model, uint32_t tile_points, PercaleColoring *coloring,
                         PercaleMemory *memory, PercaleBatches *batches);
bool percale_batch_hinges(PercaleModel *model, uint32_t tile_points, PercaleColoring *coloring,
                          PercaleMemory *memory, PercaleBatches *batches);

/// The same for the links of a coarse level, over its nodes, without tiles.
bool percale_batch_links(PercaleCoarseLevel *level, PercaleColoring *coloring, PercaleMemory *memory,
                         PercaleBatches *batches);

/// Runs of a coloring as it stands, without tiles; the constraints are found through coloring->order.
bool percale_batch_coloring(const PercaleColoring *coloring, PercaleMemory *memory, PercaleBatches *batches);

void percale_batches_free(PercaleBatches *batches, PercaleMemory *memory);

#endif
