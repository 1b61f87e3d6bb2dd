// Seams: pairs pull themselves shut, become one point, and part again when the seam is cut.

#include "testing.h"

#include "solve/sweep.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double FRAME = 1.0 / 60.0; // s
static const double WELD = 1e-3;        // m; a pair closed within this becomes one point
enum { SIDE = 9 };

/// Two sheets side by side, 60 mm apart, to be sewn along their facing rims; in one cloth or in two.
typedef struct Scene {
    PercaleSolver *solver;
    PercaleMesh left, right, both;
    PercaleCloth cloths[2]; // equal when both are in one
    uint32_t rims[2][SIDE]; // vertices along the seam, in the numbering of their cloth
    PercaleSeam seam;
} Scene;

static const float GAP = 0.06f; // m

static PercaleMesh join(const PercaleMesh *a, const PercaleMesh *b)
{
    PercaleMesh both = percale_test_sheet(2 * SIDE, 1.0f); // has room for both
    ck_assert(both.vertex_count >= a->vertex_count + b->vertex_count);
    ck_assert(both.triangle_count >= a->triangle_count + b->triangle_count);
    both.vertex_count = a->vertex_count + b->vertex_count;
    both.triangle_count = a->triangle_count + b->triangle_count;
    memcpy(both.positions, a->positions, 3 * sizeof(float) * a->vertex_count);
    memcpy(both.positions + 3 * (size_t)a->vertex_count, b->positions, 3 * sizeof(float) * b->vertex_count);
    memcpy(both.triangles, a->triangles, 3 * sizeof(uint32_t) * a->triangle_count);
    for (size_t i = 0; i < 3 * (size_t)b->triangle_count; i++) {
        both.triangles[3 * (size_t)a->triangle_count + i] = a->vertex_count + b->triangles[i];
    }
    return both;
}

static Scene create(bool one_cloth, float right_density)
{
    PercaleSolverDef def = percale_solver_def_default();
    memset(def.gravity, 0, sizeof(def.gravity));
    def.damping = 0.0f;
    def.thread_count = 2;
    Scene scene = {.solver = percale_test_solver(def)};
    scene.left = percale_test_sheet(SIDE, 0.4f);
    scene.right = percale_test_sheet(SIDE, 0.4f);
    percale_test_translate(&scene.right, 0.4f + GAP, 0.0f, 0.0f);
    scene.both = join(&scene.left, &scene.right);
    if (one_cloth) {
        scene.cloths[0] = scene.cloths[1] = percale_test_add_cloth(scene.solver, &scene.both);
    } else {
        scene.cloths[0] = percale_test_add_cloth(scene.solver, &scene.left);
        PercaleClothDef right = percale_test_cloth_def(&scene.right);
        right.material.density = right_density;
        PERCALE_TEST_OK(scene.solver, percale_cloth_add(scene.solver, &right, &scene.cloths[1]));
    }
    for (uint32_t row = 0; row < SIDE; row++) {
        scene.rims[0][row] = SIDE * row + SIDE - 1;
        scene.rims[1][row] = SIDE * row + (one_cloth ? scene.left.vertex_count : 0);
    }
    PercaleSeamDef seam = percale_seam_def_default();
    seam.cloth_a = scene.cloths[0];
    seam.cloth_b = scene.cloths[1];
    seam.vertices_a = scene.rims[0];
    seam.vertices_b = scene.rims[1];
    seam.pair_count = SIDE;
    PERCALE_TEST_OK(scene.solver, percale_seam_add(scene.solver, &seam, &scene.seam));
    return scene;
}

static void destroy(Scene *scene)
{
    percale_solver_destroy(scene->solver);
    percale_mesh_free(&scene->left);
    percale_mesh_free(&scene->right);
    percale_mesh_free(&scene->both);
}

static void run(Scene *scene, int frames)
{
    for (int frame = 0; frame < frames; frame++) {
        PERCALE_TEST_OK(scene->solver, percale_solver_step(scene->solver, FRAME));
        PERCALE_TEST_OK(scene->solver, percale_solver_validate(scene->solver));
    }
}

/// Position of pair `row` on side 0 or 1.
static void rim_point(Scene *scene, int side, uint32_t row, float point[3])
{
    float positions[3 * 2 * SIDE * SIDE];
    PERCALE_TEST_OK(scene->solver,
                    percale_cloth_get_positions(scene->solver, scene->cloths[side], positions, 0));
    memcpy(point, positions + 3 * (size_t)scene->rims[side][row], 3 * sizeof(float));
}

static double gap_of(Scene *scene, uint32_t row)
{
    float a[3];
    float b[3];
    rim_point(scene, 0, row, a);
    rim_point(scene, 1, row, b);
    double sum = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        sum += ((double)a[axis] - (double)b[axis]) * ((double)a[axis] - (double)b[axis]);
    }
    return sqrt(sum);
}

/// Mass, momentum and mass times position over all points, each welded one once.
typedef struct Sums {
    double mass, momentum[3], moment[3];
} Sums;

static Sums sums_of(Scene *scene)
{
    Sums sums = {0};
    uint32_t seen[4 * SIDE * SIDE];
    uint32_t seen_count = 0;
    int cloth_count = scene->cloths[0].id == scene->cloths[1].id ? 1 : 2;
    for (int c = 0; c < cloth_count; c++) {
        PercaleClothView view;
        PERCALE_TEST_OK(scene->solver, percale_cloth_view(scene->solver, scene->cloths[c], &view));
        for (uint32_t i = 0; i < view.vertex_count; i++) {
            uint32_t slot = view.order[i];
            bool is_new = true;
            for (uint32_t k = 0; k < seen_count; k++) {
                is_new = is_new && seen[k] != slot;
            }
            if (!is_new) {
                continue;
            }
            seen[seen_count++] = slot;
            const float *x = view.positions + 4 * (size_t)slot;
            double mass = 1.0 / (double)x[3];
            sums.mass += mass;
            for (int axis = 0; axis < 3; axis++) {
                sums.momentum[axis] += mass * (double)view.velocities[4 * (size_t)slot + (size_t)axis];
                sums.moment[axis] += mass * (double)x[axis];
            }
        }
    }
    return sums;
}

START_TEST(an_open_seam_closes_and_becomes_one_point)
{
    Scene scene = create(_i == 0, 0.2f);
    ck_assert_double_gt(gap_of(&scene, 0), 0.9 * (double)GAP);
    run(&scene, 3); // 0.05 s: 25 mm of the 60, and what the cloth adds by springing back
    ck_assert_double_gt(gap_of(&scene, 4), WELD);
    ck_assert_double_lt(gap_of(&scene, 4), 0.6 * (double)GAP);
    run(&scene, 57);
    for (uint32_t row = 0; row < SIDE; row++) {
        float a[3];
        float b[3];
        rim_point(&scene, 0, row, a);
        rim_point(&scene, 1, row, b);
        ck_assert_mem_eq(a, b, sizeof(a));
    }
    PercaleClothView views[2];
    PERCALE_TEST_OK(scene.solver, percale_cloth_view(scene.solver, scene.cloths[0], &views[0]));
    PERCALE_TEST_OK(scene.solver, percale_cloth_view(scene.solver, scene.cloths[1], &views[1]));
    for (uint32_t row = 0; row < SIDE; row++) {
        ck_assert_uint_eq(views[0].order[scene.rims[0][row]], views[1].order[scene.rims[1][row]]);
    }
    uint64_t before = percale_solver_counters(scene.solver).projections_seam;
    run(&scene, 1);
    ck_assert_uint_eq(percale_solver_counters(scene.solver).projections_seam,
                      before); // nothing is left to pull
    destroy(&scene);
}
END_TEST

// The right cloth weighs five times as much: its rim comes less far.
START_TEST(closing_and_welding_keep_mass_momentum_and_centre)
{
    Scene scene = create(false, 1.0f);
    Sums before = sums_of(&scene);
    run(&scene, 60);
    Sums after = sums_of(&scene);
    ck_assert_double_lt(gap_of(&scene, 4), 1e-9);
    ck_assert_double_eq_tol(after.mass, before.mass, 1e-6 * before.mass);
    for (int axis = 0; axis < 3; axis++) { // nothing moved at first: the scale is 0.5 m/s of all the mass
        // rounding of float32 positions, a random walk over 1,200 substeps
        ck_assert_double_eq_tol(after.momentum[axis], 0.0, 5e-4 * 0.5 * before.mass);
        ck_assert_double_eq_tol(after.moment[axis] / after.mass, before.moment[axis] / before.mass, 1e-4);
    }
    destroy(&scene);
}
END_TEST

// Two moving single points that are sewn where they meet: the mean velocity by mass.
START_TEST(a_weld_is_a_perfectly_inelastic_impact)
{
    Scene scene = create(false, 1.0f);
    PERCALE_TEST_OK(scene.solver, percale_seam_remove(scene.solver, scene.seam));
    float velocities[3 * SIDE * SIDE] = {0};
    for (size_t i = 0; i < SIDE * SIDE; i++) {
        velocities[3 * i + 1] = 0.25f;
    }
    PERCALE_TEST_OK(scene.solver, percale_cloth_set_velocities(scene.solver, scene.cloths[0], velocities, 0));
    for (size_t i = 0; i < scene.right.vertex_count; i++) {
        scene.right.positions[3 * i] -= GAP;
    }
    PERCALE_TEST_OK(scene.solver,
                    percale_cloth_set_positions(scene.solver, scene.cloths[1], scene.right.positions, 0));
    Sums before = sums_of(&scene);
    PercaleSeamDef seam = percale_seam_def_default();
    seam.cloth_a = scene.cloths[0];
    seam.cloth_b = scene.cloths[1];
    seam.vertices_a = scene.rims[0];
    seam.vertices_b = scene.rims[1];
    seam.pair_count = SIDE;
    PERCALE_TEST_OK(scene.solver, percale_seam_add(scene.solver, &seam, &scene.seam));
    Sums after = sums_of(&scene); // welded at once: they touch
    PercaleClothView view;
    PERCALE_TEST_OK(scene.solver, percale_cloth_view(scene.solver, scene.cloths[0], &view));
    double rim_speed = (double)view.velocities[4 * (size_t)view.order[scene.rims[0][4]] + 1];
    ck_assert_double_eq_tol(rim_speed, 0.25 * 0.2 / (0.2 + 1.0), 1e-6);
    ck_assert_double_eq_tol(after.mass, before.mass, 1e-6 * before.mass);
    for (int axis = 0; axis < 3; axis++) {
        ck_assert_double_eq_tol(after.momentum[axis], before.momentum[axis], 1e-6 * before.mass);
        ck_assert_double_eq_tol(after.moment[axis], before.moment[axis], 1e-6 * before.mass);
    }
    destroy(&scene);
}
END_TEST

START_TEST(a_cut_seam_parts_where_it_is)
{
    Scene scene = create(_i == 0, 0.2f);
    Sums sewn = sums_of(&scene);
    run(&scene, 60);
    float before[3];
    rim_point(&scene, 0, 4, before);
    PERCALE_TEST_OK(scene.solver, percale_seam_remove(scene.solver, scene.seam));
    float after[2][3];
    rim_point(&scene, 0, 4, after[0]);
    rim_point(&scene, 1, 4, after[1]);
    ck_assert_mem_eq(before, after[0], sizeof(before));
    ck_assert_mem_eq(before, after[1], sizeof(before));
    ck_assert_double_eq_tol(sums_of(&scene).mass, sewn.mass, 1e-6 * sewn.mass);
    // each side goes its own way again
    float velocities[3 * 2 * SIDE * SIDE] = {0};
    for (size_t i = 0; i < scene.right.vertex_count; i++) {
        velocities[3 * (i + (_i == 0 ? scene.left.vertex_count : 0))] = 0.5f;
    }
    PERCALE_TEST_OK(scene.solver, percale_cloth_set_velocities(scene.solver, scene.cloths[1], velocities, 0));
    run(&scene, 12);
    ck_assert_double_gt(gap_of(&scene, 4), 0.05);
    destroy(&scene);
}
END_TEST

// Vertices of one triangle sewn together: the triangle becomes a line, nothing else breaks.
START_TEST(neighbours_may_be_sewn_together)
{
    PercaleMesh sheet = percale_test_sheet(6, 0.5f);
    PercaleSolverDef def = percale_solver_def_default();
    PercaleSolver *solver = percale_test_solver(def);
    PercaleCloth cloth = percale_test_add_cloth(solver, &sheet);
    const uint32_t a[4] = {14, 21, 0, 35};
    const uint32_t b[4] = {15, 15, 35, 0}; // a chain of three in the middle, and the corners, twice
    PercaleSeamDef seam_def = percale_seam_def_default();
    seam_def.cloth_a = seam_def.cloth_b = cloth;
    seam_def.vertices_a = a;
    seam_def.vertices_b = b;
    seam_def.pair_count = 4;
    PercaleSeam seam;
    PERCALE_TEST_OK(solver, percale_seam_add(solver, &seam_def, &seam));
    PercaleQuality quality;
    for (int frame = 0; frame < 90; frame++) {
        PERCALE_TEST_OK(solver, percale_solver_step(solver, FRAME));
        PERCALE_TEST_OK(solver, percale_solver_validate(solver));
    }
    PERCALE_TEST_OK(solver, percale_solver_quality(solver, &quality));
    ck_assert_double_eq(quality.nonfinite, 0.0);
    PercaleClothView view;
    PERCALE_TEST_OK(solver, percale_cloth_view(solver, cloth, &view));
    ck_assert_uint_eq(view.order[0], view.order[35]);
    percale_solver_destroy(solver);
    percale_mesh_free(&sheet);
}
END_TEST

START_TEST(a_pinned_point_is_sewn_to_where_it_is_held)
{
    Scene scene = create(false, 0.2f);
    PercalePinDef def = percale_pin_def_default();
    def.cloth = scene.cloths[0];
    def.vertices = scene.rims[0];
    def.vertex_count = SIDE;
    PercalePin pin;
    PERCALE_TEST_OK(scene.solver, percale_pin_add(scene.solver, &def, &pin));
    run(&scene, 60);
    for (uint32_t row = 0; row < SIDE; row++) {
        const float *held = scene.left.positions + 3 * (size_t)scene.rims[0][row];
        float b[3];
        rim_point(&scene, 1, row, b);
        ck_assert_mem_eq(held, b, sizeof(b));
    }
    destroy(&scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("seams");
    TCase *seams = tcase_create("seams");
    tcase_set_timeout(seams, 60.0);
    tcase_add_loop_test(seams, an_open_seam_closes_and_becomes_one_point, 0, 2);
    tcase_add_test(seams, closing_and_welding_keep_mass_momentum_and_centre);
    tcase_add_test(seams, a_weld_is_a_perfectly_inelastic_impact);
    tcase_add_loop_test(seams, a_cut_seam_parts_where_it_is, 0, 2);
    tcase_add_test(seams, neighbours_may_be_sewn_together);
    tcase_add_test(seams, a_pinned_point_is_sewn_to_where_it_is_held);
    suite_add_tcase(suite, seams);
    return percale_test_run(suite);
}
