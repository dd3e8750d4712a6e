/*
 * How many Gauss nodes an outer integral needs. The integral of the kernel over a polygon (or a segment),
 * times a polynomial, is an analytic function of the outer point but where that meets a corner or the line of
 * an edge. Along a segment x(u), 0 <= u <= 1, those are points of the complex u-plane; the nearest of them,
 * in Bernstein ellipses, decides how fast Gauss converges (Trefethen 2013, thm. 19.3).
 */
#ifndef HPR_QUADRATURE_ANALYTIC_H
#define HPR_QUADRATURE_ANALYTIC_H

#include "math/vec3.h"

/* Sum of the half axes, in halves of the interval, of the ellipse around [0, 1] that goes through re + i im.
 */
double hpr_ellipse(double re, double im);

/* That of the largest ellipse around the segment in which the integral over the outline (2 corners: a
 * segment) is analytic; 1 if the segment touches the outline. */
double hpr_bernstein(hpr_vec3 from, hpr_vec3 to, const hpr_vec3 *outline, int count);

/*
 * How fast Gauss converges along a segment: the integrand is analytic inside the ellipse, times a polynomial
 * of `degree` that grows by `growth` per degree up to there (hpr_chord_growth). n nodes leave about
 *   min(strength, 1 + 1.5 n^3 (ellipse - 1)) lift growth^degree ellipse^(-2n)
 * of the integral: the second is what 1/r^4 with its root on the ellipse does, the first what a milder
 * singularity does; lift is the growth of the numerator, the height over the other's plane, if that counts.
 * Observed: at most that, mostly a tenth.
 */
typedef struct hpr_convergence {
    double ellipse, strength, lift, growth;
    int degree;
} hpr_convergence;

/* Strength of the integral over a polygon whose terms, edge by edge, cancel by this factor (hpr_lambert). */
double hpr_polygon_strength(double cancellation);

/* Nodes for a relative error, at most 1000. */
int hpr_convergence_nodes(const hpr_convergence *c, double tolerance);

/* The relative error that so many nodes are expected to leave. */
double hpr_convergence_error(const hpr_convergence *c, int nodes);

/* By how much per degree a polynomial grows that is bounded on [low, high] (around [0, 1]), from there to the
 * ellipse around [0, 1]. */
double hpr_chord_growth(double bernstein, double low, double high);

#endif
