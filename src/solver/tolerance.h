/* Solves again and again on elements that are refined where they leave out most, until a tolerance is met. */
#ifndef HPR_SOLVER_TOLERANCE_H
#define HPR_SOLVER_TOLERANCE_H

#include "solver/solution.h"
#include "solver/transport.h"

/* What the parts of a solve may err by, so that all of them together stay far below the tolerance. */
hpr_transport_demand hpr_tolerance_demand(const hpr_solve_options *options);

/*
 * Stages in order, on the elements of the solution and then on ever finer ones, until the estimated error
 * (summary.error_estimate) is below options.tolerance, a limit is reached or nothing can be refined; the last
 * solution stands, with its energy terms. series: where to begin and whom to tell, or NULL. Errors:
 * those of hpr_transport_solve and hpr_solve_resume.
 */
hpr_status hpr_tolerance_solve(hpr_solution *solution, const hpr_solve_series *series);

#endif
