// Batches hold every constraint of a model once, in runs that share no vertex.

#include "program_testing.h"

#include <stdlib.h>

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

int main(void)
{
    Suite *suite = suite_create("batches");
    TCase *batches = tcase_create("batches");
    tcase_set_timeout(batches, 60.0);
    tcase_add_loop_test(batches, batches_hold_every_constraint_once_with_what_belongs_to_it, 0, KINDS);
    tcase_add_loop_test(batches, runs_share_no_slot_and_tiles_keep_to_themselves, 0, KINDS);
    tcase_add_test(batches, the_scenes_have_welds_pins_tiles_and_more_constraints_than_colours);
    tcase_add_loop_test(batches, what_fits_into_no_colour_makes_runs_of_one, 0, 2);
    suite_add_tcase(suite, batches);
    return percale_test_run(suite);
}
