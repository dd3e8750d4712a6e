/*
 * Closed boxes, one patch per face. A furnace (the same rho and M everywhere) has B = M / (1 - rho) at every
 * point; different faces are compared with the means of a collocation solution of 9 digits (graded mesh, 90 x
 * 90 nodes per face). The energy terms are computed each by itself and must balance.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "mixed_cubes.h"
#include "rooms.h"
#include "solver/solution.h"

/* Largest relative error of B at 5 x 5 points of each face, edges and corners included. */
static double furnace_error(double a, double b, double c, double rho, int order)
{
    const double reflectance[6] = {rho, rho, rho, rho, rho, rho}, exitance[6] = {1, 1, 1, 1, 1, 1};
    hpr_room room = room_open(2);
    room_add_box(&room, a, b, c, reflectance, exitance, -1);
    hpr_solution *solution = room_solve(&room, order, 0);
    double worst = room_furnace_error(&room, solution, rho);
    assert_int_equal(hpr_solution_summary(solution)->short_count, 0);
    hpr_solution_destroy(&solution);
    room_close(&room);
    return worst;
}

static void check_furnace(double a, double b, double c)
{
    static const double rho[] = {0.5, 0.9, 0.99};
    for (int order = 0; order <= 8; order++) {
        for (int i = 0; i < 3; i++) {
            double error = furnace_error(a, b, c, rho[i], order);
            print_message("box %g x %g x %g  rho %g  degree %d  error of B %.1e\n", a, b, c, rho[i], order,
                          error);
            assert_true(error <= 1e-10);
        }
    }
}

static void cube_is_a_furnace(void **state)
{
    (void)state;
    check_furnace(1, 1, 1);
}

static void box_is_a_furnace(void **state)
{
    (void)state;
    check_furnace(1.5, 0.75, 2);
}

/* Largest relative error of a face's mean B; checks the energy balance on the way. */
static double mean_error(const mixed *m, int order)
{
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 1, 1, m->reflectance, m->exitance, m->open);
    /* all of H in the coefficients */
    hpr_solution *solution = room_solve_direct(&room, order, 0, HPR_DIRECT_GALERKIN);
    double worst = 0;
    for (int face = 0, patch = 0; face < 6; face++) {
        if (face == m->open)
            continue;
        /* T_0 = 1 on a unit square, so the first coefficient is the mean. */
        double h = solution->irradiance[3 * solution->elements->dof[patch++]];
        double mean = m->exitance[face] + m->reflectance[face] * h;
        worst = fmax(worst, fabs(mean / m->mean[face] - 1));
    }
    const hpr_energy *e = hpr_solution_energy(solution);
    double balance = (e->emitted - e->absorbed - e->lost_on_backs - e->escaped) / e->emitted;
    print_message(
        "%-12s degree %d  error of means %.2e  emitted %.6f absorbed %.6f escaped %.6f balance %.1e\n",
        m->name, order, worst, e->emitted, e->absorbed, e->escaped, balance);
    assert_true(fabs(balance) <= 1e-9);
    assert_true(e->lost_on_backs == 0);
    assert_true(m->open >= 0 ? e->escaped > 0.1 : fabs(e->escaped) <= 1e-12 * e->emitted);
    hpr_solution_destroy(&solution);
    room_close(&room);
    return worst;
}

static void means_of_mixed_cubes_converge(void **state)
{
    (void)state;
    for (size_t i = 0; i < MIXED_CUBES; i++) {
        double error[6];
        for (int order = 0; order <= 5; order++) {
            error[order] = mean_error(&mixed_cubes[i], order);
            assert_true(order < 3 || error[order] <= 1e-3);
            /* Even and odd degrees converge in turn: by symmetry each serves other parts of the solution. */
            assert_true(order < 2 || error[order] < error[order - 2]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(cube_is_a_furnace),
        cmocka_unit_test(box_is_a_furnace),
        cmocka_unit_test(means_of_mixed_cubes_converge),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
