/* Pushing is exact on polynomials, pulling is its transpose, and the halves together are the whole. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "basis/two_scale.h"
#include "lcg.h"

#include <float.h>
#include <hprad/context.h>
#include <string.h>

/* The point of the whole that (s,t) of a half is, as patch/elements.h says. */
static void whole_point(const hpr_half *half, double s, double t, double *ws, double *wt)
{
    if (half->shape == HPR_SHAPE_TRIANGLE) {
        *ws = half->which ? (1 - s - t) / 2 : (1 - s + t) / 2;
        *wt = half->which ? (1 + s - t) / 2 : (1 - s - t) / 2;
        return;
    }
    *ws = half->axis == 0 ? (s + half->which) / 2 : s;
    *wt = half->axis == 1 ? (t + half->which) / 2 : t;
}

static double value_at(hpr_shape shape, int degree, double area, const double *c, double s, double t)
{
    double phi[HPR_MAX_BASIS], sum = 0;
    hpr_basis_eval(shape, degree, s, t, phi);
    for (size_t k = 0; k < hpr_basis_count(shape, degree); k++)
        sum += c[k] * phi[k];
    return sum * hpr_basis_scale(shape, area);
}

typedef void check_half(const hpr_two_scale *tables, const hpr_half *half, uint64_t *state);

/* For both shapes, all halves and some pairs of degrees. */
static void for_all(check_half *check)
{
    static const int degrees[][2] = {{0, 0}, {1, 1}, {3, 3}, {8, 8}, {16, 16},
                                     {2, 5}, {5, 2}, {0, 3}, {7, 0}};
    hpr_context *context;
    hpr_two_scale *tables;
    uint64_t state = 1;
    assert_int_equal(hpr_context_create(NULL, &context), HPR_OK);
    assert_int_equal(hpr_two_scale_create(context, HPR_MAX_DEGREE, &tables), HPR_OK);
    for (int shape = 0; shape < 2; shape++) {
        for (size_t d = 0; d < sizeof degrees / sizeof *degrees; d++) {
            for (int i = 0; i < (shape == HPR_SHAPE_TRIANGLE ? 2 : 4); i++) {
                hpr_half half = {(hpr_shape)shape, i / 2, i % 2, degrees[d][0], degrees[d][1]};
                check(tables, &half, &state);
            }
        }
    }
    hpr_two_scale_destroy(&tables);
    hpr_context_destroy(&context);
}

/* Rounding of sums of (p+1)^2 terms of basis values up to (p+1)^2. */
static double bound_of(const hpr_half *half)
{
    int p = half->whole_degree > half->half_degree ? half->whole_degree : half->half_degree;
    return 8.0 * (p + 1) * (p + 1) * (p + 1) * (p + 1) * DBL_EPSILON;
}

static void pushed_is_same_polynomial(const hpr_two_scale *tables, const hpr_half *half, uint64_t *state)
{
    double whole[HPR_MAX_BASIS], part[HPR_MAX_BASIS] = {0}, area = 3;
    if (half->half_degree < half->whole_degree)
        return; /* the half cannot hold it */
    for (size_t k = 0; k < hpr_basis_count(half->shape, half->whole_degree); k++)
        whole[k] = random_unit(state) - 0.5;
    hpr_two_scale_push(tables, half, whole, part);
    for (int i = 0; i < 10; i++) {
        double s = random_unit(state),
               t = random_unit(state) * (half->shape == HPR_SHAPE_TRIANGLE ? 1 - s : 1);
        double ws, wt;
        whole_point(half, s, t, &ws, &wt);
        double a = value_at(half->shape, half->whole_degree, area, whole, ws, wt);
        double b = value_at(half->shape, half->half_degree, area / 2, part, s, t);
        if (!(fabs(a - b) <= bound_of(half)))
            fail_msg("shape %d axis %d half %d, degrees %d %d: %.17g pushed is %.17g, bound %.1e",
                     half->shape, half->axis, half->which, half->whole_degree, half->half_degree, a, b,
                     bound_of(half));
    }
}

static void pull_is_transpose(const hpr_two_scale *tables, const hpr_half *half, uint64_t *state)
{
    size_t n = hpr_basis_count(half->shape, half->whole_degree),
           m = hpr_basis_count(half->shape, half->half_degree);
    double whole[HPR_MAX_BASIS], part[HPR_MAX_BASIS], pushed[HPR_MAX_BASIS] = {0},
                                                      pulled[HPR_MAX_BASIS] = {0};
    double a = 0, b = 0;
    for (size_t k = 0; k < n; k++)
        whole[k] = random_unit(state) - 0.5;
    for (size_t l = 0; l < m; l++)
        part[l] = random_unit(state) - 0.5;
    hpr_two_scale_push(tables, half, whole, pushed);
    hpr_two_scale_pull(tables, half, part, pulled);
    for (size_t k = 0; k < n; k++)
        a += whole[k] * pulled[k];
    for (size_t l = 0; l < m; l++)
        b += part[l] * pushed[l];
    if (!(fabs(a - b) <= bound_of(half)))
        fail_msg("shape %d, degrees %d %d: (w, Mh) = %.17g, (MTw, h) = %.17g", half->shape,
                 half->whole_degree, half->half_degree, a, b);
}

static void halves_are_the_whole(const hpr_two_scale *tables, const hpr_half *half, uint64_t *state)
{
    size_t n = hpr_basis_count(half->shape, half->whole_degree);
    double whole[HPR_MAX_BASIS], again[HPR_MAX_BASIS] = {0};
    if (half->which || half->half_degree < half->whole_degree)
        return;
    for (size_t k = 0; k < n; k++)
        whole[k] = random_unit(state) - 0.5;
    for (int which = 0; which < 2; which++) {
        hpr_half each = *half;
        double part[HPR_MAX_BASIS] = {0};
        each.which = which;
        hpr_two_scale_push(tables, &each, whole, part);
        hpr_two_scale_pull(tables, &each, part, again);
    }
    for (size_t k = 0; k < n; k++) {
        if (!(fabs(whole[k] - again[k]) <= bound_of(half)))
            fail_msg("shape %d, degrees %d %d, function %zu: %.17g comes back as %.17g", half->shape,
                     half->whole_degree, half->half_degree, k, whole[k], again[k]);
    }
}

static void test_push(void **state)
{
    (void)state;
    for_all(pushed_is_same_polynomial);
}

static void test_pull(void **state)
{
    (void)state;
    for_all(pull_is_transpose);
}

static void test_whole(void **state)
{
    (void)state;
    for_all(halves_are_the_whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_push),
        cmocka_unit_test(test_pull),
        cmocka_unit_test(test_whole),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
