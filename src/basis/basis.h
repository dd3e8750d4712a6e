/*
 * Orthonormal polynomials on the parameter domain of an element.
 *   parallelogram, s,t in [0,1]:     phi_k = p_a(s) p_b(t), p_n(s) = sqrt(2n+1) P_n(2s-1), k = (p+1) a + b
 *   triangle, s,t >= 0, s+t <= 1:    phi_k = sqrt(2(2i+1)(i+j+1)) P_i(2s/(1-t)-1) (1-t)^i P_j^(2i+1,0)(2t-1),
 *                                    by total degree, then falling i: (0,0),(1,0),(0,1),(2,0),(1,1),(0,2) ...
 * The basis in area is T_k = scale * phi_k with scale = 1/sqrt(A), 1/sqrt(2A): ∫ T_k T_l dA = delta_kl.
 * Source: Dubiner 1991; recurrences without division by 1-t as in Karniadakis & Sherwin 2005, ch. 3.
 */
#ifndef HPR_BASIS_BASIS_H
#define HPR_BASIS_BASIS_H

#include "base/context.h"
#include "patch/patches.h"

enum { HPR_MAX_DEGREE = 16, HPR_MAX_BASIS = (HPR_MAX_DEGREE + 1) * (HPR_MAX_DEGREE + 1) };

/* Of n: sqrt(2n+1), (2n+1)/(n+1) and n/(n+1), P_(n+1)(x) = raise x P_n - lower P_(n-1); square roots and
 * divisions would cost more than all the rest. */
extern const double hpr_legendre_norm[HPR_MAX_DEGREE + 1], hpr_legendre_raise[HPR_MAX_DEGREE + 1],
    hpr_legendre_lower[HPR_MAX_DEGREE + 1];

/* Number of functions of degree p: (p+1)^2 or (p+1)(p+2)/2. */
size_t hpr_basis_count(hpr_shape shape, int degree);

/* values[hpr_basis_count] = phi_k(s,t). degree <= HPR_MAX_DEGREE. Thread-safe. */
void hpr_basis_eval(hpr_shape shape, int degree, double s, double t, double *values);

/* values[hpr_basis_count][stride], of which the first `count` <= stride of each row are written: phi_k at
 * points s, t [count]. Equal to hpr_basis_eval but for rounding,
 * and the same on every instruction set. scratch: [4 stride]. Thread-safe. */
void hpr_basis_many(hpr_isa isa, hpr_shape shape, int degree, size_t count, const double *s, const double *t,
                    size_t stride, double *values, double *scratch);

/* The factor from phi to T for an element of this area. */
double hpr_basis_scale(hpr_shape shape, double area_m2);

#endif
