// State in and out: positions, velocities, the view, materials, masks; names and figures.

#include "api_scene.h"

#include <math.h>

// ---- state in and out ----

/// A point among other things, as hosts keep it.
typedef struct Vertex {
    float colour, position[3], weight;
} Vertex;

START_TEST(what_is_set_is_what_is_got)
{
    Scene *scene = create();
    enum { COUNT = 64 };
    Vertex in[COUNT];
    Vertex out[COUNT];
    float packed[3 * COUNT];
    uint64_t seed = 3;
    for (int kind = 0; kind < 2; kind++) {
        for (size_t i = 0; i < COUNT; i++) {
            in[i] = (Vertex){1.0f, {0.0f, 0.0f, 0.0f}, 2.0f};
            out[i] = (Vertex){3.0f, {0.0f, 0.0f, 0.0f}, 4.0f};
            for (size_t axis = 0; axis < 3; axis++) {
                in[i].position[axis] = (float)percale_test_random(&seed);
            }
        }
        PercaleSolver *solver = scene->solver;
        if (kind == 0) {
            PERCALE_TEST_OK(solver,
                            percale_seam_remove(solver, scene->seam)); // a sewn vertex would get a mean
            PERCALE_TEST_OK(solver,
                            percale_cloth_set_positions(solver, scene->cloth, in[0].position, sizeof(in[0])));
            (void)percale_solver_hash(solver);
            PERCALE_TEST_OK(
                solver, percale_cloth_get_positions(solver, scene->cloth, out[0].position, sizeof(out[0])));
            PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, scene->cloth, packed, 0));
        } else {
            PERCALE_TEST_OK(
                solver, percale_cloth_set_velocities(solver, scene->cloth, in[0].position, sizeof(in[0])));
            (void)percale_solver_hash(solver);
            PERCALE_TEST_OK(
                solver, percale_cloth_get_velocities(solver, scene->cloth, out[0].position, sizeof(out[0])));
            PERCALE_TEST_OK(solver, percale_cloth_get_velocities(solver, scene->cloth, packed, 0));
        }
        for (size_t i = 0; i < COUNT; i++) {
            ck_assert_mem_eq(out[i].position, in[i].position, sizeof(in[i].position));
            ck_assert_mem_eq(packed + 3 * i, in[i].position, sizeof(in[i].position));
            ck_assert(out[i].colour == 3.0f && out[i].weight == 4.0f); // nothing beside the points is written
        }
    }
    float bad[3 * COUNT] = {0};
    bad[100] = NAN;
    PERCALE_REFUSED(scene, percale_cloth_set_positions(scene->solver, scene->cloth, bad, 0),
                    PERCALE_INVALID_ARGUMENT, "vertex 33");
    PERCALE_REFUSED(scene, percale_cloth_set_velocities(scene->solver, scene->cloth, bad, 0),
                    PERCALE_INVALID_ARGUMENT, "vertex 33");
    PERCALE_REFUSED(scene, percale_cloth_set_positions(scene->solver, scene->cloth, NULL, 0),
                    PERCALE_INVALID_ARGUMENT, "sheet");
    PERCALE_REFUSED(scene, percale_cloth_get_positions(scene->solver, scene->cloth, packed, 8),
                    PERCALE_INVALID_ARGUMENT, "stride");
    destroy(scene);
}
END_TEST

START_TEST(strides_lead_to_the_same_bits)
{
    uint64_t hash[2];
    for (int strided = 0; strided < 2; strided++) {
        PercaleMesh sheet = percale_test_sheet(6, 0.3f);
        Vertex vertices[36];
        for (size_t i = 0; i < 36; i++) {
            vertices[i] = (Vertex){.colour = NAN, .weight = NAN};
            memcpy(vertices[i].position, sheet.positions + 3 * i, sizeof(vertices[i].position));
        }
        PercaleSolver *solver = percale_test_solver(percale_solver_def_default());
        PercaleClothDef def = percale_test_cloth_def(&sheet);
        if (strided == 1) {
            def.positions = def.rest_positions = def.velocities = vertices[0].position;
            def.position_stride = def.rest_stride = def.velocity_stride = sizeof(vertices[0]);
        } else {
            def.velocities = sheet.positions; // any numbers will do
        }
        PercaleCloth cloth;
        PERCALE_TEST_OK(solver, percale_cloth_add(solver, &def, &cloth));
        run(solver, 2);
        hash[strided] = percale_solver_hash(solver);
        percale_solver_destroy(solver);
        percale_mesh_free(&sheet);
    }
    ck_assert_uint_eq(hash[0], hash[1]);
}
END_TEST

START_TEST(the_view_shows_the_same_numbers)
{
    Scene *scene = create();
    run(scene->solver, 60); // the seam has closed
    const PercaleCloth cloths[2] = {scene->cloth, scene->patch_cloth};
    float positions[3 * 64];
    float velocities[3 * 64];
    PercaleClothView views[2];
    for (int c = 0; c < 2; c++) {
        PERCALE_TEST_OK(scene->solver, percale_cloth_view(scene->solver, cloths[c], &views[c]));
        PERCALE_TEST_OK(scene->solver, percale_cloth_get_positions(scene->solver, cloths[c], positions, 0));
        PERCALE_TEST_OK(scene->solver, percale_cloth_get_velocities(scene->solver, cloths[c], velocities, 0));
        ck_assert_uint_eq(views[c].vertex_count, c == 0 ? 64 : 16);
        for (size_t i = 0; i < views[c].vertex_count; i++) {
            size_t slot = views[c].order[i];
            ck_assert_mem_eq(views[c].positions + 4 * slot, positions + 3 * i, 3 * sizeof(float));
            ck_assert_mem_eq(views[c].velocities + 4 * slot, velocities + 3 * i, 3 * sizeof(float));
            ck_assert(views[c].positions[4 * slot + 3] >= 0.0f);
            ck_assert_int_eq(views[c].positions[4 * slot + 3] == 0.0f, c == 0 && i == 3); // the pinned one
        }
    }
    ck_assert_uint_eq(views[0].order[63], views[1].order[0]);
    ck_assert_uint_ne(views[0].order[62], views[1].order[1]);
    destroy(scene);
}
END_TEST

START_TEST(a_material_can_be_changed)
{
    Scene *scene = create();
    PercaleClothView view;
    PERCALE_TEST_OK(scene->solver, percale_cloth_view(scene->solver, scene->cloth, &view));
    float before = view.positions[4 * (size_t)view.order[9] + 3];
    PercaleMaterial material = percale_material_default();
    material.density *= 8.0f;
    PERCALE_TEST_OK(scene->solver, percale_cloth_set_material(scene->solver, scene->cloth, material));
    PERCALE_TEST_OK(scene->solver, percale_cloth_view(scene->solver, scene->cloth, &view));
    float after = view.positions[4 * (size_t)view.order[9] + 3];
    ck_assert(fabsf(after - before / 8.0f) < 1e-5f * before);
    material.density = -1.0f;
    PERCALE_REFUSED(scene, percale_cloth_set_material(scene->solver, scene->cloth, material),
                    PERCALE_INVALID_ARGUMENT, "sheet: density");
    destroy(scene);
}
END_TEST

static float lowest(PercaleSolver *solver, PercaleCloth cloth)
{
    float positions[3 * 64];
    PERCALE_TEST_OK(solver, percale_cloth_get_positions(solver, cloth, positions, 0));
    float low = INFINITY;
    for (size_t i = 0; i < 64; i++) {
        low = positions[3 * i + 1] < low ? positions[3 * i + 1] : low;
    }
    return low;
}

START_TEST(only_shared_bits_collide)
{
    Scene *scene = create();
    PERCALE_TEST_OK(scene->solver, percale_pin_remove(scene->solver, scene->pin));
    PERCALE_TEST_OK(scene->solver, percale_cloth_remove(scene->solver, scene->patch_cloth));
    PERCALE_TEST_OK(scene->solver, percale_obstacle_remove(scene->solver, scene->obstacle));
    PercaleObstacleDef def = percale_test_obstacle_def(&scene->box);
    def.mask = 6;
    PERCALE_TEST_OK(scene->solver, percale_obstacle_add(scene->solver, &def, &scene->obstacle));
    PERCALE_TEST_OK(scene->solver, percale_cloth_set_mask(scene->solver, scene->cloth, 4));
    PERCALE_TEST_OK(scene->solver, percale_cloth_set_layer(scene->solver, scene->cloth, 2));
    run(scene->solver, 30);
    ck_assert(lowest(scene->solver, scene->cloth) > 0.0f);
    PERCALE_TEST_OK(scene->solver, percale_cloth_set_mask(scene->solver, scene->cloth, 9));
    uint64_t contacts = percale_solver_counters(scene->solver).stencils_vf;
    run(scene->solver, 30);
    ck_assert(lowest(scene->solver, scene->cloth) < -1.0f);
    ck_assert_uint_eq(percale_solver_counters(scene->solver).stencils_vf, contacts);
    destroy(scene);
}
END_TEST

// ---- names and figures ----

START_TEST(everything_has_a_name)
{
    char version[32];
    (void)snprintf(version, sizeof(version), "%d.%d.%d", PERCALE_VERSION_MAJOR, PERCALE_VERSION_MINOR,
                   PERCALE_VERSION_PATCH);
    ck_assert_str_eq(percale_version(), version);
    const char *stages[] = {"predict", "detect", "untangle", "color", "solve", "finish"};
    for (int i = 0; i < PERCALE_STAGE_COUNT; i++) {
        ck_assert_str_eq(percale_stage_name((PercaleStage)i), stages[i]);
    }
    ck_assert_ptr_nonnull(percale_stage_name((PercaleStage)77));
    for (int i = PERCALE_OK; i <= PERCALE_DEVICE_ERROR; i++) {
        ck_assert_str_ne(percale_result_string((PercaleResult)i), percale_result_string((PercaleResult)77));
    }
}
END_TEST

START_TEST(the_profile_adds_up)
{
    Scene *scene = create();
    run(scene->solver, 3);
    PercaleProfile profile = percale_solver_profile(scene->solver);
    double sum = 0.0;
    for (int i = 0; i < PERCALE_STAGE_COUNT; i++) {
        ck_assert_double_ge(profile.stage_seconds[i], 0.0);
        sum += profile.stage_seconds[i];
    }
    ck_assert_double_gt(sum, 0.0);
    ck_assert_double_le(sum, profile.step_seconds);
    ck_assert_double_eq(profile.stage_seconds[PERCALE_STAGE_UNTANGLE], 0.0);
    PercaleCounters counters = percale_solver_counters(scene->solver);
    ck_assert_uint_eq(counters.projections, counters.projections_stretch + counters.projections_bend +
                                                counters.projections_tether + counters.projections_link +
                                                counters.projections_seam + counters.projections_contact);
    PercaleBytes bytes = percale_solver_bytes(scene->solver);
    ck_assert(bytes.model > 0 && bytes.detect > 0 && bytes.color > 0 && bytes.solve > 0 && bytes.arena > 0);
    percale_solver_destroy(NULL);
    destroy(scene);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("access");
    TCase *state = tcase_create("state");
    tcase_set_timeout(state, 60.0);
    tcase_add_test(state, what_is_set_is_what_is_got);
    tcase_add_test(state, strides_lead_to_the_same_bits);
    tcase_add_test(state, the_view_shows_the_same_numbers);
    tcase_add_test(state, a_material_can_be_changed);
    tcase_add_test(state, only_shared_bits_collide);
    tcase_add_test(state, everything_has_a_name);
    tcase_add_test(state, the_profile_adds_up);
    suite_add_tcase(suite, state);
    return percale_test_run(suite);
}
