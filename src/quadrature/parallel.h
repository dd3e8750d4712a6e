/*
 * Parallelograms that face each other in parallel planes, with edges along the same two directions. G depends
 * on the difference d = y - x alone there, so that with a change of variables
 *   ∫_r ∫_s phi_k(x) G(y - x) phi_l(y) = ∫ G(d) c_kl(d) dd,   c_kl(d) = ∫ phi_k(x) phi_l(x + d) dx:
 * c_kl is the product of two correlations of Legendre polynomials, one along each edge, polynomials of degree
 * k + l + 1 between the places where an overlap begins or ends. Of four dimensions two are left, seen from a
 * single point; and on each of at most nine cells the moments of G against (p_r + p_s + 2)^2 polynomials give
 * all entries. Source: the relative coordinates of Sauter & Schwab 2011, sec. 5.2, carried through for a
 * kernel that is a convolution.
 */
#ifndef HPR_QUADRATURE_PARALLEL_H
#define HPR_QUADRATURE_PARALLEL_H

#include "quadrature/rule.h"

/* Whether a pair is of that kind, but for what moves it by less than the tolerance allows, or by no more than
 * rounding of its coordinates. */
bool hpr_parallel_find(const hpr_pair *pair, double tolerance, hpr_parallel *parallel);

/* Doubles that hpr_parallel_add needs as scratch for elements of no more than this degree. */
static inline size_t hpr_parallel_scratch(int degree)
{
    size_t n = (size_t)degree + 1, functions = 2 * n;
    return (5 * n * n + functions) * functions;
}

/*
 * part[k * n_send + l] += ∫ ∫ G r^2-heights included, phi_k phi_l, over both parameter domains, as the groups
 * of hpr_rule do; relative error `tolerance` of the largest entry. group: scratch for points; scratch
 * [hpr_parallel_scratch(the larger degree)]. Returns the number of kernel evaluations. Thread-safe with
 * distinct scratch.
 */
uint64_t hpr_parallel_add(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_parallel *parallel,
                          double tolerance, hpr_group *group, double *part, double *scratch);

#endif
