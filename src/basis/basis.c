#include "basis/basis.h"

#include <math.h>

size_t hpr_basis_count(hpr_shape shape, int degree)
{
    size_t n = (size_t)degree + 1;
    return shape == HPR_SHAPE_PARALLELOGRAM ? n * n : n * (n + 1) / 2;
}

double hpr_basis_scale(hpr_shape shape, double area_m2)
{
    return 1 / sqrt(shape == HPR_SHAPE_PARALLELOGRAM ? area_m2 : 2 * area_m2);
}

/* sqrt(2n+1) P_n(2s-1) for n = 0 .. degree */
static void legendre(int degree, double s, double *values)
{
    double x = 2 * s - 1, before = 0, p = 1;
    for (int n = 0; n <= degree; n++) {
        values[n] = sqrt(2.0 * n + 1) * p;
        double next = ((2 * n + 1) * x * p - n * before) / (n + 1);
        before = p;
        p = next;
    }
}

static void tensor(int degree, double s, double t, double *values)
{
    double in_s[HPR_MAX_DEGREE + 1], in_t[HPR_MAX_DEGREE + 1];
    legendre(degree, s, in_s);
    legendre(degree, t, in_t);
    for (int a = 0; a <= degree; a++) {
        for (int b = 0; b <= degree; b++)
            *values++ = in_s[a] * in_t[b];
    }
}

static void dubiner(int degree, double s, double t, double *values)
{
    double x = 2 * t - 1, u = 2 * s + t - 1, v = 1 - t;
    double row_before = 0, row = 1; /* P_i(2s/(1-t)-1) (1-t)^i */
    for (int i = 0; i <= degree; i++) {
        double alpha = 2 * i + 1, before = 0, p = 1; /* P_j^(alpha,0)(x) */
        for (int j = 0; i + j <= degree; j++) {
            int d = i + j;
            values[d * (d + 1) / 2 + j] = sqrt(2.0 * (2 * i + 1) * (d + 1)) * row * p;
            double c = 2 * j + alpha, next;
            if (j == 0)
                next = (alpha + (alpha + 2) * x) / 2;
            else
                next = ((c + 1) * (alpha * alpha + c * (c + 2) * x) * p -
                        2 * (j + alpha) * j * (c + 2) * before) /
                       (2 * (j + 1) * (j + alpha + 1) * c);
            before = p;
            p = next;
        }
        double next = ((2 * i + 1) * u * row - i * v * v * row_before) / (i + 1);
        row_before = row;
        row = next;
    }
}

void hpr_basis_eval(hpr_shape shape, int degree, double s, double t, double *values)
{
    if (shape == HPR_SHAPE_PARALLELOGRAM)
        tensor(degree, s, t, values);
    else
        dubiner(degree, s, t, values);
}
