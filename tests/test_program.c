// The solver's program: batches hold every constraint of a model once, in runs that share no vertex, and a
// sweep over them gives the same bits for any team.

#include "kernel_testing.h"

#include "solve/sweep.h"
#include "solver.h"

#include <math.h>
#include <stdlib.h>

enum { SPOKES = COLORS_MAX + 36 }; // of the fan: more than there are colours

typedef enum Kind { SHEET, SEWN, FAN, KINDS } Kind;

/// A solver's model, batched anew.
typedef struct Bench {
    PercaleSolver *solver;
    PercaleAllocator allocator;
    PercaleMemory memory;
    PercaleModel *model; // the solver's
    PercaleColoring coloring, contact_coloring;
    PercaleBatches edges, hinges, contacts;
} Bench;

// ---- scenes ----

static PercaleCloth add_cloth(PercaleSolver *solver, const PercaleMesh *mesh, float compliance)
{
    PercaleClothDef def = percale_test_cloth_def(mesh);
    PercaleCloth cloth = {0};
    def.material.stretch_compliance = compliance;
    PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
    return cloth;
}

static void add_pin(PercaleSolver *solver, PercaleCloth cloth, const uint32_t *vertices, uint32_t count)
{
    PercalePinDef def = percale_pin_def_default();
    PercalePin pin;
    def.cloth = cloth;
    def.vertices = vertices;
    def.vertex_count = count;
    PERCALE_TEST_OK(solver, percale_pin_add(solver, &def, &pin));
}

/// Joins the last row of a with the first of b, sheets of `side` vertices: `pair_count` pairs from `first`
/// on.
static void add_seam(PercaleSolver *solver, PercaleCloth a, PercaleCloth b, uint32_t side, uint32_t first)
{
    uint32_t in_a[64];
    uint32_t in_b[64];
    PercaleSeamDef def = percale_seam_def_default();
    PercaleSeam seam;
    for (uint32_t i = first; i < side; i++) {
        in_a[i - first] = side * (side - 1) + i;
        in_b[i - first] = i;
    }
    def.cloth_a = a;
    def.cloth_b = b;
    def.vertices_a = in_a;
    def.vertices_b = in_b;
    def.pair_count = side - first;
    PERCALE_TEST_OK(solver, percale_seam_add(solver, &def, &seam));
}

static void add_sheet(PercaleSolver *solver)
{
    const uint32_t pinned[3] = {0, 59, 1830};
    PercaleMesh sheet = percale_test_sheet(60, 1.0f);
    add_pin(solver, add_cloth(solver, &sheet, 0.0f), pinned, 3);
    percale_mesh_free(&sheet);
}

/// Two sheets of different compliance that have a row in common; its last pairs are apart.
static void add_sewn(PercaleSolver *solver)
{
    enum { SIDE = 44, CLOSED = 30 };
    const uint32_t pinned[2] = {0, SIDE - 1};
    PercaleMesh sheet = percale_test_sheet(SIDE, 1.0f);
    PercaleCloth a = add_cloth(solver, &sheet, 2e-5f);
    percale_test_translate(&sheet, 0.0f, 0.0f, 1.0f);
    for (size_t i = CLOSED; i < SIDE; i++) {
        sheet.positions[3 * i + 1] += 0.05f;
    }
    PercaleCloth b = add_cloth(solver, &sheet, 0.0f);
    add_seam(solver, a, b, SIDE, 0);
    add_pin(solver, a, pinned, 2);
    percale_mesh_free(&sheet);
}

/// A wheel: the rim's vertices around vertex 0.
static void add_fan(PercaleSolver *solver)
{
    float positions[3 * (SPOKES + 1)] = {0.0f};
    uint32_t triangles[3 * SPOKES];
    for (uint32_t i = 0; i < SPOKES; i++) {
        double angle = 2.0 * 3.14159265358979323846 * i / SPOKES;
        positions[3 * (i + 1)] = (float)cos(angle);
        positions[3 * (i + 1) + 2] = (float)sin(angle);
        triangles[3 * i] = 0;
        triangles[3 * i + 1] = 1 + (i + 1) % SPOKES;
        triangles[3 * i + 2] = 1 + i;
    }
    PercaleMesh fan = {.name = NULL,
                       .positions = positions,
                       .vertex_count = SPOKES + 1,
                       .triangles = triangles,
                       .triangle_count = SPOKES};
    (void)add_cloth(solver, &fan, 1e-4f);
}

/// A fresh model, whose constraints name slots as before they were batched.
static void assemble(Bench *bench)
{
    percale_solver_release_model(bench->solver);
    PERCALE_TEST_OK(bench->solver, percale_solver_prepare(bench->solver));
    bench->model = &bench->solver->model;
    for (uint32_t i = 0; i < 2 * bench->model->edge_count; i++) {
        bench->model->edges[i / 2][i % 2] = slot_at(bench->model->edges[i / 2][i % 2]);
    }
    for (uint32_t i = 0; i < 4 * bench->model->hinge_count; i++) {
        bench->model->hinges[i / 4][i % 4] = slot_at(bench->model->hinges[i / 4][i % 4]);
    }
}

static void open_bench(Bench *bench, Kind kind)
{
    *bench = (Bench){.allocator = percale_allocator_default()};
    bench->memory.allocator = &bench->allocator;
    bench->solver = percale_test_solver(percale_solver_def_default());
    void (*const add[KINDS])(PercaleSolver *) = {add_sheet, add_sewn, add_fan};
    add[kind](bench->solver);
    PercaleMesh floor = percale_test_box(4.0f, 0.1f, 4.0f);
    (void)percale_test_add_obstacle(bench->solver, &floor);
    percale_mesh_free(&floor);
    assemble(bench);
}

static void close_bench(Bench *bench)
{
    percale_coloring_free(&bench->coloring, &bench->memory);
    percale_coloring_free(&bench->contact_coloring, &bench->memory);
    percale_batches_free(&bench->edges, &bench->memory);
    percale_batches_free(&bench->hinges, &bench->memory);
    percale_batches_free(&bench->contacts, &bench->memory);
    percale_solver_destroy(bench->solver);
    ck_assert_uint_eq(bench->memory.bytes, 0);
}

/// Batches as they are built for each model anew: the same memory serves again.
static void batch(Bench *bench, uint32_t tile_points)
{
    ck_assert(
        percale_batch_edges(bench->model, tile_points, &bench->coloring, &bench->memory, &bench->edges));
    ck_assert(
        percale_batch_hinges(bench->model, tile_points, &bench->coloring, &bench->memory, &bench->hinges));
}

// ---- batches ----

/// Constraints of one kind, as the laws see them.
typedef struct Constraints {
    const uint32_t *vertices; // byte offsets
    uint32_t arity;
    const PercaleBatches *batches;
    uint32_t tile_points, slot_count;
} Constraints;

static uint32_t slot_of(const Constraints *constraints, uint32_t index, uint32_t k)
{
    uint32_t offset = constraints->vertices[(size_t)index * constraints->arity + k];
    if (offset % POINT_BYTES != 0 || slot_at(offset) >= constraints->slot_count) {
        ck_abort_msg("constraint %u names offset %u", index, offset);
    }
    return slot_at(offset);
}

/// The runs follow each other without gaps, none is empty; so do the tiles' lists of runs.
static void expect_complete_runs(const Constraints *constraints)
{
    const PercaleBatches *batches = constraints->batches;
    ck_assert_uint_eq(batches->run_first[0], 0);
    ck_assert_uint_eq(batches->run_first[batches->run_count], batches->count);
    for (uint32_t run = 0; run < batches->run_count; run++) {
        if (batches->run_first[run] >= batches->run_first[run + 1]) {
            ck_abort_msg("run %u is empty", run);
        }
    }
    ck_assert_uint_eq(batches->tile_first_run[0], 0);
    for (uint32_t tile = 0; tile < batches->tile_count; tile++) {
        ck_assert_uint_le(batches->tile_first_run[tile], batches->tile_first_run[tile + 1]);
    }
    ck_assert_uint_le(batches->tile_first_run[batches->tile_count], batches->run_count);
}

/// Remembers the run that names each of a constraint's slots; last_run: 0 for none, else run + 1.
static void enter_run(const Constraints *constraints, uint32_t index, uint32_t run, uint32_t *last_run)
{
    for (uint32_t k = 0; k < constraints->arity; k++) {
        uint32_t slot = slot_of(constraints, index, k);
        if (last_run[slot] == run + 1) {
            ck_abort_msg("run %u names slot %u twice", run, slot);
        }
        last_run[slot] = run + 1;
    }
}

// Also pinned slots count: the kernels write every vertex.
static void expect_no_shared_slot(const Constraints *constraints)
{
    const PercaleBatches *batches = constraints->batches;
    uint32_t *last_run = calloc(constraints->slot_count, sizeof(uint32_t));
    ck_assert_ptr_nonnull(last_run);
    for (uint32_t run = 0; run < batches->run_count; run++) {
        for (uint32_t i = batches->run_first[run]; i < batches->run_first[run + 1]; i++) {
            enter_run(constraints, i, run, last_run);
        }
    }
    free(last_run);
}

/// The first constraint of a tile; of the one past the last: the first that joins tiles.
static uint32_t tile_begin(const PercaleBatches *batches, uint32_t tile)
{
    return batches->run_first[batches->tile_first_run[tile]];
}

static bool is_in_one_tile(const Constraints *constraints, uint32_t index, uint32_t points, uint32_t *tile)
{
    bool inside = true;
    *tile = slot_of(constraints, index, 0) / points;
    for (uint32_t k = 1; k < constraints->arity; k++) {
        inside = inside && slot_of(constraints, index, k) / points == *tile;
    }
    return inside;
}

static uint32_t tiles_of(const Constraints *constraints, uint32_t points)
{
    return constraints->slot_count / points + (constraints->slot_count % points != 0);
}

/// The number of the smallest tile that holds the constraint: tiles of tile_points, then, while there are
/// four, of four times as many. The number of all tiles when none holds it.
static uint32_t tile_wanted(const Constraints *constraints, uint32_t index)
{
    uint32_t before = 0;
    uint32_t points = constraints->tile_points;
    while (points > 0 && (before == 0 || tiles_of(constraints, points) >= 4)) {
        uint32_t tile;
        if (is_in_one_tile(constraints, index, points, &tile)) {
            return before + tile;
        }
        before += tiles_of(constraints, points);
        points *= 4;
    }
    return before;
}

static void expect_tiles(const Constraints *constraints)
{
    const PercaleBatches *batches = constraints->batches;
    for (uint32_t tile = 0; tile <= batches->tile_count; tile++) {
        bool last = tile == batches->tile_count; // what joins tiles: all runs that are left
        uint32_t end_run = last ? batches->run_count : batches->tile_first_run[tile + 1];
        uint32_t end = batches->run_first[end_run];
        for (uint32_t i = batches->run_first[batches->tile_first_run[tile]]; i < end; i++) {
            if (tile_wanted(constraints, i) != tile) {
                ck_abort_msg("constraint %u of tile %u is in tile %u", i, tile, tile_wanted(constraints, i));
            }
        }
    }
    if (constraints->tile_points >= constraints->slot_count) {
        ck_assert_uint_eq(batches->tile_count, 1);
        ck_assert_uint_eq(batches->run_first[batches->tile_first_run[1]], batches->count);
    }
}

/// Levels follow each other, each of whole tiles: a sweep runs them one after the other.
static void expect_levels(const Constraints *constraints)
{
    const PercaleTiling *tiling = &constraints->batches->tiling;
    ck_assert_uint_eq(tiling->first_tile[0], 0);
    for (uint32_t level = 0; level < tiling->level_count; level++) {
        uint32_t count = tiling->first_tile[level + 1] - tiling->first_tile[level];
        ck_assert_uint_eq(count, tiles_of(constraints, tiling->tile_points[level]));
        ck_assert(level == 0 || count >= 4);
    }
    ck_assert_uint_eq(tiling->first_tile[tiling->level_count], constraints->batches->tile_count);
}

static void expect_laws(const Constraints *constraints)
{
    expect_complete_runs(constraints);
    expect_no_shared_slot(constraints);
    expect_tiles(constraints);
    expect_levels(constraints);
}

/// What the model had before it was batched.
typedef struct Original {
    uint32_t edge_count, hinge_count;
    uint32_t (*edges)[2];
    uint32_t (*hinges)[4];
} Original;

/// Copies the constraints and gives each a number of its own for every value beside it.
static Original label(PercaleModel *model)
{
    Original original = {model->edge_count, model->hinge_count,
                         malloc(model->edge_count * sizeof(original.edges[0])),
                         malloc(model->hinge_count * sizeof(original.hinges[0]))};
    ck_assert(original.edges != NULL && original.hinges != NULL);
    memcpy(original.edges, model->edges, model->edge_count * sizeof(original.edges[0]));
    memcpy(original.hinges, model->hinges, model->hinge_count * sizeof(original.hinges[0]));
    for (uint32_t e = 0; e < model->edge_count; e++) {
        model->edge_lengths[e] = (float)e;
        if (model->edge_compliances != NULL) {
            model->edge_compliances[e] = (float)e + 0.5f;
        }
    }
    for (uint32_t h = 0; h < model->hinge_count; h++) {
        float number = (float)h;
        model->hinge_weights[h] = (f32x4){number, -number, number + 0.25f, number + 0.75f};
        model->hinge_stiffnesses[h] = number + 0.5f;
    }
    return original;
}

/// The constraint that a label names; fails when it was met before.
static uint32_t take(bool *seen, float number, uint32_t count)
{
    uint32_t index = number >= 0.0f && number < (float)count ? (uint32_t)number : UINT32_MAX;
    if (index == UINT32_MAX || seen[index]) {
        ck_abort_msg("constraint %u is none or there twice", index);
    }
    seen[index] = true;
    return index;
}

static void expect_each_edge_once(const PercaleModel *model, const Original *original)
{
    bool *seen = calloc(original->edge_count, sizeof(bool));
    ck_assert_ptr_nonnull(seen);
    ck_assert_uint_eq(model->edge_count, original->edge_count);
    for (uint32_t e = 0; e < model->edge_count; e++) {
        uint32_t from = take(seen, model->edge_lengths[e], original->edge_count);
        bool same = model->edge_compliances == NULL || model->edge_compliances[e] == (float)from + 0.5f;
        for (int k = 0; k < 2; k++) {
            same = same && slot_at(model->edges[e][k]) == original->edges[from][k];
        }
        if (!same) {
            ck_abort_msg("edge %u is not what edge %u was", e, from);
        }
    }
    free(seen);
}

static void expect_each_hinge_once(const PercaleModel *model, const Original *original)
{
    bool *seen = calloc(original->hinge_count, sizeof(bool));
    ck_assert_ptr_nonnull(seen);
    ck_assert_uint_eq(model->hinge_count, original->hinge_count);
    for (uint32_t h = 0; h < model->hinge_count; h++) {
        float number = model->hinge_weights[h][0];
        uint32_t from = take(seen, number, original->hinge_count);
        f32x4 weights = {number, -number, number + 0.25f, number + 0.75f};
        bool same = same_bits(&model->hinge_weights[h], &weights, sizeof(weights)) &&
                    model->hinge_stiffnesses[h] == number + 0.5f;
        for (int k = 0; k < 4; k++) {
            same = same && slot_at(model->hinges[h][k]) == original->hinges[from][k];
        }
        if (!same) {
            ck_abort_msg("hinge %u is not what hinge %u was", h, from);
        }
    }
    free(seen);
}

enum { TILINGS = 8 };

/// Points of a tile; the last two hold the whole cloth, exactly and with room.
static uint32_t tiling(const PercaleModel *model, int index)
{
    static const uint32_t POINTS_OF_TILE[TILINGS - 2] = {0, 1, 10, 64, 256, 1024};
    return index < TILINGS - 2 ? POINTS_OF_TILE[index]
                               : model->slot_count + 7 * (uint32_t)(index - TILINGS + 2);
}

static Constraints edges_of(const Bench *bench, uint32_t tile_points)
{
    return (Constraints){&bench->model->edges[0][0], 2, &bench->edges, tile_points, bench->model->slot_count};
}

static Constraints hinges_of(const Bench *bench, uint32_t tile_points)
{
    return (Constraints){&bench->model->hinges[0][0], 4, &bench->hinges, tile_points,
                         bench->model->slot_count};
}

START_TEST(batches_hold_every_constraint_once_with_what_belongs_to_it)
{
    Bench bench;
    open_bench(&bench, (Kind)_i);
    for (int t = 0; t < TILINGS; t++) {
        assemble(&bench);
        Original original = label(bench.model);
        batch(&bench, tiling(bench.model, t));
        ck_assert_uint_eq(bench.edges.count, original.edge_count);
        ck_assert_uint_eq(bench.hinges.count, original.hinge_count);
        expect_each_edge_once(bench.model, &original);
        expect_each_hinge_once(bench.model, &original);
        free(original.edges);
        free(original.hinges);
    }
    close_bench(&bench);
}
END_TEST

START_TEST(runs_share_no_slot_and_tiles_keep_to_themselves)
{
    Bench bench;
    open_bench(&bench, (Kind)_i);
    for (int t = 0; t < TILINGS; t++) {
        assemble(&bench);
        uint32_t tile_points = tiling(bench.model, t);
        batch(&bench, tile_points);
        Constraints edges = edges_of(&bench, tile_points);
        Constraints hinges = hinges_of(&bench, tile_points);
        expect_laws(&edges);
        expect_laws(&hinges);
    }
    close_bench(&bench);
}
END_TEST

// The scenes are what they are meant to be: else the laws above would hold for nothing.
START_TEST(the_scenes_have_welds_pins_tiles_and_more_constraints_than_colours)
{
    Bench bench;
    open_bench(&bench, SEWN);
    ck_assert_uint_gt(bench.model->open_seam_count, 5);
    ck_assert_uint_lt(bench.model->slot_count, 2 * 44 * 44 - 20);
    ck_assert_uint_eq(bench.model->pinned_count, 2);
    ck_assert_ptr_nonnull(bench.model->edge_compliances);
    batch(&bench, 64);
    ck_assert_uint_lt(bench.edges.tile_first_run[bench.edges.tile_count], bench.edges.run_count);
    ck_assert_uint_eq(bench.edges.tiling.level_count, 3);
    for (uint32_t level = 0; level < 3; level++) {
        ck_assert_uint_lt(tile_begin(&bench.edges, bench.edges.tiling.first_tile[level]),
                          tile_begin(&bench.edges, bench.edges.tiling.first_tile[level + 1]));
    }
    close_bench(&bench);
    open_bench(&bench, SHEET);
    ck_assert_uint_eq(bench.model->pinned_count, 3);
    ck_assert_uint_gt(bench.model->tether_count, 0);
    ck_assert_ptr_null(bench.model->edge_compliances);
    close_bench(&bench);
}
END_TEST

START_TEST(what_fits_into_no_colour_makes_runs_of_one)
{
    Bench bench;
    open_bench(&bench, FAN);
    batch(&bench, _i == 0 ? 0 : 2 * SPOKES); // without tiles, and in one
    const PercaleBatches *kinds[2] = {&bench.edges, &bench.hinges};
    for (int i = 0; i < 2; i++) {
        ck_assert_uint_eq(kinds[i]->color_count, COLORS_MAX);
        ck_assert_uint_eq(kinds[i]->run_count, SPOKES); // each names the hub
        for (uint32_t run = COLORS_MAX; run < SPOKES; run++) {
            ck_assert_uint_eq(kinds[i]->run_first[run + 1] - kinds[i]->run_first[run], 1);
        }
    }
    close_bench(&bench);
}
END_TEST

// ---- sweeps ----

enum { CONTACTS = 2500, SWEEPS = 3 };
static const float DT = 1e-3f; // s

/// What the sweeps write, and what they read of it.
typedef struct State {
    f32x4 *x;                 // [point_count]
    float *edge_multipliers;  // [edge_count]
    f32x4 *hinge_multipliers; // [hinge_count]
    PercaleStencil *stencils; // [CONTACTS]
} State;

typedef struct SweepScene {
    Bench bench;
    f32x4 *start, *bend_weights;
    float *bend_relaxations, *seam_targets;
    State first; // before any sweep
    uint32_t sweep_count, contact_count;
    bool complete;
} SweepScene;

static void *copy_of(const void *source, size_t count, size_t size)
{
    void *copy = aligned_alloc(64, (count * size + 64) / 64 * 64);
    ck_assert_ptr_nonnull(copy);
    memset(copy, 0, count * size);
    if (source != NULL && count > 0) {
        memcpy(copy, source, count * size);
    }
    return copy;
}

/// Cloth vertices over the first triangles of the obstacle; many of them press.
static void make_contacts(SweepScene *scene, uint64_t *seed)
{
    const PercaleModel *model = scene->bench.model;
    for (uint32_t i = 0; i < scene->contact_count; i++) {
        uint32_t slot = (uint32_t)(percale_test_random(seed) * model->slot_count);
        f32x4 normal = {random_float(seed, -0.3, 0.3), 1.0f, random_float(seed, -0.3, 0.3), 0.0f};
        float distance = model->position[slot][1] - model->position[model->slot_count + 2][1];
        scene->first.stencils[i] = (PercaleStencil){
            .points = {slot, model->slot_count + 2, model->slot_count + 6, model->slot_count + 7},
            .weights = {1.0f, -0.5f, -0.25f, -0.25f},
            .normal = with_w(normal / length3(normal), distance + random_float(seed, -0.1, 0.02)),
            .friction = random_float(seed, 0.0, 1.0)};
    }
}

static void color_contacts(SweepScene *scene)
{
    Bench *bench = &scene->bench;
    PercaleConstraints constraints = {.vertices = scene->first.stencils[0].points,
                                      .vertex_stride = sizeof(PercaleStencil) / sizeof(uint32_t),
                                      .weights = scene->first.stencils[0].weights,
                                      .weight_stride = sizeof(PercaleStencil) / sizeof(float),
                                      .arity = 4,
                                      .count = scene->contact_count};
    ck_assert(percale_coloring_run(&bench->contact_coloring, &bench->memory, &constraints,
                                   bench->model->position, bench->model->point_count));
    ck_assert(percale_batch_coloring(&bench->contact_coloring, &bench->memory, &bench->contacts));
}

static void open_scene(SweepScene *scene, Kind kind, uint32_t tile_points)
{
    *scene = (SweepScene){.sweep_count = SWEEPS, .contact_count = kind == FAN ? 0 : CONTACTS};
    open_bench(&scene->bench, kind);
    batch(&scene->bench, tile_points);
    const PercaleModel *model = scene->bench.model;
    uint64_t seed = 4;
    scene->start = copy_of(model->position, model->point_count, sizeof(f32x4));
    scene->bend_weights = copy_of(NULL, model->hinge_count, sizeof(f32x4));
    scene->bend_relaxations = copy_of(NULL, model->hinge_count, sizeof(float));
    scene->seam_targets = copy_of(NULL, model->open_seam_count, sizeof(float));
    scene->first = (State){copy_of(model->position, model->point_count, sizeof(f32x4)),
                           copy_of(NULL, model->edge_count, sizeof(float)),
                           copy_of(NULL, model->hinge_count, sizeof(f32x4)),
                           copy_of(NULL, CONTACTS, sizeof(PercaleStencil))};
    for (uint32_t i = 0; i < model->slot_count; i++) { // wrinkled and a little larger
        f32x4 shift = {random_float(&seed, -4e-3, 4e-3), random_float(&seed, -4e-3, 4e-3),
                       random_float(&seed, -4e-3, 4e-3), 0.0f};
        f32x4 grown = with_w(model->position[i] * 1.05f, model->position[i][3]);
        scene->first.x[i] = model->position[i][3] > 0.0f ? grown + shift : model->position[i];
    }
    percale_solve_bend_prepare(model, DT, 1, scene->bend_weights, scene->bend_relaxations);
    make_contacts(scene, &seed);
    color_contacts(scene);
}

static State first_state(const SweepScene *scene)
{
    const PercaleModel *model = scene->bench.model;
    return (State){copy_of(scene->first.x, model->point_count, sizeof(f32x4)),
                   copy_of(scene->first.edge_multipliers, model->edge_count, sizeof(float)),
                   copy_of(scene->first.hinge_multipliers, model->hinge_count, sizeof(f32x4)),
                   copy_of(scene->first.stencils, CONTACTS, sizeof(PercaleStencil))};
}

static void free_state(State *state)
{
    free(state->x);
    free(state->edge_multipliers);
    free(state->hinge_multipliers);
    free(state->stencils);
}

static void close_scene(SweepScene *scene)
{
    free_state(&scene->first);
    free(scene->start);
    free(scene->bend_weights);
    free(scene->bend_relaxations);
    free(scene->seam_targets);
    close_bench(&scene->bench);
}

static PercaleSolveArrays arrays_of(const SweepScene *scene, State *state)
{
    const PercaleModel *model = scene->bench.model;
    return (PercaleSolveArrays){.model = model,
                                .x = state->x,
                                .start = scene->start,
                                .dt = DT,
                                .edge_multipliers =
                                    model->edge_compliances != NULL ? state->edge_multipliers : NULL,
                                .bend_weights = scene->bend_weights,
                                .bend_relaxations = scene->bend_relaxations,
                                .hinge_multipliers = state->hinge_multipliers,
                                .seam_targets = scene->seam_targets,
                                .stencils = state->stencils,
                                .stencil_order = scene->bench.contact_coloring.order};
}

typedef struct Sweeping {
    SweepScene *scene;
    const PercaleEngine *engine;
    State *state;
} Sweeping;

static void lead_sweeps(PercaleTeam *team, void *context)
{
    const Sweeping *sweeping = context;
    SweepScene *scene = sweeping->scene;
    PercaleSweepPlan plan = {.arrays = arrays_of(scene, sweeping->state),
                             .edges = &scene->bench.edges,
                             .hinges = &scene->bench.hinges,
                             .contacts = &scene->bench.contacts,
                             .sweep_count = scene->sweep_count};
    PercaleArena arena = {.memory = {&scene->bench.allocator, 0}};
    scene->complete = sweeping->engine->run_sweep(&plan, team, &arena);
    percale_arena_free(&arena);
}

static State swept(SweepScene *scene, const PercaleEngine *engine, int thread_count)
{
    State state = first_state(scene);
    PercaleCrowding crowding = {0};
    percale_team_open(thread_count, &crowding, lead_sweeps, &(Sweeping){scene, engine, &state});
    ck_assert(scene->complete);
    return state;
}

static void expect_equal(const SweepScene *scene, const State *a, const State *b)
{
    const PercaleModel *model = scene->bench.model;
    ck_assert(same_bits(a->x, b->x, model->point_count * sizeof(f32x4)));
    ck_assert(same_bits(a->edge_multipliers, b->edge_multipliers, model->edge_count * sizeof(float)));
    ck_assert(same_bits(a->hinge_multipliers, b->hinge_multipliers, model->hinge_count * sizeof(f32x4)));
    ck_assert(same_bits(a->stencils, b->stencils, CONTACTS * sizeof(PercaleStencil)));
}

// ---- the slow twin: one constraint after the other, as sweep.h tells it ----

static void project_each(PercaleKernel *kernel, const PercaleSolveArrays *arrays, uint32_t begin,
                         uint32_t end)
{
    for (uint32_t i = begin; i < end; i++) {
        kernel(arrays, i, i + 1);
    }
}

static State slowly_swept(const SweepScene *scene)
{
    const Bench *bench = &scene->bench;
    State state = first_state(scene);
    PercaleSolveArrays arrays = arrays_of(scene, &state);
    uint32_t tile_count = bench->edges.tile_count;
    for (uint32_t sweep = 0; sweep < scene->sweep_count; sweep++) {
        for (uint32_t tile = 0; tile < tile_count; tile++) {
            project_each(percale_solve_bend, &arrays, tile_begin(&bench->hinges, tile),
                         tile_begin(&bench->hinges, tile + 1));
            project_each(percale_solve_stretch, &arrays, tile_begin(&bench->edges, tile),
                         tile_begin(&bench->edges, tile + 1));
        }
        project_each(percale_solve_bend, &arrays, tile_begin(&bench->hinges, tile_count),
                     bench->hinges.count);
        project_each(percale_solve_stretch, &arrays, tile_begin(&bench->edges, tile_count),
                     bench->edges.count);
        project_each(percale_solve_tether, &arrays, 0,
                     bench->model->tether_layers > 0 ? bench->model->slot_count : 0);
        project_each(percale_solve_seam, &arrays, 0, bench->model->open_seam_count);
        project_each(percale_solve_contact, &arrays, 0, bench->contacts.count);
    }
    return state;
}

static const uint32_t SWEPT_TILES[] = {0, 64, 256, 1024};

static void expect_same_for_any_team(SweepScene *scene, const PercaleEngine *engine, const State *expected)
{
    static const int TEAMS[] = {1, 2, 3, 7};
    for (size_t t = 0; t < sizeof(TEAMS) / sizeof(TEAMS[0]); t++) {
        State state = swept(scene, engine, TEAMS[t]);
        expect_equal(scene, &state, expected);
        free_state(&state);
    }
}

START_TEST(a_sweep_gives_the_same_bits_for_any_team_and_engine)
{
    SweepScene scene;
    open_scene(&scene, _i % 2 == 0 ? SHEET : SEWN, SWEPT_TILES[_i / 2]);
    State slow = slowly_swept(&scene);
    uint32_t pressing = 0;
    for (uint32_t i = 0; i < CONTACTS; i++) {
        pressing += slow.stencils[i].multiplier[3] > 0.0f;
    }
    ck_assert_uint_gt(pressing, CONTACTS / 10);
    for (PercaleIsa isa = PERCALE_ISA_AUTO; isa <= PERCALE_ISA_AVX512; isa++) {
        if (percale_engine_for(isa) != NULL) {
            expect_same_for_any_team(&scene, percale_engine_for(isa), &slow);
        }
    }
    free_state(&slow);
    close_scene(&scene);
}
END_TEST

START_TEST(a_fan_of_more_edges_than_colours_is_projected_completely)
{
    SweepScene scene;
    open_scene(&scene, FAN, _i == 0 ? 0 : 1024);
    const PercaleModel *model = scene.bench.model;
    scene.sweep_count = 1;
    State slow = slowly_swept(&scene);
    for (int threads = 1; threads <= 3; threads++) {
        State state = swept(&scene, percale_engine_for(PERCALE_ISA_AUTO), threads);
        expect_equal(&scene, &state, &slow);
        for (uint32_t e = 0; e < model->edge_count; e++) {
            ck_assert_msg(state.edge_multipliers[e] != 0.0f, "edge %u was left out", e);
        }
        for (uint32_t h = 0; h < model->hinge_count; h++) {
            ck_assert_msg(length3(state.hinge_multipliers[h]) > 0.0f, "hinge %u was left out", h);
        }
        free_state(&state);
    }
    free_state(&slow);
    close_scene(&scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("program");
    TCase *batches = tcase_create("batches");
    tcase_set_timeout(batches, 60.0);
    tcase_add_loop_test(batches, batches_hold_every_constraint_once_with_what_belongs_to_it, 0, KINDS);
    tcase_add_loop_test(batches, runs_share_no_slot_and_tiles_keep_to_themselves, 0, KINDS);
    tcase_add_test(batches, the_scenes_have_welds_pins_tiles_and_more_constraints_than_colours);
    tcase_add_loop_test(batches, what_fits_into_no_colour_makes_runs_of_one, 0, 2);
    suite_add_tcase(suite, batches);
    TCase *sweeps = tcase_create("sweeps");
    tcase_set_timeout(sweeps, 60.0);
    tcase_add_loop_test(sweeps, a_sweep_gives_the_same_bits_for_any_team_and_engine, 0, 8);
    tcase_add_loop_test(sweeps, a_fan_of_more_edges_than_colours_is_projected_completely, 0, 2);
    suite_add_tcase(suite, sweeps);
    return percale_test_run(suite);
}
