/* The classical methods against each other and against hprad's own, and what they refuse. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "failing_allocator.h"
#include "methods.h"

/* Where no surface stands on another, the exact factors are hprad's own degree 0. */
static void exact_factors_are_those_of_degree_zero(void **state)
{
    (void)state;
    hpr_room room = table_room(2);
    hpr_solve_options options = method_options(HPR_METHOD_EXACT, HPR_SOLVER_AUTO);
    options.block_tolerance = 1e-7;
    hpr_solution *exact = solve(&room, &options, NULL);
    options = method_options(HPR_METHOD_GALERKIN, HPR_SOLVER_AUTO);
    options.order = 0;
    options.feet = 0;
    options.direct = HPR_DIRECT_GALERKIN;
    options.block_tolerance = 1e-7;
    options.link_tolerance = 1e-12;
    hpr_solution *own = solve(&room, &options, NULL);
    double off = difference(exact, own);
    print_message("exact form factors and blocks of degree 0: H differs by %.1e\n", off);
    assert_true(off < 1e-5); /* observed 1e-7: some sixty pairs per row, each to 1e-7 */
    hpr_solution_destroy(&own);
    hpr_solution_destroy(&exact);
    room_close(&room);
}

/* Hemicube and ray casting see from centres; on 64 elements per face that is within some percent. */
static void all_methods_come_near_each_other(void **state)
{
    (void)state;
    hpr_room room = table_room(2);
    hpr_solve_options options = method_options(HPR_METHOD_EXACT, HPR_SOLVER_AUTO);
    options.subdivide = 2;
    hpr_solution *exact = solve(&room, &options, NULL);
    const hpr_method others[] = {HPR_METHOD_HEMICUBE, HPR_METHOD_RAYCAST, HPR_METHOD_HIERARCHICAL};
    for (size_t k = 0; k < sizeof others / sizeof *others; k++) {
        options.method = others[k];
        hpr_solution *s = solve(&room, &options, NULL);
        double off = difference(s, exact);
        print_message("%s: H off by %.1e of the largest\n", hpr_method_name(others[k]), off);
        assert_true(off < 0.15); /* observed 0.034, 0.11, 0.076: links to 0.3 */
        hpr_solution_destroy(&s);
    }
    hpr_solution_destroy(&exact);
    room_close(&room);
}

/* Constants on all levels: a small part of the pairs, and within what the tolerance allows of all of them. */
static void hierarchical_radiosity_has_few_links(void **state)
{
    (void)state;
    hpr_room room = empty_box();
    hpr_solve_options options = method_options(HPR_METHOD_HIERARCHICAL, HPR_SOLVER_AUTO);
    options.subdivide = 4;
    hpr_solution *few = solve(&room, &options, NULL);
    size_t pairs = few->summary.element_count * few->summary.element_count * 5 / 12;
    print_message("%zu links for %zu pairs\n", few->summary.link_count, pairs);
    assert_true(few->summary.link_count < pairs / 8);
    assert_int_equal(few->summary.direct, HPR_DIRECT_GALERKIN);
    assert_true(few->summary.link_error <= few->summary.link_tolerance);
    hpr_solution_destroy(&few);
    room_close(&room);
}

static void the_bits_do_not_depend_on_threads(void **state)
{
    (void)state;
    for (int method = HPR_METHOD_HEMICUBE; method <= HPR_METHOD_EXACT; method++) {
        hpr_solution *first = NULL;
        hpr_room rooms[3];
        const int threads[] = {1, 2, 7};
        for (int k = 0; k < 3; k++) {
            rooms[k] = table_room(threads[k]);
            hpr_solve_options options = method_options((hpr_method)method, HPR_SOLVER_GATHERING);
            hpr_solution *s = solve(&rooms[k], &options, NULL);
            if (first)
                assert_memory_equal(s->irradiance, first->irradiance, value_count(s) * sizeof(double));
            else
                first = s;
            if (s != first)
                hpr_solution_destroy(&s);
        }
        hpr_solution_destroy(&first);
        for (int k = 0; k < 3; k++)
            room_close(&rooms[k]);
    }
}

static void what_would_have_no_effect_is_refused(void **state)
{
    (void)state;
    hpr_room room = empty_box();
    const hpr_solve_options good = method_options(HPR_METHOD_RAYCAST, HPR_SOLVER_AUTO);
    hpr_solve_options o = good;
    o.order = 1;
    assert_refused(&room, &o, NULL, HPR_ERR_ARG, "order 1");
    o.method = HPR_METHOD_HIERARCHICAL;
    assert_refused(&room, &o, NULL, HPR_ERR_ARG, "order 1");
    o = good;
    o.solver = HPR_SOLVER_GMRES;
    assert_refused(&room, &o, NULL, HPR_ERR_ARG, "gmres");
    o = good;
    o.link_tolerance = 0.1;
    assert_refused(&room, &o, NULL, HPR_ERR_ARG, "no links");
    o = good;
    o.block_tolerance = 0.1;
    assert_refused(&room, &o, NULL, HPR_ERR_ARG, "no blocks");
    o = good;
    o.method = HPR_METHOD_GALERKIN;
    o.solver = HPR_SOLVER_DIRECT;
    assert_refused(&room, &o, NULL, HPR_ERR_ARG, "full matrix");
    const hpr_baseline_options bad[] = {{.hemicube = 3, .rays = 1},
                                        {.hemicube = HPR_MAX_HEMICUBE + 2, .rays = 1},
                                        {.hemicube = 2, .rays = 0},
                                        {.hemicube = 2, .rays = HPR_MAX_RAYS + 1},
                                        {.hemicube = 2, .rays = 1, .shots = -1},
                                        {.hemicube = 2, .rays = 1, .every = 1},
                                        {.hemicube = 2, .rays = 1, .shots = 1}};
    const char *texts[] = {"hemicube of 3", "4098", "0 x 0", "65 x 65", "-1 shots", "0 shots", "shooting"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_refused(&room, &good, bad + i, HPR_ERR_ARG, texts[i]);
    const double outside = 1;
    assert_int_equal(hpr_scene_set_environment(room.scene, 1, &outside), HPR_OK);
    assert_refused(&room, &good, NULL, HPR_ERR_UNSUPPORTED, "outside");
    room_close(&room);
}

static hpr_status build_and_solve(hpr_context *ctx, void *data)
{
    hpr_room room = {.context = ctx};
    const double rho[3] = {0.5, 0.5, 0.5}, le[3] = {1, 1, 1};
    const double square[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                 {0, 0, 1}, {0, 1, 1}, {1, 1, 1}, {1, 0, 1}};
    const uint32_t vertex[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    const hpr_mesh mesh = {.vertex_count = 8, .position = square[0], .face_count = 2, .vertex = vertex};
    hpr_solve_options options = method_options(*(hpr_method *)data, HPR_SOLVER_SHOOTING);
    hpr_baseline_options baseline;
    hpr_baseline_options_init(&baseline);
    baseline.hemicube = 8;
    hpr_solution *solution = NULL;
    uint32_t material;
    options.subdivide = 0;
    hpr_status status = hpr_scene_create(ctx, "squares", 3, NULL, &room.scene);
    if (status == HPR_OK)
        status = hpr_scene_add_material(room.scene, "m", rho, le, false, &material);
    if (status == HPR_OK)
        status = hpr_scene_add_mesh(room.scene, &mesh);
    if (status == HPR_OK)
        status = hpr_baseline_solve(ctx, room.scene, &options, &baseline, &solution);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&room.scene);
    return status;
}

static void every_method_survives_without_memory(void **state)
{
    (void)state;
    for (int method = HPR_METHOD_HEMICUBE; method <= HPR_METHOD_EXACT; method++)
        sweep_allocations(build_and_solve, &method, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exact_factors_are_those_of_degree_zero),
        cmocka_unit_test(all_methods_come_near_each_other),
        cmocka_unit_test(hierarchical_radiosity_has_few_links),
        cmocka_unit_test(the_bits_do_not_depend_on_threads),
        cmocka_unit_test(what_would_have_no_effect_is_refused),
        cmocka_unit_test(every_method_survives_without_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
