/* What the tests of the classical methods share: rooms, and solving by a method. */
#ifndef HPR_TESTS_METHODS_H
#define HPR_TESTS_METHODS_H

#include "rooms.h"

#include <hprad/baseline.h>
#include <string.h>

/* A closed box of mixed walls, lit from the ceiling, and a table in it that is no side's neighbour. */
static inline hpr_room table_room(int threads)
{
    const double rho[6] = {0.2, 0.7, 0.5, 0.5, 0.8, 0.6}, m[6] = {0, 0, 0, 0, 0, 1};
    const double top[4][3] = {{0.3, 0.2, 0.4}, {0.8, 0.2, 0.4}, {0.8, 0.7, 0.4}, {0.3, 0.7, 0.4}};
    hpr_room room = room_open(threads);
    room_add_box(&room, 1, 1.25, 0.75, rho, m, -1);
    room_add(&room, 4, top, 0.4, 0, true);
    return room;
}

static inline hpr_solve_options method_options(hpr_method method, hpr_solver_method solver)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.method = method;
    options.solver = solver;
    options.subdivide = 1;
    return options;
}

static inline hpr_solution *solve(hpr_room *room, const hpr_solve_options *options,
                                  const hpr_baseline_options *baseline)
{
    hpr_solution *solution = NULL;
    hpr_status status = hpr_baseline_solve(room->context, room->scene, options, baseline, &solution);
    if (status != HPR_OK)
        print_error("%s\n", hpr_context_error(room->context));
    assert_int_equal(status, HPR_OK);
    return solution;
}

static inline size_t value_count(const hpr_solution *s)
{
    return s->elements->leaf_count * s->channel_count;
}

/* Largest difference of the coefficients of H, relative to the largest one of b. */
static inline double difference(const hpr_solution *a, const hpr_solution *b)
{
    double most = 0, worst = 0;
    assert_int_equal(value_count(a), value_count(b));
    for (size_t i = 0; i < value_count(b); i++) {
        worst = fmax(worst, fabs(a->irradiance[i] - b->irradiance[i]));
        most = fmax(most, fabs(b->irradiance[i]));
    }
    return worst / most;
}

static inline hpr_room empty_box(void)
{
    const double rho[6] = {0.5, 0.5, 0.5, 0.5, 0.5, 0.5}, m[6] = {1, 1, 1, 1, 1, 1};
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 1.3, 0.7, rho, m, -1);
    return room;
}

static inline void assert_refused(hpr_room *room, const hpr_solve_options *options,
                                  const hpr_baseline_options *baseline, hpr_status expected, const char *text)
{
    hpr_solution *solution;
    assert_int_equal(hpr_baseline_solve(room->context, room->scene, options, baseline, &solution), expected);
    assert_null(solution);
    if (!strstr(hpr_context_error(room->context), text))
        fail_msg("'%s' lacks '%s'", hpr_context_error(room->context), text);
}

#endif
