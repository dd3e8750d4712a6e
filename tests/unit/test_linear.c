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

/* A closed unit cube somewhere, the same everywhere in it. */
static void add_furnace(hpr_room *room, double x, double reflectance, double exitance)
{
    const double face[6][4][3] = {
        {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}}, {{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}},
        {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}}, {{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}},
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}}};
    for (int i = 0; i < 6; i++) {
        double corner[4][3];
        memcpy(corner, face[i], sizeof corner);
        for (int k = 0; k < 4; k++)
            corner[k][0] += x;
        room_add(room, 4, (const double(*)[3])corner, reflectance, exitance, false);
    }
}

static hpr_solution *solved_coarsely(hpr_room *room, hpr_solver_method method)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = options.subdivide = options.feet = 0;
    options.solver = method;
    options.max_sweeps = 200000;
    options.direct = HPR_DIRECT_GALERKIN;
    options.block_tolerance = 1e-13;
    hpr_solution *solution = NULL;
    assert_int_equal(hpr_solve(room->context, room->scene, &options, &solution), HPR_OK);
    return solution;
}

/* Two furnaces that do not see each other, one 1e10 times as bright. In the norm of both the darker one is
 * nothing when the brighter one has converged, after a few sweeps; by itself it needs 200 sweeps or 20,000.
 * Observed: 8e-10; left as they are then, darker faces were 1e-6 to 2e-4 off. */
static void test_range_of_rooms(void **state)
{
    (void)state;
    static const double bright = 1e10, dull = 0.3, rho[2] = {0.9, 0.999}, bound = 1e-8;
    for (int method = HPR_SOLVER_AUTO; method <= HPR_SOLVER_SHOOTING; method++) {
        bool quick = method == HPR_SOLVER_AUTO || method == HPR_SOLVER_GMRES;
        for (int dark = 0; dark < 1 + quick; dark++) {
            hpr_room room = room_open(2);
            add_furnace(&room, 0, dull, bright);
            add_furnace(&room, 3, rho[dark], 1);
            hpr_solution *solution = solved_coarsely(&room, (hpr_solver_method)method);
            double worst = 0;
            for (size_t patch = 0; patch < 12; patch++) {
                double truth = patch < 6 ? bright / (1 - dull) : 1 / (1 - rho[dark]);
                worst = fmax(worst, fabs(solution->irradiance[3 * patch] / truth - 1));
            }
            const char *name = hpr_solver_name((hpr_solver_method)method);
            print_message("%s, rho %g in the dark room: %d steps, worst patch %.1e, bound %.0e\n", name,
                          rho[dark], hpr_solution_summary(solution)->sweeps, worst, bound);
            if (!(worst <= bound))
                fail_msg("%s: a patch is off by %.2e of its own value", name, worst);
            hpr_solution_destroy(&solution);
            room_close(&room);
        }
    }
}

/* Faces of one cube shine from 1 to 1e10: what arrives from all of them is the sum of what
 * arrives from each, on every face relative to its own value. */
static void test_range_of_faces(void **state)
{
    (void)state;
    static const double reflectance[6] = {0.5, 0, 0.9, 0.3, 0.99, 0.7},
                        exitance[6] = {1, 1e10, 1e2, 1e8, 1e4, 1e6};
    static const double bound = 1e-11;
    double sum[6] = {0};
    for (int face = 0; face <= 6; face++) {
        double one[6];
        for (int i = 0; i < 6; i++)
            one[i] = face == 6 || face == i ? exitance[i] : 0;
        hpr_room room = room_open(2);
        room_add_box(&room, 1, 0.7, 2, reflectance, one, -1);
        hpr_solution *solution = solved_coarsely(&room, HPR_SOLVER_AUTO);
        for (int i = 0; i < 6; i++) {
            double error = face == 6 ? fabs(sum[i] / solution->irradiance[3 * i] - 1) : 0;
            sum[i] += solution->irradiance[3 * i];
            if (face == 6)
                print_message("face %d: off by %.1e, bound %.0e\n", i, error, bound);
            assert_true(error <= bound);
        }
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_methods_agree),  cmocka_unit_test(test_little_absorbed),
        cmocka_unit_test(test_furnace),        cmocka_unit_test(test_no_solution),
        cmocka_unit_test(test_limit),          cmocka_unit_test(test_range_of_rooms),
        cmocka_unit_test(test_range_of_faces),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
