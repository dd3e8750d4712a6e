/* The transport between two constants past blockers, as one number. */
#ifndef HPR_QUADRATURE_PARTIAL_H
#define HPR_QUADRATURE_PARTIAL_H

#include "quadrature/rule.h"

typedef struct hpr_partial {
    double exchange_m2;  /* ∫_r ∫_s G V dA dA */
    bool complete;       /* false: it stopped short */
    uint64_t clip_count; /* points that were clipped for */
} hpr_partial;

/*
 * recv, send: the polygons, in the parameters of the pair's elements. allowed: absolute error of the value
 * that is allowed; tolerance: relative, the larger of the two counts. The outer polygon is cut along its
 * event lines (events.h) where that pays, and in ever smaller cells where the estimated errors are largest,
 * until their sum is allowed. Deterministic; never allocates; thread-safe.
 */
hpr_partial hpr_partial_integrate(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_polygon *recv,
                                  const hpr_polygon *send, double tolerance, double allowed_m2);

#endif
