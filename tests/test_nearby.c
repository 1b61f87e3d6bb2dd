// What a vertex's list of near triangles answers is what the tree answers, wherever vertex and obstacle have
// moved in the meantime; and four closest points at once are those of one each.

#include "surface_testing.h"

#include "detect/nearby.h"

enum { WALKS = 24, STEPS = 60, SLOT = 3, SLOTS = 5 };

static bool are_equal(double a, double b)
{
    return !(a < b) && !(a > b);
}

static bool is_same(const PercaleClosest *a, const PercaleClosest *b)
{
    return a->region == b->region && are_equal(a->distance2, b->distance2) &&
           are_equal(a->weights[0], b->weights[0]) && are_equal(a->weights[1], b->weights[1]) &&
           are_equal(a->weights[2], b->weights[2]);
}

static int by_triangle(const void *a, const void *b)
{
    const PercaleFeature *left = a;
    const PercaleFeature *right = b;
    return left->triangle < right->triangle ? -1 : left->triangle > right->triangle;
}

static void expect_same_features(PercaleFeatureList *listed, PercaleFeatureList *expected)
{
    qsort(listed->items, listed->count, sizeof(listed->items[0]), by_triangle);
    qsort(expected->items, expected->count, sizeof(expected->items[0]), by_triangle);
    ck_assert_uint_eq(listed->count, expected->count);
    for (size_t i = 0; i < listed->count; i++) {
        ck_assert_uint_eq(listed->items[i].triangle, expected->items[i].triangle);
        ck_assert(is_same(&listed->items[i].closest, &expected->items[i].closest));
    }
}

/// Every vertex of the obstacle goes some way, none farther than `most`.
static void jitter(Scene *scene, double most, uint64_t *seed)
{
    for (size_t i = 0; i < 3 * (size_t)scene->mesh.vertex_count; i++) {
        scene->mesh.positions[i] += random_float(seed, most * 0.57);
    }
    refit(scene, 1);
}

/// What a walk has met.
typedef struct Met {
    PercaleNearbyLists lists;
    PercaleFeatureList listed, expected;
    uint32_t kept, renewed; // lists
    uint32_t nearest, far;  // answers of a list, and that nothing is within the radius
} Met;

static void ask_nearest(const PercaleNearbyQuery *query, Met *met)
{
    PercaleNearest nearest;
    if (!percale_nearby_nearest(&met->lists, SLOT, query, &nearest)) {
        return;
    }
    PercaleNearest expected =
        percale_surface_nearest(query->surface, query->point, query->radius, NO_TRIANGLE);
    ck_assert_uint_eq(nearest.triangle, expected.triangle);
    if (nearest.triangle != NO_TRIANGLE) {
        ck_assert(is_same(&nearest.closest, &expected.closest));
        met->nearest++;
    } else { // a bound
        expected = percale_surface_nearest(query->surface, query->point, 1e6, NO_TRIANGLE);
        ck_assert_double_le(nearest.closest.distance2, expected.closest.distance2);
        met->far++;
    }
}

static void ask(Scene *scene, const PercaleNearbyQuery *query, double room, Met *met)
{
    PercaleNearby *nearby = &met->lists.items[met->lists.number[SLOT]];
    PercaleNearbyQuery wide = *query;
    wide.radius *= 5.0; // farther than the list reaches
    ask_nearest(query, met);
    ask_nearest(&wide, met);
    f32x4 before = nearby->place;
    ck_assert(percale_nearby_gather(nearby, query, room, &scene->memory, &met->listed));
    ck_assert(
        percale_surface_gather(query->surface, query->point, query->radius, &scene->memory, &met->expected));
    expect_same_features(&met->listed, &met->expected);
    bool same = !(length3(before - nearby->place) > 0.0f);
    met->kept += same;
    met->renewed += !same;
}

static void walk(Scene *scene, int number, Met *met, uint64_t *seed)
{
    double scale = scene->mesh.triangle_count == 512 ? 4.0 : 1.0; // the grid's cells are larger
    double radius = scale * (number % 3 == 0 ? 0.3 : 0.1) * percale_test_random(seed);
    double room = radius * 2.0 * percale_test_random(seed);
    double step = 0.5 * room * percale_test_random(seed);
    double motion = number % 2 == 0 ? 0.0 : 0.5 * step;
    double traveled = 0.0;
    Vec3 point = make_query(&scene->mesh, number, seed);
    for (int i = 0; i < STEPS; i++) {
        PercaleNearbyQuery query = {&scene->surface, traveled, vec3_of(f32x4_of(point, 0.0f)), radius};
        ask(scene, &query, room, met);
        if (motion > 0.0 && i % 4 == 0) {
            jitter(scene, motion, seed);
            traveled += motion;
        }
        point.x += (double)random_float(seed, step);
        point.y += (double)random_float(seed, step);
        point.z += (double)random_float(seed, step);
    }
}

START_TEST(a_list_answers_what_the_tree_answers)
{
    Scene scene;
    Met met = {.kept = 0};
    uint64_t seed = 61 + (uint64_t)_i;
    const uint32_t slots[1] = {SLOT};
    open_scene(&scene, make_mesh(_i));
    ck_assert(percale_nearby_create(&met.lists, SLOTS, &scene.memory));
    for (int i = 0; i < WALKS; i++) {
        met.lists.count = 0;
        met.lists.number[SLOT] = NO_LIST;
        ck_assert(percale_nearby_reserve(&met.lists, slots, 1, &scene.memory));
        walk(&scene, i, &met, &seed);
    }
    ck_assert_uint_gt(met.kept, WALKS * STEPS / 4);
    ck_assert_uint_gt(met.renewed, WALKS);
    ck_assert_uint_gt(met.nearest, WALKS);
    ck_assert_uint_gt(met.far, WALKS);
    percale_nearby_free(&met.lists, &scene.memory);
    percale_memory_free(&scene.memory, met.listed.items);
    percale_memory_free(&scene.memory, met.expected.items);
    close_scene(&scene);
}
END_TEST

START_TEST(each_slot_has_a_list_of_its_own)
{
    PercaleAllocator allocator = percale_allocator_default();
    PercaleMemory memory = {&allocator, 0};
    PercaleNearbyLists lists;
    const uint32_t some[2] = {4, 1};
    const uint32_t more[3] = {1, 0, 4};
    ck_assert(percale_nearby_create(&lists, SLOTS, &memory));
    ck_assert(percale_nearby_reserve(&lists, some, 2, &memory));
    lists.items[lists.number[4]].count = 7;
    ck_assert(percale_nearby_reserve(&lists, more, 3, &memory));
    ck_assert_uint_eq(lists.count, 3);
    ck_assert_uint_eq(lists.items[lists.number[4]].count, 7); // kept
    ck_assert_uint_eq(lists.number[2], NO_LIST);
    ck_assert_uint_eq(lists.number[3], NO_LIST);
    ck_assert_uint_ne(lists.number[0], lists.number[1]);
    ck_assert_uint_ne(lists.number[0], lists.number[4]);
    ck_assert_uint_ne(lists.number[1], lists.number[4]);
    percale_nearby_free(&lists, &memory);
    ck_assert_uint_eq(memory.bytes, 0);
}
END_TEST

/// A corner on a coarse grid, so that points meet planes, sides and corners exactly, or anywhere.
static f32x4 any_point(uint64_t *seed, bool coarse)
{
    f32x4 point = {random_float(seed, 1.0), random_float(seed, 1.0), random_float(seed, 1.0), 0.0f};
    for (int axis = 0; coarse && axis < 3; axis++) {
        point[axis] = floorf(point[axis] * 3.0f);
    }
    return point;
}

START_TEST(four_closest_points_are_those_of_one_each)
{
    enum { ROUNDS = 20000, REGIONS = 7 };
    uint64_t seed = 67;
    int met[REGIONS] = {0};
    for (int round = 0; round < ROUNDS; round++) {
        bool coarse = round % 2 == 0;
        Vec3 point = vec3_of(any_point(&seed, coarse));
        f32x4 corners[3][CLOSEST_FOUR];
        for (uint32_t i = 0; i < CLOSEST_FOUR; i++) {
            for (int k = 0; k < 3; k++) {
                corners[k][i] = any_point(&seed, coarse);
            }
            if (round % 3 == 0 && i == 1) { // thin, among others that aren't
                corners[2][i] = corners[0][i] + (corners[1][i] - corners[0][i]) * 0.3f;
                corners[2][i][1] += round % 9 == 0 ? 0.0f : 1e-4f;
            }
        }
        PercaleFourClosest four;
        percale_closest_on_four(point, (const f32x4(*)[CLOSEST_FOUR])corners, &four);
        for (uint32_t i = 0; i < CLOSEST_FOUR; i++) {
            PercaleClosest here = one_of_four(&four, i);
            PercaleClosest expected = percale_closest_on_triangle(
                point, vec3_of(corners[0][i]), vec3_of(corners[1][i]), vec3_of(corners[2][i]));
            ck_assert_int_eq(here.region, expected.region);
            ck_assert(is_same(&here, &expected));
            met[expected.region]++;
        }
    }
    for (int region = 0; region < REGIONS; region++) {
        ck_assert_int_gt(met[region], ROUNDS / 20);
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("nearby");
    TCase *lists = tcase_create("lists");
    tcase_add_loop_test(lists, a_list_answers_what_the_tree_answers, 0, MESH_COUNT);
    tcase_add_test(lists, each_slot_has_a_list_of_its_own);
    suite_add_tcase(suite, lists);
    TCase *four = tcase_create("four");
    tcase_add_test(four, four_closest_points_are_those_of_one_each);
    suite_add_tcase(suite, four);
    return percale_test_run(suite);
}
