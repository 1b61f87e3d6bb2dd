// Stencils that are found anew because they have slid, and those that stay.

#include "pairs_testing.h"
#include "percale/geometry.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 7 };
static const float WIDTH = 0.1f;       // m
static const float THICKNESS = 0.002f; // m

// ---- finding some pairs anew ----

/// Two sheets of cloth that nearly touch.
static PercaleSolver *two_sheets(void)
{
    PercaleSolverDef def = percale_solver_def_default();
    def.self_collision = def.edge_edge = 1;
    PercaleSolver *solver = percale_test_solver(def);
    for (int sheet = 0; sheet < 2; sheet++) {
        PercaleMesh mesh = percale_test_sheet(SIDE, WIDTH);
        percale_test_translate(&mesh, 0.004f * (float)sheet, THICKNESS * (float)sheet, 0.003f * (float)sheet);
        PercaleClothDef cloth = percale_test_cloth_def(&mesh);
        cloth.material.thickness = THICKNESS;
        PercaleCloth handle;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &cloth, &handle));
        percale_mesh_free(&mesh);
    }
    PERCALE_TEST_OK(solver, percale_solver_prepare(solver));
    return solver;
}

/// Every point goes up to 3 mm along the sheets and a fifth of the thickness across: they don't cross.
static void shift(PercaleModel *model, const f32x4 *flat, uint64_t *seed)
{
    for (uint32_t i = 0; i < model->slot_count; i++) {
        f32x4 x = flat[i];
        for (int axis = 0; axis < 3; axis++) {
            float most = axis == 1 ? 0.2f * THICKNESS : 0.003f;
            x[axis] += most * (float)(2.0 * percale_test_random(seed) - 1.0);
        }
        model->position[i] = model->predicted[i] = x;
    }
}

/// Stencils and notes as they stand.
typedef struct Found {
    PercaleStencil *stencils;
    PercaleNoteList notes;
    size_t count;
} Found;

static Found find(PercaleSolver *solver, const PercaleNoteList *known, const PercaleSources *only)
{
    (void)percale_test_find_pairs(solver, known, false, only);
    const PercaleNoteList *notes = &solver->notes[1];
    Found found = {calloc(solver->stencils.count + 1, sizeof(PercaleStencil)),
                   {NULL, notes->count, 0},
                   solver->stencils.count};
    found.notes.items = calloc(notes->count + 1, sizeof(PercalePairNote));
    ck_assert(found.stencils != NULL && found.notes.items != NULL);
    memcpy(found.stencils, solver->stencils.items, found.count * sizeof(PercaleStencil));
    memcpy(found.notes.items, notes->items, notes->count * sizeof(PercalePairNote));
    return found;
}

static void free_found(Found *found)
{
    free(found->stencils);
    free(found->notes.items);
}

/// Every third source of some stencils.
static PercaleSources some_sources(const Found *found, uint64_t *items)
{
    PercaleSources sources = {items, 0};
    uint32_t number = 0;
    for (size_t i = 0; i < found->count; i++) {
        if (i == 0 || found->stencils[i].source != found->stencils[i - 1].source) {
            if (number++ % 3 == 0) {
                items[sources.count++] = found->stencils[i].source;
            }
        }
    }
    return sources;
}

static void expect_stencils(const Found *some, const Found *all, const PercaleSources *only)
{
    size_t size = 0;
    PercaleStencil *expected = calloc(all->count + 1, sizeof(*expected));
    for (size_t i = 0; i < all->count; i++) {
        if (percale_sources_contain(only, all->stencils[i].source)) {
            expected[size++] = all->stencils[i];
        }
    }
    ck_assert(some->count == size && size > 10 && all->count > 2 * size);
    ck_assert_mem_eq(some->stencils, expected, size * sizeof(*expected));
    free(expected);
}

static bool is_same(const PercalePairNote *a, const PercalePairNote *b)
{
    float apart = 0.0f;
    for (int k = 0; k < 4; k++) {
        apart += fabsf(a->normal[k] - b->normal[k]);
    }
    return a->key == b->key && a->source == b->source && !(apart > 0.0f);
}

/// How many of the notes are of the sources, or not of them; each must be among `of` with the same side.
static size_t count_notes(const PercaleNoteList *notes, const PercaleSources *sources, bool inside,
                          const PercaleNoteList *of)
{
    size_t count = 0;
    for (size_t i = 0; i < notes->count; i++) {
        const PercalePairNote *note = &notes->items[i];
        if (percale_sources_contain(sources, note->source) == inside) {
            bool known = false;
            for (size_t k = 0; k < of->count; k++) {
                known = known || is_same(&of->items[k], note);
            }
            ck_assert(known);
            count++;
        }
    }
    return count;
}

START_TEST(pairs_of_some_sources_are_theirs_among_all)
{
    PercaleSolver *solver = two_sheets();
    PercaleModel *model = &solver->model;
    f32x4 *flat = malloc(model->slot_count * sizeof(f32x4));
    memcpy(flat, model->position, model->slot_count * sizeof(f32x4));
    uint64_t seed = 5;
    for (int round = 0; round < 20; round++) {
        const PercaleNoteList none = {0};
        shift(model, flat, &seed);
        Found before = find(solver, &none, NULL);
        shift(model, flat, &seed);
        Found all = find(solver, &before.notes, NULL);
        uint64_t *items = calloc(all.count + 1, sizeof(uint64_t));
        PercaleSources only = some_sources(&all, items);
        Found some = find(solver, &before.notes, &only);
        expect_stencils(&some, &all, &only);
        size_t renewed = count_notes(&some.notes, &only, true, &all.notes);
        size_t kept = count_notes(&some.notes, &only, false, &before.notes);
        ck_assert_uint_eq(renewed, count_notes(&all.notes, &only, true, &all.notes));
        ck_assert_uint_eq(kept, count_notes(&before.notes, &only, false, &before.notes));
        for (size_t i = 1; i < some.notes.count; i++) {
            ck_assert_uint_lt(some.notes.items[i - 1].key, some.notes.items[i].key);
        }
        free(items);
        free_found(&before);
        free_found(&all);
        free_found(&some);
    }
    memcpy(model->position, flat, model->slot_count * sizeof(f32x4));
    free(flat);
    percale_solver_destroy(solver);
}
END_TEST

// ---- which stay ----

/// A vertex above a triangle, found at the origin.
static PercaleStencil stencil_of(uint64_t source, uint32_t point, float most_slip, float pushed)
{
    return (PercaleStencil){.points = {point, 1, 2, 3},
                            .weights = {1.0f, -0.5f, -0.25f, -0.25f},
                            .normal = {0.0f, 1.0f, 0.0f, 0.01f},
                            .multiplier = {0.0f, 0.0f, 0.0f, pushed},
                            .seen = {0.0f, 0.0f, 0.0f, most_slip},
                            .source = source};
}

START_TEST(what_has_slid_goes_and_what_has_pushed_stays_for_the_substep)
{
    // the vertices 4 and 5 have slid by 2 mm, 6 has only risen
    const f32x4 x[7] = {{0}, {0}, {0}, {0}, {2e-3f}, {2e-3f}, {0.0f, 0.1f}};
    PercaleStencil known[] = {
        stencil_of(1, 6, 0.0f, 1.0f),  // no limit, has pushed
        stencil_of(1, 5, 1e-3f, 0.0f), // too far
        stencil_of(3, 4, 1e-3f, 1.0f), // too far, has pushed
        stencil_of(3, 5, 3e-3f, 0.0f), // fits
        stencil_of(7, 6, 1e-3f, 0.0f), // fits
        stencil_of(8, 6, 0.0f, 0.0f),  // no limit
    };
    PercaleStencil found[] = {stencil_of(2, 0, 1e-3f, 0.0f), stencil_of(3, 5, 1e-3f, 0.0f),
                              stencil_of(3, 4, 1e-3f, 0.0f), stencil_of(9, 6, 1e-3f, 0.0f)};
    // as source, point, whether the known one has stayed
    static const uint64_t WITHIN[][3] = {{1, 6, 1}, {2, 0, 0}, {3, 5, 1}, {3, 4, 0}, {7, 6, 1}, {9, 6, 0}};
    static const uint64_t BETWEEN[][3] = {{1, 6, 1}, {2, 0, 0}, {3, 5, 1}, {3, 4, 0},
                                          {7, 6, 1}, {8, 6, 1}, {9, 6, 0}};
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    for (int i = 0; i < 6; i++) {
        known[i].friction = 1.0f; // a mark
    }
    for (int within = 0; within < 2; within++) {
        const PercaleStencilList before = {known, 6, 6};
        PercaleStencilList list = {NULL, 0, 0};
        ck_assert(
            percale_memory_reserve(&solver->detect_memory, &list.items, &list.capacity, 4, sizeof(known[0])));
        memcpy(list.items, found, sizeof(found));
        list.count = 4;
        ck_assert(percale_renew_merge(&before, within, x, &solver->arena, &solver->detect_memory,
                                      percale_team_alone(), &list));
        ck_assert_uint_eq(list.count, within ? 6 : 7);
        for (size_t i = 0; i < list.count; i++) {
            const uint64_t *expected = within ? WITHIN[i] : BETWEEN[i];
            ck_assert_uint_eq(list.items[i].source, expected[0]);
            ck_assert_uint_eq(list.items[i].points[0], expected[1]);
            ck_assert_int_eq(list.items[i].friction > 0.0f, expected[2] == 1);
        }
        percale_memory_free(&solver->detect_memory, list.items);
    }
    PercaleSources slid;
    const PercaleStencilList before = {known, 6, 6};
    ck_assert(percale_renew_find(&before, x, &solver->arena, percale_team_alone(), &slid));
    ck_assert_uint_eq(slid.count, 2);
    ck_assert(slid.items[0] == 1 && slid.items[1] == 3);
    percale_solver_destroy(solver);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("renew");
    TCase *renew = tcase_create("renew");
    tcase_set_timeout(renew, 0);
    tcase_add_test(renew, pairs_of_some_sources_are_theirs_among_all);
    tcase_add_test(renew, what_has_slid_goes_and_what_has_pushed_stays_for_the_substep);
    suite_add_tcase(suite, renew);
    return percale_test_run(suite);
}
