/*
 * Closed boxes with subdivided faces. Mixed ones converge in p to the means of a collocation solution of 9
 * digits; a box of unequal sides that hardly absorbs is a furnace, B = M / (1 - rho) at every point.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "mixed_cubes.h"
#include "rooms.h"
#include "solver/solution.h"

/* All of H in the coefficients, so that means are read off and constants are exact. */
static hpr_solution *solved(hpr_room *room, int order, int subdivide, double block_tolerance)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = order;
    options.subdivide = subdivide;
    options.block_tolerance = block_tolerance;
    options.direct = HPR_DIRECT_GALERKIN;
    hpr_solution *solution = NULL;
    assert_int_equal(hpr_solve(room->context, room->scene, &options, &solution), HPR_OK);
    assert_int_equal(hpr_solution_summary(solution)->short_count, 0);
    return solution;
}

/* Mean of H over a patch of unit area: T_0 = 1/sqrt(A) on each of its n elements of area A = 1/n. */
static double mean_irradiance(const hpr_solution *solution, size_t patch)
{
    const hpr_elements *elements = solution->elements;
    double sum = 0;
    size_t begin = elements->patch_leaf[patch], end = elements->patch_leaf[patch + 1];
    for (size_t leaf = begin; leaf < end; leaf++)
        sum += solution->irradiance[3 * elements->dof[leaf]];
    return sum / sqrt((double)(end - begin));
}

static double mean_error(const mixed *m, int order, int subdivide)
{
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 1, 1, m->reflectance, m->exitance, m->open);
    hpr_solution *solution = solved(&room, order, subdivide, 1e-10);
    double worst = 0;
    for (int face = 0, patch = 0; face < 6; face++) {
        if (face == m->open)
            continue;
        double mean = m->exitance[face] + m->reflectance[face] * mean_irradiance(solution, (size_t)patch++);
        worst = fmax(worst, fabs(mean / m->mean[face] - 1));
    }
    hpr_solution_destroy(&solution);
    room_close(&room);
    return worst;
}

/*
 * At the edges B is like r^lambda, so convergence in p is algebraic. Bounds: 1.5 times the errors observed,
 * which fall like p^-3.4 from degree 4 to 8 in both boxes.
 */
static void check_convergence(const mixed *m)
{
    static const double bound[] = {1.3e-2, 1.2e-4, 1.6e-5, 4.2e-6, 1.6e-6};
    int failures = 0;
    for (int i = 0; i < 5; i++) {
        double error = mean_error(m, 2 * i, 1);
        print_message("%s, 4 elements per face, degree %d: error of the means %.2e, bound %.1e\n", m->name,
                      2 * i, error, bound[i]);
        failures += !(error <= bound[i]);
    }
    assert_int_equal(failures, 0);
}

static void means_of_the_mixed_cube_converge(void **state)
{
    (void)state;
    check_convergence(&mixed_cubes[0]);
}

static void means_of_the_open_box_converge(void **state)
{
    (void)state;
    check_convergence(&mixed_cubes[3]);
}

static double furnace_error(double rho, int order, int subdivide)
{
    const double reflectance[6] = {rho, rho, rho, rho, rho, rho}, exitance[6] = {1, 1, 1, 1, 1, 1};
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 0.5, 3, reflectance, exitance, -1);
    hpr_solution *solution = solved(&room, order, subdivide, 1e-12);
    double worst = room_furnace_error(&room, solution, rho);
    hpr_solution_destroy(&solution);
    room_close(&room);
    return worst;
}

static void box_of_reflectance_099_is_a_furnace(void **state)
{
    (void)state;
    for (int order = 0; order <= 4; order++) {
        for (int subdivide = 0; subdivide <= (order < 3); subdivide++) {
            double error = furnace_error(0.99, order, subdivide), bound = 1e-10; /* worst seen 2e-12 */
            print_message("box 1 x 0.5 x 3, rho 0.99, degree %d, subdivide %d: error of B %.1e, bound %.0e\n",
                          order, subdivide, error, bound);
            assert_true(error <= bound);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(means_of_the_mixed_cube_converge),
        cmocka_unit_test(means_of_the_open_box_converge),
        cmocka_unit_test(box_of_reflectance_099_is_a_furnace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
