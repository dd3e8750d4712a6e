/* The orthonormal polynomials: Gram matrix, order, values. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "basis/basis.h"
#include "math/gauss.h"

#include <string.h>

/* Largest |∫ phi_k phi_l - delta_kl| over the parameter domain. */
static double gram_error(hpr_shape shape, int degree)
{
    static double gram[HPR_MAX_BASIS * HPR_MAX_BASIS];
    double values[HPR_MAX_BASIS], worst = 0;
    size_t count = hpr_basis_count(shape, degree);
    int n = degree + 1;
    const hpr_gauss_rule *in_s = &hpr_gauss.legendre[n];
    const hpr_gauss_rule *in_t = shape == HPR_SHAPE_TRIANGLE ? &hpr_gauss.jacobi[n] : in_s;
    memset(gram, 0, sizeof gram);
    for (int i = 0; i < n * n; i++) {
        double t = in_t->node[i / n], s = in_s->node[i % n] * (shape == HPR_SHAPE_TRIANGLE ? 1 - t : 1);
        double weight = in_s->weight[i % n] * in_t->weight[i / n];
        hpr_basis_eval(shape, degree, s, t, values);
        for (size_t k = 0; k < count; k++) {
            for (size_t l = 0; l < count; l++)
                gram[k * count + l] += weight * values[k] * values[l];
        }
    }
    for (size_t k = 0; k < count; k++) {
        for (size_t l = 0; l < count; l++)
            worst = fmax(worst, fabs(gram[k * count + l] - (k == l)));
    }
    return worst;
}

/* Worst seen: (p+1)^2 eps, at low degree; it grows more slowly. */
static void check_gram(hpr_shape shape, const char *name)
{
    double worst = 0;
    for (int degree = 0; degree <= HPR_MAX_DEGREE; degree++) {
        double error = gram_error(shape, degree);
        double unit = (degree + 1) * (degree + 1) * DBL_EPSILON, bound = 4 * unit;
        worst = fmax(worst, error / unit);
        if (degree % 4 == 0)
            print_message("%s, degree %2d: Gram matrix off by %.1e, bound %.1e\n", name, degree, error,
                          bound);
        if (!(error <= bound))
            fail_msg("%s, degree %d: Gram matrix off by %.2e, bound %.2e", name, degree, error, bound);
    }
    print_message("%s: worst %.2f (p+1)^2 eps\n", name, worst);
}

static void tensor_legendre_is_orthonormal(void **state)
{
    (void)state;
    check_gram(HPR_SHAPE_PARALLELOGRAM, "parallelogram");
}

static void dubiner_is_orthonormal(void **state)
{
    (void)state;
    check_gram(HPR_SHAPE_TRIANGLE, "triangle");
}

/* T_0 = 1/sqrt(A) exactly as far as the scale is: phi_0 is a constant of the reference domain. */
static void first_function_is_the_constant(void **state)
{
    (void)state;
    static const double area[] = {1, 0.3, 17.25, 1e-12, 1e12};
    for (int shape = 0; shape < 2; shape++) {
        for (int i = 0; i < 5; i++) {
            double values[HPR_MAX_BASIS];
            hpr_basis_eval((hpr_shape)shape, HPR_MAX_DEGREE, 0.21 + 0.1 * i, 0.13, values);
            double t0 = hpr_basis_scale((hpr_shape)shape, area[i]) * values[0];
            double off = fabs(t0 * sqrt(area[i]) - 1);
            if (!(off <= 4 * DBL_EPSILON))
                fail_msg("shape %d, area %g: T_0 sqrt(A) - 1 = %.2e", shape, area[i], off);
        }
    }
}

static void counts(void **state)
{
    (void)state;
    for (int p = 0; p <= HPR_MAX_DEGREE; p++) {
        assert_int_equal(hpr_basis_count(HPR_SHAPE_PARALLELOGRAM, p), (p + 1) * (p + 1));
        assert_int_equal(hpr_basis_count(HPR_SHAPE_TRIANGLE, p), (p + 1) * (p + 2) / 2);
    }
    assert_int_equal(hpr_basis_count(HPR_SHAPE_PARALLELOGRAM, HPR_MAX_DEGREE), HPR_MAX_BASIS);
}

static double legendre_shifted(int n, double s)
{
    return sqrt(2.0 * n + 1) * (n == 0 ? 1 : n == 1 ? 2 * s - 1 : 6 * s * s - 6 * s + 1);
}

static void assert_values(const double *got, const double *want, size_t count, const char *what)
{
    for (size_t k = 0; k < count; k++) {
        double bound = 32 * DBL_EPSILON * fmax(1, fabs(want[k]));
        if (!(fabs(got[k] - want[k]) <= bound))
            fail_msg("%s: function %zu is %.17g, expected %.17g", what, k, got[k], want[k]);
    }
}

/* k = (p+1) a + b, a the degree in s. */
static void order_of_the_tensor_basis(void **state)
{
    (void)state;
    double got[9], want[9];
    const double s = 0.3, t = 0.85;
    hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, 2, s, t, got);
    for (int a = 0; a < 3; a++) {
        for (int b = 0; b < 3; b++)
            want[3 * a + b] = legendre_shifted(a, s) * legendre_shifted(b, t);
    }
    assert_values(got, want, 9, "tensor");
}

/* (0,0),(1,0),(0,1),(2,0),(1,1),(0,2),(3,0),(2,1),(1,2),(0,3), written out as polynomials. */
static void order_of_the_dubiner_basis(void **state)
{
    (void)state;
    static const double point[][2] = {{0.25, 0.25}, {0.1, 0.7}, {0.6, 0.15}, {0, 1}, {1, 0}, {0, 0}};
    for (size_t i = 0; i < sizeof point / sizeof *point; i++) {
        double s = point[i][0], t = point[i][1], v = 1 - t, u = 2 * s - v, got[10];
        double p2 = (3 * u * u - v * v) / 2, p3 = (5 * u * u * u - 3 * u * v * v) / 2;
        const double want[10] = {sqrt(2),
                                 sqrt(12) * u,
                                 2 * (3 * t - 1),
                                 sqrt(30) * p2,
                                 sqrt(18) * u * (5 * t - 1),
                                 sqrt(6) * (10 * t * t - 8 * t + 1),
                                 sqrt(56) * p3,
                                 sqrt(40) * p2 * (7 * t - 1),
                                 sqrt(24) * u * (21 * t * t - 12 * t + 1),
                                 sqrt(8) * (35 * t * t * t - 45 * t * t + 15 * t - 1)};
        hpr_basis_eval(HPR_SHAPE_TRIANGLE, 3, s, t, got);
        assert_values(got, want, 10, "Dubiner");
    }
}

/* Degrees nest: by total degree a prefix on triangles, a sub-table on parallelograms. */
static void lower_degrees_are_contained(void **state)
{
    (void)state;
    double high[HPR_MAX_BASIS], low[HPR_MAX_BASIS];
    const double s = 0.37, t = 0.41;
    for (int p = 0; p < HPR_MAX_DEGREE; p++) {
        hpr_basis_eval(HPR_SHAPE_TRIANGLE, HPR_MAX_DEGREE, s, t, high);
        hpr_basis_eval(HPR_SHAPE_TRIANGLE, p, s, t, low);
        assert_memory_equal(low, high, hpr_basis_count(HPR_SHAPE_TRIANGLE, p) * sizeof *low);
        hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, HPR_MAX_DEGREE, s, t, high);
        hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, p, s, t, low);
        for (int a = 0; a <= p; a++)
            assert_memory_equal(low + (p + 1) * a, high + (HPR_MAX_DEGREE + 1) * a,
                                (size_t)(p + 1) * sizeof *low);
    }
}

/* Corners, where each factor is known: P_n(1) = 1, P_n(-1) = (-1)^n, P_j^(a,0)(1) = binomial(j+a, j). */
static void values_at_the_corners(void **state)
{
    (void)state;
    enum { P = HPR_MAX_DEGREE };
    double values[HPR_MAX_BASIS], worst = 0;
    hpr_basis_eval(HPR_SHAPE_PARALLELOGRAM, P, 1, 0, values);
    for (int a = 0; a <= P; a++) {
        for (int b = 0; b <= P; b++) {
            double want = sqrt((2.0 * a + 1) * (2.0 * b + 1)) * (b % 2 ? -1 : 1);
            worst = fmax(worst, fabs(values[(P + 1) * a + b] / want - 1));
        }
    }
    hpr_basis_eval(HPR_SHAPE_TRIANGLE, P, 0, 1, values); /* v2: only i = 0 is left, P_j^(1,0)(1) = j + 1 */
    for (int d = 0; d <= P; d++) {
        for (int j = 0; j < d; j++)
            assert_true(values[d * (d + 1) / 2 + j] == 0);
        double want = sqrt(2.0 * (d + 1)) * (d + 1);
        worst = fmax(worst, fabs(values[d * (d + 1) / 2 + d] / want - 1));
    }
    hpr_basis_eval(HPR_SHAPE_TRIANGLE, P, 1, 0, values); /* v1: P_i(1) = 1, P_j^(2i+1,0)(-1) = (-1)^j */
    for (int d = 0; d <= P; d++) {
        for (int j = 0; j <= d; j++) {
            double want = sqrt(2.0 * (2 * (d - j) + 1) * (d + 1)) * (j % 2 ? -1 : 1);
            worst = fmax(worst, fabs(values[d * (d + 1) / 2 + j] / want - 1));
        }
    }
    /* The three-term recurrences amplify rounding by at most their number of steps, squared. */
    double bound = (P + 1) * (P + 1) * DBL_EPSILON;
    print_message("corner values to degree %d: relative error %.1e, bound %.1e\n", P, worst, bound);
    assert_true(worst <= bound);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tensor_legendre_is_orthonormal), cmocka_unit_test(dubiner_is_orthonormal),
        cmocka_unit_test(first_function_is_the_constant), cmocka_unit_test(counts),
        cmocka_unit_test(order_of_the_tensor_basis),      cmocka_unit_test(order_of_the_dubiner_basis),
        cmocka_unit_test(lower_degrees_are_contained),    cmocka_unit_test(values_at_the_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
