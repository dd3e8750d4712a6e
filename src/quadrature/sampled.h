/*
 * Visibility by rays, where clipping would cost too much: one ray for each pair of quadrature points, and the
 * statistical error of that.
 */
#ifndef HPR_QUADRATURE_SAMPLED_H
#define HPR_QUADRATURE_SAMPLED_H

#include "quadrature/rule.h"

/* Four numbers in [0,1), a function of seed and index alone. Source: Steele, Lea & Flood 2014 (splitmix64).
 */
void hpr_sampled_random(uint64_t seed, uint64_t index, double random[4]);

/*
 * A place that stands for point `index` of product Gauss with these nodes in a cell: uniform over the part of
 * the cell whose area is the point's weight, so that all places together are stratified over the cell. Rays
 * between the points themselves would miss or meet the same edge from all of a row, and the errors of all
 * the blocks of one element would have one sign. (s,t) in the element's parameters.
 */
void hpr_sampled_place(const hpr_gauss_table *gauss, const hpr_cell *cell, const int nodes[2], int index,
                       const double random[2], double *s, double *t);

/* What the rays of one block have shown: sums over rays of the weight f, of f V and f^2. */
typedef struct hpr_sampled {
    double weight, seen, square;
} hpr_sampled;

/*
 * Standard error of sum f V: as if the rays were independent, each unblocked with the probability v,
 *   sqrt(v (1 - v) sum f^2),  v = (sum f V / sum f + 1/n) / (1 + 2/n),  n = (sum f)^2 / sum f^2,
 * so that a few rays that agree do not claim certainty. Strata only make the error smaller.
 * Source: Laplace's rule of succession for v; Kish 1965 for n.
 */
double hpr_sampled_error(const hpr_sampled *rays);

#endif
