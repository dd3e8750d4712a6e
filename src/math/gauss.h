/* Gauss rules on [0,1] as tables. */
#ifndef HPR_MATH_GAUSS_H
#define HPR_MATH_GAUSS_H

enum { HPR_GAUSS_MAX = 48 };

typedef struct hpr_gauss_rule {
    double node[HPR_GAUSS_MAX], weight[HPR_GAUSS_MAX];
} hpr_gauss_rule;

/*
 * Tables of all rules with 1 .. HPR_GAUSS_MAX nodes, nodes rising.
 *   legendre[n]: int_0^1 f(x) dx       = sum_i w_i f(x_i) for polynomials of degree <= 2n-1
 *   jacobi[n]:   int_0^1 f(x)(1-x) dx  = sum_i w_i f(x_i) for polynomials of degree <= 2n-1
 * Element 0 is unused. Nodes and weights are within 4 ulp of 1 (absolute).
 * Source: Newton's iteration on the three-term recurrence, deflated (Karniadakis & Sherwin 2005, app. B).
 */
typedef struct hpr_gauss_table {
    hpr_gauss_rule legendre[HPR_GAUSS_MAX + 1], jacobi[HPR_GAUSS_MAX + 1];
} hpr_gauss_table;

/* Computed when hprad is built (gauss_roots.c): at run time they would take longer than many a block. */
extern const hpr_gauss_table hpr_gauss;

#endif
