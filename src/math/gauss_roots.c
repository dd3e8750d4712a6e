/* Computes the Gauss rules when hprad is built, and writes them as C: gauss_roots FILE. */
#include "math/gauss.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>

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

static void write_numbers(FILE *file, const char *name, const double *number, int count)
{
    fprintf(file, ".%s = {", name);
    for (int i = 0; i < count; i++)
        fprintf(file, "%s%a", i ? ", " : "", number[i]);
    fprintf(file, "}");
}

static void write_rules(FILE *file, const char *name, double a)
{
    fprintf(file, "    .%s = {\n", name);
    for (int n = 1; n <= HPR_GAUSS_MAX; n++) {
        hpr_gauss_rule rule;
        gauss_jacobi(n, a, &rule);
        fprintf(file, "        [%d] = {", n);
        write_numbers(file, "node", rule.node, n);
        fprintf(file, ", ");
        write_numbers(file, "weight", rule.weight, n);
        fprintf(file, "},\n");
    }
    fprintf(file, "    },\n");
}

int main(int argc, char **argv)
{
    FILE *file = argc == 2 ? fopen(argv[1], "w") : NULL;
    if (!file) {
        fprintf(stderr, "gauss_roots FILE, which must be writable\n");
        return 1;
    }
    fprintf(file, "#include \"math/gauss.h\"\n\nconst hpr_gauss_table hpr_gauss = {\n");
    write_rules(file, "legendre", 0);
    write_rules(file, "jacobi", 1);
    fprintf(file, "};\n");
    bool written = !ferror(file);
    return fclose(file) == 0 && written ? 0 : 1;
}
