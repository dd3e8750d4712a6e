/* Ways to solve the full matrix of form factors: all against elimination. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "baseline/matrix.h"
#include "methods.h"

/* The same matrix, solved in four ways: to 1e-10 of each other, at a tolerance of 1e-13. */
static void every_solver_agrees_with_elimination(void **state)
{
    (void)state;
    for (int method = HPR_METHOD_HEMICUBE; method <= HPR_METHOD_EXACT; method++) {
        hpr_room room = table_room(2);
        hpr_solve_options options = method_options((hpr_method)method, HPR_SOLVER_DIRECT);
        hpr_solution *direct = solve(&room, &options, NULL);
        assert_int_equal(direct->summary.solver, HPR_SOLVER_DIRECT);
        assert_true(direct->summary.residual < 1e-14);
        for (int solver = HPR_SOLVER_AUTO; solver <= HPR_SOLVER_SHOOTING; solver++) {
            if (solver == HPR_SOLVER_GMRES)
                continue;
            options.solver = (hpr_solver_method)solver;
            hpr_solution *other = solve(&room, &options, NULL);
            double off = difference(other, direct);
            print_message("%s, %s: %d sweeps, off by %.1e (bound 1e-10)\n",
                          hpr_method_name((hpr_method)method), hpr_solver_name((hpr_solver_method)solver),
                          other->summary.sweeps, off);
            assert_true(off <= 1e-10);
            hpr_solution_destroy(&other);
        }
        hpr_solution_destroy(&direct);
        room_close(&room);
    }
}

/* A matrix that is nobody's, with three channels that differ; rows sum to at most 1. */
enum { RANDOM = 40, CHANNELS = 3 };

typedef struct random_problem {
    double factor[RANDOM * RANDOM], area[RANDOM], rho[CHANNELS * RANDOM], m[CHANNELS * RANDOM];
    double h[CHANNELS * RANDOM];
} random_problem;

static hpr_matrix_problem make_random(hpr_context *ctx, random_problem *r)
{
    srand(7);
    for (size_t i = 0; i < RANDOM; i++) {
        r->area[i] = 0.5 + rand() / (double)RAND_MAX;
        for (size_t j = 0; j < RANDOM; j++)
            r->factor[i * RANDOM + j] = i == j ? 0 : rand() / (double)RAND_MAX / (RANDOM - 1);
    }
    for (size_t i = 0; i < CHANNELS * RANDOM; i++) {
        r->rho[i] = rand() / (double)RAND_MAX;
        r->m[i] = rand() / (double)RAND_MAX;
    }
    return (hpr_matrix_problem){.context = ctx,
                                .count = RANDOM,
                                .channel_count = CHANNELS,
                                .factor = r->factor,
                                .area_m2 = r->area,
                                .reflectance = r->rho,
                                .exitance = r->m,
                                .tolerance = 1e-13,
                                .max_sweeps = 1000,
                                .irradiance = r->h};
}

static void channels_are_solved_each_by_itself(void **state)
{
    (void)state;
    static random_problem r;
    hpr_room room = room_open(2);
    hpr_matrix_problem p = make_random(room.context, &r);
    double direct[CHANNELS * RANDOM];
    p.method = HPR_SOLVER_DIRECT;
    assert_int_equal(hpr_matrix_solve(&p), HPR_OK);
    memcpy(direct, r.h, sizeof direct);
    for (size_t c = 0; c < CHANNELS; c++) {
        for (size_t i = 0; i < RANDOM; i++) { /* the equation itself */
            double sum = 0;
            for (size_t j = 0; j < RANDOM; j++)
                sum += r.factor[i * RANDOM + j] *
                       (r.m[c * RANDOM + j] + r.rho[c * RANDOM + j] * direct[c * RANDOM + j]);
            assert_true(fabs(sum - direct[c * RANDOM + i]) < 1e-13);
        }
    }
    const hpr_solver_method others[] = {HPR_SOLVER_GAUSS_SEIDEL, HPR_SOLVER_GATHERING, HPR_SOLVER_SHOOTING};
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        p.method = others[k];
        assert_int_equal(hpr_matrix_solve(&p), HPR_OK);
        for (size_t i = 0; i < CHANNELS * RANDOM; i++)
            assert_true(fabs(r.h[i] - direct[i]) <= 1e-10 * direct[i]);
    }
    room_close(&room);
}

/* After k shots: what is shown only grows, k is right, and the end is where it was asked for. */
typedef struct gallery {
    int last, count;
    double absorbed;
} gallery;

static hpr_status hang(void *user, const hpr_solution *solution, int shots)
{
    gallery *g = user;
    assert_int_equal(shots, g->last + 3);
    assert_int_equal(solution->summary.sweeps, shots);
    assert_true(solution->energy->absorbed > g->absorbed);
    *g = (gallery){shots, g->count + 1, solution->energy->absorbed};
    return HPR_OK;
}

static hpr_status refuse(void *user, const hpr_solution *solution, int shots)
{
    (void)user;
    (void)solution;
    (void)shots;
    return HPR_ERR_IO;
}

static void shooting_shows_what_it_has_reached(void **state)
{
    (void)state;
    hpr_room room = table_room(2);
    hpr_solve_options options = method_options(HPR_METHOD_RAYCAST, HPR_SOLVER_SHOOTING);
    gallery g = {0};
    hpr_baseline_options baseline;
    hpr_baseline_options_init(&baseline);
    baseline.shots = 20;
    baseline.every = 3;
    baseline.shot = hang;
    baseline.user = &g;
    hpr_solution *early = solve(&room, &options, &baseline), *late = solve(&room, &options, NULL);
    assert_int_equal(g.count, 6);
    assert_int_equal(early->summary.sweeps, 20);
    assert_true(early->energy->absorbed > g.absorbed && early->energy->absorbed < late->energy->absorbed);
    assert_true(early->summary.residual > 1e-3);
    hpr_solution_destroy(&early);
    hpr_solution_destroy(&late);
    baseline.shot = refuse;
    assert_int_equal(hpr_baseline_solve(room.context, room.scene, &options, &baseline, &early), HPR_ERR_IO);
    assert_null(early);
    room_close(&room);
}

static void a_white_closed_room_has_no_solution(void **state)
{
    (void)state;
    const double rho[6] = {1, 1, 1, 1, 1, 1}, m[6] = {0, 0, 0, 0, 0, 1};
    hpr_room room = room_open(1);
    room_add_box(&room, 1, 1, 1, rho, m, -1);
    hpr_solve_options options = method_options(HPR_METHOD_EXACT, HPR_SOLVER_AUTO);
    options.max_sweeps = 50;
    const hpr_solver_method solvers[] = {HPR_SOLVER_GATHERING, HPR_SOLVER_GAUSS_SEIDEL, HPR_SOLVER_SHOOTING};
    for (size_t k = 0; k < sizeof solvers / sizeof *solvers; k++) {
        options.solver = solvers[k];
        assert_refused(&room, &options, NULL, HPR_ERR_NUMERIC, "--max-reflectance");
    }
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_solver_agrees_with_elimination),
        cmocka_unit_test(channels_are_solved_each_by_itself),
        cmocka_unit_test(shooting_shows_what_it_has_reached),
        cmocka_unit_test(a_white_closed_room_has_no_solution),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
