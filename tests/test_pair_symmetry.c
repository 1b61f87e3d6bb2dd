// Pairs don't depend on how the scene is told: which way triangles wind, how vertices and triangles are
// numbered, how the scene lies in space. `test_pair_symmetry --full` tells 1,000 scenes of each kind, which
// takes minutes.

#include "detect/coplanar.h"
#include "detect/passage.h"
#include "pairs_testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// ---- one scene, told in several ways ----

// Steps of the grid are powers of two: positions on it are exact, and so are products of their differences.
enum { SIDE = 5, SHEETS = 2, SHEET = SIDE * SIDE, NAMES = SHEETS * SHEET, MOST_PAIRS = 1 << 13 };
static const float WIDTH = 0.125f;      // m
static const float STEP = 0.125f / 16;  // m; of the grid, a quarter of an edge
static const float THICKNESS = 0.0061f; // m; twice it is no distance on the grid
static const float THICK = 0.0193f;     // m; more than half the way between neighbours

/// Every vertex has a name: its number in the plain telling, over both sheets.
typedef float Places[NAMES][3];

typedef struct Telling {
    const char *what;
    bool other_windings, other_order;
    int axis; // the scene is turned by a right angle about it; -1: not
} Telling;

static const Telling TELLINGS[] = {{"plain", false, false, -1},         {"windings", true, false, -1},
                                   {"order", false, true, -1},          {"turned about x", false, false, 0},
                                   {"turned about y", false, false, 1}, {"turned about z", false, false, 2},
                                   {"all of it", true, true, 1}};
enum { TELLING_COUNT = sizeof(TELLINGS) / sizeof(TELLINGS[0]) };

typedef struct Told {
    const Telling *telling;
    PercaleSolver *solver;
    uint32_t slot_of[NAMES], name_of[NAMES];
    f32x4 *committed;
} Told;

static uint32_t random_below(uint64_t *seed, uint32_t end)
{
    return (uint32_t)(percale_test_random(seed) * (double)end);
}

static void shuffle(uint32_t *items, uint32_t count, uint64_t *seed)
{
    for (uint32_t i = count - 1; i > 0; i--) {
        uint32_t other = random_below(seed, i + 1);
        uint32_t kept = items[i];
        items[i] = items[other];
        items[other] = kept;
    }
}

static void turn(int axis, const float x[3], float turned[3])
{
    memcpy(turned, x, 3 * sizeof(float));
    if (axis >= 0) {
        turned[(axis + 1) % 3] = -x[(axis + 2) % 3];
        turned[(axis + 2) % 3] = x[(axis + 1) % 3];
    }
}

/// Adds a sheet whose vertex v has the number place[v]. Slots follow the positions, so those are anywhere;
/// the rest shape is the sheet.
static PercaleCloth add_told(PercaleSolver *solver, const Telling *telling, const uint32_t *place,
                             float thickness, uint64_t *seed)
{
    PercaleMesh flat = percale_test_sheet(SIDE, WIDTH);
    PercaleMesh mesh = percale_test_sheet(SIDE, WIDTH);
    float start[3 * SHEET];
    uint32_t order[2 * (SIDE - 1) * (SIDE - 1)];
    for (uint32_t v = 0; v < SHEET; v++) {
        memcpy(mesh.positions + 3 * (size_t)place[v], flat.positions + 3 * (size_t)v, 3 * sizeof(float));
    }
    for (uint32_t i = 0; i < 3 * SHEET; i++) {
        start[i] = telling->other_order ? (float)percale_test_random(seed) : mesh.positions[i];
    }
    for (uint32_t t = 0; t < mesh.triangle_count; t++) {
        order[t] = t;
    }
    if (telling->other_order) {
        shuffle(order, mesh.triangle_count, seed);
    }
    for (uint32_t t = 0; t < mesh.triangle_count; t++) {
        bool turned = telling->other_windings && random_below(seed, 2) == 0;
        uint32_t first = telling->other_order ? random_below(seed, 3) : 0;
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t corner = (first + (turned ? 3 - k : k)) % 3;
            mesh.triangles[3 * t + k] = place[flat.triangles[3 * order[t] + corner]];
        }
    }
    PercaleClothDef def = percale_test_cloth_def(&mesh);
    def.positions = start;
    def.rest_positions = mesh.positions;
    def.material.thickness = thickness;
    PercaleCloth cloth;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    percale_mesh_free(&flat);
    percale_mesh_free(&mesh);
    return cloth;
}

static void open_told(Told *told, const Telling *telling, float thickness)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    uint64_t seed = 3;
    uint32_t place[SHEETS][SHEET];
    told->telling = telling;
    told->solver = percale_test_solver(def);
    for (uint32_t added = 0; added < SHEETS; added++) {
        uint32_t sheet = telling->other_order ? SHEETS - 1 - added : added;
        for (uint32_t v = 0; v < SHEET; v++) {
            place[sheet][v] = v;
        }
        if (telling->other_order) {
            shuffle(place[sheet], SHEET, &seed);
        }
        (void)add_told(told->solver, telling, place[sheet], thickness, &seed);
    }
    PERCALE_TEST_OK(told->solver, percale_solver_prepare(told->solver));
    const PercaleModel *model = &told->solver->model;
    ck_assert_uint_eq(model->slot_count, NAMES);
    for (uint32_t name = 0; name < NAMES; name++) {
        uint32_t sheet = name / SHEET;
        uint32_t added = telling->other_order ? SHEETS - 1 - sheet : sheet;
        told->slot_of[name] = model->cloths[added].slots[place[sheet][name % SHEET]];
        told->name_of[told->slot_of[name]] = name;
    }
    told->committed = malloc(NAMES * sizeof(f32x4));
    memcpy(told->committed, model->position, NAMES * sizeof(f32x4));
}

static void close_told(Told *told)
{
    memcpy(told->solver->model.position, told->committed, NAMES * sizeof(f32x4));
    free(told->committed);
    percale_solver_destroy(told->solver);
}

static void put(const Told *told, f32x4 *points, Places places)
{
    for (uint32_t name = 0; name < NAMES; name++) {
        float x[3];
        turn(told->telling->axis, places[name], x);
        f32x4 *point = &points[told->slot_of[name]];
        *point = (f32x4){x[0], x[1], x[2], (*point)[3]};
    }
}

// ---- pairs by name ----

/// A pair of features: names, ascending, UINT32_MAX after them; what its stencil wants, in the plain
/// telling's space.
typedef struct Pair {
    uint32_t a[3], b[3];
    float normal[3]; // from b to a
    float target;    // m
} Pair;

typedef struct PairList {
    Pair items[MOST_PAIRS];
    uint32_t count;
} PairList;

static int by_name(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a;
    uint32_t y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

static int by_names(const void *a, const void *b)
{
    const Pair *x = a;
    const Pair *y = b;
    int order = memcmp(x->a, y->a, sizeof(x->a));
    return order != 0 ? order : memcmp(x->b, y->b, sizeof(x->b));
}

static Pair pair_of(const Told *told, const PercaleStencil *stencil)
{
    Pair pair = {.target = stencil->normal[3]};
    uint32_t names[2][3] = {{UINT32_MAX, UINT32_MAX, UINT32_MAX}, {UINT32_MAX, UINT32_MAX, UINT32_MAX}};
    int counts[2] = {0, 0};
    for (int k = 0; k < 4; k++) {
        float weight = stencil->weights[k];
        int of = weight < 0.0f;
        if (weight > 0.0f || weight < 0.0f) {
            names[of][counts[of]++] = told->name_of[stencil->points[k]];
        }
    }
    qsort(names[0], 3, sizeof(uint32_t), by_name);
    qsort(names[1], 3, sizeof(uint32_t), by_name);
    bool swapped =
        counts[0] > counts[1] || (counts[0] == counts[1] && memcmp(names[0], names[1], sizeof(names[0])) > 0);
    memcpy(pair.a, names[swapped], sizeof(pair.a));
    memcpy(pair.b, names[!swapped], sizeof(pair.b));
    float x[3] = {stencil->normal[0], stencil->normal[1], stencil->normal[2]};
    for (int quarter = 0; quarter < 3; quarter++) { // three more right angles: back again
        float turned[3];
        turn(told->telling->axis, x, turned);
        memcpy(x, turned, sizeof(x));
    }
    for (int axis = 0; axis < 3; axis++) {
        pair.normal[axis] = swapped ? -x[axis] : x[axis];
    }
    return pair;
}

/// The pairs of a pass; its notes are known to the next.
static void list_pairs(Told *told, Places places[2], PairList *list)
{
    PercaleSolver *solver = told->solver;
    put(told, solver->model.position, places[0]);
    put(told, solver->model.predicted, places[1]);
    (void)percale_test_find_pairs(solver, &solver->notes[0], false, NULL);
    PercaleNoteList written = solver->notes[1];
    solver->notes[1] = solver->notes[0];
    solver->notes[0] = written;
    ck_assert_uint_le(solver->stencils.count, MOST_PAIRS);
    list->count = (uint32_t)solver->stencils.count;
    for (uint32_t i = 0; i < list->count; i++) {
        list->items[i] = pair_of(told, &solver->stencils.items[i]);
    }
    qsort(list->items, list->count, sizeof(Pair), by_names);
}

static void print_pair(const char *what, const Pair *pair)
{
    (void)fprintf(stderr, "  %s: %d %d %d - %d %d %d, normal %g %g %g, target %g\n", what, (int)pair->a[0],
                  (int)pair->a[1], (int)pair->a[2], (int)pair->b[0], (int)pair->b[1], (int)pair->b[2],
                  (double)pair->normal[0], (double)pair->normal[1], (double)pair->normal[2],
                  (double)pair->target);
}

/// Normals and targets are rounded to float32, and their sums taken in another order.
static bool is_alike(const Pair *a, const Pair *b)
{
    const float ROUNDED = 1e-5f;
    bool alike = by_names(a, b) == 0 && fabsf(a->target - b->target) <= ROUNDED * THICKNESS;
    for (int axis = 0; axis < 3; axis++) {
        alike = alike && fabsf(a->normal[axis] - b->normal[axis]) <= ROUNDED;
    }
    return alike;
}

/// Several features around an edge or a corner may show the pair of that: any of those of its names.
static bool is_in(const PairList *list, uint32_t near, const Pair *pair)
{
    uint32_t first = near;
    while (first > 0 && by_names(&list->items[first - 1], pair) == 0) {
        first--;
    }
    bool found = false;
    for (uint32_t i = first; !found && i < list->count && by_names(&list->items[i], pair) == 0; i++) {
        found = is_alike(&list->items[i], pair);
    }
    return found;
}

static void compare(const PairList *list, const PairList *plain, const Telling *telling, int round, int pass)
{
    for (uint32_t i = 0; i < list->count && i < plain->count; i++) {
        if (!is_in(plain, i, &list->items[i]) || !is_in(list, i, &plain->items[i])) {
            print_pair(telling->what, &list->items[i]);
            print_pair("plain", &plain->items[i]);
            ck_abort_msg("round %d, pass %d, pair %u of %u: %s tells of another", round, pass, i,
                         plain->count, telling->what);
        }
    }
    ck_assert_uint_eq(list->count, plain->count);
}

// ---- where the vertices are ----

static float anywhere(uint64_t *seed, float size)
{
    return size * (float)(2.0 * percale_test_random(seed) - 1.0);
}

/// -2 .. 1 steps.
static float on_grid(uint64_t *seed)
{
    return STEP * ((float)random_below(seed, 4) - 2.0f);
}

/// Both sheets in one place.
static void lay_flat(Places places)
{
    for (uint32_t name = 0; name < NAMES; name++) {
        uint32_t column = name % SHEET % SIDE;
        uint32_t row = name % SHEET / SIDE;
        places[name][0] = WIDTH / (SIDE - 1) * (float)column - 0.5f * WIDTH;
        places[name][1] = 0.0f;
        places[name][2] = WIDTH / (SIDE - 1) * (float)row - 0.5f * WIDTH;
    }
}

static void add_random(Places places, bool gridded, float size, uint64_t *seed)
{
    for (uint32_t name = 0; name < NAMES; name++) {
        for (int axis = 0; axis < 3; axis++) {
            places[name][axis] += gridded ? on_grid(seed) : anywhere(seed, size);
        }
    }
}

/// Three passes: the first sees a scene at rest, for the others the solver has moved it, and it moves.
enum { PASSES = 3, STATES = 2 * PASSES };

/// The start and the end of each pass.
static void tell_together(Told *tellings, Places *states, PairList lists[2], int round, uint64_t *total)
{
    for (int t = 0; t < TELLING_COUNT; t++) {
        tellings[t].solver->notes[0].count = 0;
    }
    for (int pass = 0; pass < PASSES; pass++) {
        for (int t = 0; t < TELLING_COUNT; t++) {
            list_pairs(&tellings[t], states + 2 * pass, &lists[t > 0]);
            compare(&lists[t > 0], &lists[0], tellings[t].telling, round, pass);
        }
        *total += lists[0].count;
    }
}

typedef void Fill(Places *states, uint64_t *seed);

/// Scenes of a kind: the test's number 1 is the full one.
static void run_rounds(Fill *fill, float thickness, int rounds, uint64_t least, int number)
{
    enum { FULL = 1000 };
    rounds = number > 0 ? FULL : PERCALE_SANITIZED ? (rounds + 5) / 6 : rounds;
    Told *tellings = malloc(TELLING_COUNT * sizeof(Told));
    PairList *lists = malloc(2 * sizeof(PairList));
    Places *states = malloc(STATES * sizeof(Places));
    for (int t = 0; t < TELLING_COUNT; t++) {
        open_told(&tellings[t], &TELLINGS[t], thickness);
    }
    uint64_t seed = 7;
    uint64_t total = 0;
    for (int round = 0; round < rounds; round++) {
        fill(states, &seed);
        tell_together(tellings, states, lists, round, &total);
    }
    ck_assert_uint_gt(total, least * (uint64_t)rounds);
    for (int t = 0; t < TELLING_COUNT; t++) {
        close_told(&tellings[t]);
    }
    free(tellings);
    free(lists);
    free(states);
}

static void fill_states(Places *states, bool gridded, float first, float later, uint64_t *seed)
{
    lay_flat(states[0]);
    add_random(states[0], gridded, first, seed);
    memcpy(states[1], states[0], sizeof(Places));
    for (int i = 2; i < STATES; i++) {
        memcpy(states[i], states[i - 1], sizeof(Places));
        add_random(states[i], gridded, later, seed);
    }
}

static void fill_crumpled(Places *states, uint64_t *seed)
{
    fill_states(states, false, 0.03f, 0.01f, seed);
}

START_TEST(crumpled_sheets_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_crumpled, THICKNESS, 60, 60, _i);
}
END_TEST

/// Sheets that are free of each other at first, and of themselves; then they go through each other.
static void fill_passing(Places *states, uint64_t *seed)
{
    const float APART = 0.01f; // m
    lay_flat(states[0]);
    for (uint32_t name = SHEET; name < NAMES; name++) {
        states[0][name][1] += APART;
    }
    add_random(states[0], false, 0.3f * APART, seed);
    memcpy(states[1], states[0], sizeof(Places));
    for (int i = 2; i < STATES; i++) {
        memcpy(states[i], states[i - 1], sizeof(Places));
        add_random(states[i], false, APART, seed);
    }
}

START_TEST(sheets_that_pass_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_passing, THICKNESS, 60, 200, _i);
}
END_TEST

/// Pairs of the same neighbourhood keep less than the thickness.
START_TEST(thick_sheets_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_passing, THICK, 15, 200, _i);
}
END_TEST

/// Coincident points, parallel and crossing edges, vertices in the plane, over an edge or a vertex of what
/// they meet, triangles without area: all at once, and exactly.
static void fill_gridded(Places *states, uint64_t *seed)
{
    fill_states(states, true, 0.0f, 0.0f, seed);
}

START_TEST(sheets_on_a_grid_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_gridded, THICKNESS, 60, 60, _i);
}
END_TEST

/// One flat sheet over, in or below the other; as a whole they move by steps of the grid.
static void fill_flat(Places *states, uint64_t *seed)
{
    lay_flat(states[0]);
    for (int i = 0; i < STATES; i++) {
        float moved[3];
        for (int axis = 0; axis < 3; axis++) {
            moved[axis] = axis == 1 ? 0.25f * on_grid(seed) : on_grid(seed);
        }
        if (i > 0) {
            memcpy(states[i], states[i - 1], sizeof(Places));
        }
        for (uint32_t name = SHEET; i != 1 && name < NAMES; name++) {
            for (int axis = 0; axis < 3; axis++) {
                states[i][name][axis] += moved[axis];
            }
        }
    }
}

START_TEST(flat_sheets_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_flat, THICKNESS, 60, 20, _i);
}
END_TEST

/// Crumpled, with points in each other's places.
static void fill_collapsed(Places *states, uint64_t *seed)
{
    fill_crumpled(states, seed);
    for (int i = 0; i < NAMES / 4; i++) {
        uint32_t from = random_below(seed, NAMES);
        uint32_t to = random_below(seed, NAMES);
        for (int state = 0; state < STATES; state++) {
            memcpy(states[state][to], states[state][from], sizeof(states[0][0]));
        }
    }
}

START_TEST(collapsed_sheets_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_collapsed, THICKNESS, 60, 60, _i);
}
END_TEST

/// Halfway through a pass some edges have no length, and some triangles two corners in one place, as
/// neighbours change places.
static void fill_swapped(Places *states, uint64_t *seed)
{
    fill_gridded(states, seed);
    for (int i = 2; i < STATES; i += 2) {
        for (uint32_t name = 0; name + 1 < NAMES; name += 2) {
            memcpy(states[i + 1][name], states[i][name + 1], sizeof(states[0][0]));
            memcpy(states[i + 1][name + 1], states[i][name], sizeof(states[0][0]));
        }
    }
}

START_TEST(sheets_whose_edges_turn_over_have_the_same_pairs_however_they_are_told)
{
    run_rounds(fill_swapped, THICKNESS, 20, 60, _i);
}
END_TEST

// ---- passages ----

typedef bool Passes(const Vec3 *from, const Vec3 *to, PercalePassage *passage);

/// A vertex and a triangle, from each corner and both ways round; two edges, from all ends.
static const int FACE_ORDERS[][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                     {0, 1, 3, 2}, {0, 3, 2, 1}, {0, 2, 1, 3}};
static const int EDGE_ORDERS[][4] = {{0, 1, 2, 3}, {1, 0, 2, 3}, {0, 1, 3, 2}, {1, 0, 3, 2},
                                     {2, 3, 0, 1}, {3, 2, 0, 1}, {2, 3, 1, 0}, {3, 2, 1, 0}};
enum { FACE_ORDER_COUNT = 6, EDGE_ORDER_COUNT = 8 };

/// In a plane at one time; that is or is no passage, in whatever order the points are given.
static void expect_passage(bool edges, const Vec3 from[4], const Vec3 to[4], double time, bool expected)
{
    Passes *passes = edges ? percale_edges_pass : percale_vertex_passes;
    for (int i = 0; i < (edges ? EDGE_ORDER_COUNT : FACE_ORDER_COUNT); i++) {
        const int *order = edges ? EDGE_ORDERS[i] : FACE_ORDERS[i];
        Vec3 a[4];
        Vec3 b[4];
        double times[3];
        for (int k = 0; k < 4; k++) {
            a[k] = from[order[k]];
            b[k] = to[order[k]];
        }
        PercalePassage passage;
        ck_assert_int_eq(percale_coplanar_times(a, b, times), 1);
        ck_assert_msg(fabs(times[0] - time) < 1e-12, "order %d: at %.17g", i, times[0]);
        ck_assert_msg(passes(a, b, &passage) == expected, "order %d", i);
    }
}

/// Halfway the triangle is a line, far from the vertex.
START_TEST(a_vertex_does_not_pass_a_triangle_that_turns_over_edge_on)
{
    const Vec3 from[4] = {{-1, -4, 4}, {-6, -6, 3}, {-6, -1, 6}, {-6, 1, 6}};
    const Vec3 to[4] = {{-2, -4, 5}, {-8, -6, 4}, {-8, -1, 6}, {-8, -1, 7}};
    expect_passage(false, from, to, 0.5, false);
}
END_TEST

/// After a third of the way two corners are in one place.
START_TEST(a_vertex_does_not_pass_a_triangle_whose_corners_pass_each_other)
{
    const Vec3 from[4] = {{-5, -2, -4}, {-2, -1, -5}, {-4, -3, -4}, {-4, -3, -3}};
    const Vec3 to[4] = {{-5, -2, -4}, {-1, 0, -6}, {-5, -5, -3}, {-5, -5, -5}};
    expect_passage(false, from, to, 1.0 / 3.0, false);
}
END_TEST

/// Halfway one of them has no length, far from the other.
START_TEST(an_edge_that_turns_over_end_to_end_passes_none)
{
    const Vec3 from[4] = {{3, -1, -2}, {4, 0, -3}, {6, -1, -2}, {3, 0, 4}};
    const Vec3 to[4] = {{3, 0, -3}, {2, -1, -2}, {6, 0, -4}, {2, -1, 4}};
    expect_passage(true, from, to, 0.5, false);
}
END_TEST

/// An end of each is in the same place halfway, where they are three times in a plane.
START_TEST(edges_pass_at_a_time_that_is_three_in_one)
{
    const Vec3 from[4] = {{-1, -2, -3}, {-3, -1, -4}, {-2, -2, -2}, {-5, -2, 0}};
    const Vec3 to[4] = {{-3, -1, -3}, {-5, -2, -3}, {-2, -1, -4}, {-4, -1, -1}};
    expect_passage(true, from, to, 0.5, true);
}
END_TEST

int main(int argc, char **argv)
{
    bool full = argc > 1 && strcmp(argv[1], "--full") == 0;
    const int first = full ? 1 : 0;
    const TTest *tests[] = {crumpled_sheets_have_the_same_pairs_however_they_are_told,
                            sheets_that_pass_have_the_same_pairs_however_they_are_told,
                            sheets_on_a_grid_have_the_same_pairs_however_they_are_told,
                            sheets_whose_edges_turn_over_have_the_same_pairs_however_they_are_told,
                            flat_sheets_have_the_same_pairs_however_they_are_told,
                            collapsed_sheets_have_the_same_pairs_however_they_are_told,
                            thick_sheets_have_the_same_pairs_however_they_are_told};
    Suite *suite = suite_create("pair_symmetry");
    TCase *symmetry = tcase_create("symmetry");
    tcase_set_tags(symmetry, PERCALE_ONE_THREAD);
    tcase_set_timeout(symmetry, 0);
    for (size_t i = 0; i < sizeof(tests) / sizeof(tests[0]); i++) {
        tcase_add_loop_test(symmetry, tests[i], first, first + 1);
    }
    suite_add_tcase(suite, symmetry);
    TCase *passages = tcase_create("passages");
    tcase_set_tags(passages, PERCALE_ONE_THREAD);
    tcase_add_test(passages, a_vertex_does_not_pass_a_triangle_that_turns_over_edge_on);
    tcase_add_test(passages, a_vertex_does_not_pass_a_triangle_whose_corners_pass_each_other);
    tcase_add_test(passages, an_edge_that_turns_over_end_to_end_passes_none);
    tcase_add_test(passages, edges_pass_at_a_time_that_is_three_in_one);
    suite_add_tcase(suite, passages);
    return percale_test_run(suite);
}
