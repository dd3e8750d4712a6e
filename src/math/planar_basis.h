/*
 * Orthonormal polynomials of two variables over a convex quadrilateral Q with the corners (0,0), (1,0), (a,b)
 * and (0,1): phi_k of total degree d, k = d (d + 1)/2 + j with j = 0 .. d, and ∫_Q phi_k phi_l ds dt =
 * delta_kl. The first p (p + 1)/2 + p + 1 span all polynomials of degree <= p.
 *
 * phi_0 is constant. A function of degree 1 comes from s or t, a higher one from phi_1 or phi_2 times one of
 * the degree before, made orthogonal to all before it; for a product with an affine function that concerns
 * only the last two degrees. Of the products, the one of which most is left is taken next: in a fixed order
 * what is left would shrink from degree to degree, and six digits would go at degree 16. The coefficients are
 * kept as a recurrence, and phi is evaluated by it: a sum of Legendre polynomials of a box around Q would
 * lose up to twelve digits. Source: Stieltjes' procedure in two variables; Brubeck, Nakatsukasa & Trefethen
 * 2021 (Vandermonde with Arnoldi).
 */
#ifndef HPR_MATH_PLANAR_BASIS_H
#define HPR_MATH_PLANAR_BASIS_H

#include "base/context.h"
#include "math/gauss.h"

#include <stdbool.h>
#include <stddef.h>

/* Doubles of a recurrence up to degree p; that of a lower degree is its beginning. */
size_t hpr_planar_size(int degree);

/* Doubles of scratch that hpr_planar_make needs. */
size_t hpr_planar_scratch(int degree);

/* recurrence [hpr_planar_size] for the corner opposite to the origin, (a,b) with a, b > 0 and a + b > 1.
 * rule: Gauss-Legendre of degree + 1 nodes. Thread-safe. */
void hpr_planar_make(const double opposite[2], int degree, const hpr_gauss_rule *rule, double *recurrence,
                     double *scratch);

/* values [(p + 1)(p + 2)/2] = phi_k(s,t). Thread-safe. */
void hpr_planar_eval(const double *recurrence, int degree, double s, double t, double *values);

/* values [(p + 1)(p + 2)/2][stride], of which the first `count` <= stride of each row are written: phi_k at
 * points s, t [count]. Equal to hpr_planar_eval but for rounding, and the same on every
 * instruction set. Thread-safe. */
void hpr_planar_many(hpr_isa isa, const double *recurrence, int degree, size_t count, const double *s,
                     const double *t, size_t stride, double *values);

/* matrix [functions][functions]: phi_k = sum_l matrix[k][l] P_a(2s/box[0] - 1) P_b(2t/box[1] - 1), l running
 * through a + b <= p by a, then b. Thread-safe. */
void hpr_planar_matrix(const double *recurrence, int degree, const double box[2], double *matrix);

/* Node `index` of n x n product Gauss over Q by the bilinear map, which integrates polynomials of degree
 * 2 n - 2 exactly: parameters, and the weight in ds dt. */
typedef struct hpr_planar_node {
    double s, t, weight;
} hpr_planar_node;

hpr_planar_node hpr_planar_gauss(const double opposite[2], const hpr_gauss_rule *rule, int n, int index);

#endif
