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

void hpr_basis_table_init(hpr_basis_table *table)
{
    for (int i = 0; i <= HPR_MAX_DEGREE; i++) {
        table->norm[i] = sqrt(2.0 * i + 1);
        table->rise[i] = (2.0 * i + 1) / (i + 1);
        table->fall[i] = i / (i + 1.0);
        double alpha = 2 * i + 1;
        for (int j = 0; i + j <= HPR_MAX_DEGREE; j++) {
            double c = 2 * j + alpha, below = 2 * (j + 1) * (j + alpha + 1) * c;
            table->dubiner[i][j].norm = sqrt(2.0 * (2 * i + 1) * (i + j + 1));
            table->dubiner[i][j].rise = (c + 1) * c * (c + 2) / below;
            table->dubiner[i][j].shift = (c + 1) * alpha * alpha / below;
            table->dubiner[i][j].fall = 2 * (j + alpha) * j * (c + 2) / below;
        }
    }
}

/* sqrt(2n+1) P_n(2s-1) into rows `step` apart. */
static void legendre_many(const hpr_basis_table *table, int degree, size_t count, const double *restrict s,
                          double *restrict before, double *restrict now, size_t step, double *values)
{
    for (size_t k = 0; k < count; k++) {
        before[k] = 0;
        now[k] = 1;
    }
    for (int n = 0; n <= degree; n++) {
        double *restrict row = values + (size_t)n * step;
        for (size_t k = 0; k < count; k++) {
            row[k] = table->norm[n] * now[k];
            double next = table->rise[n] * (2 * s[k] - 1) * now[k] - table->fall[n] * before[k];
            before[k] = now[k];
            now[k] = next;
        }
    }
}

static void tensor_many(const hpr_basis_table *table, int degree, size_t count, const double *s,
                        const double *t, size_t stride, double *values, double *scratch)
{
    size_t n = (size_t)degree + 1;
    /* in s at k = n a, in t at k = b; a = 0 is 1 and stays to the last */
    legendre_many(table, degree, count, s, scratch, scratch + stride, n * stride, values);
    legendre_many(table, degree, count, t, scratch, scratch + stride, stride, values);
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

static void dubiner_many(const hpr_basis_table *table, int degree, size_t count, const double *s,
                         const double *t, size_t stride, double *values, double *scratch)
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
            double norm = table->dubiner[i][j].norm, rise = table->dubiner[i][j].rise;
            double shift = table->dubiner[i][j].shift, fall = table->dubiner[i][j].fall;
            double *restrict out = values + (size_t)(d * (d + 1) / 2 + j) * stride;
            for (size_t k = 0; k < count; k++) {
                out[k] = norm * now[k];
                double next = (rise * (2 * t[k] - 1) + shift) * now[k] - fall * before[k];
                before[k] = now[k];
                now[k] = next;
            }
        }
        for (size_t k = 0; k < count; k++) {
            double v = 1 - t[k];
            double next = table->rise[i] * (2 * s[k] + t[k] - 1) * row[k] - table->fall[i] * v * v * row_before[k];
            row_before[k] = row[k];
            row[k] = next;
        }
    }
}

void hpr_basis_many(const hpr_basis_table *table, hpr_shape shape, int degree, size_t count, const double *s,
                    const double *t, size_t stride, double *values, double *scratch)
{
    if (shape == HPR_SHAPE_PARALLELOGRAM)
        tensor_many(table, degree, count, s, t, stride, values, scratch);
    else
        dubiner_many(table, degree, count, s, t, stride, values, scratch);
}
