#include "solve/solve_arrays.h"

#include <string.h>

/// Eight edges that share no vertex; or some of them stand there more than once, which gives the same.
typedef struct Block {
    const uint32_t (*edges)[2];
    const float *lengths;
    const float *compliances; // NULL: all 0
    float *multipliers;       // with the compliances
} Block;

static inline void store_pair(f32x4 *x, const uint32_t (*edges)[2], uint32_t end, f32x8 pair, uint32_t k)
{
    *point_at(x, edges[k][end]) = low_point(pair);
    *point_at(x, edges[k + 4][end]) = high_point(pair);
}

#define MOVE_PAIR(k)                                                           \
    do {                                                                       \
        store_pair(x, edges, 0, a[k] + product3(d[k], SPREAD(share_a, k)), k); \
        store_pair(x, edges, 1, b[k] - product3(d[k], SPREAD(share_b, k)), k); \
    } while (0)

/// C = |xa - xb| - l;  dlambda = (-C - alpha lambda) / (wa + wb + alpha), alpha = compliance / dt^2. Pair k
/// holds edges k and k + 4. Differences are taken on whole points; only they and the inverse masses are
/// transposed.
__attribute__((always_inline)) static inline void project(f32x4 *x, float inverse_dt2, const Block *block,
                                                          bool compliant)
{
    f32x8 a[4];
    f32x8 b[4];
    f32x8 d[4];
    for (uint32_t k = 0; k < 4; k++) {
        const uint32_t *low = block->edges[k];
        const uint32_t *high = block->edges[k + 4];
        a[k] = pair_of_points(*point_at(x, low[0]), *point_at(x, high[0]));
        b[k] = pair_of_points(*point_at(x, low[1]), *point_at(x, high[1]));
        d[k] = a[k] - b[k];
    }
    WidePoints d3 = transpose_pairs(d);
    f32x8 length = sqrt8((d3.x * d3.x + d3.y * d3.y) + d3.z * d3.z);
    f32x8 weight_a = transpose_w(a);
    f32x8 weight_b = transpose_w(b);
    f32x8 weight = weight_a + weight_b;
    f32x8 excess = load8(block->lengths) - length;
    f32x8 multiplier = all8(0.0f);
    if (compliant) {
        f32x8 alpha = load8(block->compliances) * inverse_dt2;
        multiplier = load8(block->multipliers);
        weight += alpha;
        excess -= alpha * multiplier;
    }
    f32x8 divisor = length * weight;
    f32x8 change =
        where8(greater8(divisor, all8(0.0f)), excess / divisor); // 0: no direction, or nothing to move
    if (compliant) {
        store8(block->multipliers, multiplier + change * length);
    }
    f32x8 share_a = change * weight_a;
    f32x8 share_b = change * weight_b;
    const uint32_t(*edges)[2] = block->edges;
    __asm__("" : "+r"(edges)); // read anew: sixteen addresses don't fit into the registers
    MOVE_PAIR(0);
    MOVE_PAIR(1);
    MOVE_PAIR(2);
    MOVE_PAIR(3);
}

/// The last `count` edges, fewer than eight, filled up with the first of them.
static void project_rest(const PercaleSolveArrays *arrays, uint32_t first, uint32_t count, bool compliant)
{
    const PercaleModel *model = arrays->model;
    uint32_t edges[WIDE][2];
    float lengths[WIDE];
    float compliances[WIDE] = {0.0f};
    float multipliers[WIDE] = {0.0f};
    for (uint32_t i = 0; i < WIDE; i++) {
        uint32_t e = first + (i < count ? i : 0);
        memcpy(edges[i], model->edges[e], sizeof(edges[i]));
        lengths[i] = model->edge_lengths[e];
        if (compliant) {
            compliances[i] = model->edge_compliances[e];
            multipliers[i] = arrays->edge_multipliers[e];
        }
    }
    Block block = {(const uint32_t(*)[2])edges, lengths, compliances, multipliers};
    project(arrays->x, 1.0f / (arrays->dt * arrays->dt), &block, compliant);
    if (compliant) {
        memcpy(arrays->edge_multipliers + first, multipliers, count * sizeof(float));
    }
}

__attribute__((always_inline)) static inline void project_all(const PercaleSolveArrays *arrays,
                                                              uint32_t begin, uint32_t end, bool compliant)
{
    const PercaleModel *model = arrays->model;
    float inverse_dt2 = 1.0f / (arrays->dt * arrays->dt);
    uint32_t e = begin;
    for (; e + WIDE <= end; e += WIDE) {
        Block block = {(const uint32_t(*)[2])model->edges + e, model->edge_lengths + e, NULL, NULL};
        if (compliant) {
            block.compliances = model->edge_compliances + e;
            block.multipliers = arrays->edge_multipliers + e;
        }
        project(arrays->x, inverse_dt2, &block, compliant);
    }
    if (e < end) {
        project_rest(arrays, e, end - e, compliant);
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
