// clusters.h: which parts of a state a round has made worse.
//
//   in   pairs of triangles that crossed before and that cross now, the stencils that have been projected
//   out  points and triangles of the parts where far more pairs cross than before
//
// What shares points belongs together: pairs, before and after, and stencils. So a part that goes wrong is
// put back while the others go on.

#ifndef PERCALE_CLUSTERS_H
#define PERCALE_CLUSTERS_H

#include "untangle/tangle_stage.h"

typedef struct PercaleTanglePairs {
    uint32_t (*items)[2];
    size_t count, capacity;
} PercaleTanglePairs;

typedef struct PercaleTangleClusters {
    uint32_t *parents;        // [point_count] union-find
    uint32_t *before, *now;   // [point_count] pairs of the cluster with this root
    PercaleTanglePairs pairs; // that crossed before
} PercaleTangleClusters;

/// False without memory.
bool percale_tangle_clusters_open(PercaleTangleClusters *clusters, uint32_t point_count,
                                  PercaleMemory *memory);
void percale_tangle_clusters_free(PercaleTangleClusters *clusters, PercaleMemory *memory);

/// Keeps the pairs of the stage's contours as those of before. False without memory.
bool percale_tangle_clusters_begin(PercaleTangleClusters *clusters, const PercaleTangleStage *stage);

/// Compares with the stage's contours of now. Returns whether any part is worse.
bool percale_tangle_clusters_judge(PercaleTangleClusters *clusters, const PercaleTangleStage *stage);

/// Whether the point is in a part that has become worse.
bool percale_tangle_cluster_is_worse(const PercaleTangleClusters *clusters, uint32_t point);

#endif
