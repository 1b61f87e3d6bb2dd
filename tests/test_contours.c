// Edges that go through faces, found by the tree and by all pairs, and their contours: nothing is lost or
// counted twice, whatever touches or lies in one plane.

#include "tangle_testing.h"
#include "untangle/exact_sign.h"

#include <stdlib.h>
#include <string.h>

/// Crumpled sheets put into each other; on a lattice everything touches and lies in planes.
static PercaleSolver *crumple(uint64_t seed, bool on_lattice)
{
    PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
    for (int i = 0; i < 2; i++) {
        PercaleMesh mesh = percale_test_sheet(9, 0.8f);
        for (uint32_t k = 0; k < 3 * mesh.vertex_count; k++) {
            double moved = (double)mesh.positions[k] + 0.3 * (percale_test_random(&seed) - 0.5);
            moved += i == 1 && k % 3 == 0 ? 0.033 : 0.0;
            mesh.positions[k] = (float)(on_lattice ? 0.0625 * floor(moved / 0.0625 + 0.5) : moved);
        }
        PercaleClothDef def = percale_test_cloth_def(&mesh);
        PercaleMesh flat = percale_test_sheet(9, 0.8f);
        PercaleCloth cloth;
        def.rest_positions = flat.positions; // a triangle may have no area where it is, but not at rest
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
        percale_mesh_free(&flat);
        percale_mesh_free(&mesh);
    }
    return solver;
}

enum { SEEDS = 8 }; // half of them on the lattice

static Tangle *look_at_crumple(int seed, int thread_count)
{
    return look(crumple((uint64_t)seed + 1, seed % 2 == 1), thread_count);
}

START_TEST(crossings_equal_all_pairs)
{
    Tangle *tangle = look_at_crumple(_i, 2);
    const PercaleTangleMesh *mesh = &tangle->mesh;
    size_t found = 0;
    for (uint32_t edge = 0; edge < mesh->edges.edge_count; edge++) {
        const uint32_t *ends = mesh->edges.vertices[edge];
        for (uint32_t face = 0; face < mesh->triangle_count; face++) {
            const uint32_t *corners = corners_of_triangle(mesh, face);
            bool meet = false;
            for (int k = 0; k < 6; k++) {
                meet = meet || ends[k / 3] == corners[k % 3];
            }
            if (!meet && percale_does_edge_cross(tangle->solver->model.position, ends, corners)) {
                ck_assert(found < tangle->crossings.count);
                ck_assert_uint_eq(tangle->crossings.items[found].edge, edge);
                ck_assert_uint_eq(tangle->crossings.items[found++].face, face);
            }
        }
    }
    ck_assert_uint_eq(found, tangle->crossings.count);
    ck_assert(found > 100);
    look_away(tangle);
}
END_TEST

START_TEST(two_triangles_have_no_crossing_or_two)
{
    Tangle *tangle = look_at_crumple(_i, 1);
    const PercaleContours *contours = &tangle->contours;
    uint32_t loops = 0;
    for (size_t i = 0; i < contours->piece_count; i++) {
        const PercaleContourPiece *piece = &contours->pieces[i];
        bool meet = do_triangles_meet(&tangle->mesh, piece->triangles[0], piece->triangles[1]);
        ck_assert_msg(meet == (piece->crossings[1] == NO_INDEX), "triangles %u and %u", piece->triangles[0],
                      piece->triangles[1]);
        loops += meet;
    }
    ck_assert(loops > 10);
    look_away(tangle);
}
END_TEST

/// The place on the edge and the place on the face are one, and between them.
START_TEST(a_crossing_is_on_its_edge_and_on_its_face)
{
    Tangle *tangle = look_at_crumple(2 * _i, 1);
    const f32x4 *x = tangle->solver->model.position;
    for (size_t i = 0; i < tangle->crossings.count; i++) {
        const PercaleTangleCrossing *crossing = &tangle->crossings.items[i];
        const uint32_t *corners = corners_of_triangle(&tangle->mesh, crossing->face);
        Vec3 on_face = vec3(0.0, 0.0, 0.0);
        for (int k = 0; k < 3; k++) {
            ck_assert(crossing->weights[k] >= 0.0);
            on_face = vadd(on_face, vscale(crossing->weights[k], vec3_of(x[corners[k]])));
        }
        ck_assert(crossing->along >= 0.0 && crossing->along <= 1.0);
        Vec3 gap = vsub(on_face, percale_crossing_point(&tangle->mesh, crossing, x));
        ck_assert_msg(vlength(gap) < 1e-9, "crossing %zu: %g m", i, vlength(gap));
    }
    look_away(tangle);
}
END_TEST

/// Every crossing is a step of one contour, once; open contours end where the classes say.
START_TEST(contours_hold_every_crossing_once)
{
    Tangle *tangle = look_at_crumple(_i, 1);
    const PercaleContours *contours = &tangle->contours;
    uint8_t *seen = calloc(tangle->crossings.count, 1);
    ck_assert_ptr_nonnull(seen);
    size_t pieces = 0;
    for (size_t i = 0; i < contours->count; i++) {
        const PercaleContour *contour = &contours->items[i];
        for (uint32_t k = 0; k < contour->count; k++) {
            const PercaleContourStep *step = &contours->steps[contour->first + k];
            ck_assert_uint_eq(seen[step->crossing]++, 0);
            bool is_last = k + 1 == contour->count;
            bool ends = !contour->is_closed && is_last && contour->ends[step->trace][1] == 'B';
            ck_assert_int_eq(step->after == NO_INDEX, ends);
        }
        bool loop_first = contour->ends[0][0] == 'L';
        bool loop_last = contour->ends[0][1] == 'L';
        pieces += contour->count - 1 + contour->is_closed + loop_first + loop_last;
    }
    for (size_t i = 0; i < tangle->crossings.count; i++) {
        ck_assert_msg(seen[i] == 1, "crossing %zu is in no contour", i);
    }
    ck_assert_uint_eq(pieces, contours->piece_count);
    free(seen);
    look_away(tangle);
}
END_TEST

/// The sign turns with every exchange of two points and is never 0.
START_TEST(sides_turn_with_the_order)
{
    uint64_t seed = 5;
    for (int i = 0; i < 4000; i++) {
        f32x4 x[4];
        uint32_t numbers[4] = {0, 1, 2, 3};
        for (int k = 0; k < 12; k++) {
            x[k / 3][k % 3] = (float)(int)(percale_test_random(&seed) * 3.0);
        }
        int sign = percale_plane_side(x, numbers);
        ck_assert(sign == 1 || sign == -1);
        for (int a = 0; a < 4; a++) {
            for (int b = a + 1; b < 4; b++) {
                uint32_t turned[4] = {0, 1, 2, 3};
                turned[a] = (uint32_t)b;
                turned[b] = (uint32_t)a;
                ck_assert_int_eq(percale_plane_side(x, turned), -sign);
            }
        }
        Vec3 a = vec3_of(x[0]);
        double volume = vdot(vsub(vec3_of(x[1]), a),
                             vcross(vsub(vec3_of(x[2]), a), vsub(vec3_of(x[3]), a))); // exact: small integers
        ck_assert(volume == 0.0 || (volume > 0.0) == (sign > 0));
    }
}
END_TEST

START_TEST(one_thread_equals_seven)
{
    Tangle *one = look_at_crumple(_i, 1);
    Tangle *seven = look_at_crumple(_i, 7);
    ck_assert_uint_eq(one->crossings.count, seven->crossings.count);
    ck_assert_uint_eq(one->contours.count, seven->contours.count);
    for (size_t i = 0; i < one->contours.count; i++) {
        ck_assert_uint_eq(one->contours.items[i].count, seven->contours.items[i].count);
        ck_assert(one->contours.items[i].length == seven->contours.items[i].length);
    }
    look_away(one);
    look_away(seven);
}
END_TEST

// ---- kinds ----

/// Each standard case has a contour of its kind; those that are nothing else have no other.
START_TEST(standard_case_is_recognised)
{
    const char *name = tangle_standard_name((uint32_t)_i);
    bool is_pure = strcmp(name, "Cross") != 0 && strcmp(name, "Eight") != 0;
    for (uint32_t resolution = 0; resolution < TANGLE_RESOLUTIONS; resolution++) {
        TangleCase tangle_case;
        ck_assert(tangle_case_make_standard(name, 2, resolution, &tangle_case));
        Tangle *tangle = look(solver_of_case(&tangle_case), 2);
        int of_kind = 0;
        for (size_t i = 0; i < tangle->contours.count; i++) {
            const char *kind = percale_contour_kind_name(tangle->contours.items[i].kind);
            of_kind += strcmp(kind, name) == 0;
            ck_assert_msg(!is_pure || strcmp(kind, name) == 0, "%s: %s", tangle_case.name, kind);
        }
        ck_assert_msg(of_kind > 0 && (!is_pure || of_kind == 1), "%s: %d contours of its kind among %zu",
                      tangle_case.name, of_kind, tangle->contours.count);
        look_away(tangle);
        tangle_case_free(&tangle_case);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("contours");
    TCase *crossings = tcase_create("crossings");
    tcase_add_loop_test(crossings, crossings_equal_all_pairs, 0, SEEDS);
    tcase_add_loop_test(crossings, two_triangles_have_no_crossing_or_two, 0, SEEDS);
    tcase_add_loop_test(crossings, a_crossing_is_on_its_edge_and_on_its_face, 0, SEEDS / 2);
    tcase_add_test(crossings, sides_turn_with_the_order);
    TCase *contours = tcase_create("contours");
    tcase_add_loop_test(contours, contours_hold_every_crossing_once, 0, SEEDS);
    tcase_add_loop_test(contours, one_thread_equals_seven, 0, SEEDS);
    tcase_add_loop_test(contours, standard_case_is_recognised, 0, TANGLE_STANDARD);
    suite_add_tcase(suite, crossings);
    suite_add_tcase(suite, contours);
    return percale_test_run(suite);
}
