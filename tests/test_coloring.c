// Colours: what may run in parallel shares no vertex that moves.

#include "testing.h"

#include "color/coloring.h"
#include "solver.h"

#include <stdlib.h>
#include <string.h>

enum { ARITY = 4 };

/// Constraints as a contact's stencils have them: four vertices with weights, some 0, some immovable.
typedef struct Problem {
    uint32_t count, point_count;
    uint32_t (*vertices)[ARITY];
    float (*weights)[ARITY];
    f32x4 *points;
} Problem;

static Problem new_problem(uint32_t count, uint32_t point_count)
{
    Problem problem = {.count = count, .point_count = point_count};
    problem.vertices = calloc(count, sizeof(problem.vertices[0]));
    problem.weights = calloc(count, sizeof(problem.weights[0]));
    problem.points = calloc(point_count, sizeof(f32x4));
    ck_assert(problem.vertices != NULL && problem.weights != NULL && problem.points != NULL);
    for (uint32_t i = 0; i < point_count; i++) {
        problem.points[i][3] = 1.0f;
    }
    for (uint32_t i = 0; i < count * ARITY; i++) {
        problem.weights[i / ARITY][i % ARITY] = 0.25f;
    }
    return problem;
}

static Problem random_problem(uint32_t count, uint32_t point_count, uint64_t seed)
{
    Problem problem = new_problem(count, point_count);
    for (uint32_t i = 0; i < point_count; i++) {
        problem.points[i][3] = percale_test_random(&seed) < 0.2 ? 0.0f : 3.0f;
    }
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t k = 0; k < ARITY; k++) {
            problem.vertices[i][k] = (uint32_t)(percale_test_random(&seed) * point_count);
            problem.weights[i][k] = percale_test_random(&seed) < 0.3 ? 0.0f : -0.5f;
        }
    }
    return problem;
}

/// count constraints that all move vertex 0 and three vertices of their own.
static Problem make_star(uint32_t count)
{
    Problem problem = new_problem(count, 1 + 3 * count);
    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t k = 1; k < ARITY; k++) {
            problem.vertices[i][k] = 3 * i + k;
        }
    }
    return problem;
}

static void free_problem(Problem *problem)
{
    free(problem->vertices);
    free(problem->weights);
    free(problem->points);
}

typedef struct Bench {
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleColoring coloring;
} Bench;

static void open_bench(Bench *bench)
{
    *bench = (Bench){.allocator = percale_allocator_default()};
    bench->memory.allocator = &bench->allocator;
}

static void close_bench(Bench *bench)
{
    percale_coloring_free(&bench->coloring, &bench->memory);
    ck_assert_uint_eq(bench->memory.bytes, 0);
}

static void color_some_late(Bench *bench, const Problem *problem, const uint8_t *waits)
{
    PercaleConstraints constraints = {
        &problem->vertices[0][0], ARITY, &problem->weights[0][0], ARITY, ARITY, problem->count, false, waits};
    ck_assert(percale_coloring_run(&bench->coloring, &bench->memory, &constraints, problem->points,
                                   problem->point_count));
}

static void color(Bench *bench, const Problem *problem)
{
    color_some_late(bench, problem, NULL);
}

static uint32_t remainder_of(const PercaleColoring *coloring)
{
    return coloring->count - coloring->first[coloring->color_count];
}

static bool moves(const Problem *problem, uint32_t constraint, uint32_t k)
{
    return problem->weights[constraint][k] != 0.0f &&
           problem->points[problem->vertices[constraint][k]][3] > 0.0f;
}

/// Whether both constraints move a common vertex.
static bool conflict(const Problem *problem, uint32_t a, uint32_t b)
{
    for (uint32_t k = 0; k < ARITY; k++) {
        for (uint32_t l = 0; l < ARITY; l++) {
            if (moves(problem, a, k) && moves(problem, b, l) &&
                problem->vertices[a][k] == problem->vertices[b][l]) {
                return true;
            }
        }
    }
    return false;
}

static void expect_no_conflict(const PercaleColoring *coloring, const Problem *problem, uint32_t color)
{
    for (uint32_t i = coloring->first[color]; i < coloring->first[color + 1]; i++) {
        for (uint32_t j = i + 1; j < coloring->first[color + 1]; j++) {
            if (conflict(problem, coloring->order[i], coloring->order[j])) {
                ck_abort_msg("colour %u: constraints %u and %u move the same vertex", color,
                             coloring->order[i], coloring->order[j]);
            }
        }
    }
}

static void expect_each_once(const PercaleColoring *coloring)
{
    uint8_t *seen = calloc(coloring->count, 1);
    ck_assert_ptr_nonnull(seen);
    for (uint32_t i = 0; i < coloring->count; i++) {
        if (coloring->order[i] >= coloring->count || seen[coloring->order[i]] != 0) {
            ck_abort_msg("place %u: constraint %u is none or stands twice", i, coloring->order[i]);
        }
        seen[coloring->order[i]] = 1;
    }
    free(seen);
}

static void expect_valid(const PercaleColoring *coloring, const Problem *problem)
{
    ck_assert_uint_eq(coloring->count, problem->count);
    ck_assert_uint_le(coloring->color_count, COLORS_MAX);
    ck_assert_uint_eq(coloring->first[0], 0);
    for (uint32_t color = 0; color < coloring->color_count; color++) {
        ck_assert_uint_lt(coloring->first[color], coloring->first[color + 1]); // no colour is empty
        expect_no_conflict(coloring, problem, color);
    }
    expect_each_once(coloring);
}

START_TEST(no_colour_moves_a_vertex_twice)
{
    Bench bench;
    open_bench(&bench);
    for (uint64_t seed = 1; seed <= 40; seed++) { // from sparse to crowded beyond a round
        uint32_t point_count = (uint32_t)(60 * seed - 50);
        Problem problem = random_problem(600, point_count, seed);
        color(&bench, &problem);
        expect_valid(&bench.coloring, &problem);
        free_problem(&problem);
    }
    close_bench(&bench);
}
END_TEST

START_TEST(inside_a_colour_the_old_order_stays)
{
    Bench bench;
    open_bench(&bench);
    Problem problem = random_problem(800, 900, 5);
    color(&bench, &problem);
    for (uint32_t c = 0; c <= bench.coloring.color_count; c++) {
        uint32_t end = c < bench.coloring.color_count ? bench.coloring.first[c + 1] : bench.coloring.count;
        for (uint32_t i = bench.coloring.first[c] + 1; i < end; i++) {
            ck_assert_uint_lt(bench.coloring.order[i - 1], bench.coloring.order[i]);
        }
    }
    free_problem(&problem);
    close_bench(&bench);
}
END_TEST

// Scratch that one call leaves behind would be seen by the next.
START_TEST(the_same_input_gives_the_same_colours_whatever_came_before)
{
    Bench fresh;
    Bench used;
    open_bench(&fresh);
    open_bench(&used);
    Problem other = make_star(COLORS_MAX + 100);
    Problem problem = random_problem(700, 500, 9);
    color(&used, &other);
    ck_assert_uint_gt(remainder_of(&used.coloring), 0); // the hardest case leaves the most behind
    color(&used, &problem);
    color(&fresh, &problem);
    ck_assert_uint_eq(used.coloring.color_count, fresh.coloring.color_count);
    ck_assert_mem_eq(used.coloring.first, fresh.coloring.first,
                     (fresh.coloring.color_count + 1) * sizeof(fresh.coloring.first[0]));
    ck_assert_mem_eq(used.coloring.order, fresh.coloring.order, problem.count * sizeof(uint32_t));
    for (size_t i = 0; i < used.coloring.used_capacity; i++) {
        ck_assert_uint_eq(used.coloring.used[i], 0);
    }
    free_problem(&other);
    free_problem(&problem);
    close_bench(&fresh);
    close_bench(&used);
}
END_TEST

START_TEST(constraints_on_one_vertex_need_a_colour_each)
{
    static const uint32_t COUNTS[] = {
        1, 2, 40, 63, 64, 65, 128, 129, 400, COLORS_MAX, COLORS_MAX + 1, COLORS_MAX + 100};
    Bench bench;
    open_bench(&bench);
    for (size_t i = 0; i < sizeof(COUNTS) / sizeof(COUNTS[0]); i++) {
        Problem problem = make_star(COUNTS[i]);
        color(&bench, &problem);
        expect_valid(&bench.coloring, &problem);
        uint32_t colors = COUNTS[i] < COLORS_MAX ? COUNTS[i] : COLORS_MAX;
        ck_assert_uint_eq(bench.coloring.color_count, colors);
        ck_assert_uint_eq(remainder_of(&bench.coloring), COUNTS[i] - colors);
        free_problem(&problem);
    }
    close_bench(&bench);
}
END_TEST

enum { SLOW_COLORS = 1 << 12 };

/// The first colour that none of a constraint's vertices has.
static uint32_t first_free(const Problem *problem, uint32_t constraint, bool (*used)[SLOW_COLORS])
{
    for (uint32_t color = 0; color < SLOW_COLORS; color++) {
        bool is_taken = false;
        for (uint32_t k = 0; k < ARITY; k++) {
            is_taken =
                is_taken || (moves(problem, constraint, k) && used[problem->vertices[constraint][k]][color]);
        }
        if (!is_taken) {
            return color;
        }
    }
    return SLOW_COLORS;
}

/// First fit as one would write it down: a table of which vertex has which colour.
static void fit_slowly(const Problem *problem, const uint8_t *waits, uint32_t *colors)
{
    bool(*used)[SLOW_COLORS] = calloc(problem->point_count, sizeof(used[0]));
    ck_assert_ptr_nonnull(used);
    for (uint32_t turn = 0; turn < 2 * problem->count; turn++) {
        uint32_t i = turn % problem->count;
        if (waits[i] != turn / problem->count) {
            continue;
        }
        colors[i] = first_free(problem, i, used);
        for (uint32_t k = 0; k < ARITY; k++) {
            used[problem->vertices[i][k]][colors[i]] |= moves(problem, i, k);
        }
    }
    free(used);
}

/// Sparse problems need one round, dense ones many; some leave a remainder.
START_TEST(rounds_give_the_colours_of_one_first_fit)
{
    enum { COUNT = 1500 };
    static const uint32_t POINTS[] = {3, 6, 12, 50, 200, 2000};
    uint32_t *colors = malloc(COUNT * sizeof(*colors));
    uint8_t *waits = malloc(COUNT);
    uint64_t seed = 3;
    uint32_t most = 0;
    uint32_t least = UINT32_MAX;
    uint32_t left = 0;
    Bench bench;
    open_bench(&bench);
    for (size_t i = 0; i < sizeof(POINTS) / sizeof(POINTS[0]); i++) {
        Problem problem = random_problem(COUNT, POINTS[i], 5 + i);
        for (uint32_t k = 0; k < COUNT; k++) {
            waits[k] = percale_test_random(&seed) < 0.3;
        }
        color_some_late(&bench, &problem, waits);
        fit_slowly(&problem, waits, colors);
        expect_each_once(&bench.coloring);
        for (uint32_t c = 0; c <= bench.coloring.color_count; c++) {
            bool last = c == bench.coloring.color_count;
            uint32_t end = last ? COUNT : bench.coloring.first[c + 1];
            for (uint32_t at = bench.coloring.first[c]; at < end; at++) {
                uint32_t expected = colors[bench.coloring.order[at]];
                ck_assert_uint_eq(expected < COLORS_MAX ? expected : COLORS_MAX, last ? COLORS_MAX : c);
            }
        }
        most = bench.coloring.color_count > most ? bench.coloring.color_count : most;
        least = bench.coloring.color_count < least ? bench.coloring.color_count : least;
        left += remainder_of(&bench.coloring);
        free_problem(&problem);
    }
    ck_assert_uint_lt(least, COLORS_OF_ROUND);
    ck_assert_uint_eq(most, COLORS_MAX);
    ck_assert_uint_gt(left, 0);
    close_bench(&bench);
    free(colors);
    free(waits);
}
END_TEST

START_TEST(a_vertex_that_cannot_move_takes_no_part)
{
    Bench bench;
    open_bench(&bench);
    Problem problem = make_star(100);
    problem.points[0][3] = 0.0f;
    color(&bench, &problem);
    ck_assert_uint_eq(bench.coloring.color_count, 1);
    ck_assert_uint_eq(remainder_of(&bench.coloring), 0);
    free_problem(&problem);
    close_bench(&bench);
}
END_TEST

START_TEST(a_vertex_without_weight_takes_no_part)
{
    Bench bench;
    open_bench(&bench);
    Problem problem = make_star(100);
    for (uint32_t i = 0; i < problem.count; i++) {
        problem.weights[i][0] = i % 2 == 0 ? 0.0f : -0.0f;
    }
    color(&bench, &problem);
    ck_assert_uint_eq(bench.coloring.color_count, 1);
    free_problem(&problem);
    close_bench(&bench);
}
END_TEST

/// Those that wait come and go; the others keep their colours.
START_TEST(colours_do_not_depend_on_those_that_wait)
{
    uint64_t seed = 21;
    enum { OTHERS = 40, WAITING = 40 };
    f32x4 points[30];
    for (int i = 0; i < 30; i++) {
        points[i] = (f32x4){0.0f, 0.0f, 0.0f, 1.0f};
    }
    for (int trial = 0; trial < 50; trial++) {
        uint32_t vertices[OTHERS + WAITING][2];
        uint8_t waits[OTHERS + WAITING];
        uint32_t alone[OTHERS][2];
        uint32_t other_count = 0;
        for (uint32_t i = 0; i < OTHERS + WAITING; i++) {
            vertices[i][0] = (uint32_t)(30.0 * percale_test_random(&seed));
            vertices[i][1] = (vertices[i][0] + 1 + (uint32_t)(29.0 * percale_test_random(&seed))) % 30;
            waits[i] = (i % 2) != 0;
            if (waits[i] == 0) {
                memcpy(alone[other_count++], vertices[i], sizeof(vertices[i]));
            }
        }
        Bench both;
        Bench others;
        open_bench(&both);
        open_bench(&others);
        PercaleConstraints all = {vertices[0], 2, NULL, 0, 2, OTHERS + WAITING, false, waits};
        PercaleConstraints some = {alone[0], 2, NULL, 0, 2, OTHERS, false, NULL};
        ck_assert(percale_coloring_run(&both.coloring, &both.memory, &all, points, 30));
        ck_assert(percale_coloring_run(&others.coloring, &others.memory, &some, points, 30));
        for (uint32_t i = 0; i < OTHERS; i++) {
            ck_assert_uint_eq(both.coloring.color_of[2 * i], others.coloring.color_of[i]);
        }
        close_bench(&both);
        close_bench(&others);
    }
}
END_TEST

START_TEST(nothing_needs_no_colour)
{
    Bench bench;
    open_bench(&bench);
    Problem problem = make_star(1);
    problem.count = 0;
    color(&bench, &problem);
    ck_assert_uint_eq(bench.coloring.color_count, 0);
    ck_assert_uint_eq(remainder_of(&bench.coloring), 0);
    free_problem(&problem);
    close_bench(&bench);
}
END_TEST

// ---- the model's own constraints ----

static PercaleSolver *new_sheet_solver(void)
{
    PercaleMesh sheet = percale_test_sheet(20, 1.0f);
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    (void)percale_test_add_cloth(solver, &sheet);
    percale_mesh_free(&sheet);
    PERCALE_TEST_OK(solver, percale_solver_validate(solver));
    return solver;
}

/// Validation must refuse the model and name what it found.
static void expect_refused(PercaleSolver *solver, const char *words)
{
    ck_assert_int_ne((int)percale_solver_validate(solver), (int)PERCALE_OK);
    const char *error = percale_solver_last_error(solver);
    ck_assert_msg(strstr(error, words) != NULL, "'%s' does not say '%s'", error, words);
}

START_TEST(validation_finds_edges_that_share_a_vertex)
{
    PercaleSolver *solver = new_sheet_solver();
    PercaleModel *model = &solver->model;
    uint32_t last = solver->edges.run_first[2] - 1; // of the second run
    uint32_t kept = model->edges[last][1];
    model->edges[last][1] = model->edges[last - 1][0];
    char words[96];
    (void)snprintf(words, sizeof(words), "edge %u shares point %u within run 1", last,
                   slot_at(model->edges[last][1]));
    expect_refused(solver, words);
    model->edges[last][1] = kept;
    PERCALE_TEST_OK(solver, percale_solver_validate(solver));
    percale_solver_destroy(solver);
}
END_TEST

START_TEST(validation_finds_hinges_that_share_a_vertex)
{
    PercaleSolver *solver = new_sheet_solver();
    uint32_t last = solver->hinges.run_first[1] - 1;
    solver->model.hinges[last][3] = solver->model.hinges[0][2];
    expect_refused(solver, "shares point");
    expect_refused(solver, "hinge");
    percale_solver_destroy(solver);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("coloring");
    TCase *rules = tcase_create("rules");
    tcase_add_test(rules, no_colour_moves_a_vertex_twice);
    tcase_add_test(rules, inside_a_colour_the_old_order_stays);
    tcase_add_test(rules, the_same_input_gives_the_same_colours_whatever_came_before);
    tcase_add_test(rules, constraints_on_one_vertex_need_a_colour_each);
    tcase_add_test(rules, rounds_give_the_colours_of_one_first_fit);
    tcase_add_test(rules, a_vertex_that_cannot_move_takes_no_part);
    tcase_add_test(rules, a_vertex_without_weight_takes_no_part);
    tcase_add_test(rules, colours_do_not_depend_on_those_that_wait);
    tcase_add_test(rules, nothing_needs_no_colour);
    suite_add_tcase(suite, rules);
    TCase *validation = tcase_create("validation");
    tcase_add_test(validation, validation_finds_edges_that_share_a_vertex);
    tcase_add_test(validation, validation_finds_hinges_that_share_a_vertex);
    suite_add_tcase(suite, validation);
    return percale_test_run(suite);
}
