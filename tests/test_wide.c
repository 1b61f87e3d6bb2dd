// Eight lanes against one: the shuffles of wide.h against plain loops, bit for bit.

#include "kernel_testing.h"

#include "base/wide.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

enum { TRIALS = 100 };

/// Any bits: numbers, denormals, NaNs with a payload, infinities, negative zeros.
static float any_float(uint64_t *seed)
{
    static const float SPECIAL[] = {0.0f, -0.0f, HUGE_VALF, -HUGE_VALF, 1e-40f, -FLT_MIN, FLT_MAX, 1.0f};
    if (percale_test_random(seed) < 0.3) {
        return SPECIAL[random_below(seed, 8)];
    }
    uint32_t bits = random_below(seed, UINT32_MAX);
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static f32x4 any_point(uint64_t *seed)
{
    float p[4];
    f32x4 point;
    for (int k = 0; k < 4; k++) {
        p[k] = any_float(seed);
    }
    memcpy(&point, p, sizeof(point));
    return point;
}

static f32x8 any_pair(uint64_t *seed)
{
    f32x4 points[2] = {any_point(seed), any_point(seed)};
    f32x8 pair;
    memcpy(&pair, points, sizeof(pair));
    return pair;
}

static f32x8 random_pair(uint64_t *seed)
{
    f32x8 pair;
    for (int k = 0; k < 8; k++) {
        pair[k] = random_float(seed, -2.0, 2.0);
    }
    return pair;
}

static void lanes_of(f32x8 pair, float lanes[8])
{
    memcpy(lanes, &pair, 8 * sizeof(float));
}

static void expect_lanes(f32x8 pair, const float expected[8])
{
    ck_assert_mem_eq(&pair, expected, 8 * sizeof(float));
}

START_TEST(a_pair_is_its_two_points)
{
    uint64_t seed = 1;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x4 points[2] = {any_point(&seed), any_point(&seed)};
        f32x8 pair = pair_of_points(points[0], points[1]);
        f32x4 back[2] = {low_point(pair), high_point(pair)};
        ck_assert_mem_eq(&pair, points, sizeof(pair));
        ck_assert_mem_eq(back, points, sizeof(back));
    }
}
END_TEST

#define EXPECT_SHUFFLE(i, j, k, l)                                                                          \
    do {                                                                                                    \
        const int from[4] = {i, j, k, l};                                                                   \
        float expected[8];                                                                                  \
        for (int lane = 0; lane < 8; lane++) {                                                              \
            int half = lane / 4 * 4;                                                                        \
            int source = from[lane % 4];                                                                    \
            memcpy(&expected[lane], source < 4 ? &a[half + source] : &b[half + source - 4], sizeof(float)); \
        }                                                                                                   \
        expect_lanes(SHUFFLE_HALVES(wide_a, wide_b, i, j, k, l), expected);                                 \
    } while (0)

START_TEST(shuffles_stay_inside_the_halves)
{
    uint64_t seed = 2;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 wide_a = any_pair(&seed);
        f32x8 wide_b = any_pair(&seed);
        float a[8];
        float b[8];
        lanes_of(wide_a, a);
        lanes_of(wide_b, b);
        EXPECT_SHUFFLE(0, 1, 2, 3);
        EXPECT_SHUFFLE(4, 5, 6, 7);
        EXPECT_SHUFFLE(0, 4, 1, 5);
        EXPECT_SHUFFLE(2, 6, 3, 7);
        EXPECT_SHUFFLE(0, 1, 4, 5);
        EXPECT_SHUFFLE(2, 3, 6, 7);
        EXPECT_SHUFFLE(3, 0, 7, 4);
        EXPECT_SHUFFLE(6, 6, 1, 5);
    }
}
END_TEST

#define EXPECT_SPREAD(k)                                                    \
    do {                                                                    \
        float expected[8];                                                  \
        for (int lane = 0; lane < 8; lane++) {                              \
            memcpy(&expected[lane], &a[lane / 4 * 4 + (k)], sizeof(float)); \
        }                                                                   \
        expect_lanes(SPREAD(pair, k), expected);                            \
    } while (0)

START_TEST(spreading_fills_each_half_with_its_own_component)
{
    uint64_t seed = 3;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 pair = any_pair(&seed);
        float a[8];
        lanes_of(pair, a);
        EXPECT_SPREAD(0);
        EXPECT_SPREAD(1);
        EXPECT_SPREAD(2);
        EXPECT_SPREAD(3);
    }
}
END_TEST

START_TEST(transposing_gives_the_components_of_eight_points_in_order)
{
    uint64_t seed = 4;
    for (int trial = 0; trial < TRIALS; trial++) {
        float points[8][4];
        float expected[4][8];
        f32x8 pairs[4];
        for (int k = 0; k < 4; k++) {
            f32x4 low = any_point(&seed);
            f32x4 high = any_point(&seed);
            memcpy(points[k], &low, sizeof(low));
            memcpy(points[k + 4], &high, sizeof(high));
            pairs[k] = pair_of_points(low, high);
        }
        for (int i = 0; i < 8; i++) {
            for (int axis = 0; axis < 4; axis++) {
                memcpy(&expected[axis][i], &points[i][axis], sizeof(float));
            }
        }
        WidePoints wide = transpose_pairs(pairs);
        expect_lanes(wide.x, expected[0]);
        expect_lanes(wide.y, expected[1]);
        expect_lanes(wide.z, expected[2]);
        expect_lanes(transpose_w(pairs), expected[3]);
    }
}
END_TEST

START_TEST(dot_products_stand_in_all_places_of_their_half)
{
    uint64_t seed = 5;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 a = random_pair(&seed);
        f32x8 b = random_pair(&seed);
        float expected[8];
        for (int lane = 0; lane < 8; lane++) {
            int half = lane / 4 * 4;
            expected[lane] = (a[half] * b[half] + a[half + 1] * b[half + 1]) + a[half + 2] * b[half + 2];
        }
        expect_lanes(dot3_pairs(a, b), expected);
    }
}
END_TEST

START_TEST(square_roots_are_those_of_the_lanes)
{
    uint64_t seed = 6;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 a = random_pair(&seed);
        a = a * a * (trial % 2 == 0 ? 1e-30f : 1e30f);
        a[trial % 8] = trial % 3 == 0 ? -0.0f : HUGE_VALF;
        float expected[8];
        for (int lane = 0; lane < 8; lane++) {
            expected[lane] = sqrtf(a[lane]);
        }
        expect_lanes(sqrt8(a), expected);
    }
}
END_TEST

START_TEST(masks_choose_bits_lane_by_lane)
{
    uint64_t seed = 7;
    for (int trial = 0; trial < TRIALS; trial++) {
        f32x8 wide_a = any_pair(&seed);
        f32x8 wide_b = any_pair(&seed);
        float a[8];
        float b[8];
        float chosen[8];
        float kept[8] = {0.0f};
        float first_three[8] = {0.0f};
        i32x8 mask = {0};
        uint32_t set = random_below(&seed, 256);
        lanes_of(wide_a, a);
        lanes_of(wide_b, b);
        for (int lane = 0; lane < 8; lane++) {
            bool on = (set >> lane & 1) != 0;
            mask[lane] = on ? -1 : 0;
            memcpy(&chosen[lane], on ? &a[lane] : &b[lane], sizeof(float));
            memcpy(&kept[lane], on ? &a[lane] : &kept[lane], sizeof(float));
            memcpy(&first_three[lane], lane % 4 != 3 ? &a[lane] : &first_three[lane], sizeof(float));
        }
        expect_lanes(select8(mask, wide_a, wide_b), chosen);
        expect_lanes(where8(mask, wide_a), kept);
        expect_lanes(without_w(wide_a), first_three);
        ck_assert_uint_eq(lane_bits(mask), set);
    }
}
END_TEST

START_TEST(one_or_two_points_are_loaded_and_stored_and_nothing_beside_them)
{
    uint64_t seed = 8;
    for (uint32_t count = 1; count <= 2; count++) {
        for (int trial = 0; trial < TRIALS; trial++) {
            f32x4 *source = malloc(count * sizeof(f32x4)); // no byte more: the sanitizer sees what is read
            f32x4 place[4];
            f32x4 expected[4];
            ck_assert_ptr_nonnull(source);
            for (uint32_t i = 0; i < 4; i++) {
                place[i] = any_point(&seed);
            }
            memcpy(expected, place, sizeof(place));
            for (uint32_t i = 0; i < count; i++) {
                source[i] = any_point(&seed);
                memcpy(&expected[1 + i], &source[i], sizeof(f32x4));
            }
            f32x8 pair = load_two(source, count);
            ck_assert_mem_eq(&pair, source, count * sizeof(f32x4));
            if (count == 1) {
                f32x4 other = high_point(pair);
                ck_assert_mem_eq(&other, source, sizeof(f32x4));
            }
            store_two(place + 1, pair, count);
            ck_assert_mem_eq(place, expected, sizeof(place));
            free(source);
        }
    }
}
END_TEST

START_TEST(what_is_not_finite_is_seen_in_its_own_lane_alone)
{
    static const float BAD[3] = {NAN, HUGE_VALF, -HUGE_VALF};
    static const float GOOD[8] = {0.0f, -0.0f, FLT_MAX, -FLT_MAX, FLT_MIN, 1e-40f, 1.0f, -3.0f};
    for (int first = 0; first < 8; first++) {
        f32x8 good;
        for (int lane = 0; lane < 8; lane++) {
            good[lane] = GOOD[(first + lane) % 8];
        }
        ck_assert_uint_eq(lane_bits(not_finite8(good)), 0);
        for (int lane = 0; lane < 8; lane++) {
            for (int kind = 0; kind < 3; kind++) {
                f32x8 bad = good;
                bad[lane] = BAD[kind];
                ck_assert_uint_eq(lane_bits(not_finite8(bad)), 1u << lane);
                bad[(lane + 3) % 8] = BAD[(kind + 1) % 3];
                ck_assert_uint_eq(lane_bits(not_finite8(bad)), 1u << lane | 1u << (lane + 3) % 8);
            }
        }
    }
}
END_TEST

START_TEST(of_eight_bytes_the_sign_of_each_is_seen_alone)
{
    static const int8_t SOME[] = {0, 1, 2, -1, 127, -128, 64};
    enum { SOME_COUNT = sizeof(SOME) };
    for (uint32_t i = 0; i < SOME_COUNT * SOME_COUNT * SOME_COUNT; i++) {
        int8_t bytes[8];
        for (uint32_t k = 0; k < 8; k++) {
            bytes[k] = SOME[k % 3 == 0   ? i % SOME_COUNT
                            : k % 3 == 1 ? i / SOME_COUNT % SOME_COUNT
                                         : i / SOME_COUNT / SOME_COUNT];
        }
        ByteSigns signs = signs_of(load_bytes8(bytes));
        uint8_t positive[8];
        uint8_t negative[8];
        memcpy(positive, &signs.positive, sizeof(positive));
        memcpy(negative, &signs.negative, sizeof(negative));
        for (uint32_t k = 0; k < 8; k++) {
            ck_assert_uint_eq(positive[k], bytes[k] > 0);
            ck_assert_uint_eq(negative[k], bytes[k] < 0);
            ck_assert_uint_eq(byte_bits(signs.positive) >> k & 1, bytes[k] > 0);
        }
    }
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("wide");
    TCase *lanes = tcase_create("lanes");
    tcase_add_test(lanes, a_pair_is_its_two_points);
    tcase_add_test(lanes, shuffles_stay_inside_the_halves);
    tcase_add_test(lanes, spreading_fills_each_half_with_its_own_component);
    tcase_add_test(lanes, transposing_gives_the_components_of_eight_points_in_order);
    tcase_add_test(lanes, dot_products_stand_in_all_places_of_their_half);
    tcase_add_test(lanes, square_roots_are_those_of_the_lanes);
    tcase_add_test(lanes, masks_choose_bits_lane_by_lane);
    tcase_add_test(lanes, one_or_two_points_are_loaded_and_stored_and_nothing_beside_them);
    tcase_add_test(lanes, what_is_not_finite_is_seen_in_its_own_lane_alone);
    tcase_add_test(lanes, of_eight_bytes_the_sign_of_each_is_seen_alone);
    suite_add_tcase(suite, lanes);
    return percale_test_run(suite);
}
