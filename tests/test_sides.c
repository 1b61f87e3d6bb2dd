// On which side of each other two features belong: as their paths, the notes and an obstacle's surface say.

#include "pairs_testing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/// Two sheets of one cell, 0.1 m wide: `face` lies level, a corner of `other` is what it meets. Times: the
/// start of the substep and its end.
typedef struct Meeting {
    PercaleSolver *solver;
    PercaleMesh mesh;
    uint32_t corner; // of `other`: its slot
    bool hangs;      // from its corner; else it rises
} Meeting;

static void place_other(Meeting *meeting, f32x4 *points, float x, float y, float z)
{
    const PercaleModel *model = &meeting->solver->model;
    for (uint32_t i = 0; i < model->cloths[1].vertex_count; i++) {
        const float *at = meeting->mesh.positions + 3 * (size_t)i;
        f32x4 *point = &points[model->cloths[1].slots[i]];
        // it rises from its first corner, steeply, or hangs down, so that nothing but that is near
        float away = (at[0] + 0.05f) + (at[2] + 0.05f);
        *point = (f32x4){x + (at[0] + 0.05f) * 0.3f, meeting->hangs ? y - away : y + away,
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
    meeting->hangs = false;
}

static void close_meeting(Meeting *meeting)
{
    place_other(meeting, meeting->solver->model.position, 0.0f, 0.0f, 0.0f);
    percale_solver_destroy(meeting->solver);
    percale_mesh_free(&meeting->mesh);
}

/// Height of the normal of the corner's stencil with a face; 0 without one.
static float push_of(Meeting *meeting, const PercaleNoteList *known)
{
    PercaleSolver *solver = meeting->solver;
    (void)percale_test_find_pairs(solver, known, false, NULL);
    for (size_t i = 0; i < solver->stencils.count; i++) {
        const PercaleStencil *stencil = &solver->stencils.items[i];
        if (stencil->points[0] == meeting->corner && stencil->weights[1] < 0.0f &&
            stencil->weights[2] < 0.0f && stencil->weights[3] < 0.0f) {
            return stencil->normal[1];
        }
    }
    return 0.0f;
}

/// The ways of the corner: where it was at the start and at the end; which way it is pushed.
static const struct {
    float x[2][2]; // level place (of x; z is 0.01) and height
    float push;
} WAYS[] = {
    {{{-0.02f, 0.003f}, {-0.02f, 0.001f}}, 1.0f},    // comes near from above
    {{{-0.02f, -0.003f}, {-0.02f, -0.001f}}, -1.0f}, // from below
    {{{-0.02f, 0.003f}, {-0.02f, -0.002f}}, 1.0f},   // would go through
    {{{-0.02f, -0.003f}, {-0.02f, 0.002f}}, -1.0f},  // too, upwards
    {{{-0.02f, 0.050f}, {-0.02f, -0.050f}}, 1.0f},   // far
    {{{-0.08f, 0.003f}, {-0.02f, -0.001f}}, 1.0f},   // through, beside the rim at first
    {{{-0.08f, 0.001f}, {-0.02f, -0.003f}}, -1.0f},  // around the rim
};

static void go(Meeting *meeting, const float x[2][2])
{
    PercaleModel *model = &meeting->solver->model;
    f32x4 *places[2] = {model->position, model->predicted};
    for (int i = 0; i < 2; i++) {
        place_other(meeting, places[i], x[i][0], x[i][1], 0.01f);
    }
}

START_TEST(a_vertex_keeps_the_side_that_its_path_says)
{
    const PercaleNoteList none = {0};
    for (size_t i = 0; i < sizeof(WAYS) / sizeof(WAYS[0]); i++) {
        Meeting meeting;
        open_meeting(&meeting);
        meeting.hangs = WAYS[i].x[0][1] < 0.0f; // free of the face at first
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
    const float through[2][2] = {{-0.02f, 0.003f}, {-0.02f, -0.002f}};
    const float below[2][2] = {{-0.02f, -0.002f}, {-0.015f, -0.002f}};
    const float beside[2][2] = {{-0.015f, -0.002f}, {0.03f, -0.002f}};
    const float(*const ways[3])[2] = {through, below, beside};
    for (int i = 0; i < 3; i++) {
        go(&meeting, ways[i]);
        PercaleNoteList known = solver->notes[0];
        float push = push_of(&meeting, i == 0 ? &none : &known);
        ck_assert_msg(fabsf(push - 1.0f) < 1e-6f, "step %d: %g", i, (double)push);
        solver->notes[0] = solver->notes[1];
        solver->notes[1] = known;
    }
    go(&meeting, below);
    ck_assert(fabsf(push_of(&meeting, &none)) <= 0.0f); // without a note it has always been through
    close_meeting(&meeting);
}
END_TEST

/// Two long edges across each other, one moves through the other, or doesn't: the normal is that of the
/// start.
START_TEST(edges_keep_the_side_that_their_path_says)
{
    const float HEIGHTS[][2] = {{0.003f, 0.001f}, {0.003f, -0.002f}, {-0.003f, 0.002f}, {0.05f, -0.05f}};
    const PercaleNoteList none = {0};
    for (size_t i = 0; i < sizeof(HEIGHTS) / sizeof(HEIGHTS[0]); i++) {
        Meeting meeting;
        open_meeting(&meeting);
        PercaleSolver *solver = meeting.solver;
        PercaleModel *model = &solver->model;
        f32x4 *places[2] = {model->position, model->predicted};
        for (int p = 0; p < 2; p++) {
            for (uint32_t v = 0; v < 4; v++) { // upright sheets: row 0 at the height, row 1 away from it
                const float *at = meeting.mesh.positions + 3 * (size_t)v;
                float up = at[2] > 0.0f ? 0.1f : 0.0f;
                f32x4 *low = &places[p][model->cloths[0].slots[v]];
                f32x4 *high = &places[p][model->cloths[1].slots[v]];
                // they are free of each other at first
                float away = HEIGHTS[i][0] > 0.0f ? up : -up;
                *low = (f32x4){at[0], -away, 0.01f, (*low)[3]};
                *high = (f32x4){0.013f, HEIGHTS[i][p] + away, at[0], (*high)[3]};
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
    const PercaleNoteList none = {0};
    PercalePairCounts counts = percale_test_find_pairs(solver, &none, true, NULL);
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

int main(void)
{
    Suite *suite = suite_create("sides");
    TCase *sides = tcase_create("sides");
    tcase_add_test(sides, a_vertex_keeps_the_side_that_its_path_says);
    tcase_add_test(sides, a_note_keeps_the_side_while_the_vertex_is_below);
    tcase_add_test(sides, edges_keep_the_side_that_their_path_says);
    tcase_add_test(sides, corners_of_a_box_hold_a_face_above_them);
    suite_add_tcase(suite, sides);
    return percale_test_run(suite);
}
