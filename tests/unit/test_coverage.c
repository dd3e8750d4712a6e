/* What of an element lies open. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "link/coverage.h"
#include "rooms.h"

/* A box on the floor without a bottom, its faces outward. */
static void add_leg(hpr_room *room, double x, double y, double a, double height)
{
    const double low[4][2] = {{x, y}, {x + a, y}, {x + a, y + a}, {x, y + a}};
    double top[4][3];
    for (int i = 0; i < 4; i++) {
        const double *p = low[i], *q = low[(i + 1) % 4];
        const double side[4][3] = {
            {p[0], p[1], 0}, {q[0], q[1], 0}, {q[0], q[1], height}, {p[0], p[1], height}};
        room_add(room, 4, side, 0.5, 0, false);
        top[i][0] = p[0];
        top[i][1] = p[1];
        top[i][2] = height;
    }
    room_add(room, 4, (const double(*)[3])top, 0.5, 0, false);
}

/* The legs of a few chairs: 4 x 4 of them on one element. */
static void many_legs_on_one_element_cover_their_area(void **state)
{
    (void)state;
    static const double a = 0.05, rounding = 1e-12;
    enum { SIDE = 4 };
    hpr_room room = room_open(1);
    room_add(&room, 4, (const double[4][3]){{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, 0.5, 1, false);
    for (int i = 0; i < SIDE * SIDE; i++) /* no two edges on one line */
        add_leg(&room, 0.1 + 0.2 * (i % SIDE) + 0.011 * (i / SIDE),
                0.1 + 0.2 * (i / SIDE) + 0.013 * (i % SIDE), a, 0.3);
    hpr_patches *patches = NULL;
    hpr_elements *elements = NULL;
    hpr_coverage *coverage = NULL;
    assert_int_equal(hpr_patches_build(room.scene, &patches), HPR_OK);
    assert_int_equal(hpr_elements_uniform(patches, 1, 0, &elements), HPR_OK);
    assert_int_equal(hpr_coverage_create(patches, elements, &coverage), HPR_OK);
    int parts;
    assert_non_null(hpr_coverage_parts(coverage, 0, &parts));
    double share = hpr_coverage_open_share(coverage, 0), expected = 1 - SIDE * SIDE * a * a;
    print_message("%d parts, open %.15g, expected %.15g\n", parts, share, expected);
    assert_true(parts <= HPR_COVERAGE_PIECES && fabs(share - expected) <= rounding);
    assert_false(hpr_coverage_open(coverage, 0, 0.12, 0.12));
    assert_true(hpr_coverage_open(coverage, 0, 0.08, 0.12));
    hpr_coverage_destroy(&coverage);
    hpr_elements_destroy(&elements);
    hpr_patches_destroy(&patches);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_legs_on_one_element_cover_their_area),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
