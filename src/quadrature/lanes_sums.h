/*
 * The inner loops of fast blocks: kernels, polynomials and sums over points, eight at a time, for each
 * instruction set. Arrays of points are read to the end of their last eight: see hpr_points_pad.
 */
#ifndef HPR_QUADRATURE_LANES_SUMS_H
#define HPR_QUADRATURE_LANES_SUMS_H

#include "basis/basis.h"
#include "math/lanes.h"
#include "quadrature/rule.h"

/*
 * Products X_a(s,t) Y_b(s,t), a, b <= degree, that span an element's polynomials and are cheap to evaluate:
 *   X_0 = 1, X_(n+1) = (2n+1)/(n+1) u X_n - n/(n+1) q^2 X_(n-1),  u = u[0] + u[1] s + u[2] t, q = 1 - c t
 *   Y_n = P_n(w), w = w[0] + w[1] t.
 * In order of a, then b; with `total` only those with a + b <= degree.
 */
typedef struct hpr_products {
    int degree;
    bool total;
    double u[3], c, w[2];
} hpr_products;

/*
 * A grid of nodes, point j nodes[0] + i, on which phi_k = X_a Y, X_a of i alone, Y of j: of a parallelogram
 * Y_b, b <= degree, k = a (degree + 1) + b; with `total` Y_ab, a + b <= degree, in order of a, then b, and
 * k = (a + b) (a + b + 1) / 2 + b.
 */
typedef struct hpr_factors {
    int degree;
    bool total;
    size_t nodes[2];
    const double *first, *second;     /* X, Y in rows of HPR_FACTOR_POINTS, padded */
    double *wide_first, *wide_second; /* room for eight times as many */
} hpr_factors;

enum { HPR_FACTOR_POINTS = HPR_NODES_MAX };

/* Vectors that tables of polynomials hold at a time. */
enum { HPR_TABLE_VECTORS = 16, HPR_TABLE_POINTS = HPR_TABLE_VECTORS * HPR_LANES };

/* Outer points whose sums are kept until all are taken together: 8 vectors. */
enum { HPR_ROWS = 64 };

typedef struct hpr_sums_scratch {
    hpr_lanes x[HPR_MAX_DEGREE + 1][HPR_TABLE_VECTORS], y[HPR_MAX_DEGREE + 1][HPR_TABLE_VECTORS];
    hpr_lanes sum[2 * HPR_MAX_BASIS + HPR_LANES]; /* eights are read to the end */
    hpr_lanes kernel[HPR_TABLE_POINTS];           /* whole fours */
} hpr_sums_scratch;

/* Left rows and right rows, arrays [rows][stride] of `vectors` eights. */
typedef struct hpr_row_product {
    const double *left, *right;
    size_t left_stride, right_stride, left_count, right_count, vectors;
} hpr_row_product;

/* Points on a line: each of s, t, x, y, z and height is at[k] + u by[k]. */
typedef struct hpr_point_line {
    double at[6], by[6];
    size_t count;
    const double *u, *weight; /* read to the end of the last eight */
    double scale, least;      /* the weight is scale * weight * max(height, least) */
} hpr_point_line;

/* Loops of one instruction set. All are thread-safe with distinct output and scratch. */
typedef struct hpr_sums {
    /* kernel[j] = scale weight_j / |y_j - x_i|^4 */
    void (*kernel)(const hpr_points *from, size_t i, const hpr_points *to, double scale, double *kernel);
    /* moment[k stride] = sum_j kernel_j (X_a Y_b)_k(s_j, t_j) */
    void (*moments)(const hpr_products *products, size_t count, const double *s, const double *t,
                    const double *kernel, double *moment, size_t stride, hpr_sums_scratch *scratch);
    /* moment[l][i - first] += scale sum_j kernel_ij basis[l][j - start], HPR_ROWS outer points from `first`
     * and HPR_TABLE_POINTS inner ones from `start` on, or as many as there are; moment [functions][HPR_ROWS],
     * basis [functions][HPR_TABLE_POINTS] */
    void (*grid)(const hpr_points *outer, size_t first, const hpr_points *inner, size_t start, double scale,
                 size_t functions, const double *basis, double *moment, hpr_sums_scratch *scratch);
    /* the same for all inner points, by one axis after the other */
    void (*factored)(const hpr_points *outer, size_t first, const hpr_points *inner,
                     const hpr_factors *factors, double scale, double *moment, hpr_sums_scratch *scratch);
    /* table [functions][HPR_ROWS]: phi_k of the points, of which there are few enough that a padded row of
     * nodes in place of the last one does not go beyond HPR_ROWS; 0 up to the end of the last eight */
    void (*spread)(const hpr_factors *factors, double *table);
    /* to[k right_count + l] += left row k . right row l */
    void (*rows)(const hpr_row_product *product, double *to, hpr_sums_scratch *scratch);
    /* appends the points of a line; there is room */
    void (*line)(const hpr_point_line *line, hpr_points *points);
    /* the largest magnitude; a NaN counts as nothing */
    double (*largest)(const double *entry, size_t count);
    /* sinh and cosh of low + width node[i], up to the end of the last eight; they err by 4 ulp of cosh */
    void (*hyperbolic)(double low, double width, const double *node, size_t count, double *sine,
                       double *cosine);
} hpr_sums;

const hpr_sums *hpr_sums_of(hpr_isa isa);

#endif
