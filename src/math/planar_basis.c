#include "math/planar_basis.h"

#include "math/lanes.h"

#include <math.h>
#include <string.h>

/*
 * A recurrence begins with phi_0; then come the rows of k = 1, 2, ...: which function m of the degree before
 * is multiplied by which affine function x, as the number 2 m + (0 or 1); the factor g of the product; and
 * the coefficients c of the functions from degree d - 2 on to k - 1: phi_k = g x phi_m - sum_i c_i phi_i.
 */
enum { HEADER = 2 };

static size_t first_of(int degree)
{
    return degree > 0 ? (size_t)degree * ((size_t)degree + 1) / 2 : 0;
}

/* The first function that the rows of a degree hold. */
static size_t band_of(int degree)
{
    return first_of(degree - 2);
}

size_t hpr_planar_size(int degree)
{
    size_t size = 1;
    for (int d = 1; d <= degree; d++) {
        for (size_t k = first_of(d); k < first_of(d + 1); k++)
            size += HEADER + k - band_of(d);
    }
    return size;
}

void hpr_planar_eval(const double *recurrence, int degree, double s, double t, double *values)
{
    values[0] = *recurrence++;
    for (int d = 1; d <= degree; d++) {
        const double *by = d == 1 ? (const double[2]){s, t} : values + 1;
        for (size_t k = first_of(d); k < first_of(d + 1); k++) {
            size_t source = (size_t)*recurrence++;
            double value = *recurrence++ * by[source % 2] * values[source / 2];
            for (size_t i = band_of(d); i < k; i++)
                value -= *recurrence++ * values[i];
            values[k] = value;
        }
    }
}

HPR_LANES_BODY void many_body(const double *recurrence, int degree, size_t count, const double *s,
                              const double *t, size_t stride, double *values)
{
    for (size_t p = 0; p < count; p++)
        values[p] = recurrence[0];
    recurrence++;
    for (int d = 1; d <= degree; d++) {
        for (size_t k = first_of(d); k < first_of(d + 1); k++) {
            size_t source = (size_t)*recurrence++;
            const double *by = d == 1 ? (source % 2 ? t : s) : values + (1 + source % 2) * stride;
            const double *multiplied = values + source / 2 * stride;
            double *restrict row = values + k * stride, factor = *recurrence++;
            for (size_t p = 0; p < count; p++)
                row[p] = factor * by[p] * multiplied[p];
            for (size_t i = band_of(d); i < k; i++) {
                const double *before = values + i * stride, c = *recurrence++;
                for (size_t p = 0; p < count; p++)
                    row[p] -= c * before[p];
            }
        }
    }
}

HPR_TARGET_AVX2 static void many_avx2(const double *recurrence, int degree, size_t count, const double *s,
                                      const double *t, size_t stride, double *values)
{
    many_body(recurrence, degree, count, s, t, stride, values);
}

HPR_TARGET_AVX512 static void many_avx512(const double *recurrence, int degree, size_t count, const double *s,
                                          const double *t, size_t stride, double *values)
{
    many_body(recurrence, degree, count, s, t, stride, values);
}

void hpr_planar_many(hpr_isa isa, const double *recurrence, int degree, size_t count, const double *s,
                     const double *t, size_t stride, double *values)
{
    if (isa == HPR_ISA_AVX512)
        many_avx512(recurrence, degree, count, s, t, stride, values);
    else if (isa == HPR_ISA_AVX2)
        many_avx2(recurrence, degree, count, s, t, stride, values);
    else
        many_body(recurrence, degree, count, s, t, stride, values);
}

/* Adds (f[0] + f[1] u + f[2] w) times a sum of P_a(u) P_b(w) of a degree less than `degree`. */
static void add_product(int degree, const double f[3], const double *from, double *to)
{
    size_t at = 0;
    for (int a = 0; a <= degree; a++) {
        size_t wide = (size_t)(degree - a + 1); /* places of row a */
        for (int b = 0; a + b <= degree; b++, at++) {
            double c = from[at];
            if (c == 0)
                continue;
            to[at] += f[0] * c;
            to[at + wide] += f[1] * c * (a + 1) / (2 * a + 1);
            if (a > 0)
                to[at - wide - 1] += f[1] * c * a / (2 * a + 1);
            to[at + 1] += f[2] * c * (b + 1) / (2 * b + 1);
            if (b > 0)
                to[at - 1] += f[2] * c * b / (2 * b + 1);
        }
    }
}

void hpr_planar_matrix(const double *recurrence, int degree, const double box[2], double *matrix)
{
    size_t count = first_of(degree + 1), in_u = (size_t)degree + 1;
    double by[2][3] = {{box[0] / 2, box[0] / 2, 0}, {box[1] / 2, 0, box[1] / 2}}; /* s, t */
    memset(matrix, 0, count * count * sizeof *matrix);
    matrix[0] = *recurrence++;
    for (int d = 1; d <= degree; d++) {
        for (int i = 0; d == 2 && i < 2; i++) {
            const double *affine = matrix + (size_t)(1 + i) * count;
            by[i][0] = affine[0];
            by[i][1] = affine[in_u];
            by[i][2] = affine[1];
        }
        for (size_t k = first_of(d); k < first_of(d + 1); k++) {
            size_t source = (size_t)*recurrence++;
            double *row = matrix + k * count, factor = *recurrence++;
            const double *f = by[source % 2];
            add_product(degree, (const double[3]){factor * f[0], factor * f[1], factor * f[2]},
                        matrix + source / 2 * count, row);
            for (size_t i = band_of(d); i < k; i++) {
                double c = *recurrence++;
                for (size_t l = 0; l < count; l++)
                    row[l] -= c * matrix[i * count + l];
            }
        }
    }
}

hpr_planar_node hpr_planar_gauss(const double opposite[2], const hpr_gauss_rule *rule, int n, int index)
{
    /* (s,t) = (u, v) + u v (a - 1, b - 1) */
    double u = rule->node[index % n], v = rule->node[index / n], a = opposite[0] - 1, b = opposite[1] - 1;
    return (hpr_planar_node){u + u * v * a, v + u * v * b,
                             rule->weight[index % n] * rule->weight[index / n] * (1 + v * a + u * b)};
}

size_t hpr_planar_scratch(int degree)
{
    size_t nodes = ((size_t)degree + 1) * ((size_t)degree + 1);
    return nodes * (3 + first_of(degree + 1) + 2 * (size_t)degree);
}

/* Nodes, the functions so far at them, [functions][node_count], and what may become a function of the degree
 * that is made: [2 m + (0 or 1)] less what the functions so far have of it. */
typedef struct workshop {
    size_t node_count;
    double *s, *t, *weight, *values, *candidate;
} workshop;

static double product(const workshop *w, const double *f, const double *g)
{
    double sum = 0;
    for (size_t p = 0; p < w->node_count; p++)
        sum += w->weight[p] * f[p] * g[p];
    return sum;
}

/* value -= (value, function k) function k. Returns the product. */
static double remove_part(const workshop *w, size_t k, double *value)
{
    const double *function = w->values + k * w->node_count;
    double part = product(w, value, function);
    for (size_t p = 0; p < w->node_count; p++)
        value[p] -= part * function[p];
    return part;
}

/* Affine function 0 or 1 times function m. */
static void multiply(const workshop *w, int degree, size_t source, double *value)
{
    size_t n = w->node_count;
    const double *by = degree > 1 ? w->values + (1 + source % 2) * n : source % 2 ? w->t : w->s;
    for (size_t p = 0; p < n; p++)
        value[p] = by[p] * w->values[source / 2 * n + p];
}

static void gather_candidates(const workshop *w, int degree)
{
    size_t first = 2 * first_of(degree - 1), count = 2 * (size_t)degree;
    for (size_t c = 0; c < count; c++) {
        double *value = w->candidate + c * w->node_count;
        multiply(w, degree, first + c, value);
        for (size_t i = band_of(degree); i < first_of(degree); i++)
            remove_part(w, i, value);
    }
}

/* The candidate of which most is left; of those that are equal but for rounding the first. */
static size_t choose(const workshop *w, int degree)
{
    static const double tie = 1e-6;
    size_t best = 0;
    double most = 0;
    for (size_t c = 0; c < 2 * (size_t)degree; c++) {
        const double *value = w->candidate + c * w->node_count;
        double left = product(w, value, value);
        if (left > most * (1 + tie)) {
            most = left;
            best = c;
        }
    }
    return 2 * first_of(degree - 1) + best;
}

/* Makes the row of function k and its values. Returns where the next row begins. */
static double *add_function(const workshop *w, int degree, size_t k, double *row)
{
    size_t n = w->node_count, band = band_of(degree), source = choose(w, degree);
    double *value = w->values + k * n, *coefficient = row + HEADER;
    multiply(w, degree, source, value);
    memset(coefficient, 0, (k - band) * sizeof *coefficient);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = band; i < k; i++)
            coefficient[i - band] += remove_part(w, i, value);
    }
    double factor = 1 / sqrt(product(w, value, value));
    row[0] = (double)source;
    row[1] = factor;
    for (size_t i = band; i < k; i++)
        coefficient[i - band] *= factor;
    for (size_t p = 0; p < n; p++)
        value[p] *= factor;
    for (size_t c = 0; c < 2 * (size_t)degree; c++)
        remove_part(w, k, w->candidate + c * n);
    return coefficient + (k - band);
}

void hpr_planar_make(const double opposite[2], int degree, const hpr_gauss_rule *rule, double *recurrence,
                     double *scratch)
{
    int nodes = degree + 1;
    size_t n = (size_t)nodes * (size_t)nodes;
    workshop w = {
        n, scratch, scratch + n, scratch + 2 * n, scratch + 3 * n, scratch + (3 + first_of(degree + 1)) * n};
    *recurrence = 1 / sqrt((opposite[0] + opposite[1]) / 2);
    for (size_t p = 0; p < n; p++) {
        hpr_planar_node node = hpr_planar_gauss(opposite, rule, nodes, (int)p);
        w.s[p] = node.s;
        w.t[p] = node.t;
        w.weight[p] = node.weight;
        w.values[p] = *recurrence;
    }
    double *row = recurrence + 1;
    for (int d = 1; d <= degree; d++) {
        gather_candidates(&w, d);
        for (size_t k = first_of(d); k < first_of(d + 1); k++)
            row = add_function(&w, d, k, row);
    }
}
