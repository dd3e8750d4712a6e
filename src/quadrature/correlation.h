/*
 * Correlations of Legendre polynomials on two intervals of one line: what is left of a double integral along
 * a direction in which a kernel depends on the difference d = y - x alone, c_kl(d) = ∫ p_k(x) p_l(x + d) dx,
 * p_n(x) = sqrt(2n+1) P_n(2x - 1) of either interval's own parameter: polynomials of degree k + l + 1 between
 * the places where an overlap begins or ends. Source: the relative coordinates of Sauter & Schwab 2011,
 * sec. 5.2, carried through for a kernel that is a convolution.
 */
#ifndef HPR_QUADRATURE_CORRELATION_H
#define HPR_QUADRATURE_CORRELATION_H

#include "basis/basis.h"
#include "math/gauss.h"

/* The sender's interval in units of the receiver's, which is [0, 1]. */
typedef struct hpr_overlap {
    double first, length; /* [first, first + length] */
    bool reversed;        /* the sender's parameter runs the other way */
} hpr_overlap;

/* An interval of d on which the overlap is of one kind. */
typedef struct hpr_span {
    enum { HPR_OVERLAP_RISES, HPR_OVERLAP_WHOLE, HPR_OVERLAP_FALLS } kind;
    double low, high; /* of d */
} hpr_span;

/* Returns how many there are, two or three. Each begins just where the last one ends: of a gap as wide as
 * rounding a thin slit between the planes makes more. */
int hpr_overlap_spans(const hpr_overlap *overlap, hpr_span spans[3]);

enum { HPR_CORRELATION_FUNCTIONS = 2 * HPR_MAX_DEGREE + 2 };

/* coefficient[(k * n_send + l) * functions + a] of P_a(xi) on one span, xi from -1 to 1 along it;
 * k < n_recv, l < n_send, a < functions = n_recv + n_send. With dx and dy, the sender's own parameter. */
typedef struct hpr_correlation {
    int n_recv, n_send, functions;
    double *coefficient;
} hpr_correlation;

/* They do not depend on overlap->first. */
void hpr_correlate(const hpr_gauss_table *gauss, const hpr_overlap *overlap, const hpr_span *span,
                   const hpr_correlation *correlation);

/* values[n] = P_n(x), n < count */
void hpr_legendre(double x, int count, double *values);

#endif
