// Laws of the settings: what is accepted, what is refused and with which words, and what the solver gets.

#include "scene/settings.h"
#include "testing.h"

#include <string.h>

static PercaleSettings settings;

static void make_settings(void)
{
    PercaleSceneError error;
    ck_assert(percale_settings_create(&settings, NULL, 0, &error));
}

static void free_settings(void)
{
    percale_settings_free(&settings);
}

static void set(const char *key, const char *value)
{
    PercaleSceneError error = {""};
    const uint32_t index = percale_settings_find(&settings, key, &error);
    ck_assert_msg(index < settings.count, "%s", error.text);
    ck_assert_msg(percale_settings_assign_text(&settings, index, value, &error), "%s", error.text);
}

// The error must hold both texts; the setting keeps its value.
static void expect_refused(const char *key, const char *value, const char *culprit, const char *reason)
{
    PercaleSceneError error = {""};
    const uint32_t index = percale_settings_find(&settings, key, &error);
    if (index < settings.count) {
        const double before = settings.items[index].value[0];
        ck_assert_msg(!percale_settings_assign_text(&settings, index, value, &error), "accepted: %s=%s", key,
                      value);
        ck_assert_double_eq(settings.items[index].value[0], before);
    }
    ck_assert_msg(strstr(error.text, culprit) != NULL && strstr(error.text, reason) != NULL,
                  "\"%s\" or \"%s\" is not in: %s", culprit, reason, error.text);
}

START_TEST(an_unknown_key_is_named_with_the_nearest_known_one)
{
    expect_refused("substep", "3", "\"substep\"", "\"substeps\"");
    expect_refused("Friction", "3", "\"Friction\"", "\"friction\"");
    expect_refused("bending_stifness", "3", "bending_stifness", "\"bending_stiffness\"");
    expect_refused("", "3", "\"\"", "did you mean");
    expect_refused("a_key_that_is_much_longer_than_any_key_that_there_is_or_will_ever_be", "3", "a_key_that",
                   "did you mean");
}
END_TEST

START_TEST(values_that_are_not_of_the_kind_are_refused)
{
    expect_refused("substeps", "many", "substeps=many", "a number");
    expect_refused("substeps", "2.5", "substeps=2.5", "whole");
    expect_refused("substeps", "", "substeps=", "a number");
    expect_refused("substeps", "20x", "substeps=20x", "a number");
    expect_refused("thickness", "nan", "thickness=nan", "a number");
    expect_refused("bending", "maybe", "bending=maybe", "off|on");
    expect_refused("bending", "1", "bending=1", "off|on");
    expect_refused("reuse", "never", "reuse=never", "auto|always|audit");
    expect_refused("reuse", "aut", "reuse=aut", "auto|always|audit");
    expect_refused("gravity", "1,2", "gravity=1,2", "three numbers");
    expect_refused("gravity", "1,2,3,4", "gravity=1,2,3,4", "three numbers");
    expect_refused("gravity", "-9.81", "gravity=-9.81", "three numbers");
}
END_TEST

START_TEST(values_out_of_range_are_refused_with_the_range)
{
    expect_refused("substeps", "0", "substeps=0", "1 to 1000");
    expect_refused("substeps", "1001", "substeps=1001", "1 to 1000");
    expect_refused("friction", "-0.1", "friction=-0.1", "0 to 10");
    expect_refused("density", "0", "density=0", "kg/m^2");
    expect_refused("gravity", "0,-1e9,0", "gravity=-1e+09", "m/s^2");
    expect_refused("seed", "4294967296", "seed", "out of range");
}
END_TEST

START_TEST(switches_arrive_in_the_def)
{
    ck_assert_int_eq(percale_settings_solver_def(&settings, 1).untangle, 1);
    set("self", "off");
    set("ee", "off");
    set("untangle", "off");
    set("tethers", "off");
    const PercaleSolverDef def = percale_settings_solver_def(&settings, 1);
    ck_assert_int_eq(def.self_collision + def.edge_edge + def.untangle, 0);
    ck_assert_int_eq(def.ccd, PERCALE_CCD_RAY);
}
END_TEST

START_TEST(every_setting_reaches_the_solver)
{
    set("substeps", "7");
    set("iterations", "3");
    set("passes", "5");
    set("reuse", "always");
    set("ccd", "off");
    set("obstacle", "off");
    set("self", "on");
    set("ee", "on");
    set("bending", "off");
    set("damping", "0.5");
    set("gravity", "1,-2.5,3");
    set("wind", "4,5,6");
    set("speed_max", "12");
    set("origin", "10000.125,0,-3");
    set("isa", "sse2");
    const PercaleSolverDef def = percale_settings_solver_def(&settings, 3);
    ck_assert_int_eq(def.substeps, 7);
    ck_assert_int_eq(def.iterations, 3);
    ck_assert_int_eq(def.passes, 5);
    ck_assert_int_eq(def.thread_count, 3);
    ck_assert_int_eq(def.reuse, PERCALE_REUSE_ALWAYS);
    ck_assert_int_eq(def.ccd, PERCALE_CCD_OFF);
    ck_assert_int_eq(def.vertex_face, 0);
    ck_assert_int_eq(def.self_collision, 1);
    ck_assert_int_eq(def.edge_edge, 1);
    ck_assert_int_eq(def.bending, 0);
    ck_assert_double_eq((double)def.damping, (double)0.5F);
    ck_assert_double_eq((double)def.gravity[1], (double)-2.5F);
    ck_assert_double_eq((double)def.wind[2], (double)6.0F);
    ck_assert_double_eq((double)def.speed_max, (double)12.0F);
    ck_assert_double_eq(def.origin[0], 10000.125);
    ck_assert_int_eq(def.isa, PERCALE_ISA_SSE2);
}
END_TEST

START_TEST(every_material_setting_reaches_the_cloth)
{
    set("density", "0.3");
    set("stretch_compliance", "1e-5");
    set("bending_stiffness", "2e-6");
    set("thickness", "0.004");
    set("friction", "0.7");
    const PercaleMaterial material = percale_settings_material(&settings);
    ck_assert_double_eq((double)material.density, (double)0.3F);
    ck_assert_double_eq((double)material.stretch_compliance, (double)1e-5F);
    ck_assert_double_eq((double)material.bending_stiffness, (double)2e-6F);
    ck_assert_double_eq((double)material.thickness, (double)0.004F);
    ck_assert_double_eq((double)material.friction, (double)0.7F);
}
END_TEST

START_TEST(iterations_per_frame_splits_into_as_many_substeps_as_can_be)
{
    static const struct {
        const char *sweeps;
        int substeps, iterations;
    } SPLITS[] = {{"20", 20, 1}, {"1", 1, 1}, {"1000", 1000, 1}, {"1500", 750, 2}, {"1000000", 1000, 1000}};
    for (size_t k = 0; k < sizeof SPLITS / sizeof SPLITS[0]; ++k) {
        set("iterations_per_frame", SPLITS[k].sweeps);
        const PercaleSolverDef def = percale_settings_solver_def(&settings, 1);
        ck_assert_int_eq(def.substeps, SPLITS[k].substeps);
        ck_assert_int_eq(def.iterations, SPLITS[k].iterations);
    }
    expect_refused("iterations_per_frame", "1009", "1009", "substeps x iterations"); // a prime number
}
END_TEST

START_TEST(iterations_per_frame_is_always_the_product)
{
    set("substeps", "4");
    set("iterations", "5");
    ck_assert_double_eq(percale_settings_number(&settings, PERCALE_SET_ITERATIONS_PER_FRAME), 20.0);
    set("iterations", "6");
    ck_assert_double_eq(percale_settings_number(&settings, PERCALE_SET_ITERATIONS_PER_FRAME), 24.0);
}
END_TEST

START_TEST(more_passes_than_sweeps_are_refused_whatever_the_order)
{
    PercaleSceneError error = {""};
    set("passes", "24");
    ck_assert(!percale_settings_check(&settings, &error));
    ck_assert_ptr_nonnull(strstr(error.text, "passes=24"));
    ck_assert_ptr_nonnull(strstr(error.text, "20"));
    set("substeps", "6");
    set("iterations", "4");
    ck_assert(percale_settings_check(&settings, &error));
    set("substeps", "5");
    ck_assert(!percale_settings_check(&settings, &error));
    set("passes", "0");
    ck_assert(percale_settings_check(&settings, &error));
}
END_TEST

START_TEST(presets_set_the_sweeps_and_later_settings_win)
{
    PercaleSceneError error = {""};
    ck_assert_str_eq(settings.preset, "balanced");
    ck_assert(percale_settings_assign_preset(&settings, "swift", &error));
    ck_assert_int_eq(percale_settings_solver_def(&settings, 1).substeps, 2);
    ck_assert_int_eq(percale_settings_solver_def(&settings, 1).iterations, 5);
    ck_assert(percale_settings_assign_preset(&settings, "accurate", &error));
    ck_assert_int_eq(percale_settings_solver_def(&settings, 1).substeps, 80);
    ck_assert_int_eq(percale_settings_solver_def(&settings, 1).iterations, 1);
    set("substeps", "9");
    ck_assert_int_eq(percale_settings_solver_def(&settings, 1).substeps, 9);
    ck_assert_str_eq(settings.preset, "accurate");
    ck_assert(!percale_settings_assign_preset(&settings, "fast", &error));
    ck_assert_ptr_nonnull(strstr(error.text, "\"fast\""));
}
END_TEST

START_TEST(every_default_is_a_value_that_may_be_set)
{
    PercaleSceneError error = {""};
    for (uint32_t index = 0; index < settings.count; ++index) {
        const PercaleSetting setting = settings.items[index];
        ck_assert_msg(percale_settings_assign(&settings, index, setting.value, &error), "%s", error.text);
        ck_assert_ptr_nonnull(setting.help);
        ck_assert_ptr_nonnull(setting.unit);
        ck_assert_int_eq(setting.choices != NULL, setting.kind == PERCALE_SETTING_CHOICE);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("settings");
    TCase *laws = tcase_create("laws");
    tcase_add_checked_fixture(laws, make_settings, free_settings);
    tcase_add_test(laws, an_unknown_key_is_named_with_the_nearest_known_one);
    tcase_add_test(laws, values_that_are_not_of_the_kind_are_refused);
    tcase_add_test(laws, values_out_of_range_are_refused_with_the_range);
    tcase_add_test(laws, switches_arrive_in_the_def);
    tcase_add_test(laws, every_setting_reaches_the_solver);
    tcase_add_test(laws, every_material_setting_reaches_the_cloth);
    tcase_add_test(laws, iterations_per_frame_splits_into_as_many_substeps_as_can_be);
    tcase_add_test(laws, iterations_per_frame_is_always_the_product);
    tcase_add_test(laws, more_passes_than_sweeps_are_refused_whatever_the_order);
    tcase_add_test(laws, presets_set_the_sweeps_and_later_settings_win);
    tcase_add_test(laws, every_default_is_a_value_that_may_be_set);
    suite_add_tcase(suite, laws);
    return percale_test_run(suite);
}
