/* Polygons cut along segments, and put together again. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

#include "quadrature/cuts.h"

static const double slack = 1e-9, rounding = 1e-12;

static const hpr_polygon square = {4, {{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

static hpr_cuts *cuts_open(void)
{
    hpr_cuts *cuts = malloc(sizeof *cuts);
    hpr_cuts_init(cuts, &square);
    return cuts;
}

/* The outline of [x0,x1] x [y0,y1] as four segments. */
static void cut_out(hpr_cuts *cuts, double x0, double y0, double x1, double y1)
{
    const double corner[5][2] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}, {x0, y0}};
    for (int i = 0; i < 4; i++)
        hpr_cuts_segment(cuts, corner[i], corner[i + 1], slack);
}

static double area_of(const hpr_polygon *piece, int count)
{
    double area = 0;
    for (int i = 0; i < count; i++)
        area += hpr_polygon_area(&piece[i]);
    return area;
}

static bool inside(const hpr_polygon *piece, double x0, double y0, double x1, double y1)
{
    double x = 0, y = 0;
    for (int i = 0; i < piece->count; i++) {
        x += piece->corner[i][0] / piece->count;
        y += piece->corner[i][1] / piece->count;
    }
    return x > x0 && x < x1 && y > y0 && y < y1;
}

/* What is not run through stays whole: a second hole does not cut the pieces beside it. */
static void a_segment_cuts_only_what_it_runs_through(void **state)
{
    (void)state;
    hpr_cuts *cuts = cuts_open();
    cut_out(cuts, 0.1, 0.1, 0.2, 0.2);
    assert_int_equal(cuts->count, 5);
    cut_out(cuts, 0.7, 0.7, 0.9, 0.9);
    assert_int_equal(cuts->count, 9);
    assert_true(fabs(area_of(cuts->piece, cuts->count) - 1) <= rounding);
    double hole = 0;
    for (int i = 0; i < cuts->count; i++)
        hole += inside(&cuts->piece[i], 0.7, 0.7, 0.9, 0.9) ? hpr_polygon_area(&cuts->piece[i]) : 0;
    assert_true(fabs(hole - 0.04) <= rounding);
    free(cuts);
}

static void a_segment_outside_or_along_a_border_cuts_nothing(void **state)
{
    (void)state;
    hpr_cuts *cuts = cuts_open();
    hpr_cuts_segment(cuts, (const double[]){1.5, 0}, (const double[]){1.2, 3}, slack);
    hpr_cuts_segment(cuts, (const double[]){0, 0}, (const double[]){1, 0}, slack);
    hpr_cuts_segment(cuts, (const double[]){-1, 1}, (const double[]){1, -1}, slack); /* through a corner */
    hpr_cuts_segment(cuts, (const double[]){0.5, 0.5}, (const double[]){0.5, 0.5}, slack);
    assert_int_equal(cuts->count, 1);
    hpr_cuts_segment(cuts, (const double[]){0.5, 0.5}, (const double[]){0.5, 0.6}, slack);
    assert_int_equal(cuts->count, 2);
    free(cuts);
}

static void what_was_cut_is_put_together(void **state)
{
    (void)state;
    hpr_cuts *cuts = cuts_open();
    hpr_cuts_segment(cuts, (const double[]){0.3, -1}, (const double[]){0.4, 2}, slack);
    hpr_cuts_segment(cuts, (const double[]){-1, 0.3}, (const double[]){2, 0.3}, slack);
    hpr_cuts_segment(cuts, (const double[]){-1, 0.8}, (const double[]){2, 0.6}, slack);
    assert_int_equal(cuts->count, 6);
    assert_int_equal(hpr_cuts_merge(cuts->piece, cuts->count, slack), 1);
    assert_int_equal(cuts->piece[0].count, 4);
    assert_true(fabs(hpr_polygon_area(&cuts->piece[0]) - 1) <= rounding);
    free(cuts);
}

/* Around a hole the union is not convex: the pieces stay apart, and no area is lost or gained. */
static void what_is_not_convex_stays_apart(void **state)
{
    (void)state;
    hpr_cuts *cuts = cuts_open();
    cut_out(cuts, 0.4, 0.4, 0.6, 0.5);
    int open = 0;
    for (int i = 0; i < cuts->count; i++) {
        if (!inside(&cuts->piece[i], 0.4, 0.4, 0.6, 0.5))
            cuts->piece[open++] = cuts->piece[i];
    }
    int left = hpr_cuts_merge(cuts->piece, open, slack);
    assert_true(left >= 3 && left <= open);
    assert_true(fabs(area_of(cuts->piece, left) - 0.98) <= rounding);
    free(cuts);
}

/* One cell for a parallelogram, a fan for all else; the areas agree. */
static void tiles_cover_the_piece(void **state)
{
    (void)state;
    static const hpr_polygon pieces[] = {{4, {{0, 0}, {0.5, 0.1}, {0.7, 0.6}, {0.2, 0.5}}},
                                         {4, {{0, 0}, {0.5, 0.1}, {0.7, 0.7}, {0.2, 0.5}}},
                                         {3, {{0, 0}, {0.5, 0.1}, {0.7, 0.7}}}};
    static const int expected[] = {1, 4, 3};
    for (int i = 0; i < 3; i++) {
        hpr_cell cell[HPR_POLYGON_MAX];
        double area = 0;
        int count = hpr_cuts_tiles(&pieces[i], cell);
        assert_int_equal(count, expected[i]);
        for (int k = 0; k < count; k++)
            area += fabs(cell[k].edge1[0] * cell[k].edge2[1] - cell[k].edge1[1] * cell[k].edge2[0]) /
                    (cell[k].shape == HPR_SHAPE_TRIANGLE ? 2 : 1);
        assert_true(fabs(area - hpr_polygon_area(&pieces[i])) <= rounding);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_segment_cuts_only_what_it_runs_through),
        cmocka_unit_test(a_segment_outside_or_along_a_border_cuts_nothing),
        cmocka_unit_test(what_was_cut_is_put_together),
        cmocka_unit_test(what_is_not_convex_stays_apart),
        cmocka_unit_test(tiles_cover_the_piece),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
