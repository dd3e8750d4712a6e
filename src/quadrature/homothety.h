/*
 * Pairs that touch. G is homogeneous of degree -2 about a point c that lies in both planes, so that along
 * rays from (c, c) only the polynomials have to be integrated, and that is done exactly. What is left of the
 * four dimensions is the boundary of the product of the two polygons P, Q, seen from c in both: ∫_P ∫_Q g =
 * ∫_0^1 [ sum_a |a x c| ∫_a ∫_Q g + sum_b |b x c| ∫_P ∫_b g ] lambda dlambda, a and b their edges that do not
 * contain c, g at c + lambda (. - c). All terms are positive if c belongs to both. Where an edge a ends in
 * another contact point c', the same is done once more about c': ∫_a ∫_Q g = ∫_0^1 [ ∫_Q g(end of a) + sum_b
 * |b x c'| ∫_a ∫_b g ] dmu. On these the kernel is bounded. With an orthonormal basis, ∫ g lambda dlambda is
 * a sum of two-sided products with the matrices of phi_l(c + lambda (y - c)) = sum_m C_lm(lambda) phi_m(y).
 * Source: the idea of Sauter & Schwab 2011, sec. 5.2, for polygons that meet anyhow; Lenoir & Salles 2012 for
 * the reduction by homogeneity.
 */
#ifndef HPR_QUADRATURE_HOMOTHETY_H
#define HPR_QUADRATURE_HOMOTHETY_H

#include "basis/basis.h"
#include "quadrature/contact.h"
#include "quadrature/rule.h"

/* What is needed of a pair of polygons, in the parameters of their elements. */
typedef struct hpr_homothety {
    hpr_polygon recv, send;
    bool touching;
    int centre_count;
    hpr_centre centre[2];
} hpr_homothety;

/* The fronts of a pair that touches, about its contact points. */
hpr_homothety hpr_homothety_touching(const hpr_contact *contact);

/*
 * The fronts of a pair that does not touch, about a point of the line in which the planes cross. Terms have
 * either sign then, and polynomials grow on the way to the centre: *condition is the factor by which rounding
 * may grow, infinite for parallel planes. group: scratch.
 */
hpr_homothety hpr_homothety_apart(const hpr_gauss_table *gauss, const hpr_pair *pair,
                                  const hpr_contact *contact, hpr_group *group, double *condition);

/* The rules; level 1 refers to centre[0], level 2 to centre[1]. False if some rule misses the tolerance. */
bool hpr_homothety_choose(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_homothety *homothety,
                          double tolerance, hpr_rule_sink sink, void *user);

/* block += ∫_0^1 lambda^power C_recv(lambda) inside C_send(lambda)T dlambda; both [n_recv][n_send]. scratch:
 * [2 n_recv n_send + max(n_recv, n_send)^2]. */
void hpr_homothety_apply(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_centre *centre,
                         int power, const double *inside, double *block, double *scratch);

#endif
