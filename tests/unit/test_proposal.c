/* What may be done with an element: something that helps, whatever it leaves out. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "lcg.h"
#include "rooms.h"
#include "solver/along.h"
#include "solver/proposal.h"

/* Some choice leaves no more than this of the square: halving a singular axis leaves 0.2, low degrees of the
 * halves add a tenth of that, and another axis keeps a tenth at most; a smooth one 0.5^4 after two degrees.
 * Of a constant, of which nothing is known, 0.4. */
static const double most_left = 0.41;

/* Leaf 0 is a square, or one with a corner moved. */
static hpr_solution *solve_plates(hpr_room *room, int order, double moved)
{
    const double lower[4][3] = {{0, 0, 0}, {1, 0, 0}, {1 + moved, 1 + moved, 0}, {0, 1, 0}};
    const double upper[4][3] = {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    hpr_solve_options options;
    hpr_solution *solution = NULL;
    room_add(room, 4, lower, 0.5, 1, false);
    room_add(room, 4, upper, 0.5, 0, false);
    hpr_solve_options_init(&options);
    options.order = order;
    options.subdivide = 0;
    assert_int_equal(hpr_solve(room->context, room->scene, &options, &solution), HPR_OK);
    return solution;
}

/* The least that any choice leaves, of what it is now. */
static double least_left(const hpr_solution *solution, const hpr_two_scale *two_scale,
                         const hpr_indicator *indicator)
{
    const double norm2[3] = {1, 1, 1};
    hpr_proposal proposal;
    double least = INFINITY;
    hpr_propose(solution, two_scale, solution->irradiance, norm2, indicator, 0, false, &proposal);
    assert_true(proposal.count <= HPR_CHOICES);
    for (int k = 0; k < proposal.count; k++)
        least = fmin(least, proposal.choice[k].error2);
    return least / (indicator->error2[0] + indicator->error2[1]);
}

/* However the error is shared out between the axes, and however smooth each of them is. */
static void test_nothing_is_stuck(void **state)
{
    (void)state;
    static const double ratio[] = {0.02, 0.2, 0.3, 0.4, 0.49, 0.52, 0.6, 0.85};
    enum { RATIOS = sizeof ratio / sizeof *ratio, SHARES = 25, ORDERS = 9 };
    int failures = 0;
    for (int k = 0; k < 2 * ORDERS; k++) {
        int order = k / 2;
        hpr_room room = room_open(1);
        hpr_solution *solution = solve_plates(&room, order, k % 2 ? 0.2 : 0);
        hpr_two_scale *two_scale = NULL;
        assert_int_equal(hpr_two_scale_create(room.context, HPR_MAX_ORDER, &two_scale), HPR_OK);
        for (int i = 0; i < RATIOS * RATIOS * (SHARES + 1); i++) {
            double share = i % (SHARES + 1) / (double)SHARES;
            const hpr_indicator indicator = {
                .error2 = {share, 1 - share},
                .ratio = {ratio[i / (SHARES + 1) % RATIOS], ratio[i / (SHARES + 1) / RATIOS]}};
            double left = least_left(solution, two_scale, &indicator);
            if (left > most_left && failures++ < 10)
                print_message("degree %d, shares %.2f and %.2f, ratios %.2f and %.2f: %.2f is left\n", order,
                              share, 1 - share, indicator.ratio[0], indicator.ratio[1], left);
        }
        hpr_two_scale_destroy(&two_scale);
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
    assert_int_equal(failures, 0);
}

/* What stands along the axes of a quadrilateral is its polynomial, in the parameters of the bilinear map.
 * Observed: 2e-14 of the largest value. */
static void test_along_axes(void **state)
{
    (void)state;
    enum { ORDER = 5, POINTS = 20 };
    hpr_room room = room_open(1);
    hpr_solution *solution = solve_plates(&room, ORDER, 0.2);
    const hpr_element_frame frame = hpr_leaf_frame(solution->patches, solution->elements, 0);
    double coefficient[HPR_MAX_BASIS], value[HPR_MAX_BASIS], own[HPR_MAX_BASIS], tensor[HPR_MAX_BASIS];
    double off = 0, most = 0;
    size_t functions = hpr_basis_count(frame.shape, ORDER);
    uint64_t seed = 1;
    assert_int_equal(frame.shape, HPR_SHAPE_QUADRILATERAL);
    for (size_t k = 0; k < functions; k++)
        coefficient[k] = random_unit(&seed) - 0.5;
    hpr_along_axes(&frame, coefficient, 1, value);
    for (int i = 0; i < POINTS; i++) {
        double u = random_unit(&seed), v = random_unit(&seed), f = 0, g = 0;
        hpr_frame_basis(&frame, u + u * v * (frame.opposite[0] - 1), v + u * v * (frame.opposite[1] - 1),
                        own);
        hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, ORDER, u, v, tensor);
        for (size_t k = 0; k < functions; k++)
            f += coefficient[k] * own[k] * hpr_frame_scale(&frame) * sqrt(frame.area_m2);
        for (size_t k = 0; k < (ORDER + 1) * (ORDER + 1); k++)
            g += value[k] * tensor[k];
        off = fmax(off, fabs(f - g));
        most = fmax(most, fabs(f));
    }
    print_message("off by %.1e of the largest value\n", off / most);
    assert_true(off <= 1e-12 * most);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_nothing_is_stuck),
                                       cmocka_unit_test(test_along_axes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
