#include "finish/passing.h"

#include "detect/impact_time.h"
#include "detect/passage.h"
#include "detect/pinch.h"
#include "finish/flat_passing.h"
#include "percale/geometry.h"

#include <string.h>

// Share of the distance at the start that is left to what has passed, and the least distance, m: contact
// widens it again, but what is pressed on for long halves it in each substep, and rounding passes what is
// nearer than it.
static const double KEPT = 0.5;
static const double LEAST_KEPT = 1e-6;

// With exact tests nothing comes nearer than this, m, or a tenth of its distance: the next start is apart,
// too.
static const double APART = 1e-6;
static const double SHARE_APART = 0.1;

static double start_distance(const Vec3 *from, bool edges)
{
    double x[4][3];
    double weights[4];
    for (int k = 0; k < 4; k++) {
        x[k][0] = from[k].x;
        x[k][1] = from[k].y;
        x[k][2] = from[k].z;
    }
    return edges ? percale_edge_edge_closest((const double(*)[3])x, weights)
                 : percale_vertex_face_closest((const double(*)[3])x, weights);
}

/// Whether two features may have touched on their ways; of those that overlap at the start, whether they
/// pass.
static bool may_touch(const Vec3 *from, const Vec3 *to, bool edges, PercalePassage *passage)
{
    PercaleImpact touch;
    PercaleImpact near;
    bool (*impact_time)(const Vec3 *, const Vec3 *, double, PercaleImpact *) =
        edges ? percale_edge_edge_impact_time : percale_vertex_face_impact_time;
    if (!impact_time(from, to, 0.0, &touch)) {
        return false;
    }
    double apart = fmin(APART, SHARE_APART * start_distance(from, edges));
    const PercaleImpact *impact = impact_time(from, to, apart, &near) ? &near : &touch;
    if (!(vdot(impact->normal, impact->normal) > 0.0)) {
        return edges ? percale_edges_pass(from, to, passage) : percale_vertex_passes(from, to, passage);
    }
    passage->time = impact->time;
    passage->normal = impact->normal;
    memcpy(passage->weights, impact->weights, sizeof(passage->weights));
    return true;
}

static bool has_passed(const PercalePairGuardStage *stage, const Vec3 *from, const Vec3 *to, bool edges,
                       PercalePassage *passage)
{
    if (stage->exact) {
        return may_touch(from, to, edges, passage);
    }
    return edges ? percale_edges_pass(from, to, passage) : percale_vertex_passes(from, to, passage);
}

/// Back to the side that it came from, a little less far than it was, if that is far enough.
static void add_push(PercaleCollector *collector, const uint32_t points[4], const Vec3 *from,
                     const PercalePassage *passage, bool edges, double most)
{
    double gap = vdot(passage->normal, weigh_points(from, passage->weights));
    PercaleStencil stencil = {.normal =
                                  f32x4_of(passage->normal, (float)fmax(KEPT * fmin(gap, most), LEAST_KEPT))};
    memcpy(stencil.points, points, sizeof(stencil.points));
    percale_stencil_weigh(&stencil, passage->weights, edges);
    percale_collect_stencil(collector, &stencil);
}

/// Outward normal of an obstacle's vertex or edge at the end of the substep; zero where no face is.
static Vec3 outward_of(const PercalePassing *passing, uint32_t item)
{
    const PercaleModelSurface *mesh = passing->mesh;
    PercaleSurface surface = {mesh, NULL, passing->stage->model->predicted, NULL};
    if (passing->of_edges) {
        uint32_t side = mesh->edges.sides[mesh->edges.first_side[item]];
        return percale_surface_normal(&surface, side / 3, (PercaleRegion)(REGION_SIDE_0 + side % 3));
    }
    uint32_t first = mesh->vertex_first_face[item];
    if (first == mesh->vertex_first_face[item + 1]) {
        return vec3(0.0, 0.0, 0.0);
    }
    uint32_t face = mesh->vertex_faces[first];
    uint32_t corner = 0;
    while (mesh->triangles[3 * (size_t)face + corner] != mesh->first_point + item) {
        corner++;
    }
    return percale_surface_normal(&surface, face, (PercaleRegion)(REGION_CORNER_0 + corner));
}

/// Whether the cloth passes a feature of an obstacle from behind: through an open one that is a free way, out
/// of a closed one the only way.
static bool comes_from_behind(const PercalePassing *passing, uint32_t item, const PercalePassage *passage)
{
    if (passing->mesh == &passing->stage->model->cloth) {
        return false;
    }
    Vec3 outward = outward_of(passing, item);
    return !(vdot(outward, outward) > 0.0) || vdot(passage->normal, outward) > 0.0;
}

/// Whether a feature of the cloth is held between obstacles: there is no holding it back from them.
static bool is_pinched(const PercalePassing *passing, const uint32_t *corners)
{
    const uint8_t *pinched = passing->stage->is_pinched;
    return pinched != NULL && passing->mesh != &passing->stage->model->cloth &&
           percale_pinched_any(pinched, PINCH_HELD, corners, passing->of_edges ? 2 : 3);
}

static bool is_free(const PercalePassing *passing, const PercaleFeaturePair *pair)
{
    const PercaleNoteList *known = passing->stage->known;
    const PercaleReleases *releases = passing->stage->releases;
    if (passing->mesh != &passing->stage->model->cloth) {
        return false;
    }
    return (known != NULL && percale_pairs_are_free(known, passing->of_edges, pair->item, pair->primitive)) ||
           (releases != NULL && are_released(releases, pair->points, passing->of_edges ? 2 : 1, pair->corners,
                                             passing->of_edges ? 2 : 3));
}

void percale_passing_ask(const PercalePassing *passing, PercaleCollector *collector,
                         const PercaleFeaturePair *pair)
{
    const PercaleModel *model = passing->stage->model;
    bool edges = passing->of_edges;
    const uint32_t *corners = pair->corners;
    uint32_t points[4] = {pair->points[0], edges ? pair->points[1] : corners[0], corners[edges ? 0 : 1],
                          corners[edges ? 1 : 2]};
    if (!percale_candidates_collide(passing->stage->candidates, points[0], corners[0]) ||
        is_free(passing, pair) || is_pinched(passing, corners)) {
        return;
    }
    Vec3 from[4];
    Vec3 to[4];
    for (int k = 0; k < 4; k++) {
        from[k] = vec3_of(model->position[points[k]]);
        to[k] = vec3_of(model->predicted[points[k]]);
    }
    PercalePassage passage;
    if (has_passed(passing->stage, from, to, edges, &passage) &&
        !comes_from_behind(passing, pair->item, &passage)) {
        add_push(collector, points, from, &passage, edges, passing->reach);
    }
}

// ---- of the candidates ----

/// The candidates of one kind of item.
typedef struct Kind {
    PercalePassing passing;
    PercaleVisiting visiting;
} Kind;

static void find_passing(const void *context, PercaleCollector *collector, const PercaleQuery *query,
                         uint32_t place, uint32_t item)
{
    (void)place;
    const Kind *kind = context;
    const PercaleNeighborhood *hood = &kind->visiting.hood;
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        uint32_t primitive = collector->neighbors.items[i].index;
        PercaleFeaturePair pair = {item, primitive, query->points,
                                   hood->primitives + (size_t)hood->arity * primitive};
        percale_passing_ask(&kind->passing, collector, &pair);
    }
}

static void find_items(const void *context, PercaleCollector *collector, uint64_t first, uint64_t end)
{
    const Kind *kind = context;
    percale_candidates_visit(&kind->visiting, collector, first, end);
}

bool percale_passages_find(const PercalePairGuardStage *stage, const uint8_t *touched,
                           PercalePairGuardCounts *counts)
{
    PercaleCandidates *candidates = stage->candidates;
    double reach = (double)percale_candidates_least_reach(candidates);
    PercaleCandidateStage needed = {.from = stage->model->position,
                                    .to = stage->model->predicted,
                                    .again = touched != NULL,
                                    .spare = (float)reach,
                                    .collectors = stage->collectors,
                                    .memory = stage->memory,
                                    .team = stage->team};
    bool complete = percale_candidates_keep(candidates, &needed, &counts->candidates);
    stage->passing->count = 0;
    PercaleCollected to = {.stencils = stage->passing};
    for (uint32_t i = 0; complete && i < candidates->list_count; i++) {
        const PercaleCandidateList *list = &candidates->lists[i];
        Kind kind = {
            {stage, list->mesh, i % 2 == 1, reach},
            {candidates, i, percale_candidates_hood(candidates, i), touched, false, find_passing, &kind}};
        kind.visiting.hood.only_passing = true;
        complete = percale_collect(stage->team, percale_candidate_count(list), find_items, &kind,
                                   stage->collectors, stage->memory, &to);
        counts->candidates += stage->collectors->candidates;
    }
    for (uint32_t o = 0; complete && stage->obstacles && o < stage->model->obstacle_count; o++) {
        complete = percale_flat_passages_find(stage, o, touched, reach);
        counts->candidates += stage->collectors->candidates;
    }
    return complete;
}
