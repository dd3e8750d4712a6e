/* Gauss rules on [0,1]: the identities that define them. */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "math/gauss.h"

/* int_0^1 x^m dx or int_0^1 x^m (1-x) dx */
static double moment(int jacobi, int m)
{
    return jacobi ? 1 / ((m + 1.0) * (m + 2.0)) : 1 / (m + 1.0);
}

static double sum_of_powers(const hpr_gauss_rule *rule, int n, int m)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += rule->weight[i] * pow(rule->node[i], m);
    return sum;
}

/* Relative: a node's error of 4 ulp of 1 changes x^m near x = 1 by 4 m eps, and m <= 2n - 1. */
static void check_exactness(int jacobi)
{
    double worst = 0;
    for (int n = 1; n <= HPR_GAUSS_MAX; n++) {
        const hpr_gauss_rule *rule = jacobi ? &hpr_gauss.jacobi[n] : &hpr_gauss.legendre[n];
        for (int m = 0; m <= 2 * n - 1; m++) {
            double error = fabs(sum_of_powers(rule, n, m) / moment(jacobi, m) - 1);
            double bound = 4 * (m + 2) * DBL_EPSILON * 2;
            worst = fmax(worst, error / bound);
            if (!(error <= bound))
                fail_msg("%d nodes, x^%d: off by %.2e, bound %.2e", n, m, error, bound);
        }
    }
    print_message("%s rules: worst error %.2f of its bound\n", jacobi ? "Jacobi" : "Legendre", worst);
}

static void legendre_is_exact_to_degree_2n_minus_1(void **state)
{
    (void)state;
    check_exactness(0);
}

static void jacobi_is_exact_to_degree_2n_minus_1(void **state)
{
    (void)state;
    check_exactness(1);
}

/*
 * What the rule misses of x^2n is the integral of w (x-x_1)^2 ... (x-x_n)^2 > 0, for w = (1-x)^a:
 *   (n! (n+a)! / (2n+a)!)^2 / (2n+a+1).
 * It falls like 16^-n, so it can be told from rounding up to 10 nodes.
 */
static double monic_square(int jacobi, int n)
{
    double a = jacobi;
    double ratio = 1; /* n! (n+a)! / (2n+a)! */
    for (int i = 1; i <= n; i++)
        ratio *= i / (n + a + i);
    return ratio * ratio / (2 * n + a + 1);
}

static void degree_2n_fails(void **state)
{
    (void)state;
    for (int jacobi = 0; jacobi < 2; jacobi++) {
        for (int n = 1; n <= 10; n++) {
            const hpr_gauss_rule *rule = jacobi ? &hpr_gauss.jacobi[n] : &hpr_gauss.legendre[n];
            double missed = moment(jacobi, 2 * n) - sum_of_powers(rule, n, 2 * n);
            double expected = monic_square(jacobi, n), bound = 16 * n * DBL_EPSILON * moment(jacobi, 2 * n);
            if (n % 3 == 1)
                print_message("%s, %2d nodes: x^%d misses %.6e, theory %.6e\n",
                              jacobi ? "Jacobi" : "Legendre", n, 2 * n, missed, expected);
            if (!(fabs(missed - expected) <= bound))
                fail_msg("%d nodes: misses %.6e instead of %.6e", n, missed, expected);
        }
    }
}

static void weights_are_positive_and_nodes_rise_inside(void **state)
{
    (void)state;
    for (int jacobi = 0; jacobi < 2; jacobi++) {
        for (int n = 1; n <= HPR_GAUSS_MAX; n++) {
            const hpr_gauss_rule *rule = jacobi ? &hpr_gauss.jacobi[n] : &hpr_gauss.legendre[n];
            for (int i = 0; i < n; i++) {
                double before = i ? rule->node[i - 1] : 0;
                if (!(rule->weight[i] > 0 && rule->node[i] > before && rule->node[i] < 1))
                    fail_msg("%d nodes: node %d at %.17g, weight %.17g", n, i, rule->node[i],
                             rule->weight[i]);
            }
        }
    }
}

/* Nodes and weights in closed form. */
static void small_rules_are_the_known_ones(void **state)
{
    (void)state;
    const struct {
        double got, want;
    } facts[] = {
        {hpr_gauss.legendre[1].node[0], 0.5},
        {hpr_gauss.legendre[1].weight[0], 1},
        {hpr_gauss.legendre[2].node[0], 0.5 - 0.5 / sqrt(3)},
        {hpr_gauss.legendre[2].weight[1], 0.5},
        {hpr_gauss.legendre[3].node[2], 0.5 + 0.5 * sqrt(0.6)},
        {hpr_gauss.legendre[3].weight[0], 5.0 / 18},
        {hpr_gauss.legendre[3].weight[1], 4.0 / 9},
        {hpr_gauss.jacobi[1].node[0], 1.0 / 3},
        {hpr_gauss.jacobi[1].weight[0], 0.5},
        {hpr_gauss.jacobi[2].node[0], (4 - sqrt(6)) / 10},
        {hpr_gauss.jacobi[2].node[1], (4 + sqrt(6)) / 10},
        {hpr_gauss.jacobi[2].weight[0], (9 + sqrt(6)) / 36},
    };
    for (size_t i = 0; i < sizeof facts / sizeof *facts; i++) {
        if (!(fabs(facts[i].got - facts[i].want) <= 4 * DBL_EPSILON))
            fail_msg("fact %zu: %.17g instead of %.17g", i, facts[i].got, facts[i].want);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(legendre_is_exact_to_degree_2n_minus_1),
        cmocka_unit_test(jacobi_is_exact_to_degree_2n_minus_1),
        cmocka_unit_test(degree_2n_fails),
        cmocka_unit_test(weights_are_positive_and_nodes_rise_inside),
        cmocka_unit_test(small_rules_are_the_known_ones),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
