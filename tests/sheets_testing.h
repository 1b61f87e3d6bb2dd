// sheets_testing.h: sheets one above the other, and all pairs of their vertices, edges and faces.

#ifndef PERCALE_SHEETS_TESTING_H
#define PERCALE_SHEETS_TESTING_H

#include "detect/passage.h"
#include "pairs_testing.h"

#include <string.h>

enum { SIDE = 12, SHEETS = 2 };
static const float EDGE = 0.02f; // m

/// Sheets, each 12 mm above the one before, of so many vertices a side.
typedef struct Sheets {
    PercaleSolver *solver;
    PercaleMesh mesh;
    PercaleModel *model;
    PercaleCandidates *candidates;
    uint64_t seed;
} Sheets;

static inline void open_pile(Sheets *sheets, uint32_t side, int count)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    sheets->solver = percale_test_solver(def);
    sheets->mesh = percale_test_sheet(side, EDGE * (float)(side - 1));
    sheets->seed = 11;
    for (int s = 0; s < count; s++) {
        (void)percale_test_add_cloth(sheets->solver, &sheets->mesh);
        percale_test_translate(&sheets->mesh, 0.003f, 0.012f, 0.004f);
    }
    PERCALE_TEST_OK(sheets->solver, percale_solver_prepare(sheets->solver));
    sheets->model = &sheets->solver->model;
    sheets->candidates = &sheets->solver->candidates;
}

static inline void open_sheets(Sheets *sheets, uint32_t side)
{
    open_pile(sheets, side, SHEETS);
}

static inline void close_sheets(Sheets *sheets)
{
    percale_solver_destroy(sheets->solver);
    percale_mesh_free(&sheets->mesh);
}

/// Every predicted position moves by `all` and, at random, by up to `each`.
static inline void move(Sheets *sheets, f32x4 all, float each)
{
    for (uint32_t i = 0; i < sheets->model->slot_count; i++) {
        f32x4 by = all;
        for (int axis = 0; axis < 3; axis++) {
            by[axis] += each * (float)(2.0 * percale_test_random(&sheets->seed) - 1.0);
        }
        sheets->model->predicted[i] += with_w(by, 0.0f);
    }
}

/// All pairs of a kind, one after the other: vertices and faces, or edges with those after them.
typedef struct AllPairs {
    const PercaleModel *model;
    bool edges;
    uint32_t item, primitive; // of the next one
} AllPairs;

/// The points of the next pair that shares none. False when there is no other.
static inline bool next_pair(AllPairs *all, uint32_t points[4])
{
    const PercaleModelSurface *cloth = &all->model->cloth;
    uint32_t item_count = all->edges ? cloth->edges.edge_count : all->model->slot_count;
    uint32_t primitive_count = all->edges ? cloth->edges.edge_count : cloth->triangle_count;
    while (all->item < item_count) {
        uint32_t primitive = all->primitive++;
        if (primitive >= primitive_count) {
            all->item++;
            all->primitive = all->edges ? all->item + 1 : 0;
            continue;
        }
        if (all->edges) {
            memcpy(points, cloth->edges.vertices[all->item], 2 * sizeof(uint32_t));
            memcpy(points + 2, cloth->edges.vertices[primitive], 2 * sizeof(uint32_t));
        } else {
            points[0] = all->item;
            memcpy(points + 1, cloth->triangles + 3 * (size_t)primitive, 3 * sizeof(uint32_t));
        }
        bool own = points[2] == points[0] || points[3] == points[0];
        own = own || (all->edges ? points[2] == points[1] || points[3] == points[1] : points[1] == points[0]);
        if (!own) {
            return true;
        }
    }
    return false;
}

static inline AllPairs all_pairs(const PercaleModel *model, bool edges)
{
    return (AllPairs){model, edges, 0, edges ? 1 : 0};
}

/// Whether a vertex and a face, or two edges, go through each other on their predicted ways.
static inline bool do_pass(const PercaleModel *model, bool edges, const uint32_t points[4])
{
    Vec3 from[4];
    Vec3 to[4];
    for (int k = 0; k < 4; k++) {
        from[k] = vec3_of(model->position[points[k]]);
        to[k] = vec3_of(model->predicted[points[k]]);
    }
    PercalePassage passage;
    return edges ? percale_edges_pass(from, to, &passage) : percale_vertex_passes(from, to, &passage);
}

/// All passages of the predicted ways, by all pairs.
static inline uint32_t count_passages(const PercaleModel *model)
{
    uint32_t count = 0;
    uint32_t points[4];
    for (int kind = 0; kind < 2; kind++) {
        for (AllPairs all = all_pairs(model, kind == 1); next_pair(&all, points);) {
            count += do_pass(model, kind == 1, points);
        }
    }
    return count;
}

#endif
