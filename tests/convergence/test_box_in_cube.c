/*
 * View factors of a closed box inside a cube, every face in squares: blocked pairs by the hundred. Closure,
 * bounds, convergence in the tolerance, and an independent estimate.
 */
#include "link/form_factors.h"
#include "shapes.h"

enum { CUBE_FACES = 6, BOX_FACES = 6 };

/* A parallelepiped: corner and three edges, right-handed. */
typedef struct solid {
    double corner[3], edge[3][3];
} solid;

static const solid cube = {{0, 0, 0}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
static const solid level_box = {{0.3, 0.25, 0.2}, {{0.4, 0, 0}, {0, 0.4, 0}, {0, 0, 0.55}}};
/* turned about all axes, nothing parallel to the cube */
static const solid turned_box = {{0.35, 0.2, 0.25},
                                 {{0.36, 0.15, 0.09}, {-0.144, 0.288, 0.096}, {-0.048, -0.168, 0.432}}};

/* The six faces of a solid in n x n squares, fronts inside or outside. */
static void add_faces(hpr_model *model, const solid *it, int n, bool inside)
{
    for (int axis = 0; axis < 3; axis++) {
        const double *a = it->edge[(axis + 1) % 3], *b = it->edge[(axis + 2) % 3];
        for (int cell = 0; cell < 2 * n * n; cell++) {
            int far = cell / (n * n), i = cell % n, j = cell / n % n;
            hpr_surface s = {.kind = HPR_SURFACE_RADIATES,
                             .corner_count = 4,
                             .base = HPR_NONE,
                             .combine = HPR_NONE,
                             .emissivity = 0.5,
                             .name = (char[]){"s"}};
            for (int c = 0; c < 4; c++) {
                /* a x b points along the edge of the axis: inside on the near face, outside on the far one */
                int turn = (far == 0) == inside ? c : 3 - c;
                double u = (double)(i + (turn == 1 || turn == 2)) / n, v = (double)(j + (turn >= 2)) / n;
                for (int k = 0; k < 3; k++)
                    s.corner[c][k] = it->corner[k] + far * it->edge[axis][k] + u * a[k] + v * b[k];
            }
            assert_int_equal(hpr_model_add(model, &s), HPR_OK);
        }
    }
}

/* 30 m^2 surfaces: the cube's faces 2m x 2m, the box's m x m. box NULL: the cube alone. */
static hpr_form_factors *factors_of(hpr_context *ctx, const solid *box, int m, double tolerance)
{
    hpr_model *model = NULL;
    hpr_rows *rows = NULL;
    hpr_form_factors *factors = NULL;
    assert_int_equal(hpr_model_create(ctx, "box in a cube", &model), HPR_OK);
    add_faces(model, &cube, 2 * m, true);
    if (box)
        add_faces(model, box, m, false);
    assert_int_equal(hpr_model_check(model), HPR_OK);
    assert_int_equal(hpr_rows_of_model(model, &rows), HPR_OK);
    assert_int_equal(hpr_form_factors_create(rows, tolerance, &factors), HPR_OK);
    assert_int_equal(factors->done.short_count, 0);
    hpr_rows_destroy(&rows);
    hpr_model_destroy(&model);
    return factors;
}

static double worst_row(const hpr_form_factors *factors)
{
    double worst = 0, *row = calloc(factors->count, sizeof *row);
    for (size_t i = 0; i < factors->count; i++) {
        double sum = 0;
        hpr_form_factors_row(factors, i, row);
        for (size_t j = 0; j < factors->count; j++)
            sum += row[j];
        worst = fmax(worst, fabs(sum - 1));
    }
    free(row);
    return worst;
}

/* Relative errors of the entries of a row are within the tolerance, so their sum is. */
static void rows_close(void **state)
{
    hpr_context *ctx = *state;
    static const double tolerance = 1e-7;
    const struct {
        const char *what;
        const solid *box;
        int m;
    } cases[] = {{"level box", &level_box, 1},
                 {"level box", &level_box, 2},
                 {"level box", &level_box, 3},
                 {"turned box", &turned_box, 1},
                 {"turned box", &turned_box, 2}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        hpr_form_factors *factors = factors_of(ctx, cases[i].box, cases[i].m, tolerance);
        double worst = worst_row(factors);
        print_message("%s, %zu surfaces: %zu of %zu pairs blocked, rows within %.2g of 1\n", cases[i].what,
                      factors->count, factors->done.blocked_count, factors->done.pair_count, worst);
        if (!(worst <= tolerance))
            fail_msg("a row is off by %g, more than %g", worst, tolerance);
        assert_true(5 * factors->done.blocked_count > factors->done.pair_count / 5);
        hpr_form_factors_destroy(&factors);
    }
}

/* Entry by entry against a much tighter tolerance. What is estimated is the error of the lower of two rules;
 * cells in which both miss the same kink err by more: observed at most 2.8 tolerances. */
static void entries_converge_with_the_tolerance(void **state)
{
    hpr_context *ctx = *state;
    static const double tolerances[] = {1e-3, 1e-5, 1e-7}, margin = 6;
    const solid *boxes[] = {&level_box, &turned_box};
    for (int b = 0; b < 2; b++) {
        hpr_form_factors *exact = factors_of(ctx, boxes[b], 1, 1e-10);
        for (int t = 0; t < 3; t++) {
            hpr_form_factors *factors = factors_of(ctx, boxes[b], 1, tolerances[t]);
            double worst = 0;
            for (size_t i = 0; i < exact->count; i++) {
                for (size_t j = 0; j < i; j++) {
                    double value = hpr_form_factors_at(exact, i, j),
                           found = hpr_form_factors_at(factors, i, j);
                    if (value == 0 && found == 0)
                        continue;
                    worst = fmax(worst, fabs(found - value) / value);
                }
            }
            print_message("box %d, tolerance %g: worst entry off by %.2g of itself\n", b, tolerances[t],
                          worst);
            if (!(worst <= margin * tolerances[t]))
                fail_msg("an entry is off by %g at tolerance %g", worst, tolerances[t]);
            hpr_form_factors_destroy(&factors);
        }
        hpr_form_factors_destroy(&exact);
    }
}

/* The cube's faces see each other past the box no better than without it. */
static void a_box_only_takes_away(void **state)
{
    hpr_context *ctx = *state;
    static const double tolerance = 1e-6;
    hpr_form_factors *open = factors_of(ctx, NULL, 2, tolerance),
                     *past = factors_of(ctx, &level_box, 2, tolerance);
    size_t less = 0, none = 0, same = 0;
    for (size_t i = 0; i < open->count; i++) {
        for (size_t j = 0; j < open->count; j++) {
            double whole = hpr_form_factors_at(open, i, j), part = hpr_form_factors_at(past, i, j);
            if (!(part >= 0 && part <= whole * (1 + 2 * tolerance)))
                fail_msg("A F [%zu][%zu] is %.17g past the box, %.17g without it", i, j, part, whole);
            less += part > 0 && part < 0.999 * whole;
            none += part == 0 && whole > 0;
            same += part > 0 && fabs(part - whole) <= 2 * tolerance * whole;
        }
    }
    print_message("of %zu entries %zu are less, %zu nothing, %zu the same\n", open->count * open->count, less,
                  none, same);
    assert_true(less > 1000 && none > 500 && same > 1000);
    hpr_form_factors_destroy(&open);
    hpr_form_factors_destroy(&past);
}

/* Does the segment from x to y pass through the solid? By the slabs between its faces. */
static bool passes_through(const solid *it, const double x[3], const double y[3])
{
    double from = 0, to = 1, volume = 0;
    for (int axis = 0; axis < 3; axis++) {
        double across[3], offset[3], step[3];
        hpr_cross3(it->edge[(axis + 1) % 3], it->edge[(axis + 2) % 3], across);
        volume = hpr_dot3(across, it->edge[axis]);
        hpr_subtract3(x, it->corner, offset);
        hpr_subtract3(y, x, step);
        double start = hpr_dot3(across, offset) / volume, along = hpr_dot3(across, step) / volume;
        if (along == 0 && (start <= 0 || start >= 1))
            return false;
        double a = -start / along, b = (1 - start) / along;
        from = fmax(from, fmin(a, b));
        to = fmin(to, fmax(a, b));
    }
    return to - from > 1e-9;
}

static void cell_point(const solid *it, int n, int index, double u, double v, double point[3],
                       double normal[3])
{
    int axis = index / (2 * n * n), far = index / (n * n) % 2, i = index % n, j = index / n % n;
    const double *a = it->edge[(axis + 1) % 3], *b = it->edge[(axis + 2) % 3];
    for (int k = 0; k < 3; k++)
        point[k] = it->corner[k] + far * it->edge[axis][k] + (i + u) / n * a[k] + (j + v) / n * b[k];
    hpr_cross3(a, b, normal);
    double length = hpr_length3(normal);
    for (int k = 0; k < 3; k++)
        normal[k] *= (far ? -1 : 1) / length;
}

/* Mean and standard error of the kernel between two squares of the cube past the box: independent pairs of
 * points. */
static void estimate(const solid *box, int n, int p, int q, uint64_t *seed, double *mean, double *deviation)
{
    enum { COUNT = 100000 };
    double sum = 0, squares = 0;
    for (int s = 0; s < COUNT; s++) {
        double x[3], y[3], nx[3], ny[3], step[3];
        cell_point(&cube, n, p, shapes_random(seed), shapes_random(seed), x, nx);
        cell_point(&cube, n, q, shapes_random(seed), shapes_random(seed), y, ny);
        hpr_subtract3(y, x, step);
        double r2 = hpr_dot3(step, step), value = 0;
        if (!passes_through(box, x, y))
            value = fmax(hpr_dot3(nx, step), 0) * fmax(-hpr_dot3(ny, step), 0) /
                    (3.14159265358979323846 * r2 * r2);
        sum += value;
        squares += value * value;
    }
    double area = 1.0 / (n * n);
    *mean = area * area * sum / COUNT;
    *deviation = area * area * sqrt((squares - sum * sum / COUNT) / COUNT / (COUNT - 1));
}

/* Blocked entries between the cube's squares against sampling with another visibility test: 60 of them, none
 * by 4.5 standard errors, which happens once in 2500 runs. The seed is fixed. */
static void blocked_entries_agree_with_sampling(void **state)
{
    hpr_context *ctx = *state;
    enum { M = 2, N = 2 * M, WANTED = 30 };
    const solid *boxes[] = {&level_box, &turned_box};
    uint64_t seed = 5;
    for (int b = 0; b < 2; b++) {
        hpr_form_factors *open = factors_of(ctx, NULL, M, 1e-6), *past = factors_of(ctx, boxes[b], M, 1e-6);
        double worst = 0, precision = 0;
        for (int done = 0, tried = 0; done < WANTED; tried++) {
            assert_true(tried < 100000);
            int p = (int)(shapes_random(&seed) * CUBE_FACES * N * N),
                q = (int)(shapes_random(&seed) * CUBE_FACES * N * N);
            double whole = hpr_form_factors_at(open, (size_t)p, (size_t)q);
            double part = hpr_form_factors_at(past, (size_t)p, (size_t)q), mean, deviation;
            if (!(part < 0.9 * whole))
                continue;
            done++;
            estimate(boxes[b], N, p, q, &seed, &mean, &deviation);
            if (part == 0 && mean == 0)
                continue;
            worst = fmax(worst, fabs(part - mean) / deviation);
            precision = fmax(precision, deviation / whole);
            if (!(fabs(part - mean) <= 4.5 * deviation))
                fail_msg("box %d, squares %d, %d: A F %.6g, sampled %.6g +- %.2g", b, p, q, part, mean,
                         deviation);
        }
        print_message("box %d: off by at most %.2g standard errors, each up to %.2g of the unblocked entry\n",
                      b, worst, precision);
        assert_true(precision < 0.01);
        hpr_form_factors_destroy(&open);
        hpr_form_factors_destroy(&past);
    }
}

static int open_context(void **state)
{
    *state = shapes_context(2, NULL);
    return 0;
}

static int close_context(void **state)
{
    hpr_context *ctx = *state;
    hpr_context_destroy(&ctx);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_close),
        cmocka_unit_test(entries_converge_with_the_tolerance),
        cmocka_unit_test(a_box_only_takes_away),
        cmocka_unit_test(blocked_entries_agree_with_sampling),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
