/* Final gathering: the irradiance at single points by what a finished solution's radiosity sends there. */
#ifndef HPR_SOLVER_GATHER_H
#define HPR_SOLVER_GATHER_H

#include "link/spots.h"
#include "solver/solution.h"

/*
 * indirect [count][channels]: what hpr_reconstruct_parts says of it, but integrated anew at each spot, past
 * the true obstacles (solver/arrivals.h), and never below 0 where that is not. It takes some milliseconds a
 * spot and, beforehand, the moments of direct light. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED. Same bits for any thread count.
 */
hpr_status hpr_gather(const hpr_solution *solution, size_t count, const hpr_spot *spot, double *indirect);

#endif
