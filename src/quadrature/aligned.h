/*
 * Parallelograms in any two planes that have one direction of their edges in common, as walls of a room have.
 * Along it G depends on the difference of the points alone, and the heights do not change at all, so that
 *   ∫_r ∫_s phi_k(x) G phi_l(y) = ∫∫ h_x(v) h_y(w) p(v) p(w) [ ∫ c(d) / (pi (d^2 + q(v, w)^2)^2) dd ] dv dw,
 * v and w the coordinates across, q the distance of their lines, c a correlation (correlation.h). Of four
 * dimensions three are left; in v and w cells that are large for their distance are halved, along d the rule
 * of polar.h serves however small q is.
 */
#ifndef HPR_QUADRATURE_ALIGNED_H
#define HPR_QUADRATURE_ALIGNED_H

#include "quadrature/rule.h"

/* Whether a pair that does not touch is of that kind, but for what moves it by less than the tolerance
 * allows, or by no more than rounding of its coordinates. */
bool hpr_aligned_find(const hpr_pair *pair, double tolerance, hpr_aligned *aligned);

/* Doubles that hpr_aligned_add needs as scratch for elements of no more than this degree. */
static inline size_t hpr_aligned_scratch(int degree)
{
    size_t n = (size_t)degree + 1, functions = 2 * n;
    return (3 * n * n + HPR_NODES_MAX + 3) * functions + (n + 1) * n * n;
}

/*
 * part[k * n_send + l] += what the groups of a rule would; relative error `tolerance` of the largest entry.
 * scratch [hpr_aligned_scratch(the larger degree)]. *kernels: evaluations, added to. False if it stopped
 * short. Thread-safe with distinct scratch.
 */
bool hpr_aligned_add(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_aligned *aligned,
                     double tolerance, double *part, double *scratch, uint64_t *kernels);

#endif
