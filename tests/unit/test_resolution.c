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
    *full = hpr_resolution_choose(&patches, &options);
    free(patches.shape);
    return (choice){options.order, options.subdivide, options.feet};
}

static void assert_choice(choice found, choice expected)
{
    assert_int_equal(found.order, expected.order);
    assert_int_equal(found.subdivide, expected.subdivide);
    assert_int_equal(found.feet, expected.feet);
}

static const choice free_choice = {HPR_CHOOSE, HPR_CHOOSE, HPR_CHOOSE};

static void the_options_leave_the_choice_open(void **state)
{
    (void)state;
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    assert_choice((choice){options.order, options.subdivide, options.feet}, free_choice);
}

/* 25 functions on 16 elements: 25 parallelograms have 10,000 coefficients, one more has too many. */
static void a_small_scene_is_solved_in_full(void **state)
{
    (void)state;
    bool full;
    assert_choice(choose(25, 0, free_choice, &full),
                  (choice){HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE, HPR_DEFAULT_FEET});
    assert_true(full);
    assert_choice(choose(26, 0, free_choice, &full), (choice){3, 2, 0});
    assert_false(full);
}

/* Every step at the last number of patches that has it, in triangles: (p + 1)(p + 2) / 2 4^N functions. */
static void more_patches_coarser(void **state)
{
    (void)state;
    static const struct {
        size_t triangles;
        choice expected;
    } cases[] = {{41, {4, 2, HPR_DEFAULT_FEET}},
                 {42, {3, 2, 0}},
                 {62, {3, 2, 0}},
                 {63, {2, 2, 0}},
                 {104, {2, 2, 0}},
                 {105, {2, 1, 0}},
                 {416, {2, 1, 0}},
                 {417, {1, 1, 0}},
                 {833, {1, 1, 0}},
                 {834, {1, 0, 0}},
                 {3333, {1, 0, 0}},
                 {3334, {0, 0, 0}},
                 {100000, {0, 0, 0}}};
    bool full;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_choice(choose(0, cases[i].triangles, free_choice, &full), cases[i].expected);
}

static void what_is_given_wins(void **state)
{
    (void)state;
    bool full;
    assert_choice(choose(5000, 0, (choice){7, 3, 2}, &full), (choice){7, 3, 2});
    assert_true(full);
    assert_choice(choose(5000, 0, (choice){7, HPR_CHOOSE, HPR_CHOOSE}, &full), (choice){7, 0, 0});
    assert_choice(choose(300, 0, (choice){HPR_CHOOSE, 2, HPR_CHOOSE}, &full), (choice){0, 2, 0});
    assert_choice(choose(300, 0, (choice){HPR_CHOOSE, HPR_CHOOSE, 1}, &full), (choice){1, 1, 1});
    assert_choice(choose(300, 0, (choice){5, 3, HPR_CHOOSE}, &full), (choice){5, 3, HPR_DEFAULT_FEET});
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
