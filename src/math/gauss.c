#include "math/gauss.h"

#include <float.h>
#include <math.h>

/* P_n^(a,0) and its derivative at x in (-1,1). */
static void jacobi_polynomial(int n, double a, double x, double *value, double *derivative)
{
    double before = 1, p = (a + (a + 2) * x) / 2;
    if (n == 0) {
        *value = 1;
        *derivative = 0;
        return;
    }
    for (int k = 1; k < n; k++) {
        double c = 2 * k + a;
        double a1 = 2 * (k + 1) * (k + a + 1) * c;
        double a2 = (c + 1) * a * a;
        double a3 = c * (c + 1) * (c + 2);
        double a4 = 2 * (k + a) * k * (c + 2);
        double next = ((a2 + a3 * x) * p - a4 * before) / a1;
        before = p;
        p = next;
    }
    double c = 2 * n + a;
    *value = p;
    *derivative = (n * (a - c * x) * p + 2 * (n + a) * n * before) / (c * (1 - x * x));
}

/* Roots in falling order by Newton from Chebyshev points, deflated by the roots already found. */
static void gauss_jacobi(int n, double a, hpr_gauss_rule *rule)
{
    double root[HPR_GAUSS_MAX];
    for (int i = 0; i < n; i++) {
        double x = cos(3.14159265358979323846 * (2 * i + 1) / (2 * n));
        if (i > 0)
            x = (x + root[i - 1]) / 2;
        for (int step = 0; step < 100; step++) {
            double value, derivative, deflation = 0;
            jacobi_polynomial(n, a, x, &value, &derivative);
            for (int j = 0; j < i; j++)
                deflation += 1 / (x - root[j]);
            double change = value / (derivative - value * deflation);
            x -= change;
            if (fabs(change) <= DBL_EPSILON)
                break;
        }
        root[i] = x;
    }
    for (int i = 0; i < n; i++) {
        double x = root[n - 1 - i], value, derivative;
        jacobi_polynomial(n, a, x, &value, &derivative);
        rule->node[i] = (1 + x) / 2;
        /* On [-1,1] the weight is 2^(a+1) / ((1-x^2) P'^2); the map to [0,1] takes the power of two away. */
        rule->weight[i] = 1 / ((1 - x * x) * derivative * derivative);
    }
}

void hpr_gauss_table_init(hpr_gauss_table *table)
{
    for (int n = 1; n <= HPR_GAUSS_MAX; n++) {
        gauss_jacobi(n, 0, &table->legendre[n]);
        gauss_jacobi(n, 1, &table->jacobi[n]);
    }
}
