// Laws of candidates: however things move, every pair in reach is visited; what moves together spends
// nothing, and what moves spends its own.

#include "percale/geometry.h"
#include "sheets_testing.h"

#include <stdlib.h>
#include <string.h>

enum { MIDDLE_SIDE = 14, LARGE_SIDE = 20, STEPS = 24 };

static void start_here(Sheets *sheets)
{
    memcpy(sheets->model->position, sheets->model->predicted, sheets->model->slot_count * sizeof(f32x4));
}

/// Blocks that had to be searched again. `again`: the ways start where they did.
static uint32_t keep_again(Sheets *sheets, bool again)
{
    PercaleCandidateStage stage = {.from = sheets->model->position,
                                   .to = sheets->model->predicted,
                                   .again = again,
                                   .collectors = &sheets->solver->collectors,
                                   .memory = &sheets->solver->detect_memory,
                                   .team = percale_team_alone()};
    uint64_t tested = 0;
    ck_assert(percale_candidates_keep(sheets->candidates, &stage, &tested));
    ck_assert((tested > 0) <= (sheets->candidates->spent.count > 0));
    return sheets->candidates->spent.count;
}

static uint32_t keep(Sheets *sheets)
{
    return keep_again(sheets, false);
}

/// Which pairs of a list are visited.
typedef struct Visited {
    bool *pairs; // [item][primitive]
    size_t primitive_count;
} Visited;

static void mark(const void *context, PercaleCollector *collector, const PercaleQuery *query, uint32_t place,
                 uint32_t item)
{
    (void)query;
    (void)place;
    const Visited *visited = context;
    for (size_t i = 0; i < collector->neighbors.count; i++) {
        bool *pair = &visited->pairs[item * visited->primitive_count + collector->neighbors.items[i].index];
        ck_assert(!*pair);
        *pair = true;
    }
}

/// `touched`: of the points whose pairs are visited; NULL: all.
static Visited visit(Sheets *sheets, bool edges, const uint8_t *touched)
{
    const PercaleModelSurface *cloth = &sheets->model->cloth;
    size_t item_count = edges ? cloth->edges.edge_count : cloth->vertex_count;
    Visited visited = {NULL, edges ? cloth->edges.edge_count : cloth->triangle_count};
    visited.pairs = calloc(item_count * visited.primitive_count, sizeof(bool));
    ck_assert_ptr_nonnull(visited.pairs);
    PercaleCollector *collector = &sheets->solver->collectors.shares[0];
    collector->memory = (PercaleMemory){sheets->solver->detect_memory.allocator, 0};
    collector->complete = true;
    PercaleVisiting visiting = {.candidates = sheets->candidates,
                                .list = edges ? 1 : 0,
                                .hood = percale_candidates_hood(sheets->candidates, edges ? 1 : 0),
                                .touched = touched,
                                .visit = mark,
                                .context = &visited};
    visiting.hood.ends_too = true;
    size_t count = percale_candidate_count(&sheets->candidates->lists[edges ? 1 : 0]);
    percale_candidates_visit(&visiting, collector, 0, count / 3); // in shares, as threads do
    percale_candidates_visit(&visiting, collector, count / 3, count);
    ck_assert(collector->complete);
    sheets->solver->detect_memory.bytes += collector->memory.bytes;
    return visited;
}

/// All pairs of one kind within reach are visited. Returns their number.
static uint32_t expect_all(Sheets *sheets, bool edges)
{
    const PercaleModel *model = sheets->model;
    const float reach = CONTACT_REACH * model->cloths[0].thickness;
    Visited visited = visit(sheets, edges, NULL);
    uint32_t count = 0;
    uint32_t points[4];
    for (AllPairs all = all_pairs(model, edges); next_pair(&all, points);) {
        double x[4][3];
        double weights[4];
        if (length3(model->predicted[points[0]] - model->predicted[points[2]]) > 4.0f * EDGE) {
            continue; // one edge is no longer than two of the sheet's
        }
        for (int k = 0; k < 4; k++) {
            for (int axis = 0; axis < 3; axis++) {
                x[k][axis] = (double)model->predicted[points[k]][axis];
            }
        }
        double distance = edges ? percale_edge_edge_closest((const double(*)[3])x, weights)
                                : percale_vertex_face_closest((const double(*)[3])x, weights);
        if (distance <= (double)reach) {
            ck_assert_msg(visited.pairs[all.item * visited.primitive_count + all.primitive - 1], "%u and %u",
                          all.item, all.primitive - 1);
            count++;
        }
    }
    free(visited.pairs);
    return count;
}

/// The lower sheet turns and the upper one comes down on it while both shake and fall by metres; now and then
/// a block rests, so that blocks are found anew at different times.
START_TEST(however_they_move_all_pairs_in_reach_are_visited)
{
    Sheets sheets;
    open_sheets(&sheets, MIDDLE_SIDE);
    PercaleModel *model = sheets.model;
    const uint32_t block_count = sheets.candidates->blocks.cloth_count;
    uint32_t pairs = 0;
    uint32_t searched = 0;
    for (int step = 0; step < STEPS; step++) {
        const f32x4 fall = {0.3f, -1.0f, 0.2f, 0.0f};
        const float turn = 0.01f;
        move(&sheets, fall, step % 8 < 4 ? 0.0004f : 0.0f);
        for (uint32_t i = 0; i < model->slot_count; i++) {
            f32x4 x = model->predicted[i] - (float)(step + 1) * fall; // but for what all fall
            model->predicted[i][0] -= model->cloth_of[i] == 0 ? turn * x[2] : 0.0f;
            model->predicted[i][2] += model->cloth_of[i] == 0 ? turn * x[0] : 0.0f;
            model->predicted[i][1] -= model->cloth_of[i] == 1 ? 0.0003f : 0.0f;
        }
        searched += keep(&sheets);
        pairs += expect_all(&sheets, false) + expect_all(&sheets, true);
        start_here(&sheets);
    }
    ck_assert_uint_gt(pairs, 1000);
    ck_assert_uint_gt(searched, block_count); // but not all of them each time
    ck_assert_uint_lt(searched, block_count * (uint32_t)STEPS * 3 / 4);
    close_sheets(&sheets);
}
END_TEST

/// Returns how many pairs are visited of all.
static uint32_t expect_touched(Sheets *sheets, bool edges, const uint8_t *touched, uint32_t *all_count)
{
    Visited full = visit(sheets, edges, NULL);
    Visited some = visit(sheets, edges, touched);
    uint32_t count = 0;
    uint32_t points[4];
    for (AllPairs all = all_pairs(sheets->model, edges); next_pair(&all, points);) {
        size_t at = all.item * full.primitive_count + all.primitive - 1;
        bool any = (touched[points[0]] | touched[points[1]] | touched[points[2]] | touched[points[3]]) != 0;
        ck_assert_msg(some.pairs[at] == (full.pairs[at] && any), "%u and %u", all.item, all.primitive - 1);
        count += some.pairs[at];
        *all_count += full.pairs[at];
    }
    free(full.pairs);
    free(some.pairs);
    return count;
}

START_TEST(of_what_is_touched_all_pairs_are_visited_and_no_others)
{
    enum { EVERY = 9 };
    Sheets sheets;
    open_sheets(&sheets, MIDDLE_SIDE);
    uint8_t *touched = calloc(sheets.model->point_count, 1);
    ck_assert_ptr_nonnull(touched);
    for (uint32_t i = 0; i < sheets.model->point_count; i += EVERY) {
        touched[i] = 1;
    }
    for (uint32_t i = 0; i < sheets.model->slot_count; i++) { // the upper one comes into reach
        sheets.model->predicted[i][1] -= sheets.model->cloth_of[i] == 1 ? 0.0105f : 0.0f;
    }
    move(&sheets, (f32x4){0}, 0.0005f);
    (void)keep(&sheets);
    for (int edges = 0; edges < 2; edges++) {
        uint32_t all = 0;
        uint32_t count = expect_touched(&sheets, edges != 0, touched, &all);
        ck_assert_uint_gt(count, all / EVERY);
        ck_assert_uint_lt(count, all);
    }
    free(touched);
    close_sheets(&sheets);
}
END_TEST

START_TEST(what_falls_together_spends_nothing_and_what_does_not_does)
{
    Sheets sheets;
    open_sheets(&sheets, SIDE);
    const PercaleBlocks *blocks = &sheets.candidates->blocks;
    ck_assert_uint_eq(keep(&sheets), blocks->count);
    move(&sheets, (f32x4){0.0f, -5.0f, 0.0f, 0.0f}, 0.0f);
    ck_assert_uint_eq(keep(&sheets), 0);
    for (uint32_t i = 0; i < sheets.model->slot_count; i++) {
        sheets.model->predicted[i][0] +=
            sheets.model->cloth_of[i] == 1 ? 1.01f * sheets.candidates->margin : 0.0f;
    }
    ck_assert_uint_gt(keep(&sheets), 0);
    start_here(&sheets);
    ck_assert_uint_eq(keep(&sheets), 0);
    close_sheets(&sheets);
}
END_TEST

/// One corner of the lower sheet comes up: only blocks near it are found anew.
START_TEST(what_moves_spends_its_own)
{
    Sheets sheets;
    open_sheets(&sheets, LARGE_SIDE);
    (void)keep(&sheets);
    const PercaleBlocks *blocks = &sheets.candidates->blocks;
    f32x4 corner = sheets.model->predicted[sheets.model->cloths[0].slots[0]];
    for (uint32_t i = 0; i < sheets.model->slot_count; i++) {
        bool moves = sheets.model->cloth_of[i] == 0 && length3(sheets.model->predicted[i] - corner) < 0.03f;
        sheets.model->predicted[i][1] += moves ? 1.5f * sheets.candidates->margin : 0.0f;
    }
    uint32_t searched = keep(&sheets);
    ck_assert_uint_gt(searched, 0);
    ck_assert_uint_le(searched, blocks->count / 2);
    for (uint32_t i = 0; i < searched; i++) { // none is far from the corner
        const PercaleBlock *block = &blocks->items[sheets.candidates->spent.blocks[i]];
        f32x4 apart = max4(block->low - corner, corner - block->high);
        ck_assert(fmaxf(apart[0], apart[2]) < 11.0f * EDGE);
    }
    close_sheets(&sheets);
}
END_TEST

/// One corner goes up and down; what lies still is found anew all the same before its moment is forgotten.
START_TEST(no_block_counts_from_a_moment_that_is_forgotten)
{
    Sheets sheets;
    open_sheets(&sheets, LARGE_SIDE);
    (void)keep(&sheets);
    const PercaleBlocks *blocks = &sheets.candidates->blocks;
    const uint32_t corner = sheets.model->cloths[0].slots[0];
    uint32_t *ages = calloc(blocks->count, sizeof(uint32_t));
    ck_assert_ptr_nonnull(ages);
    uint32_t rested = 0;
    for (uint32_t i = 0; i < 2 * BLOCK_MOMENTS; i++) {
        sheets.model->predicted[corner][1] += (i % 2 == 0 ? 1.5f : -1.5f) * sheets.candidates->margin;
        ck_assert_uint_gt(keep(&sheets), 0);
        for (uint32_t b = 0; b < blocks->count; b++) {
            ages[b]++;
            rested = ages[b] > rested ? ages[b] : rested;
            ck_assert_uint_lt(ages[b], BLOCK_MOMENTS + 1);
        }
        for (uint32_t k = 0; k < sheets.candidates->spent.count; k++) {
            ages[sheets.candidates->spent.blocks[k]] = 0;
        }
        start_here(&sheets);
    }
    ck_assert_uint_gt(rested, BLOCK_MOMENTS / 2);
    free(ages);
    close_sheets(&sheets);
}
END_TEST

/// Two sheets are thrown together and fold: what is kept must not matter for what comes of it.
START_TEST(the_state_is_that_of_finding_all_anew_in_each_substep)
{
    uint64_t hashes[2];
    for (int always = 0; always < 2; always++) {
        PercaleSolverDef def = percale_solver_def_default();
        def.self_collision = def.edge_edge = 1;
        def.substeps = def.iterations = def.passes = 1;
        Sheets sheets = {.solver = percale_test_solver(def),
                         .mesh = percale_test_sheet(SIDE, EDGE * (SIDE - 1))};
        for (int s = 0; s < SHEETS; s++) {
            (void)percale_test_add_cloth(sheets.solver, &sheets.mesh);
            percale_test_translate(&sheets.mesh, 0.003f, 0.004f, 0.03f);
        }
        for (int step = 0; step < 4 * STEPS; step++) {
            sheets.solver->candidates.known = sheets.solver->candidates.known && always == 0;
            PERCALE_TEST_OK(sheets.solver, percale_solver_step(sheets.solver, 1e-3));
            for (uint32_t i = 0; step == 0 && i < sheets.solver->model.slot_count; i++) {
                PercaleModel *model = &sheets.solver->model; // thrown together, and folding
                float side = model->cloth_of[i] == 0 ? 1.0f : -1.0f;
                model->velocity[i] += (f32x4){-20.0f * model->position[i][0], side, 2.0f * side, 0.0f};
            }
        }
        ck_assert_uint_gt(sheets.solver->counters.stencils_vf, 1000);
        ck_assert_uint_gt(sheets.solver->counters.stencils_ee, 1000);
        hashes[always] = percale_solver_hash(sheets.solver);
        close_sheets(&sheets);
    }
    ck_assert_uint_eq(hashes[0], hashes[1]);
}
END_TEST

/// Blocks are quarters of a sheet of large cells; a small thing falls into the cells between them, where no
/// vertex is.
START_TEST(blocks_reach_as_far_as_their_triangles)
{
    enum { CELLS = 15 };
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    Sheets sheets = {.solver = percale_test_solver(def), .mesh = percale_test_sheet(CELLS + 1, CELLS)};
    (void)percale_test_add_cloth(sheets.solver, &sheets.mesh);
    percale_test_translate(&sheets.mesh, 0.0f, 0.0f, 100.0f);
    (void)percale_test_add_cloth(sheets.solver, &sheets.mesh);
    PERCALE_TEST_OK(sheets.solver, percale_solver_prepare(sheets.solver));
    PercaleModel *model = sheets.model = &sheets.solver->model;
    sheets.candidates = &sheets.solver->candidates;
    f32x4 *places[2] = {model->position, model->predicted};
    for (uint32_t i = 0; i < model->slot_count; i++) {
        for (int p = 0; model->cloth_of[i] == 1 && p < 2; p++) {
            f32x4 x = places[p][i];
            places[p][i] = (f32x4){0.01f * x[0], 10.0f, 3.0f + 0.01f * (x[2] - 100.0f), x[3]};
        }
    }
    (void)keep(&sheets);
    ck_assert_uint_eq(keep(&sheets), 0);
    for (uint32_t i = 0; i < model->slot_count; i++) {
        if (model->cloth_of[i] == 1) {
            model->predicted[i][1] = model->position[i][1] = 0.001f;
        }
    }
    ck_assert_uint_gt(keep(&sheets), 0);
    close_sheets(&sheets);
}
END_TEST

/// A flat sheet whose edges are as long as it is thick: what is near on the rest shape, too, is no pair
/// before it comes nearer than it lies there. Those within the reach of what isn't near there are 84 a
/// vertex.
START_TEST(fine_cloth_is_no_candidate_of_its_own)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    Sheets sheets = {.solver = percale_test_solver(def),
                     .mesh = percale_test_sheet(LARGE_SIDE, EDGE * (LARGE_SIDE - 1))};
    PercaleClothDef cloth = percale_test_cloth_def(&sheets.mesh);
    cloth.material.thickness = EDGE;
    PercaleCloth handle;
    PERCALE_TEST_OK(sheets.solver, percale_cloth_add(sheets.solver, &cloth, &handle));
    PERCALE_TEST_OK(sheets.solver, percale_solver_prepare(sheets.solver));
    sheets.model = &sheets.solver->model;
    sheets.candidates = &sheets.solver->candidates;
    (void)keep(&sheets);
    size_t count = percale_candidate_count(&sheets.candidates->lists[0]) +
                   percale_candidate_count(&sheets.candidates->lists[1]);
    ck_assert_uint_gt(count, 0);
    ck_assert_uint_le(count, 34 * (size_t)sheets.model->slot_count);
    close_sheets(&sheets);
}
END_TEST

/// A sheet flies over another one, as low as half a millimetre, and beyond its rim, much farther than the
/// margin; then it ends a little deeper: nothing is searched for again, and all that passes now is visited.
START_TEST(ways_that_end_elsewhere_are_known)
{
    enum { SMALL_SIDE = 4 };
    Sheets sheets;
    open_sheets(&sheets, SMALL_SIDE);
    PercaleModel *model = sheets.model;
    for (uint32_t i = 0; i < model->slot_count; i++) {
        bool flies = model->cloth_of[i] == 1;
        model->position[i] -= flies ? (f32x4){0.038f, 0.0f, 0.0f, 0.0f} : (f32x4){0};
        model->predicted[i] += flies ? (f32x4){0.072f, -0.0115f, 0.0f, 0.0f} : (f32x4){0};
    }
    (void)keep(&sheets);
    ck_assert_uint_eq(count_passages(model), 0);
    for (uint32_t i = 0; i < model->slot_count; i++) {
        model->predicted[i][1] -= model->cloth_of[i] == 1 ? 0.9f * sheets.candidates->margin : 0.0f;
    }
    ck_assert_uint_eq(keep_again(&sheets, true), 0);
    ck_assert_uint_gt(count_passages(model), 10);
    for (int edges = 0; edges < 2; edges++) {
        Visited visited = visit(&sheets, edges != 0, NULL);
        uint32_t points[4];
        for (AllPairs all = all_pairs(model, edges != 0); next_pair(&all, points);) {
            ck_assert_msg(!do_pass(model, edges != 0, points) ||
                              visited.pairs[all.item * visited.primitive_count + all.primitive - 1],
                          "edges %d: %u and %u", edges, all.item, all.primitive - 1);
        }
        free(visited.pairs);
    }
    close_sheets(&sheets);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("candidates");
    TCase *candidates = tcase_create("candidates");
    tcase_set_timeout(candidates, 60.0);
    tcase_add_test(candidates, however_they_move_all_pairs_in_reach_are_visited);
    tcase_add_test(candidates, of_what_is_touched_all_pairs_are_visited_and_no_others);
    tcase_add_test(candidates, what_falls_together_spends_nothing_and_what_does_not_does);
    tcase_add_test(candidates, what_moves_spends_its_own);
    tcase_add_test(candidates, no_block_counts_from_a_moment_that_is_forgotten);
    tcase_add_test(candidates, the_state_is_that_of_finding_all_anew_in_each_substep);
    tcase_add_test(candidates, blocks_reach_as_far_as_their_triangles);
    tcase_add_test(candidates, fine_cloth_is_no_candidate_of_its_own);
    tcase_add_test(candidates, ways_that_end_elsewhere_are_known);
    suite_add_tcase(suite, candidates);
    return percale_test_run(suite);
}
