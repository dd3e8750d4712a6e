/* The transport between two constants past blockers, as one number. */
#ifndef HPR_QUADRATURE_PARTIAL_H
#define HPR_QUADRATURE_PARTIAL_H

#include "quadrature/pair.h"

#include "math/gauss.h"

#include <stdbool.h>
#include <stdint.h>

enum { HPR_PARTIAL_CELLS = 8000 };

/* Four corners in the outer parameters, (u,v) = (0,0) (1,0) (1,1) (0,1), bilinear between; of a triangle the
 * last two are one. */
typedef struct hpr_partial_cell {
    double corner[4][2];
    double value, error;
    uint64_t blockers; /* bit b: blocker b of the pair may come between the cell and the inner polygon */
    bool hidden;       /* one blocker hides all of the inner polygon from all of the cell */
    int axis;          /* to halve along */
} hpr_partial_cell;

typedef struct hpr_partial_demand {
    double tolerance;  /* relative */
    double allowed_m2; /* absolute error of the value that is allowed; the larger of the two counts */
    /* What rounding of the coordinates does anyhow, relative and absolute; the lesser counts, and a quarter
     * of it is allowed as well. */
    double flat, swept_m2;
    bool slit; /* the polygons nearly touch or their planes nearly agree: see below */
} hpr_partial_demand;

typedef struct hpr_partial {
    double exchange_m2;  /* ∫_r ∫_s G V dA dA */
    double error_m2;     /* estimated */
    bool complete;       /* false: it stopped short */
    uint64_t clip_count; /* points that were clipped for */
} hpr_partial;

/*
 * recv, send: the polygons, in the parameters of the pair's elements. The outer polygon is cut along its
 * event lines (events.h) where that pays, and in ever smaller cells where the estimated errors are largest,
 * until their sum is allowed, or HPR_PARTIAL_CELLS are made: that bounds the effort for one pair to a second
 * or so. In a slit the integrand falls from 1 to 0 over an edge of the inner polygon within the width of the
 * slit, where no node may lie: there a cell counts as unknown until it is as small as its distance. cells:
 * scratch. Deterministic; never allocates; thread-safe with distinct scratch.
 */
hpr_partial hpr_partial_integrate(const hpr_gauss_table *gauss, const hpr_pair *pair, const hpr_polygon *recv,
                                  const hpr_polygon *send, const hpr_partial_demand *demand,
                                  hpr_partial_cell cells[HPR_PARTIAL_CELLS]);

#endif
