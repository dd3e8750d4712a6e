/*
 * What an element leaves out of the irradiance, told from how its coefficients fall. Along an axis the band
 * b_m is the root of the sum of squares of the coefficients of degree m along it. Where H is analytic they
 * fall like q^m, where it is not, like a power of m; either way the next ones are b_p q^k, q taken from the
 * last two pairs of bands, so that a function that is even or odd does not deceive.
 * Source: Mavriplis 1994; Houston & Sueli 2005.
 */
#ifndef HPR_SOLVER_INDICATOR_H
#define HPR_SOLVER_INDICATOR_H

#include "link/coverage.h"
#include "solver/solution.h"

typedef struct hpr_indicator {
    double error2[2]; /* square of what is left out along each axis; of a triangle [0] */
    double ratio[2];  /* q, 0 .. 1, of each */
    bool cut;         /* something stands on the element: H is singular at its foot */
    double unsent2;   /* square of what others do not get of the direct light here */
} hpr_indicator;

/*
 * indirect: [dofs][channels] coefficients of what the basis carries, direct: [channels][dofs] of the rest;
 * norm2 [channels] square of the norm of H: error2 is relative to it, summed over channels. indicator
 * [leaf_count]. Below degree 2 the coefficients tell little: error2 then is an upper bound.
 */
void hpr_indicate(const hpr_solution *solution, const hpr_coverage *coverage, const double *indirect,
                  const double *direct, const double *norm2, hpr_indicator *indicator);

#endif
