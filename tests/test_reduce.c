// Reductions: the least and the greatest do not depend on the order, nor on who finds them.

#include "team_testing.h"

#include "base/reduce.h"

enum { VALUES = 3000 };

typedef struct Reduction {
    uint32_t whole[VALUES];
    float real[VALUES];
    ReducedUint least, greatest;
} Reduction;

static void reduce_range(void *context, uint32_t first, uint32_t end)
{
    Reduction *reduction = context;
    for (uint32_t i = first; i < end; i++) {
        reduce_min(&reduction->least, reduction->whole[i]);
        reduce_max_float(&reduction->greatest, reduction->real[i]);
    }
}

static void lead_reduction(PercaleTeam *team, void *context)
{
    percale_team_for(team, VALUES, 16, reduce_range, context);
}

static void shuffle(Reduction *reduction, uint64_t *seed)
{
    for (uint32_t i = VALUES - 1; i > 0; i--) {
        uint32_t j = random_below(seed, i + 1);
        uint32_t whole = reduction->whole[i];
        float real = reduction->real[i];
        reduction->whole[i] = reduction->whole[j];
        reduction->real[i] = reduction->real[j];
        reduction->whole[j] = whole;
        reduction->real[j] = real;
    }
}

START_TEST(least_and_greatest_do_not_depend_on_the_order)
{
    Reduction reduction;
    uint64_t seed = 3;
    for (int trial = 0; trial < 20; trial++) {
        uint32_t least = UINT32_MAX;
        float greatest = 0.0f;
        double scale = trial % 2 == 0 ? 1e-6 : 1e30;
        for (uint32_t i = 0; i < VALUES; i++) {
            reduction.whole[i] = 1000 + random_below(&seed, UINT32_MAX - 1000);
            reduction.real[i] = (float)(scale * percale_test_random(&seed));
            least = reduction.whole[i] < least ? reduction.whole[i] : least;
            greatest = reduction.real[i] > greatest ? reduction.real[i] : greatest;
        }
        for (int order = 0; order < 3; order++) {
            atomic_init(&reduction.least, UINT32_MAX);
            atomic_init(&reduction.greatest, 0);
            open_team(TEAMS[_i], lead_reduction, &reduction);
            ck_assert_uint_eq(reduction.least, least);
            ck_assert(reduced_float(&reduction.greatest) == greatest);
            shuffle(&reduction, &seed);
        }
    }
}
END_TEST

START_TEST(of_nothing_the_greatest_is_zero)
{
    ReducedUint greatest = 0;
    ck_assert(reduced_float(&greatest) == 0.0f);
    reduce_max_float(&greatest, 0.0f);
    ck_assert(reduced_float(&greatest) == 0.0f);
    reduce_max_float(&greatest, HUGE_VALF);
    reduce_max_float(&greatest, 1.0f);
    ck_assert(reduced_float(&greatest) == HUGE_VALF);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("reductions");
    TCase *reductions = tcase_create("reductions");
    tcase_set_timeout(reductions, 60.0);
    tcase_add_loop_test(reductions, least_and_greatest_do_not_depend_on_the_order, 0, TEAM_COUNT);
    tcase_add_test(reductions, of_nothing_the_greatest_is_zero);
    suite_add_tcase(suite, reductions);
    return percale_test_run(suite);
}
