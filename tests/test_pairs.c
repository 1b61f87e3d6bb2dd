// Which features of the cloth become pairs: against all pairs; times at which four points are in a plane;
// ways on the rest shape.

#include "detect/coplanar.h"
#include "detect/pairs.h"
#include "percale/geometry.h"
#include "solver.h"
#include "testing.h"

#include <stdlib.h>
#include <string.h>

// ---- the pair list ----

enum { SIDE = 5, SHEETS = 2, MOST_PAIRS = 1 << 14 };
static const float WIDTH = 0.1f;    // m
static const double MEETING = 1e-7; // m; features this near have no direction between them that two formulas
                                    // agree on

/// A pair of features as the points of its first and its second one, ascending, UINT32_MAX after them.
typedef struct Pair {
    uint32_t a[3], b[3];
} Pair;

typedef struct PairList {
    Pair items[MOST_PAIRS];
    uint32_t count;
} PairList;

static void sort_points(uint32_t points[3])
{
    for (int i = 1; i < 3; i++) {
        for (int k = i; k > 0 && points[k - 1] > points[k]; k--) {
            uint32_t swapped = points[k];
            points[k] = points[k - 1];
            points[k - 1] = swapped;
        }
    }
}

/// Two edges and two vertices have no order: the smaller comes first.
static void add_pair(PairList *list, Pair pair)
{
    sort_points(pair.a);
    sort_points(pair.b);
    bool alike = (pair.a[1] == UINT32_MAX) == (pair.b[1] == UINT32_MAX) && pair.b[2] == UINT32_MAX;
    if (alike && memcmp(pair.a, pair.b, sizeof(pair.a)) > 0) {
        pair = (Pair){{pair.b[0], pair.b[1], pair.b[2]}, {pair.a[0], pair.a[1], pair.a[2]}};
    }
    ck_assert_uint_lt(list->count, MOST_PAIRS);
    list->items[list->count++] = pair;
}

static int by_points(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(Pair));
}

static Vec3 at(const PercaleModel *model, uint32_t point)
{
    return vec3_of(model->predicted[point]);
}

static PercaleClosest closest_of(const PercaleModel *model, uint32_t vertex, const uint32_t *t)
{
    return percale_closest_on_triangle(at(model, vertex), at(model, t[0]), at(model, t[1]), at(model, t[2]));
}

/// Which corners of a triangle its closest point belongs to: all, two or one.
static Pair feature_pair(uint32_t vertex, const uint32_t *t, PercaleRegion region)
{
    Pair pair = {{vertex, UINT32_MAX, UINT32_MAX}, {t[0], t[1], t[2]}};
    if (region >= REGION_CORNER_0) {
        pair.b[0] = t[region - REGION_CORNER_0];
        pair.b[1] = pair.b[2] = UINT32_MAX;
    } else if (region != REGION_FACE) {
        pair.b[0] = t[region - REGION_SIDE_0];
        pair.b[1] = t[(region - REGION_SIDE_0 + 1) % 3];
        pair.b[2] = UINT32_MAX;
    }
    return pair;
}

static bool has(const uint32_t *t, uint32_t vertex)
{
    return t[0] == vertex || t[1] == vertex || t[2] == vertex;
}

/// Whether each triangle around the feature says that the vertex is in its region; without those of the
/// vertex itself.
static bool all_agree(const PercaleModel *model, const Pair *pair)
{
    for (uint32_t t = 0; t < model->triangle_count; t++) {
        const uint32_t *corners = model->triangles[t];
        bool around = true;
        for (int k = 0; k < 3; k++) {
            around = around && (pair->b[k] == UINT32_MAX || has(corners, pair->b[k]));
        }
        if (!around) {
            continue;
        }
        Pair here = feature_pair(pair->a[0], corners, closest_of(model, pair->a[0], corners).region);
        sort_points(here.b);
        Pair sorted = *pair;
        sort_points(sorted.b);
        if (has(corners, pair->a[0]) || memcmp(here.b, sorted.b, sizeof(here.b)) != 0) {
            return false;
        }
    }
    return true;
}

/// The pair as its stencil shows it: a corner whose weight rounds to nothing is not there.
static Pair without_nothing(uint32_t vertex, const uint32_t *t, const PercaleClosest *closest)
{
    Pair pair = {{vertex, UINT32_MAX, UINT32_MAX}, {UINT32_MAX, UINT32_MAX, UINT32_MAX}};
    float weights[3];
    int count = 0;
    quantize_weights(closest->weights, weights);
    for (int k = 0; k < 3; k++) {
        if (weights[k] > 0.0f) {
            pair.b[count++] = t[k];
        }
    }
    return pair;
}

/// Features that a vertex has found: each triangle around one finds it.
typedef struct Found {
    uint64_t keys[MOST_PAIRS];
    uint32_t count;
} Found;

static bool is_new(Found *found, uint64_t key)
{
    for (uint32_t i = 0; i < found->count; i++) {
        if (found->keys[i] == key) {
            return false;
        }
    }
    found->keys[found->count++] = key;
    return true;
}

/// A pair of vertices that see each other belongs to the first.
static bool belongs_to_other(const PercaleModel *model, const Pair *pair)
{
    Pair turned = {{pair->b[0], UINT32_MAX, UINT32_MAX}, {pair->a[0], UINT32_MAX, UINT32_MAX}};
    return pair->b[1] == UINT32_MAX && pair->b[0] < pair->a[0] && all_agree(model, &turned);
}

static void list_vertex_pairs(const PercaleModel *model, double reach, PairList *list)
{
    PercaleSurface surface = {&model->cloth, NULL, model->predicted};
    for (uint32_t vertex = 0; vertex < model->slot_count; vertex++) {
        Found found;
        found.count = 0;
        for (uint32_t t = 0; t < model->triangle_count; t++) {
            const uint32_t *corners = model->triangles[t];
            if (has(corners, vertex)) {
                continue;
            }
            PercaleClosest closest = closest_of(model, vertex, corners);
            Pair pair = feature_pair(vertex, corners, closest.region);
            if (closest.distance2 > reach * reach || !all_agree(model, &pair) ||
                belongs_to_other(model, &pair) ||
                !is_new(&found, percale_surface_feature_key(&surface, t, closest.region))) {
                continue;
            }
            Pair shown = without_nothing(vertex, corners, &closest);
            if (shown.b[2] != UINT32_MAX || closest.distance2 >= MEETING * MEETING) {
                add_pair(list, shown);
            }
        }
    }
}

static void list_edge_pairs(const PercaleModel *model, double reach, PairList *list)
{
    const PercaleEdges *edges = &model->cloth.edges;
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        for (uint32_t f = e + 1; f < edges->edge_count; f++) {
            const uint32_t *a = edges->vertices[e];
            const uint32_t *b = edges->vertices[f];
            if (a[0] == b[0] || a[0] == b[1] || a[1] == b[0] || a[1] == b[1]) {
                continue;
            }
            double x[4][3];
            double weights[4];
            for (int k = 0; k < 4; k++) {
                Vec3 p = at(model, k < 2 ? a[k] : b[k - 2]);
                x[k][0] = p.x;
                x[k][1] = p.y;
                x[k][2] = p.z;
            }
            double distance = percale_edge_edge_closest((const double(*)[3])x, weights);
            bool inside = weights[0] > 1e-6 && weights[1] > 1e-6 && weights[2] < -1e-6 && weights[3] < -1e-6;
            if (inside && distance >= MEETING && distance <= reach) {
                add_pair(list, (Pair){{a[0], a[1], UINT32_MAX}, {b[0], b[1], UINT32_MAX}});
            }
        }
    }
}

/// Features of a stencil: the points with weight of either sign.
static void list_stencils(const PercaleModel *model, const PercaleStencilList *stencils, PairList *list)
{
    for (size_t i = 0; i < stencils->count; i++) {
        const PercaleStencil *stencil = &stencils->items[i];
        Pair pair = {{UINT32_MAX, UINT32_MAX, UINT32_MAX}, {UINT32_MAX, UINT32_MAX, UINT32_MAX}};
        int counts[2] = {0, 0};
        float sum = 0.0f;
        for (int k = 0; k < 4; k++) {
            sum += stencil->weights[k];
            if (stencil->weights[k] > 0.0f) {
                pair.a[counts[0]++] = stencil->points[k];
            } else if (stencil->weights[k] < 0.0f) {
                pair.b[counts[1]++] = stencil->points[k];
            }
        }
        ck_assert(sum == 0.0f);
        Vec3 between = {0.0, 0.0, 0.0};
        for (int k = 0; k < 4; k++) {
            between = vadd(between, vscale((double)stencil->weights[k], at(model, stencil->points[k])));
        }
        if (counts[1] == 3 || vlength(between) >= MEETING) {
            add_pair(list, pair);
        }
    }
}

/// Two crumpled sheets in one place; sometimes flat on a grid, so that features are parallel or in a line.
static void crumple(PercaleModel *model, int round, uint64_t *seed)
{
    for (uint32_t i = 0; i < model->slot_count; i++) {
        f32x4 x = model->position[i];
        for (int axis = 0; axis < 3; axis++) {
            double random = 2.0 * percale_test_random(seed) - 1.0;
            double step = (double)WIDTH / (4.0 * (SIDE - 1));
            x[axis] += (float)(round % 4 == 0 ? step * floor(2.0 * random) : 0.03 * random);
        }
        model->position[i] = model->predicted[i] = x;
    }
}

static void compare(const PairList *found, const PairList *expected, int round)
{
    for (uint32_t i = 0; i < found->count && i < expected->count; i++) {
        const Pair *a = &found->items[i];
        const Pair *b = &expected->items[i];
        if (memcmp(a, b, sizeof(Pair)) != 0) {
            ck_abort_msg("round %d, pair %u: %d %d %d - %d %d %d found, %d %d %d - %d %d %d expected", round,
                         i, (int)a->a[0], (int)a->a[1], (int)a->a[2], (int)a->b[0], (int)a->b[1],
                         (int)a->b[2], (int)b->a[0], (int)b->a[1], (int)b->a[2], (int)b->b[0], (int)b->b[1],
                         (int)b->b[2]);
        }
    }
    ck_assert_uint_eq(found->count, expected->count);
}

static void find_pairs(PercaleSolver *solver, PairList *list)
{
    PercaleModel *model = &solver->model;
    PercaleNoteList none = {0};
    PercalePairCounts counts = {0};
    percale_tree_refit(&solver->cloth_tree, model->cloth.triangles, model->predicted, percale_team_alone());
    PercalePairStage stage = {.model = model,
                              .tree = &solver->cloth_tree,
                              .earlier = model->position,
                              .ahead = model->predicted,
                              .known = &none,
                              .dt = 1e-3f,
                              .cloth = true,
                              .edges = true,
                              .team = percale_team_alone()};
    solver->stencils.count = 0;
    ck_assert(percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                 &solver->notes[1], &counts));
    list->count = 0;
    list_stencils(model, &solver->stencils, list);
    qsort(list->items, list->count, sizeof(Pair), by_points);
    ck_assert_uint_eq(counts.vertex_face + counts.edge_edge, solver->stencils.count);
}

START_TEST(pairs_are_those_of_all_pairs)
{
    enum { ROUNDS = PERCALE_SANITIZED ? 30 : 1000 };
    PairList *found = malloc(sizeof(*found));
    PairList *expected = malloc(sizeof(*expected));
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh mesh = percale_test_sheet(SIDE, WIDTH);
    for (int s = 0; s < SHEETS; s++) {
        (void)percale_test_add_cloth(solver, &mesh);
    }
    PERCALE_TEST_OK(solver, percale_solver_prepare(solver));
    PercaleModel *model = &solver->model;
    f32x4 *flat = malloc(model->slot_count * sizeof(f32x4));
    memcpy(flat, model->position, model->slot_count * sizeof(f32x4));
    double reach = 2.0 * (double)model->cloths[0].thickness;
    uint64_t seed = 7;
    uint64_t total = 0;
    for (int round = 0; round < ROUNDS; round++) {
        memcpy(model->position, flat, model->slot_count * sizeof(f32x4));
        crumple(model, round, &seed);
        find_pairs(solver, found);
        expected->count = 0;
        list_vertex_pairs(model, reach, expected);
        list_edge_pairs(model, reach, expected);
        qsort(expected->items, expected->count, sizeof(Pair), by_points);
        compare(found, expected, round);
        total += expected->count;
    }
    ck_assert_uint_gt(total, 20 * (uint64_t)ROUNDS);
    memcpy(model->position, flat, model->slot_count * sizeof(f32x4));
    free(flat);
    free(found);
    free(expected);
    percale_solver_destroy(solver);
    percale_mesh_free(&mesh);
}
END_TEST

// ---- sides ----

/// Two sheets of one cell, 0.1 m wide: `face` lies level, a corner of `other` is what it meets. Times: when
/// the notes were written, at the start of the substep, at its end.
typedef struct Meeting {
    PercaleSolver *solver;
    PercaleMesh mesh;
    f32x4 *earlier;
    uint32_t corner; // of `other`: its slot
} Meeting;

static void place_other(Meeting *meeting, f32x4 *points, float x, float y, float z)
{
    const PercaleModel *model = &meeting->solver->model;
    for (uint32_t i = 0; i < model->cloths[1].vertex_count; i++) {
        const float *at = meeting->mesh.positions + 3 * (size_t)i;
        f32x4 *point = &points[model->cloths[1].slots[i]];
        // it hangs up from its first corner, steeply, so that nothing but that is near
        *point = (f32x4){x + (at[0] + 0.05f) * 0.3f, y + (at[0] + 0.05f) + (at[2] + 0.05f),
                         z + (at[2] + 0.05f) * 0.3f, (*point)[3]};
    }
}

static void open_meeting(Meeting *meeting)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    meeting->solver = percale_test_solver(def);
    meeting->mesh = percale_test_sheet(2, 0.1f);
    (void)percale_test_add_cloth(meeting->solver, &meeting->mesh);
    (void)percale_test_add_cloth(meeting->solver, &meeting->mesh);
    PERCALE_TEST_OK(meeting->solver, percale_solver_prepare(meeting->solver));
    PercaleModel *model = &meeting->solver->model;
    meeting->corner = model->cloths[1].slots[0];
    meeting->earlier = malloc(model->point_count * sizeof(f32x4));
    memcpy(meeting->earlier, model->position, model->point_count * sizeof(f32x4));
}

static void close_meeting(Meeting *meeting)
{
    place_other(meeting, meeting->solver->model.position, 0.0f, 0.0f, 0.0f);
    free(meeting->earlier);
    percale_solver_destroy(meeting->solver);
    percale_mesh_free(&meeting->mesh);
}

/// Height of the normal of the corner's stencil with a face; 0 without one.
static float push_of(Meeting *meeting, const PercaleNoteList *known)
{
    PercaleSolver *solver = meeting->solver;
    PercaleModel *model = &solver->model;
    PercalePairCounts counts = {0};
    const f32x4 *places[3] = {meeting->earlier, model->position, model->predicted};
    percale_tree_refit_swept(&solver->cloth_tree, model->cloth.triangles, places, 3, percale_team_alone());
    PercalePairStage stage = {.model = model,
                              .tree = &solver->cloth_tree,
                              .earlier = meeting->earlier,
                              .ahead = model->predicted,
                              .known = known,
                              .dt = 1e-3f,
                              .cloth = true,
                              .edges = true,
                              .team = percale_team_alone()};
    solver->stencils.count = 0;
    ck_assert(percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                 &solver->notes[1], &counts));
    for (size_t i = 0; i < solver->stencils.count; i++) {
        const PercaleStencil *stencil = &solver->stencils.items[i];
        if (stencil->points[0] == meeting->corner && stencil->weights[1] < 0.0f &&
            stencil->weights[2] < 0.0f && stencil->weights[3] < 0.0f) {
            return stencil->normal[1];
        }
    }
    return 0.0f;
}

/// The ways of the corner: where it was earlier, at the start and at the end; which way it is pushed.
static const struct {
    float x[3][2]; // level place (of x; z is 0.01) and height
    float push;
} WAYS[] = {
    {{{-0.02f, 0.003f}, {-0.02f, 0.003f}, {-0.02f, 0.001f}}, 1.0f},     // comes near from above
    {{{-0.02f, -0.003f}, {-0.02f, -0.003f}, {-0.02f, -0.001f}}, -1.0f}, // from below
    {{{-0.02f, 0.003f}, {-0.02f, 0.003f}, {-0.02f, -0.002f}}, 1.0f},    // would go through
    {{{-0.02f, -0.003f}, {-0.02f, -0.003f}, {-0.02f, 0.002f}}, -1.0f},  // too, upwards
    {{{-0.02f, 0.050f}, {-0.02f, 0.050f}, {-0.02f, -0.050f}}, 1.0f},    // far
    {{{-0.08f, 0.003f}, {-0.08f, 0.003f}, {-0.02f, -0.001f}}, 1.0f},    // through, beside the rim at first
    {{{-0.08f, 0.001f}, {-0.08f, 0.001f}, {-0.02f, -0.003f}}, -1.0f},   // around the rim
    {{{-0.02f, 0.003f}, {-0.02f, -0.002f}, {-0.02f, -0.003f}}, 1.0f},   // was pushed through in the solver
    {{{-0.02f, -0.003f}, {-0.02f, 0.002f}, {-0.02f, 0.003f}}, -1.0f},   // too, upwards
};

static void go(Meeting *meeting, const float x[3][2])
{
    PercaleModel *model = &meeting->solver->model;
    f32x4 *places[3] = {meeting->earlier, model->position, model->predicted};
    for (int i = 0; i < 3; i++) {
        place_other(meeting, places[i], x[i][0], x[i][1], 0.01f);
    }
}

START_TEST(a_vertex_keeps_the_side_that_its_path_says)
{
    const PercaleNoteList none = {0};
    for (size_t i = 0; i < sizeof(WAYS) / sizeof(WAYS[0]); i++) {
        Meeting meeting;
        open_meeting(&meeting);
        go(&meeting, WAYS[i].x);
        float push = push_of(&meeting, &none);
        ck_assert_msg(fabsf(push - WAYS[i].push) < 1e-6f, "way %zu: %g", i, (double)push);
        close_meeting(&meeting);
    }
}
END_TEST

/// What was above is still pushed up when it has been below for a while, also under the neighbouring face.
START_TEST(a_note_keeps_the_side_while_the_vertex_is_below)
{
    Meeting meeting;
    open_meeting(&meeting);
    PercaleSolver *solver = meeting.solver;
    const PercaleNoteList none = {0};
    const float through[3][2] = {{-0.02f, 0.003f}, {-0.02f, 0.003f}, {-0.02f, -0.002f}};
    const float below[3][2] = {{-0.02f, -0.002f}, {-0.02f, -0.002f}, {-0.015f, -0.002f}};
    const float beside[3][2] = {{-0.015f, -0.002f}, {-0.015f, -0.002f}, {0.03f, -0.002f}};
    const float(*const ways[3])[2] = {through, below, beside};
    for (int i = 0; i < 3; i++) {
        go(&meeting, ways[i]);
        PercaleNoteList known = solver->notes[0];
        float push = push_of(&meeting, i == 0 ? &none : &known);
        ck_assert_msg(fabsf(push - 1.0f) < 1e-6f, "step %d: %g", i, (double)push);
        solver->notes[0] = solver->notes[1];
        solver->notes[1] = known;
    }
    ck_assert(push_of(&meeting, &none) < 0.0f); // without a note it is on the side where it is
    close_meeting(&meeting);
}
END_TEST

/// Two long edges across each other, one moves through the other, or doesn't: the normal is that of the
/// start.
START_TEST(edges_keep_the_side_that_their_path_says)
{
    const float HEIGHTS[][3] = {{0.003f, 0.003f, 0.001f},
                                {0.003f, 0.003f, -0.002f},
                                {-0.003f, -0.003f, 0.002f},
                                {0.003f, -0.002f, -0.003f},
                                {0.05f, 0.05f, -0.05f}};
    const PercaleNoteList none = {0};
    for (size_t i = 0; i < sizeof(HEIGHTS) / sizeof(HEIGHTS[0]); i++) {
        Meeting meeting;
        open_meeting(&meeting);
        PercaleSolver *solver = meeting.solver;
        PercaleModel *model = &solver->model;
        f32x4 *places[3] = {meeting.earlier, model->position, model->predicted};
        for (int p = 0; p < 3; p++) {
            for (uint32_t v = 0; v < 4; v++) { // upright sheets: row 0 at the height, row 1 away from it
                const float *at = meeting.mesh.positions + 3 * (size_t)v;
                float up = at[2] > 0.0f ? 0.1f : 0.0f;
                f32x4 *low = &places[p][model->cloths[0].slots[v]];
                f32x4 *high = &places[p][model->cloths[1].slots[v]];
                *low = (f32x4){at[0], -up, 0.01f, (*low)[3]};
                *high = (f32x4){0.013f, HEIGHTS[i][p] + up, at[0], (*high)[3]};
            }
        }
        (void)push_of(&meeting, &none);
        int found = 0;
        for (size_t k = 0; k < solver->stencils.count; k++) {
            const PercaleStencil *stencil = &solver->stencils.items[k];
            bool first_is_low = model->cloth_of[stencil->points[0]] == 0;
            if (stencil->weights[1] > 0.0f &&
                model->cloth_of[stencil->points[2]] != model->cloth_of[stencil->points[0]] &&
                fabsf(stencil->normal[1]) > 0.99f) {
                float up = first_is_low ? -stencil->normal[1] : stencil->normal[1]; // of the higher edge
                ck_assert_msg(up * HEIGHTS[i][0] > 0.0f, "way %zu: %g", i, (double)up);
                found++;
            }
        }
        ck_assert_msg(found == 1, "way %zu: %d stencils", i, found);
        close_meeting(&meeting);
    }
}
END_TEST

/// A level face comes down onto a box: the box's upper corners push it up, that is themselves down.
START_TEST(corners_of_a_box_hold_a_face_above_them)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    PercaleMesh box = percale_test_box(0.02f, 0.02f, 0.02f);
    PercaleMesh sheet = percale_test_sheet(2, 0.1f);
    percale_test_translate(&box, 0.003f, -0.01f, 0.0f);
    (void)percale_test_add_obstacle(solver, &box);
    (void)percale_test_add_cloth(solver, &sheet);
    PERCALE_TEST_OK(solver, percale_solver_prepare(solver));
    PercaleModel *model = &solver->model;
    for (uint32_t slot = 0; slot < model->slot_count; slot++) {
        model->position[slot][1] = 0.003f;
        model->predicted[slot][1] = -0.001f;
    }
    const f32x4 *places[2] = {model->position, model->predicted};
    percale_tree_refit_swept(&solver->cloth_tree, model->cloth.triangles, places, 2, percale_team_alone());
    const PercaleNoteList none = {0};
    PercalePairCounts counts = {0};
    PercalePairStage stage = {.model = model,
                              .tree = &solver->cloth_tree,
                              .earlier = model->position,
                              .ahead = model->predicted,
                              .known = &none,
                              .dt = 1e-3f,
                              .edges = true,
                              .obstacles = true,
                              .team = percale_team_alone()};
    solver->stencils.count = 0;
    ck_assert(percale_pairs_find(&stage, &solver->collectors, &solver->detect_memory, &solver->stencils,
                                 &solver->notes[1], &counts));
    ck_assert_uint_eq(counts.vertex_face, 4);
    for (size_t i = 0; i < counts.vertex_face; i++) {
        const PercaleStencil *stencil = &solver->stencils.items[i];
        ck_assert(stencil->points[0] >= model->slot_count && stencil->normal[1] == -1.0f);
        ck_assert(fabsf(stencil->normal[3] - 0.0035f) < 1e-6f); // 3 mm at the start, and 0.5 m/s
    }
    percale_solver_destroy(solver);
    percale_mesh_free(&box);
    percale_mesh_free(&sheet);
}
END_TEST

// ---- four points in a plane ----

static double volume(const Vec3 from[4], const Vec3 to[4], double time)
{
    Vec3 x[4];
    for (int k = 0; k < 4; k++) {
        x[k] = vadd(from[k], vscale(time, vsub(to[k], from[k])));
    }
    return vdot(vsub(x[1], x[0]), vcross(vsub(x[2], x[0]), vsub(x[3], x[0])));
}

START_TEST(at_the_times_found_the_volume_is_zero_and_between_them_it_keeps_its_sign)
{
    enum { ROUNDS = 20000, SAMPLES = 64 };
    uint64_t seed = 11;
    int by_count[4] = {0, 0, 0, 0};
    for (int round = 0; round < ROUNDS; round++) {
        Vec3 from[4];
        Vec3 to[4];
        for (int k = 0; k < 4; k++) {
            from[k] =
                vec3(percale_test_random(&seed), percale_test_random(&seed), percale_test_random(&seed));
            to[k] = vec3(percale_test_random(&seed), percale_test_random(&seed), percale_test_random(&seed));
        }
        double times[3];
        int count = percale_coplanar_times(from, to, times);
        ck_assert_int_le(count, 3);
        by_count[count]++;
        for (int i = 0; i < count; i++) {
            ck_assert(times[i] >= 0.0 && times[i] <= 1.0 && (i == 0 || times[i] >= times[i - 1]));
            ck_assert_double_lt(fabs(volume(from, to, times[i])), 1e-12);
        }
        for (int i = 0; i <= SAMPLES; i++) {
            double time = (double)i / SAMPLES;
            int passed = 0;
            bool close = false;
            for (int k = 0; k < count; k++) {
                passed += times[k] <= time;
                close = close || fabs(times[k] - time) < 1e-9;
            }
            bool positive = (volume(from, to, 0.0) >= 0.0) == (passed % 2 == 0);
            double here = volume(from, to, time);
            ck_assert(close || fabs(here) < 1e-12 || (here > 0.0) == positive);
        }
    }
    ck_assert(by_count[0] > 1000 && by_count[1] > 1000 && by_count[2] > 1000 && by_count[3] > 100);
}
END_TEST

START_TEST(points_that_only_move_along_have_no_time)
{
    Vec3 from[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2, 0.2, 0.1}};
    Vec3 to[4];
    double times[3];
    for (int k = 0; k < 4; k++) {
        to[k] = vadd(from[k], vec3(3.0, -2.0, 5.0));
    }
    ck_assert_int_eq(percale_coplanar_times(from, to, times), 0);
    to[3].z -= 0.2; // at half the way
    ck_assert_int_eq(percale_coplanar_times(from, to, times), 1);
    ck_assert_double_eq_tol(times[0], 0.5, 1e-12);
}
END_TEST

// ---- ways on the rest shape ----

START_TEST(near_slots_are_those_within_the_radius_along_edges)
{
    enum { LONG = 12 };
    PercaleAllocator allocator = percale_allocator_default();
    PercaleMemory memory = {&allocator, 0};
    uint32_t edges[LONG - 1][2]; // a chain whose edges grow
    float lengths[LONG - 1];
    double place[LONG] = {0.0};
    for (uint32_t e = 0; e + 1 < LONG; e++) {
        edges[e][0] = e;
        edges[e][1] = e + 1;
        lengths[e] = 1.0f + 0.125f * (float)e;
        place[e + 1] = place[e] + (double)lengths[e];
    }
    const float radius = 3.5f;
    PercaleNear near;
    ck_assert(
        percale_near_build(&near, LONG, (const uint32_t(*)[2])edges, lengths, LONG - 1, radius, &memory));
    for (uint32_t a = 0; a < LONG; a++) {
        for (uint32_t b = 0; b < LONG; b++) {
            double way = fabs(place[a] - place[b]);
            float expected = way < (double)radius ? (float)way : radius;
            ck_assert(a == b || near_distance(&near, a, b) == expected);
        }
    }
    percale_near_free(&near, &memory);
    ck_assert_uint_eq(memory.bytes, 0);
}
END_TEST

START_TEST(where_too_many_are_near_the_radius_shrinks)
{
    enum { ARMS = 2 * NEAR_MOST }; // a star: all ends are as near as their arm is long
    PercaleAllocator allocator = percale_allocator_default();
    PercaleMemory memory = {&allocator, 0};
    uint32_t edges[ARMS][2];
    float lengths[ARMS];
    for (uint32_t e = 0; e < ARMS; e++) {
        edges[e][0] = 0;
        edges[e][1] = e + 1;
        lengths[e] = 1.0f + 0.001f * (float)((e * 37) % ARMS);
    }
    PercaleNear near;
    ck_assert(
        percale_near_build(&near, ARMS + 1, (const uint32_t(*)[2])edges, lengths, ARMS, 10.0f, &memory));
    ck_assert(near.radius[0] < 10.0f);
    for (uint32_t e = 0; e < ARMS; e++) { // a lower bound for all, exact within the radius
        float distance = near_distance(&near, 0, e + 1);
        ck_assert(distance == (lengths[e] < near.radius[0] ? lengths[e] : near.radius[0]));
    }
    percale_near_free(&near, &memory);
    ck_assert_uint_eq(memory.bytes, 0);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("pairs");
    TCase *pairs = tcase_create("pairs");
    tcase_set_timeout(pairs, 0);
    tcase_add_test(pairs, pairs_are_those_of_all_pairs);
    tcase_add_test(pairs, a_vertex_keeps_the_side_that_its_path_says);
    tcase_add_test(pairs, a_note_keeps_the_side_while_the_vertex_is_below);
    tcase_add_test(pairs, edges_keep_the_side_that_their_path_says);
    tcase_add_test(pairs, corners_of_a_box_hold_a_face_above_them);
    tcase_add_test(pairs, at_the_times_found_the_volume_is_zero_and_between_them_it_keeps_its_sign);
    tcase_add_test(pairs, points_that_only_move_along_have_no_time);
    tcase_add_test(pairs, near_slots_are_those_within_the_radius_along_edges);
    tcase_add_test(pairs, where_too_many_are_near_the_radius_shrinks);
    suite_add_tcase(suite, pairs);
    return percale_test_run(suite);
}
