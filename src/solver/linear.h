/* The linear system G H = D + K rho H, G the Gram matrices of the elements' open parts, and ways to solve it.
 */
#ifndef HPR_SOLVER_LINEAR_H
#define HPR_SOLVER_LINEAR_H

#include "link/coverage.h"
#include "link/links.h"
#include "solver/mass.h"

#include <hprad/solve.h>

typedef struct hpr_linear_problem {
    /* in */
    const hpr_patches *patches;
    const hpr_links *links;
    size_t channel_count;
    const hpr_coverage *coverage;
    const double *direct; /* [channel_count][dofs] moments of D, what comes straight from emitters */
    const hpr_mass *mass; /* rho; has as many channels or more, of which the first are taken */
    hpr_solver_method method;
    double tolerance; /* on the estimated relative error of H: the worst channel's */
    int max_sweeps;
    /* out */
    double *irradiance; /* [channel_count][dofs]; in: the start */
    int sweeps;         /* applications of the operator; of shooting: shots */
    hpr_solver_method used;
    double residual; /* |D + K rho H - H| / |H|, worst channel, computed afresh at the end */
} hpr_linear_problem;

/*
 * HPR_SOLVER_AUTO sweeps by Gauss-Seidel until it converges, or until it is plain that GMRES is cheaper.
 * Errors: HPR_ERR_NUMERIC (max_sweeps reached, or the changes do not fall: rho = 1 in a closed scene),
 * HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. Same bits for any thread count.
 */
hpr_status hpr_linear_solve(hpr_linear_problem *problem);

#endif
