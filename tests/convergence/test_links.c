/*
 * Links between nodes of any level against all pairs of leaves: the solution differs by less than the link
 * tolerance, there are fewer links, and leaf plus ancestors close.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "lcg.h"
#include "mixed_cubes.h"
#include "rooms.h"
#include "solver/operator.h"
#include "solver/solution.h"

#include <stdlib.h>

/* The smallest tolerance that there is: links stand at leaves. */
static const double dense = 1e-300;

static hpr_solution *solved(const hpr_room *room, int order, int subdivide, double link_tolerance)
{
    hpr_solve_options options;
    hpr_solve_options_init(&options);
    options.order = order;
    options.subdivide = subdivide;
    options.feet = 0;
    options.link_tolerance = link_tolerance;
    hpr_solution *solution = NULL;
    assert_int_equal(hpr_solve(room->context, room->scene, &options, &solution), HPR_OK);
    return solution;
}

/* A closed box of unequal sides with random materials, one face of which shines. */
static void add_random_box(hpr_room *room, uint64_t *state)
{
    double reflectance[6], exitance[6] = {0}, side[3];
    for (int k = 0; k < 3; k++)
        side[k] = 0.3 + random_unit(state);
    for (int k = 0; k < 6; k++)
        reflectance[k] = 0.9 * random_unit(state);
    exitance[(int)(6 * random_unit(state))] = 1;
    room_add_box(room, side[0], side[1], side[2], reflectance, exitance, -1);
}

/* A plate of two triangles in the middle of the room casts shadows from both sides. */
static void add_shelf(hpr_room *room)
{
    const double lower[3][3] = {{0.2, 0.2, 0.15}, {0.7, 0.25, 0.15}, {0.6, 0.6, 0.16}};
    room_add(room, 3, lower, 0.5, 0, true);
}

/* A closed box stands askew on the floor and covers a part of it, at no line of the elements. */
static void add_block(hpr_room *room)
{
    const double low[4][2] = {{0.1, 0.12}, {0.32, 0.08}, {0.36, 0.29}, {0.14, 0.33}}, h = 0.17;
    const double top[4][3] = {{low[0][0], low[0][1], h},
                              {low[1][0], low[1][1], h},
                              {low[2][0], low[2][1], h},
                              {low[3][0], low[3][1], h}};
    room_add(room, 4, top, 0.6, 0, false);
    for (int i = 0; i < 4; i++) {
        const double *a = low[i], *b = low[(i + 1) % 4];
        const double side[4][3] = {{a[0], a[1], 0}, {b[0], b[1], 0}, {b[0], b[1], h}, {a[0], a[1], h}};
        room_add(room, 4, side, 0.6, 0, false);
    }
}

typedef struct scene {
    const char *name;
    int boxes_seed;
    bool shelf, plates, block;
    int order, subdivide;
} scene;

static const scene scenes[] = {
    {"box 1", 1, false, false, false, 0, 2},  {"box 2", 2, false, false, false, 1, 2},
    {"box 3", 3, false, false, false, 2, 2},  {"box 4", 4, false, false, false, 1, 3},
    {"plates", 0, false, true, false, 3, 2},  {"plates, fine", 0, false, true, false, 1, 4},
    {"shelf 1", 5, true, false, false, 0, 2}, {"shelf 2", 6, true, false, false, 1, 2},
    {"block", 7, false, false, true, 1, 2},   {"block, fine", 7, false, false, true, 1, 3},
};

static hpr_room opened(const scene *s)
{
    hpr_room room = room_open(2);
    uint64_t state = (uint64_t)s->boxes_seed;
    random_unit(&state);
    if (s->plates)
        room_add_plates(&room, 0.3, 0.8, 1);
    else
        add_random_box(&room, &state);
    if (s->shelf)
        add_shelf(&room);
    if (s->block)
        add_block(&room);
    return room;
}

static void test_against_all_pairs(void **state)
{
    (void)state;
    int failures = 0;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        const scene *s = &scenes[i];
        hpr_room room = opened(s);
        hpr_solution *all = solved(&room, s->order, s->subdivide, dense);
        /* blocks past blockers are clipped to tolerances of their own, so that no more can be seen */
        int most_digits = s->shelf || s->block ? 6 : 8;
        for (int digits = 2; digits <= most_digits; digits += 2) {
            double tolerance = pow(10, -digits);
            hpr_solution *linked = solved(&room, s->order, s->subdivide, tolerance);
            double error = room_difference(all, linked);
            const hpr_solve_summary *a = hpr_solution_summary(all), *b = hpr_solution_summary(linked);
            bool good = error <= tolerance && b->link_count <= a->link_count;
            print_message("%s, degree %d, tolerance %.0e: %zu of %zu links, H differs by %.1e%s\n", s->name,
                          s->order, tolerance, b->link_count, a->link_count, error, good ? "" : " FAILED");
            failures += !good;
            hpr_solution_destroy(&linked);
        }
        hpr_solution_destroy(&all);
        room_close(&room);
    }
    assert_int_equal(failures, 0);
}

/* Of a cube with 4^n elements per face, at 1e-2. The far field is settled high up in the trees: what grows is
 * the number of elements along the edges, 2^n. */
static void test_growth(void **state)
{
    (void)state;
    size_t before = 0;
    for (int subdivide = 3; subdivide <= 5; subdivide++) {
        hpr_room room = room_open(2);
        const mixed *m = &mixed_cubes[0];
        room_add_box(&room, 1, 1, 1, m->reflectance, m->exitance, -1);
        hpr_solution *solution = solved(&room, 1, subdivide, 1e-2);
        size_t links = hpr_solution_summary(solution)->link_count;
        double exponent = before ? log((double)links / (double)before) / log(4) : 0;
        print_message("%zu elements: %zu links, exponent %.2f\n",
                      hpr_solution_summary(solution)->element_count, links, exponent);
        if (before && !(exponent <= 0.9)) /* observed: 0.74, 0.65 */
            fail_msg("%zu links after %zu: exponent %.2f", links, before, exponent);
        before = links;
        hpr_solution_destroy(&solution);
        room_close(&room);
    }
}

/* sum_j sqrt(A_j) K_ij^k0 = sqrt(A_i) delta_k0 over a leaf's links and its ancestors' pushed down: the
 * operator makes 1 of 1. Links between nodes leave that out by their tolerance. */
static void test_closure(void **state)
{
    (void)state;
    static const double tolerance = 1e-6, bound = 1e-6;
    hpr_room room = room_open(2);
    const mixed *m = &mixed_cubes[0];
    room_add_box(&room, 1, 1, 1, m->reflectance, m->exitance, -1);
    hpr_solution *solution = solved(&room, 2, 3, tolerance);
    const hpr_elements *e = solution->elements;
    const bool sends[6] = {true, true, true, true, true, true};
    const hpr_links_demand demand = {.link_tolerance = tolerance, .sends = sends};
    hpr_coverage *coverage = NULL;
    hpr_links *links = NULL;
    hpr_operator *op = NULL;
    assert_int_equal(hpr_coverage_create(solution->patches, e, &coverage), HPR_OK);
    assert_int_equal(hpr_links_assemble(coverage, e, &demand, &links), HPR_OK);
    assert_int_equal(hpr_operator_create(links, 1, &op), HPR_OK);
    size_t dofs = e->dof[e->leaf_count];
    double *one = calloc(dofs, sizeof *one), *result = calloc(dofs, sizeof *result), worst = 0;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++)
        one[e->dof[leaf]] = sqrt(e->area_m2[e->leaf[leaf]]);
    hpr_operator_apply(op, one, result);
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        for (size_t i = e->dof[leaf]; i < e->dof[leaf + 1]; i++)
            worst = fmax(worst, fabs(result[i] - one[i]) / one[e->dof[leaf]]);
    }
    print_message("%zu links: closure %.1e, bound %.0e\n", links->count, worst, bound);
    assert_true(worst <= bound);
    assert_true(links->count < e->leaf_count * e->leaf_count / 3);
    free(one);
    free(result);
    hpr_operator_destroy(&op);
    hpr_links_destroy(&links);
    hpr_coverage_destroy(&coverage);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

/* A black room: no link, no block. */
static void test_black_room(void **state)
{
    (void)state;
    const double reflectance[6] = {0}, exitance[6] = {1, 0, 0, 0, 0, 0};
    hpr_room room = room_open(2);
    room_add_box(&room, 1, 1, 1, reflectance, exitance, -1);
    hpr_solution *solution = solved(&room, 1, 1, 0);
    assert_int_equal(hpr_solution_summary(solution)->link_count, 0);
    hpr_solution_destroy(&solution);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_against_all_pairs),
        cmocka_unit_test(test_growth),
        cmocka_unit_test(test_closure),
        cmocka_unit_test(test_black_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
