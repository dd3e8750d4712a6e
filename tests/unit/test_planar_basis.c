/* Polynomials over quadrilaterals: orthonormal, complete, the same by either evaluation, nested in degree. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "math/planar_basis.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 16, FUNCTIONS = (MOST + 1) * (MOST + 2) / 2 };

/* A square, trapezoids, nearly triangles, slender kites along and across the diagonal, far from parallel. */
static const double shapes[][2] = {{1, 1},      {0.5, 1}, {1, 1.0001}, {0.1, 1},   {0.05, 1.3},
                                   {0.51, 0.5}, {20, 20}, {49, 1},     {1.7, 0.4}, {3, 0.02}};
enum { SHAPES = sizeof shapes / sizeof *shapes };

typedef struct basis {
    const double *opposite;
    int degree;
    double *recurrence;
} basis;

static basis make(const double opposite[2], int degree)
{
    basis b = {opposite, degree, malloc(hpr_planar_size(degree) * sizeof(double))};
    double *scratch = malloc(hpr_planar_scratch(degree) * sizeof(double));
    assert_non_null(b.recurrence);
    assert_non_null(scratch);
    hpr_planar_make(opposite, degree, &hpr_gauss.legendre[degree + 1], b.recurrence, scratch);
    free(scratch);
    return b;
}

static int count_of(int degree)
{
    return (degree + 1) * (degree + 2) / 2;
}

/* ∫ phi_k phi_l over the two triangles beside the diagonal from the origin, by a rule other than that which
 * made the basis. */
static void gram_of(const basis *b, double *gram)
{
    const double corner[4][2] = {{0, 0}, {1, 0}, {b->opposite[0], b->opposite[1]}, {0, 1}};
    int n = count_of(b->degree), nodes = b->degree + 3;
    double values[FUNCTIONS];
    memset(gram, 0, (size_t)(n * n) * sizeof *gram);
    for (int half = 0; half < 2; half++) {
        const double *p = corner[1 + half], *q = corner[2 + half];
        double area = fabs(p[0] * q[1] - p[1] * q[0]);
        for (int i = 0; i < nodes * nodes; i++) {
            double v = hpr_gauss.jacobi[nodes].node[i / nodes],
                   u = hpr_gauss.legendre[nodes].node[i % nodes] * (1 - v);
            double weight = area * hpr_gauss.jacobi[nodes].weight[i / nodes] *
                            hpr_gauss.legendre[nodes].weight[i % nodes];
            hpr_planar_eval(b->recurrence, b->degree, u * p[0] + v * q[0], u * p[1] + v * q[1], values);
            for (int k = 0; k < n; k++) {
                for (int l = 0; l < n; l++)
                    gram[k * n + l] += weight * values[k] * values[l];
            }
        }
    }
}

static void test_orthonormal(void **state)
{
    (void)state;
    static const int degrees[] = {0, 1, 2, 5, 8, MOST};
    static double gram[FUNCTIONS * FUNCTIONS];
    for (size_t i = 0; i < SHAPES; i++) {
        for (size_t d = 0; d < sizeof degrees / sizeof *degrees; d++) {
            basis b = make(shapes[i], degrees[d]);
            int n = count_of(b.degree);
            double worst = 0;
            gram_of(&b, gram);
            for (int k = 0; k < n * n; k++)
                worst = fmax(worst, fabs(gram[k] - (k % (n + 1) == 0)));
            /* worst seen: 11 (p + 1)^2 eps, at degree 16; 3 up to degree 8 */
            double bound = 64 * (b.degree + 1) * (b.degree + 1) * DBL_EPSILON;
            if (!(worst <= bound))
                fail_msg("opposite corner (%g, %g), degree %d: off the unit matrix by %.2e, bound %.2e",
                         shapes[i][0], shapes[i][1], b.degree, worst, bound);
            free(b.recurrence);
        }
    }
}

/* s^a t^(p-a), shifted and scaled to be of order 1, is in the span: its projection is itself. */
static void test_complete(void **state)
{
    (void)state;
    static const int degrees[] = {1, 2, 5, 9, MOST};
    for (size_t i = 0; i < SHAPES; i++) {
        for (size_t d = 0; d < sizeof degrees / sizeof *degrees; d++) {
            basis b = make(shapes[i], degrees[d]);
            int n = count_of(b.degree), nodes = b.degree + 1;
            double size[2] = {fmax(1, shapes[i][0]), fmax(1, shapes[i][1])}, values[FUNCTIONS];
            for (int a = 0; a <= b.degree; a++) {
                double c[FUNCTIONS] = {0}, worst = 0;
                for (int k = 0; k < nodes * nodes; k++) {
                    hpr_planar_node x = hpr_planar_gauss(b.opposite, &hpr_gauss.legendre[nodes], nodes, k);
                    double f = pow(x.s / size[0], a) * pow(x.t / size[1], b.degree - a);
                    hpr_planar_eval(b.recurrence, b.degree, x.s, x.t, values);
                    for (int l = 0; l < n; l++)
                        c[l] += x.weight * f * values[l];
                }
                for (int k = 0; k < nodes * nodes; k++) {
                    hpr_planar_node x = hpr_planar_gauss(b.opposite, &hpr_gauss.legendre[nodes], nodes, k);
                    double f = pow(x.s / size[0], a) * pow(x.t / size[1], b.degree - a);
                    hpr_planar_eval(b.recurrence, b.degree, x.s, x.t, values);
                    for (int l = 0; l < n; l++)
                        f -= c[l] * values[l];
                    worst = fmax(worst, fabs(f));
                }
                /* values at corners are of the order (p + 1)^2 */
                double bound = 64 * pow(b.degree + 1, 2) * DBL_EPSILON;
                if (!(worst <= bound))
                    fail_msg("opposite corner (%g, %g): s^%d t^%d comes back off by %.2e, bound %.2e",
                             shapes[i][0], shapes[i][1], a, b.degree - a, worst, bound);
            }
            free(b.recurrence);
        }
    }
}

static void test_many_and_nested(void **state)
{
    (void)state;
    enum { POINTS = 5, LOWER = 4, STRIDE = 7 };
    for (size_t i = 0; i < SHAPES; i++) {
        basis b = make(shapes[i], MOST);
        double s[POINTS], t[POINTS], many[FUNCTIONS * STRIDE], one[FUNCTIONS], lower[FUNCTIONS];
        for (int p = 0; p < POINTS; p++) {
            hpr_planar_node x =
                hpr_planar_gauss(b.opposite, &hpr_gauss.legendre[POINTS], POINTS, p * POINTS + p);
            s[p] = x.s;
            t[p] = x.t;
        }
        hpr_planar_many(HPR_ISA_SSE2, b.recurrence, MOST, POINTS, s, t, STRIDE, many);
        for (int p = 0; p < POINTS; p++) {
            hpr_planar_eval(b.recurrence, MOST, s[p], t[p], one);
            hpr_planar_eval(b.recurrence, LOWER, s[p], t[p], lower);
            assert_memory_equal(one, lower, count_of(LOWER) * sizeof *one);
            for (int k = 0; k < FUNCTIONS; k++) {
                double bound = 64 * (MOST + 1) * (MOST + 1) * DBL_EPSILON;
                if (!(fabs(many[k * STRIDE + p] - one[k]) <= bound))
                    fail_msg("function %d: %.17g at many points, %.17g at one", k, many[k * STRIDE + p],
                             one[k]);
            }
        }
        free(b.recurrence);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_orthonormal),
        cmocka_unit_test(test_complete),
        cmocka_unit_test(test_many_and_nested),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
