/* What is too large for the machine is refused at once, by an estimate that is not too high. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "link/afford.h"
#include "rooms.h"
#include "visibility/views.h"

enum { SIDE = 46 };

/* SIDE x SIDE triangles on the inside of a bowl, every third turned over so that it sees nothing of it. */
static void add_bowl(hpr_room *room)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        double x = (double)(i % SIDE) / SIDE - 0.5, y = (double)(i / SIDE) / SIDE - 0.5, d = 0.8 / SIDE;
        double corner[3][3] = {{x, y, 0}, {x + d, y, 0}, {x, y + d, 0}};
        for (int k = 0; k < 3; k++)
            corner[k][2] = corner[k][0] * corner[k][0] + corner[k][1] * corner[k][1];
        double turned[3][3];
        for (int k = 0; k < 3; k++)
            memcpy(turned[k], corner[i % 3 ? k : 2 - k], sizeof turned[k]);
        room_add(room, 3, (const double(*)[3])turned, 0.5, 1, false);
    }
}

/* Against the count of all pairs: at most that, and no less than three standard errors more than the two that
 * are taken off, 200 pairs being seen. */
static void the_prediction_is_the_lower_end_of_an_estimate(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    hpr_patches *patches = NULL;
    hpr_elements *elements = NULL;
    hpr_visibility *visibility = NULL;
    hpr_views *views = NULL;
    hpr_views_cursor *cursor = NULL;
    add_bowl(&room);
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_elements_uniform(patches, 1, 0, &elements), HPR_OK);
    assert_int_equal(hpr_visibility_create(patches, &visibility), HPR_OK);
    assert_int_equal(hpr_views_create(visibility, NULL, &views), HPR_OK);
    assert_int_equal(hpr_views_cursor_create(views, &cursor), HPR_OK);
    double seen = 0, n = (double)patches->count;
    for (size_t i = 0; i < patches->count; i++) {
        for (size_t j = i + 1; j < patches->count; j++)
            seen += hpr_views_classify(views, cursor, i, j, NULL, NULL) != HPR_SEES_NOTHING;
    }
    assert_true(seen > 0.1 * n * n / 2 && seen < 0.9 * n * n / 2);
    /* 3 functions */
    double exact = n * n + seen * (40 + 8 * 3 * 3), predicted = hpr_links_predict(visibility, elements);
    print_message("%.4g of %.4g bytes predicted\n", predicted, exact);
    assert_true(predicted <= exact && predicted >= (1 - 5 / sqrt(200)) * exact);
    hpr_views_cursor_destroy(&cursor);
    hpr_views_destroy(&views);
    hpr_visibility_destroy(&visibility);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

/* 2116 patches of 153 coefficients, of whose pairs some half see each other: 10^11 bytes. */
static void what_no_machine_has_is_refused(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    hpr_solution *solution = NULL;
    hpr_solve_options options;
    add_bowl(&room);
    hpr_solve_options_init(&options);
    options.order = 16;
    options.subdivide = 0;
    options.feet = 0;
    assert_int_equal(hpr_solve(room.context, room.scene, &options, &solution), HPR_ERR_MEMORY);
    const char *text = hpr_context_error(room.context);
    print_message("%s\n", text);
    assert_non_null(strstr(text, "2116 patches with 323748 coefficients need about "));
    assert_non_null(strstr(text, "a lower --subdivide or --order"));
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_prediction_is_the_lower_end_of_an_estimate),
        cmocka_unit_test(what_no_machine_has_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
