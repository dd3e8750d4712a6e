/* The ways to solve the linear system: one solution, the limits of each, few steps where little is absorbed.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "mixed_cubes.h"
#include "rooms.h"
#include "solver/solution.h"

#include <string.h>

/* A solved unit cube; closed() when done. */
typedef struct box {
    hpr_room room;
    hpr_status status;
    hpr_solution *solution;
} box;

static box solved(const double *reflectance, const double *exitance, int subdivide, hpr_solver_method method,
                  int max_sweeps)
{
    box b = {.room = room_open(2)};
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    room_add_box(&b.room, 1, 1, 1, reflectance, exitance, -1);
    options.order = subdivide > 1 ? 0 : 1;
    options.subdivide = subdivide;
    options.feet = 0;
    options.solver = method;
    options.max_sweeps = max_sweeps;
    options.direct = HPR_DIRECT_GALERKIN;
    b.status = hpr_solve(b.room.context, b.room.scene, &options, &b.solution);
    return b;
}

static void closed(box *b)
{
    hpr_solution_destroy(&b->solution);
    room_close(&b->room);
}

/* Each stops when it expects an error of 1e-13; the estimates are good to a digit or two. */
static void test_methods_agree(void **state)
{
    (void)state;
    static const double bound = 1e-11;
    for (int i = 0; i < 3; i++) {
        const mixed *m = &mixed_cubes[i];
        box first = solved(m->reflectance, m->exitance, 1, HPR_SOLVER_GAUSS_SEIDEL, 20000);
        assert_int_equal(first.status, HPR_OK);
        for (int method = HPR_SOLVER_AUTO; method <= HPR_SOLVER_SHOOTING; method++) {
            const char *name = hpr_solver_name((hpr_solver_method)method);
            box other = solved(m->reflectance, m->exitance, 1, (hpr_solver_method)method, 200000);
            assert_int_equal(other.status, HPR_OK);
            double error = room_difference(first.solution, other.solution);
            const hpr_solve_summary *s = hpr_solution_summary(other.solution);
            print_message("%s by %s: %d steps, residual %.1e, differs by %.1e, bound %.0e\n", m->name, name,
                          s->sweeps, s->residual, error, bound);
            if (method != HPR_SOLVER_AUTO)
                assert_int_equal(s->solver, method);
            if (!(error <= bound))
                fail_msg("%s by %s differs by %.2e", m->name, name, error);
            closed(&other);
        }
        closed(&first);
    }
}

/* Reflectance 0.999 everywhere, faces 16 x 16: Gauss-Seidel alone takes 13,820 sweeps for six faces. */
static void test_little_absorbed(void **state)
{
    (void)state;
    static const double reflectance[6] = {0.999, 0.999, 0.999, 0.999, 0.999, 0.999};
    static const double exitance[6] = {0.1, 0.5, 0, 0, 0.25, 1};
    box b = solved(reflectance, exitance, 4, HPR_SOLVER_AUTO, 20000);
    assert_int_equal(b.status, HPR_OK);
    const hpr_solve_summary *s = hpr_solution_summary(b.solution);
    print_message("%d applications, residual %.1e; asked: 25, 1e-12\n", s->sweeps, s->residual);
    assert_int_equal(s->solver, HPR_SOLVER_GMRES);
    assert_in_range(s->sweeps, 1, 25);
    assert_true(s->residual <= 1e-12);
    closed(&b);
}

/* The error of the closure, 1e-14 of these blocks, is multiplied by 1/(1 - rho). */
static void test_furnace(void **state)
{
    (void)state;
    static const double rho = 0.999, bound = 1e-9;
    const double reflectance[6] = {rho, rho, rho, rho, rho, rho}, exitance[6] = {1, 1, 1, 1, 1, 1};
    box b = solved(reflectance, exitance, 3, HPR_SOLVER_AUTO, 20000);
    assert_int_equal(b.status, HPR_OK);
    const hpr_elements *e = b.solution->elements;
    double worst = 0;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        double mean = b.solution->irradiance[3 * e->dof[leaf]] / sqrt(e->area_m2[e->leaf[leaf]]);
        worst = fmax(worst, fabs(mean * (1 - rho) - 1));
    }
    print_message("furnace of 0.999: %.2e, bound %.0e\n", worst, bound);
    assert_true(worst <= bound);
    closed(&b);
}

/* Nothing absorbs, nothing escapes: every method says so. */
static void test_no_solution(void **state)
{
    (void)state;
    static const double reflectance[6] = {1, 1, 1, 1, 1, 1}, exitance[6] = {0, 0, 0, 0, 0, 1};
    static const hpr_solver_method methods[] = {HPR_SOLVER_AUTO, HPR_SOLVER_GAUSS_SEIDEL, HPR_SOLVER_GMRES,
                                                HPR_SOLVER_GATHERING};
    for (size_t i = 0; i < sizeof methods / sizeof *methods; i++) {
        box b = solved(reflectance, exitance, 1, methods[i], 20000);
        const char *message = hpr_context_error(b.room.context);
        assert_int_equal(b.status, HPR_ERR_NUMERIC);
        assert_null(b.solution);
        if (!strstr(message, "--max-reflectance"))
            fail_msg("%s: %s", hpr_solver_name(methods[i]), message);
        closed(&b);
    }
}

static void test_limit(void **state)
{
    (void)state;
    for (int method = HPR_SOLVER_AUTO; method <= HPR_SOLVER_SHOOTING; method++) {
        const mixed *m = &mixed_cubes[0];
        box b = solved(m->reflectance, m->exitance, 1, (hpr_solver_method)method, 3);
        assert_int_equal(b.status, HPR_ERR_NUMERIC);
        closed(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods_agree), cmocka_unit_test(test_little_absorbed),
        cmocka_unit_test(test_furnace),       cmocka_unit_test(test_no_solution),
        cmocka_unit_test(test_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
