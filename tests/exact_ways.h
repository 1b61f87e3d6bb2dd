// exact_ways.h: what the tests of ccd=exact and obstacles share: whether a cloth vertex touches an obstacle
// on its way through a step of one substep, in exact integers (impact_oracle.h), all ways being straight.

#ifndef PERCALE_TESTS_EXACT_WAYS_H
#define PERCALE_TESTS_EXACT_WAYS_H

#include "testing.h"

#include "impact_oracle.h"
#include "solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double PI = 3.14159265358979323846;
static const float THICKNESS = 0.002f; // m, of cloth and obstacles

static inline double between(uint64_t *seed, double least, double most)
{
    return least + (most - least) * percale_test_random(seed);
}

static inline PercaleObstacle add_obstacle(PercaleSolver *solver, const PercaleMesh *mesh)
{
    PercaleObstacleDef def = percale_test_obstacle_def(mesh);
    def.thickness = THICKNESS;
    PercaleObstacle obstacle;
    PERCALE_TEST_OK(solver, percale_obstacle_add(solver, &def, &obstacle));
    return obstacle;
}

/// Where all points are.
static inline f32x4 *points_of(PercaleSolver *solver)
{
    PERCALE_TEST_OK(solver, percale_solver_validate(solver)); // assembles the model
    size_t bytes = solver->model.point_count * sizeof(f32x4);
    f32x4 *points = malloc(bytes);
    ck_assert_ptr_nonnull(points);
    memcpy(points, solver->model.position, bytes);
    return points;
}

static inline bool boxes_touch(const ImpactQuery *query)
{
    for (int axis = 0; axis < 3; axis++) {
        double low = HUGE_VAL;
        double high = -HUGE_VAL;
        for (int k = 1; k < 4; k++) {
            low = fmin(low, fmin(query->start[k][axis], query->end[k][axis]));
            high = fmax(high, fmax(query->start[k][axis], query->end[k][axis]));
        }
        if (fmax(query->start[0][axis], query->end[0][axis]) < low ||
            fmin(query->start[0][axis], query->end[0][axis]) > high) {
            return false;
        }
    }
    return true;
}

static inline bool touches(const f32x4 *start, const f32x4 *end, uint32_t slot, const uint32_t *corners)
{
    ImpactQuery query = {.edges = false};
    for (int k = 0; k < 4; k++) {
        uint32_t point = k == 0 ? slot : corners[k - 1];
        for (int axis = 0; axis < 3; axis++) {
            query.start[k][axis] = (double)start[point][axis];
            query.end[k][axis] = (double)end[point][axis];
        }
    }
    if (!boxes_touch(&query)) {
        return false;
    }
    ImpactTruth truth;
    impact_truth(&query, &truth);
    bool touched = truth.count > 0;
    exact_forget();
    return touched;
}

/// Cloth vertices that touch an obstacle on their ways.
static inline uint64_t count_touches(const PercaleModel *model, const f32x4 *start, const f32x4 *end)
{
    uint64_t count = 0;
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        bool touched = false;
        for (uint32_t o = 0; o < model->obstacle_count; o++) {
            const PercaleModelSurface *obstacle = &model->obstacles[o];
            for (uint32_t t = 0; t < obstacle->triangle_count && !touched; t++) {
                touched = touches(start, end, slot, obstacle->triangles + 3 * (size_t)t);
            }
        }
        count += touched;
    }
    return count;
}

/// Makes a step and counts the vertices that came against an obstacle; `would`, if not NULL: those that would
/// have, had they gone straight on.
static inline uint64_t step_and_count(PercaleSolver *solver, double seconds, uint64_t *would)
{
    f32x4 *start = points_of(solver);
    f32x4 *straight = points_of(solver);
    for (uint32_t slot = 0; slot < solver->model.slot_count; slot++) {
        straight[slot] += solver->model.velocity[slot] * (float)seconds;
    }
    PERCALE_TEST_OK(solver, percale_solver_step(solver, seconds));
    const PercaleModel *model = &solver->model;
    uint64_t count = count_touches(model, start, model->position);
    if (would != NULL) {
        memcpy(straight + model->slot_count, model->position + model->slot_count,
               (model->point_count - model->slot_count) * sizeof(f32x4));
        *would = count_touches(model, start, straight);
    }
    free(start);
    free(straight);
    return count;
}

#endif
