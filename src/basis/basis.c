#include "basis/basis.h"

#include "math/lanes.h"

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

const double hpr_legendre_norm[HPR_MAX_DEGREE + 1] = {
    1,
    1.7320508075688772,
    2.2360679774997898,
    2.6457513110645907,
    3,
    3.3166247903553998,
    3.6055512754639891,
    3.872983346207417,
    4.1231056256176606,
    4.358898943540674,
    4.5825756949558398,
    4.7958315233127191,
    5,
    5.196152422706632,
    5.3851648071345037,
    5.5677643628300215,
    5.7445626465380286,
};
const double hpr_legendre_raise[HPR_MAX_DEGREE + 1] = {
    1,
    1.5,
    1.6666666666666667,
    1.75,
    1.8,
    1.8333333333333333,
    1.8571428571428572,
    1.875,
    1.8888888888888888,
    1.8999999999999999,
    1.9090909090909092,
    1.9166666666666667,
    1.9230769230769231,
    1.9285714285714286,
    1.9333333333333333,
    1.9375,
    1.9411764705882353,
};
const double hpr_legendre_lower[HPR_MAX_DEGREE + 1] = {
    0,
    0.5,
    0.66666666666666663,
    0.75,
    0.80000000000000004,
    0.83333333333333337,
    0.8571428571428571,
    0.875,
    0.88888888888888884,
    0.90000000000000002,
    0.90909090909090906,
    0.91666666666666663,
    0.92307692307692313,
    0.9285714285714286,
    0.93333333333333335,
    0.9375,
    0.94117647058823528,
};

/* sqrt(2n+1) P_n(2s-1) for n = 0 .. degree */
static void legendre(int degree, double s, double *values)
{
    double x = 2 * s - 1, before = 0, p = 1;
    for (int n = 0; n <= degree; n++) {
        values[n] = hpr_legendre_norm[n] * p;
        double next = hpr_legendre_raise[n] * x * p - hpr_legendre_lower[n] * before;
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

/* sqrt(2n+2), and 1/n (0 for n = 0). */
static const double root[HPR_MAX_DEGREE + 1] = {
    1.4142135623730951, 2,
    2.4494897427831779, 2.8284271247461903,
    3.1622776601683795, 3.4641016151377544,
    3.7416573867739413, 4,
    4.2426406871192848, 4.4721359549995796,
    4.6904157598234297, 4.8989794855663558,
    5.0990195135927845, 5.2915026221291814,
    5.4772255750516612, 5.6568542494923806,
    5.8309518948453007,
};
static const double inverse[3 * HPR_MAX_DEGREE + 3] = {
    0,
    1,
    0.5,
    0.33333333333333331,
    0.25,
    0.20000000000000001,
    0.16666666666666666,
    0.14285714285714285,
    0.125,
    0.1111111111111111,
    0.10000000000000001,
    0.090909090909090912,
    0.083333333333333329,
    0.076923076923076927,
    0.071428571428571425,
    0.066666666666666666,
    0.0625,
    0.058823529411764705,
    0.055555555555555552,
    0.052631578947368418,
    0.050000000000000003,
    0.047619047619047616,
    0.045454545454545456,
    0.043478260869565216,
    0.041666666666666664,
    0.040000000000000001,
    0.038461538461538464,
    0.037037037037037035,
    0.035714285714285712,
    0.034482758620689655,
    0.033333333333333333,
    0.032258064516129031,
    0.03125,
    0.030303030303030304,
    0.029411764705882353,
    0.028571428571428571,
    0.027777777777777776,
    0.027027027027027029,
    0.026315789473684209,
    0.02564102564102564,
    0.025000000000000001,
    0.024390243902439025,
    0.023809523809523808,
    0.023255813953488372,
    0.022727272727272728,
    0.022222222222222223,
    0.021739130434782608,
    0.021276595744680851,
    0.020833333333333332,
    0.020408163265306121,
    0.02,
};

static void dubiner(int degree, double s, double t, double *values)
{
    double x = 2 * t - 1, u = 2 * s + t - 1, v = 1 - t;
    double row_before = 0, row = 1; /* P_i(2s/(1-t)-1) (1-t)^i */
    for (int i = 0; i <= degree; i++) {
        double alpha = 2 * i + 1, before = 0, p = 1; /* P_j^(alpha,0)(x) */
        for (int j = 0; i + j <= degree; j++) {
            int d = i + j;
            values[d * (d + 1) / 2 + j] = hpr_legendre_norm[i] * root[d] * row * p;
            double c = 2 * j + alpha, next;
            if (j == 0)
                next = (alpha + (alpha + 2) * x) / 2;
            else
                next = ((c + 1) * (alpha * alpha + c * (c + 2) * x) * p -
                        2 * (j + alpha) * j * (c + 2) * before) *
                       (0.5 * inverse[j + 1] * inverse[j + 2 * i + 2] * inverse[2 * j + 2 * i + 1]);
            before = p;
            p = next;
        }
        double next = hpr_legendre_raise[i] * u * row - hpr_legendre_lower[i] * v * v * row_before;
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

/* sqrt(2n+1) P_n(2s-1) into rows `step` apart. */
HPR_LANES_BODY void legendre_many(int degree, size_t count, const double *restrict s, double *restrict before,
                                  double *restrict now, size_t step, double *values)
{
    for (size_t k = 0; k < count; k++) {
        before[k] = 0;
        now[k] = 1;
    }
    for (int n = 0; n <= degree; n++) {
        double *restrict row = values + (size_t)n * step;
        for (size_t k = 0; k < count; k++) {
            row[k] = hpr_legendre_norm[n] * now[k];
            double next = hpr_legendre_raise[n] * (2 * s[k] - 1) * now[k] - hpr_legendre_lower[n] * before[k];
            before[k] = now[k];
            now[k] = next;
        }
    }
}

HPR_LANES_BODY void tensor_many(int degree, size_t count, const double *s, const double *t, size_t stride,
                                double *values, double *scratch)
{
    size_t n = (size_t)degree + 1;
    /* in s at k = n a, in t at k = b; a = 0 is 1 and stays to the last */
    legendre_many(degree, count, s, scratch, scratch + stride, n * stride, values);
    legendre_many(degree, count, t, scratch, scratch + stride, stride, values);
    for (size_t a = 1; a < n; a++) {
        const double *in_s = values + n * a * stride;
        for (size_t b = 1; b < n; b++) {
            const double *in_t = values + b * stride;
            double *restrict product = values + (n * a + b) * stride;
            for (size_t k = 0; k < count; k++)
                product[k] = in_s[k] * in_t[k];
        }
    }
}

HPR_LANES_BODY void dubiner_many(int degree, size_t count, const double *s, const double *t, size_t stride,
                                 double *values, double *scratch)
{
    double *row_before = scratch, *row = scratch + stride, *before = scratch + 2 * stride,
           *now = scratch + 3 * stride;
    for (size_t k = 0; k < count; k++) {
        row_before[k] = 0;
        row[k] = 1;
    }
    for (int i = 0; i <= degree; i++) {
        for (size_t k = 0; k < count; k++) {
            before[k] = 0;
            now[k] = row[k];
        }
        for (int j = 0; i + j <= degree; j++) {
            int d = i + j;
            double alpha = 2 * i + 1, c = 2 * j + alpha;
            double below = 0.5 * inverse[j + 1] * inverse[j + 2 * i + 2] * inverse[2 * j + 2 * i + 1];
            double rise = (c + 1) * c * (c + 2) * below, shift = (c + 1) * alpha * alpha * below;
            double fall = 2 * (j + alpha) * j * (c + 2) * below, factor = hpr_legendre_norm[i] * root[d];
            double *restrict out = values + (size_t)(d * (d + 1) / 2 + j) * stride;
            for (size_t k = 0; k < count; k++) {
                out[k] = factor * now[k];
                double next = (rise * (2 * t[k] - 1) + shift) * now[k] - fall * before[k];
                before[k] = now[k];
                now[k] = next;
            }
        }
        for (size_t k = 0; k < count; k++) {
            double v = 1 - t[k];
            double next = hpr_legendre_raise[i] * (2 * s[k] + t[k] - 1) * row[k] -
                          hpr_legendre_lower[i] * v * v * row_before[k];
            row_before[k] = row[k];
            row[k] = next;
        }
    }
}

HPR_LANES_BODY void many_body(hpr_shape shape, int degree, size_t count, const double *s, const double *t,
                              size_t stride, double *values, double *scratch)
{
    if (shape == HPR_SHAPE_PARALLELOGRAM)
        tensor_many(degree, count, s, t, stride, values, scratch);
    else
        dubiner_many(degree, count, s, t, stride, values, scratch);
}

HPR_TARGET_AVX2 static void many_avx2(hpr_shape shape, int degree, size_t count, const double *s,
                                      const double *t, size_t stride, double *values, double *scratch)
{
    many_body(shape, degree, count, s, t, stride, values, scratch);
}

HPR_TARGET_AVX512 static void many_avx512(hpr_shape shape, int degree, size_t count, const double *s,
                                          const double *t, size_t stride, double *values, double *scratch)
{
    many_body(shape, degree, count, s, t, stride, values, scratch);
}

void hpr_basis_many(hpr_isa isa, hpr_shape shape, int degree, size_t count, const double *s, const double *t,
                    size_t stride, double *values, double *scratch)
{
    if (isa == HPR_ISA_AVX512)
        many_avx512(shape, degree, count, s, t, stride, values, scratch);
    else if (isa == HPR_ISA_AVX2)
        many_avx2(shape, degree, count, s, t, stride, values, scratch);
    else
        many_body(shape, degree, count, s, t, stride, values, scratch);
}
