/* How finely a scene is solved when nobody says it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "solver/resolution.h"

typedef struct choice {
    int order, subdivide, feet;
    double element_size; /* HPR_CHOOSE: to be found */
} choice;

/* For so many parallelograms and triangles. */
static choice choose(size_t parallelograms, size_t triangles, choice asked, bool *full)
{
    hpr_patches patches = {.count = parallelograms + triangles};
    patches.shape = calloc(patches.count ? patches.count : 1, sizeof *patches.shape);
    for (size_t i = 0; i < patches.count; i++)
        patches.shape[i] = i < parallelograms ? HPR_SHAPE_PARALLELOGRAM : HPR_SHAPE_TRIANGLE;
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = asked.order;
    options.subdivide = asked.subdivide;
    options.feet = asked.feet;
    options.element_size = asked.element_size;
    *full = hpr_resolution_choose(&patches, &options);
    free(patches.shape);
    return (choice){options.order, options.subdivide, options.feet, options.element_size};
}

static void assert_choice(choice found, choice expected)
{
    assert_int_equal(found.order, expected.order);
    assert_int_equal(found.subdivide, expected.subdivide);
    assert_int_equal(found.feet, expected.feet);
    assert_true(found.element_size == expected.element_size);
}

static const choice free_choice = {HPR_CHOOSE, HPR_CHOOSE, HPR_CHOOSE, HPR_CHOOSE};

static void the_options_leave_the_choice_open(void **state)
{
    (void)state;
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    assert_choice((choice){options.order, options.subdivide, options.feet, options.element_size},
                  free_choice);
}

/* 25 functions on 16 elements: 30 parallelograms have 12,000 coefficients, one more has too many. */
static void a_small_scene_is_solved_in_full(void **state)
{
    (void)state;
    bool full;
    assert_choice(choose(30, 0, free_choice, &full),
                  (choice){HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE, HPR_DEFAULT_FEET, 0});
    assert_true(full);
    assert_choice(choose(31, 0, free_choice, &full), (choice){4, 0, 0, HPR_CHOOSE});
    assert_false(full);
}

/* Every step at the last number of patches that has it, in triangles: (p + 1)(p + 2) / 2 functions each. */
static void more_patches_coarser(void **state)
{
    (void)state;
    static const struct {
        size_t triangles;
        choice expected;
    } cases[] = {{50, {4, 2, HPR_DEFAULT_FEET, 0}},
                 {51, {4, 0, 0, HPR_CHOOSE}},
                 {400, {4, 0, 0, HPR_CHOOSE}},
                 {401, {3, 0, 0, HPR_CHOOSE}},
                 {600, {3, 0, 0, HPR_CHOOSE}},
                 {601, {2, 0, 0, HPR_CHOOSE}},
                 {1000, {2, 0, 0, HPR_CHOOSE}},
                 {1001, {1, 0, 0, HPR_CHOOSE}},
                 {2000, {1, 0, 0, HPR_CHOOSE}},
                 {2001, {1, 0, 0, 0}},
                 {4000, {1, 0, 0, 0}},
                 {4001, {0, 0, 0, 0}},
                 {100000, {0, 0, 0, 0}}};
    bool full;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_choice(choose(0, cases[i].triangles, free_choice, &full), cases[i].expected);
}

static void what_is_given_wins(void **state)
{
    (void)state;
    bool full;
    const int any = HPR_CHOOSE;
    assert_choice(choose(5000, 0, (choice){7, 3, 2, any}, &full), (choice){7, 3, 2, 0});
    assert_true(full);
    assert_choice(choose(5000, 0, (choice){7, any, any, any}, &full), (choice){7, 0, 0, 0});
    assert_choice(choose(90, 0, (choice){7, any, any, any}, &full), (choice){7, 0, 0, any});
    assert_choice(choose(5000, 0, (choice){0, any, any, any}, &full), (choice){0, 0, 0, any});
    assert_choice(choose(300, 0, (choice){any, 2, any, any}, &full), (choice){0, 2, 0, 0});
    assert_choice(choose(300, 0, (choice){any, any, 1, any}, &full), (choice){3, 0, 1, any});
    assert_choice(choose(300, 0, (choice){5, 3, any, any}, &full), (choice){5, 3, HPR_DEFAULT_FEET, 0});
    assert_true(full);
    assert_choice(choose(20, 0, (choice){any, any, any, 0.25}, &full), (choice){4, 0, 0, 0.25});
    assert_true(full);
    assert_choice(choose(20, 0, (choice){2, 1, any, 0.25}, &full), (choice){2, 1, HPR_DEFAULT_FEET, 0.25});
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_options_leave_the_choice_open),
        cmocka_unit_test(a_small_scene_is_solved_in_full),
        cmocka_unit_test(more_patches_coarser),
        cmocka_unit_test(what_is_given_wins),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
