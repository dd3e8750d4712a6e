/*
 * How many Gauss nodes an outer integral needs. The integral of the kernel over a polygon (or a segment),
 * times a polynomial, is an analytic function of the outer point but where that meets a corner or the line of
 * an edge. Along a segment x(u), 0 <= u <= 1, those are points of the complex u-plane; the nearest of them, in
 * Bernstein ellipses, decides how fast Gauss converges (Trefethen 2013, thm. 19.3).
 */
#ifndef HPR_QUADRATURE_ANALYTIC_H
#define HPR_QUADRATURE_ANALYTIC_H

#include "math/vec3.h"

/* Sum of the half axes, in halves of the interval, of the ellipse around [0, 1] that goes through re + i im. */
double hpr_ellipse(double re, double im);

/* That of the largest ellipse around the segment in which the integral over the outline (2 corners: a segment)
 * is analytic; 1 if the segment touches the outline. */
double hpr_bernstein(hpr_vec3 from, hpr_vec3 to, const hpr_vec3 *outline, int count);

/*
 * Gauss nodes, at most 1000, for this relative error of a function that is analytic inside the ellipse, times a
 * polynomial of a degree that grows by `growth` per degree up to there (hpr_chord_growth).
 */
int hpr_bernstein_nodes(double bernstein, double tolerance, int degree, double growth);

/* The relative error that this number of nodes is expected to leave; polynomials are not counted. */
double hpr_bernstein_error(double bernstein, int nodes);

/* By how much per degree a polynomial grows that is bounded on [low, high] (around [0, 1]), from there to the
 * ellipse around [0, 1]. */
double hpr_chord_growth(double bernstein, double low, double high);

#endif
