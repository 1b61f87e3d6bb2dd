// Which features of the cloth become pairs: against all pairs; times at which four points are in a plane;
// ways on the rest shape.

#include "detect/coplanar.h"
#include "pairs_testing.h"
#include "percale/geometry.h"

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

/// All features of a triangle that are closest; their number.
static int closest_of(const PercaleModel *model, uint32_t vertex, const uint32_t *t,
                      PercaleClosest closest[CLOSEST_MOST])
{
    const Vec3 x[4] = {at(model, vertex), at(model, t[0]), at(model, t[1]), at(model, t[2])};
    closest[0] = percale_closest_on_triangle(x[0], x[1], x[2], x[3]);
    return percale_closest_features(x[0], x[1], x[2], x[3], closest);
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
    for (uint32_t t = 0; t < model->cloth.triangle_count; t++) {
        const uint32_t *corners = (model->cloth.triangles + 3 * (size_t)t);
        bool around = true;
        for (int k = 0; k < 3; k++) {
            around = around && (pair->b[k] == UINT32_MAX || has(corners, pair->b[k]));
        }
        if (!around) {
            continue;
        }
        PercaleClosest closest[CLOSEST_MOST];
        int count = closest_of(model, pair->a[0], corners, closest);
        Pair sorted = *pair;
        sort_points(sorted.b);
        bool says = false;
        for (int i = 0; i < count; i++) {
            Pair here = feature_pair(pair->a[0], corners, closest[i].region);
            sort_points(here.b);
            says = says || memcmp(here.b, sorted.b, sizeof(here.b)) == 0;
        }
        if (has(corners, pair->a[0]) || !says) {
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

/// Six times the volume of the tetrahedron of a triangle and a point; below rounding it is nothing.
static int side_of(Vec3 a, Vec3 b, Vec3 c, Vec3 point)
{
    const double ROUNDED = 1e-18; // m^3
    double volume = vdot(vsub(point, a), vcross(vsub(b, a), vsub(c, a)));
    return (volume > ROUNDED) - (volume < -ROUNDED);
}

static bool do_cross(const PercaleModel *model, const uint32_t *edge, const uint32_t *t)
{
    Vec3 p = at(model, edge[0]);
    Vec3 q = at(model, edge[1]);
    int counts[2] = {0, 0}; // of sides that the edge passes on their left, and right
    for (uint32_t k = 0; k < 3; k++) {
        int turn = side_of(p, q, at(model, t[k]), at(model, t[next_corner(k)]));
        counts[0] += turn >= 0;
        counts[1] += turn <= 0;
    }
    bool apart = side_of(at(model, t[0]), at(model, t[1]), at(model, t[2]), p) *
                     side_of(at(model, t[0]), at(model, t[1]), at(model, t[2]), q) <
                 0;
    return apart && (counts[0] == 3 || counts[1] == 3) && !has(t, edge[0]) && !has(t, edge[1]);
}

/// A vertex and a face begin crossed where an edge from the vertex goes through the face.
static bool are_vertex_and_face_crossed(const PercaleModel *model, uint32_t vertex, const uint32_t *t)
{
    const PercaleEdges *edges = &model->cloth.edges;
    bool crossed = false;
    for (uint32_t e = 0; e < edges->edge_count; e++) {
        const uint32_t *edge = edges->vertices[e];
        crossed = crossed || ((edge[0] == vertex || edge[1] == vertex) && do_cross(model, edge, t));
    }
    return crossed;
}

/// Two edges do where one goes through a face that the other is a side of.
static bool are_edges_crossed(const PercaleModel *model, const uint32_t *a, const uint32_t *b)
{
    bool crossed = false;
    for (uint32_t i = 0; i < model->cloth.triangle_count; i++) {
        const uint32_t *t = (model->cloth.triangles + 3 * (size_t)i);
        crossed = crossed || (has(t, a[0]) && has(t, a[1]) && do_cross(model, b, t)) ||
                  (has(t, b[0]) && has(t, b[1]) && do_cross(model, a, t));
    }
    return crossed;
}

enum { SLOTS = SHEETS * SIDE * SIDE };

/// Shortest ways along edges at rest between all slots, m (Floyd and Warshall).
typedef struct Ways {
    double between[SLOTS][SLOTS];
} Ways;

static void find_ways(const PercaleModel *model, Ways *ways)
{
    ck_assert_uint_eq(model->slot_count, SLOTS);
    for (int a = 0; a < SLOTS; a++) {
        for (int b = 0; b < SLOTS; b++) {
            ways->between[a][b] = a == b ? 0.0 : HUGE_VAL;
        }
    }
    for (uint32_t e = 0; e < model->edge_count; e++) {
        uint32_t a = slot_at(model->edges[e][0]);
        uint32_t b = slot_at(model->edges[e][1]);
        ways->between[a][b] = ways->between[b][a] = (double)model->edge_lengths[e];
    }
    for (int k = 0; k < SLOTS; k++) {
        for (int a = 0; a < SLOTS; a++) {
            for (int b = 0; b < SLOTS; b++) {
                ways->between[a][b] = fmin(ways->between[a][b], ways->between[a][k] + ways->between[k][b]);
            }
        }
    }
}

/// Reach of a pair: one and a half times its thickness, which is half the way between its features at most.
static double reach_of(const PercaleModel *model, const Ways *ways, const Pair *pair)
{
    double nearest = HUGE_VAL;
    for (int i = 0; i < 3 && pair->a[i] != UINT32_MAX; i++) {
        for (int k = 0; k < 3 && pair->b[k] != UINT32_MAX; k++) {
            nearest = fmin(nearest, ways->between[pair->a[i]][pair->b[k]]);
        }
    }
    return 1.5 * fmin((double)model->cloths[0].thickness, 0.5 * nearest);
}

/// Features of a triangle that the vertex is in reach of.
static void list_features(const PercaleModel *model, uint32_t vertex, uint32_t t, const Ways *ways,
                          Found *found, PairList *list)
{
    PercaleSurface surface = {&model->cloth, NULL, model->predicted, NULL};
    const uint32_t *corners = (model->cloth.triangles + 3 * (size_t)t);
    PercaleClosest closest[CLOSEST_MOST];
    int count = closest_of(model, vertex, corners, closest);
    for (int i = 0; i < count; i++) {
        Pair pair = feature_pair(vertex, corners, closest[i].region);
        double reach = reach_of(model, ways, &pair);
        bool crossed =
            closest[i].region == REGION_FACE && are_vertex_and_face_crossed(model, vertex, corners);
        if (!crossed && closest[i].distance2 <= reach * reach && closest[i].distance2 >= MEETING * MEETING &&
            all_agree(model, &pair) && !belongs_to_other(model, &pair) &&
            is_new(found, percale_surface_feature_key(&surface, t, closest[i].region))) {
            add_pair(list, without_nothing(vertex, corners, &closest[i]));
        }
    }
}

static void list_vertex_pairs(const PercaleModel *model, const Ways *ways, PairList *list)
{
    for (uint32_t vertex = 0; vertex < model->slot_count; vertex++) {
        Found found;
        found.count = 0;
        for (uint32_t t = 0; t < model->cloth.triangle_count; t++) {
            if (!has((model->cloth.triangles + 3 * (size_t)t), vertex)) {
                list_features(model, vertex, t, ways, &found, list);
            }
        }
    }
}

static void list_edge_pairs(const PercaleModel *model, const Ways *ways, PairList *list)
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
            const Pair pair = {{a[0], a[1], UINT32_MAX}, {b[0], b[1], UINT32_MAX}};
            if (inside && distance >= MEETING && distance <= reach_of(model, ways, &pair) &&
                !are_edges_crossed(model, a, b)) {
                add_pair(list, pair);
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
        if (vlength(between) >= MEETING) {
            add_pair(list, pair);
        }
    }
}

/// Two crumpled sheets in one place; sometimes flat on a grid, so that features are parallel or in a line.
static void crumple(PercaleModel *model, bool on_grid, uint64_t *seed)
{
    for (uint32_t i = 0; i < model->slot_count; i++) {
        f32x4 x = model->position[i];
        for (int axis = 0; axis < 3; axis++) {
            double random = 2.0 * percale_test_random(seed) - 1.0;
            double step = (double)WIDTH / (4.0 * (SIDE - 1));
            x[axis] += (float)(on_grid ? step * floor(2.0 * random) : 0.03 * random);
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
    const PercaleModel *model = &solver->model;
    const PercaleNoteList none = {0};
    PercalePairCounts counts = percale_test_find_pairs(solver, &none, false, NULL);
    list->count = 0;
    list_stencils(model, &solver->stencils, list);
    qsort(list->items, list->count, sizeof(Pair), by_points);
    ck_assert_uint_eq(counts.vertex_face + counts.edge_edge, solver->stencils.count);
}

/// Two in one place, whose edges are a little shorter at rest.
static void add_sheets(PercaleSolver *solver, float thickness)
{
    PercaleMesh mesh = percale_test_sheet(SIDE, WIDTH);
    PercaleMesh rest = percale_test_sheet(SIDE, 0.97f * WIDTH);
    PercaleClothDef def = percale_test_cloth_def(&mesh);
    def.rest_positions = rest.positions;
    def.material.thickness = thickness;
    for (int s = 0; s < SHEETS; s++) {
        PercaleCloth cloth;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    }
    PERCALE_TEST_OK(solver, percale_solver_prepare(solver));
    percale_mesh_free(&mesh);
    percale_mesh_free(&rest);
}

/// Of thin sheets, and of some that are thicker than their edges are long; these not on a grid, where too
/// many edges are parallel: it is rounding then that says where they are closest.
START_TEST(pairs_are_those_of_all_pairs)
{
    enum { ROUNDS = PERCALE_SANITIZED ? 30 : 500 };
    static const float THICKNESSES[] = {0.0f, 0.03f}; // m; 0: the default
    PairList *found = malloc(sizeof(*found));
    PairList *expected = malloc(sizeof(*expected));
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    add_sheets(solver, THICKNESSES[_i]);
    solver->candidates.margin = 0.0f; // nothing but what is within reach
    Ways *ways = malloc(sizeof(*ways));
    find_ways(&solver->model, ways);
    PercaleModel *model = &solver->model;
    f32x4 *flat = malloc(model->slot_count * sizeof(f32x4));
    memcpy(flat, model->position, model->slot_count * sizeof(f32x4));
    uint64_t seed = 7;
    uint64_t total = 0;
    for (int round = 0; round < ROUNDS; round++) {
        memcpy(model->position, flat, model->slot_count * sizeof(f32x4));
        crumple(model, _i == 0 && round % 4 == 0, &seed);
        find_pairs(solver, found);
        expected->count = 0;
        list_vertex_pairs(model, ways, expected);
        list_edge_pairs(model, ways, expected);
        qsort(expected->items, expected->count, sizeof(Pair), by_points);
        compare(found, expected, round);
        total += expected->count;
    }
    ck_assert_uint_gt(total, 20 * (uint64_t)ROUNDS);
    memcpy(model->position, flat, model->slot_count * sizeof(f32x4));
    free(flat);
    free(found);
    free(expected);
    free(ways);
    percale_solver_destroy(solver);
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
    tcase_set_tags(pairs, PERCALE_ONE_THREAD);
    tcase_set_timeout(pairs, 0);
    tcase_add_loop_test(pairs, pairs_are_those_of_all_pairs, 0, 2);
    tcase_add_test(pairs, at_the_times_found_the_volume_is_zero_and_between_them_it_keeps_its_sign);
    tcase_add_test(pairs, points_that_only_move_along_have_no_time);
    tcase_add_test(pairs, near_slots_are_those_within_the_radius_along_edges);
    tcase_add_test(pairs, where_too_many_are_near_the_radius_shrinks);
    suite_add_tcase(suite, pairs);
    return percale_test_run(suite);
}
