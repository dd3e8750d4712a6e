/* Form factors by hemicube and by ray casting against closed forms. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "baseline/hemicube.h"
#include "baseline/raycast.h"
#include "direct/lambert.h"
#include "methods.h"
#include "patch/rows_build.h"
#include "quadrature/pair.h"

/* What the centre of leaf i sees of leaf j where nothing comes between, in closed form. */
static double point_factor(const hpr_solution *s, size_t i, size_t j)
{
    const hpr_elements *e = s->elements;
    hpr_element_frame r = hpr_leaf_frame(s->patches, e, i), f = hpr_leaf_frame(s->patches, e, j);
    double centre[3], normal[3], corner[4][3];
    hpr_vec3_store(centre, hpr_madd(hpr_madd(r.origin, 0.5, r.edge1), 0.5, r.edge2));
    hpr_vec3_store(normal, r.normal);
    hpr_vec3_store(corner[0], f.origin);
    hpr_vec3_store(corner[1], hpr_add(f.origin, f.edge1));
    hpr_vec3_store(corner[2], hpr_add(hpr_add(f.origin, f.edge1), f.edge2));
    hpr_vec3_store(corner[3], hpr_add(f.origin, f.edge2));
    return e->patch[e->leaf[i]] == e->patch[e->leaf[j]]
               ? 0
               : hpr_lambert_fraction(centre, normal, (const double(*)[3])corner, 4);
}

/* RMS over all pairs of what the factors are off, relative to that of the factors. */
static double factor_error(const hpr_solution *s, const double *factor)
{
    size_t n = s->elements->leaf_count;
    double off2 = 0, all2 = 0;
    for (size_t k = 0; k < n * n; k++) {
        double exact = point_factor(s, k / n, k % n);
        off2 += (factor[k] - exact) * (factor[k] - exact);
        all2 += exact * exact;
    }
    return sqrt(off2 / all2);
}

/* In an empty box the sum of a row is 1 but for the pixels' shares, 0.1 / N^2, and each factor is known.
 * Edges are off by a part of a pixel: the error falls like 1 / N at least. Not one ray. */
static void a_finer_hemicube_is_more_exact(void **state)
{
    (void)state;
    hpr_room room = empty_box();
    hpr_solve_options options = method_options(HPR_METHOD_HEMICUBE, HPR_SOLVER_AUTO);
    hpr_solution *s = solve(&room, &options, NULL);
    size_t n = s->elements->leaf_count;
    double before = INFINITY, *factor = NULL;
    for (int resolution = 16; resolution <= 1024; resolution *= 4) {
        double closure = 0;
        factor = calloc(n * n, sizeof *factor);
        assert_int_equal(hpr_hemicube_factors(s->patches, s->elements, resolution, factor), HPR_OK);
        double error = factor_error(s, factor);
        for (size_t i = 0; i < n; i++) {
            double sum = 0;
            for (size_t j = 0; j < n; j++)
                sum += factor[i * n + j];
            closure = fmax(closure, fabs(sum - 1));
        }
        print_message("hemicube of %4d pixels: factors off by %.2e (bound %.1e), row sums by %.1e\n",
                      resolution, error, 2.0 / resolution, closure);
        assert_true(error <= 2.0 / resolution); /* observed: two thirds of it at 16 pixels, later less */
        assert_true(error < before / 3);
        assert_true(closure <= 1.0 / ((double)resolution * resolution)); /* observed half of it */
        before = error;
        free(factor);
    }
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_RAYS), 0);
    hpr_solution_destroy(&s);
    room_close(&room);
}

/* Elements are compared with what the solver saw: the error of the whole falls too, and still no ray. */
static void a_hemicube_casts_no_ray(void **state)
{
    (void)state;
    hpr_room room = table_room(2);
    hpr_solve_options options = method_options(HPR_METHOD_HEMICUBE, HPR_SOLVER_AUTO);
    hpr_baseline_options baseline;
    hpr_baseline_options_init(&baseline);
    double off[3];
    baseline.hemicube = 2048;
    hpr_solution *best = solve(&room, &options, &baseline);
    for (int k = 0; k < 3; k++) {
        baseline.hemicube = 16 << (2 * k);
        hpr_solution *s = solve(&room, &options, &baseline);
        off[k] = difference(s, best);
        hpr_solution_destroy(&s);
    }
    print_message("hemicubes of 16, 64, 256 pixels: H off by %.1e, %.1e, %.1e\n", off[0], off[1], off[2]);
    assert_true(off[1] < off[0] / 2 && off[2] < off[1] / 2);
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_RAYS), 0);
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_CLIPS), 0);
    hpr_solution_destroy(&best);
    room_close(&room);
}

/* A lid that faces up, between two plates: the lower plate sees its black back, and gets none of its light.
 */
static void backs_hide_and_send_nothing(void **state)
{
    (void)state;
    hpr_room room = room_open(1);
    const double lid[4][3] = {{-9, -9, 0.5}, {9, -9, 0.5}, {9, 9, 0.5}, {-9, 9, 0.5}};
    room_add_plates(&room, 1, 0.5, 0);
    room_add(&room, 4, lid, 0.5, 1, false);
    hpr_solve_options options = method_options(HPR_METHOD_HEMICUBE, HPR_SOLVER_AUTO);
    for (int method = HPR_METHOD_HEMICUBE; method <= HPR_METHOD_RAYCAST; method++) {
        options.method = (hpr_method)method;
        hpr_solution *s = solve(&room, &options, NULL);
        size_t values = value_count(s) / 3; /* of each of the three patches */
        for (size_t i = 0; i < values; i++)
            assert_true(s->irradiance[i] == 0 && s->irradiance[values + i] > 0);
        assert_true(isnan(s->energy->escaped) && isnan(s->energy->lost_on_backs));
        assert_true(fabs(s->energy->emitted - 18 * 18) < 1e-12);
        hpr_solution_destroy(&s);
    }
    room_close(&room);
}

/* One row per leaf, as hpr_baseline_factors makes it, of a solution's patches. */
static hpr_rows *rows_of(hpr_solution *s)
{
    hpr_rows *rows = NULL;
    size_t n = s->patches->count;
    assert_int_equal(hpr_rows_create(s->context, n, &rows), HPR_OK);
    rows->patches = s->patches;
    rows->patch_row = hpr_allocate(s->context, n, sizeof(uint32_t));
    rows->patch_surface = hpr_allocate(s->context, n, sizeof(uint32_t));
    for (uint32_t i = 0; i < n; i++)
        rows->patch_row[i] = rows->patch_surface[i] = i;
    assert_int_equal(hpr_rows_index(rows), HPR_OK);
    return rows;
}

/* N x N discs for a square: the midpoint rule but for the discs' size, both of order 1 / N^2. */
static void more_discs_are_more_exact(void **state)
{
    (void)state;
    hpr_room room = empty_box();
    hpr_solve_options options = method_options(HPR_METHOD_RAYCAST, HPR_SOLVER_AUTO);
    options.subdivide = 0;
    hpr_solution *s = solve(&room, &options, NULL);
    hpr_rows *rows = rows_of(s);
    double factor[36], before = INFINITY;
    bool blocked = true;
    for (int n = 2; n <= 32; n *= 2) {
        assert_int_equal(hpr_raycast_factors(rows, n, factor, &blocked), HPR_OK);
        double error = factor_error(s, factor);
        print_message("%2d x %2d discs: factors off by %.2e\n", n, n, error);
        assert_true(error < before / 3.5);
        before = error;
    }
    assert_true(before < 1e-3); /* observed 1.5e-4 */
    assert_false(blocked);
    assert_int_equal(hpr_counter_value(room.context, HPR_COUNT_RAYS), 0);
    rows->patches = NULL; /* the solution's */
    hpr_rows_destroy(&rows);
    hpr_solution_destroy(&s);
    room_close(&room);
}

/* Triangles are cut into triangles: their middles' mean is the centroid, so that a constant kernel is exact,
 * and far away the factor of two triangles is that of the square that they make. */
static void discs_of_triangles(void **state)
{
    (void)state;
    const double floor_[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double lower[3][3] = {{0, 0, 9}, {0, 1, 9}, {1, 0, 9}},
                 upper[3][3] = {{1, 1, 9}, {1, 0, 9}, {0, 1, 9}};
    const double whole[4][3] = {{0, 0, 9}, {0, 1, 9}, {1, 1, 9}, {1, 0, 9}};
    hpr_room room = room_open(1);
    room_add(&room, 4, floor_, 0.5, 1, false);
    room_add(&room, 3, lower, 0.5, 0, false);
    room_add(&room, 3, upper, 0.5, 0, false);
    hpr_solve_options options = method_options(HPR_METHOD_RAYCAST, HPR_SOLVER_AUTO);
    options.subdivide = 0;
    hpr_solution *s = solve(&room, &options, NULL);
    hpr_rows *rows = rows_of(s);
    const double centre[3] = {0.5, 0.5, 0}, up[3] = {0, 0, 1};
    double factor[9], exact = hpr_lambert_fraction(centre, up, whole, 4);
    bool blocked;
    for (int n = 3; n <= 12; n += 3) {
        assert_int_equal(hpr_raycast_factors(rows, n, factor, &blocked), HPR_OK);
        double off = fabs(factor[1] + factor[2] - exact) / exact;
        print_message("two triangles of %d x %d discs: off by %.2e\n", n, n, off);
        /* Discs: relative a / (pi r^2), a = 1 / (2 n^2); the midpoint rule is off by about as much. */
        assert_true(off < 2.0 / (n * n) / (3.14 * 81));
        assert_true(fabs(factor[1] - factor[2]) < 1e-14);
    }
    rows->patches = NULL;
    hpr_rows_destroy(&rows);
    hpr_solution_destroy(&s);
    room_close(&room);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_finer_hemicube_is_more_exact),
        cmocka_unit_test(a_hemicube_casts_no_ray),
        cmocka_unit_test(backs_hide_and_send_nothing),
        cmocka_unit_test(more_discs_are_more_exact),
        cmocka_unit_test(discs_of_triangles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
