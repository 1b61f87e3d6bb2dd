// A sweep over a program's batches gives the same bits for any team, and for one constraint after the other.

#include "program_testing.h"

#include "solve/sweep.h"

#include <stdlib.h>

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
    Suite *suite = suite_create("sweeps");
    TCase *sweeps = tcase_create("sweeps");
    tcase_set_timeout(sweeps, 60.0);
    tcase_add_loop_test(sweeps, a_sweep_gives_the_same_bits_for_any_team_and_engine, 0, 8);
    tcase_add_loop_test(sweeps, a_fan_of_more_edges_than_colours_is_projected_completely, 0, 2);
    suite_add_tcase(suite, sweeps);
    return percale_test_run(suite);
}
