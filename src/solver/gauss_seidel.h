/* Block Gauss-Seidel on G H = D + K rho H, G the Gram matrices of the elements' open parts. */
#ifndef HPR_SOLVER_GAUSS_SEIDEL_H
#define HPR_SOLVER_GAUSS_SEIDEL_H

#include "link/coverage.h"
#include "link/links.h"

typedef struct hpr_gauss_seidel {
    /* in */
    const hpr_patches *patches;
    const hpr_links *links;
    size_t channel_count;
    const hpr_coverage *coverage;
    const double *direct;      /* [channel_count][dofs] moments of D, what comes straight from emitters */
    const double *reflectance; /* [patches][channel_count] */
    double tolerance;          /* on the estimated relative error of H: the worst channel's */
    int max_sweeps;
    /* out */
    double *irradiance; /* [channel_count][dofs]; in: the start */
    int sweeps;
    double residual; /* |D + K rho H - H| / |H|, worst channel, after the last sweep, computed afresh */
} hpr_gauss_seidel;

/*
 * One block is one patch: its leaves do not see each other, so they are updated in parallel with the same
 * bits for any thread count. Sweeps go through the patches in index order until the error estimated from the
 * last two changes, |change| q / (1 - q) with q their ratio, is within tolerance or the changes are at
 * rounding. Errors: HPR_ERR_NUMERIC (max_sweeps reached, or the changes do not fall: rho = 1 in a closed
 * scene), HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. Source: Gortler, Cohen & Slusallek 1994 (relaxation); the
 * estimate: Golub & Van Loan 2013, 11.2.
 */
hpr_status hpr_gauss_seidel_solve(hpr_gauss_seidel *problem);

#endif
