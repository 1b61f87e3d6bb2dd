#include "solve/solve_arrays.h"

/// Eight edges: pair k holds edges k and k + 4.
typedef struct Block {
    f32x8 a[4], b[4];
} Block;

/// Where edge i of a block of `count` is; a short block repeats its first.
static inline uint32_t place(uint32_t i, uint32_t count)
{
    return i < count ? i : 0;
}

static inline f32x8 load_values(const float *values, uint32_t count)
{
    if (count == WIDE) {
        return load8(values);
    }
    f32x8 wide = all8(values[0]);
    for (uint32_t i = 0; i < count; i++) {
        wide[i] = values[i];
    }
    return wide;
}

static inline void store_values(float *values, f32x8 wide, uint32_t count)
{
    if (count == WIDE) {
        store8(values, wide);
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        values[i] = wide[i];
    }
}

static inline void store_pair(f32x4 *x, const uint32_t (*edges)[2], uint32_t end, f32x8 pair, uint32_t k,
                              uint32_t count)
{
    if (k < count) {
        *point_at(x, edges[k][end]) = low_point(pair);
    }
    if (k + 4 < count) {
        *point_at(x, edges[k + 4][end]) = high_point(pair);
    }
}

#define MOVE_PAIR(k)                                                                  \
    do {                                                                              \
        f32x8 between = without_w(d[k]);                                              \
        store_pair(x, edges, 0, block.a[k] + between * SPREAD(share_a, k), k, count); \
        store_pair(x, edges, 1, block.b[k] - between * SPREAD(share_b, k), k, count); \
    } while (0)

/// C = |xa - xb| - l;  dlambda = (-C - alpha lambda) / (wa + wb + alpha), alpha = compliance / dt^2.
/// Differences are taken on whole points, only they and the inverse masses are transposed.
static inline void project(const PercaleSolveArrays *arrays, uint32_t first, uint32_t count, bool compliant)
{
    f32x4 *x = arrays->x;
    const uint32_t(*edges)[2] = (const uint32_t(*)[2])arrays->model->edges + first;
    Block block;
    f32x8 d[4];
    for (uint32_t k = 0; k < 4; k++) {
        const uint32_t *low = edges[place(k, count)];
        const uint32_t *high = edges[place(k + 4, count)];
        block.a[k] = pair_of_points(*point_at(x, low[0]), *point_at(x, high[0]));
        block.b[k] = pair_of_points(*point_at(x, low[1]), *point_at(x, high[1]));
        d[k] = block.a[k] - block.b[k];
    }
    WidePoints between3 = transpose_pairs(d);
    f32x8 length = sqrt8((between3.x * between3.x + between3.y * between3.y) + between3.z * between3.z);
    f32x8 weight_a = transpose_w(block.a);
    f32x8 weight_b = transpose_w(block.b);
    f32x8 weight = weight_a + weight_b;
    f32x8 excess = load_values(arrays->model->edge_lengths + first, count) - length;
    f32x8 multiplier = all8(0.0f);
    if (compliant) {
        f32x8 alpha = load_values(arrays->model->edge_compliances + first, count) *
                      all8(1.0f / (arrays->dt * arrays->dt));
        multiplier = load_values(arrays->edge_multipliers + first, count);
        weight += alpha;
        excess -= alpha * multiplier;
    }
    f32x8 divisor = length * weight;
    f32x8 change =
        where8(greater8(divisor, all8(0.0f)), excess / divisor); // 0: no direction, or nothing to move
    if (compliant) {
        store_values(arrays->edge_multipliers + first, multiplier + change * length, count);
    }
    f32x8 share_a = change * weight_a;
    f32x8 share_b = change * weight_b;
    MOVE_PAIR(0);
    MOVE_PAIR(1);
    MOVE_PAIR(2);
    MOVE_PAIR(3);
}

static inline void project_all(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end, bool compliant)
{
    uint32_t e = begin;
    for (; e + WIDE <= end; e += WIDE) {
        project(arrays, e, WIDE, compliant);
    }
    if (e < end) {
        project(arrays, e, end - e, compliant);
    }
}

void percale_solve_stretch(const PercaleSolveArrays *arrays, uint32_t begin, uint32_t end)
{
    if (arrays->edge_multipliers == NULL) {
        project_all(arrays, begin, end, false);
    } else {
        project_all(arrays, begin, end, true);
    }
}
