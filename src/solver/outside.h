/* Light from outside in the making of a solution. outside [dofs] are the moments of V, the open part of the
 * view (direct/environment.h); direct [channels][dofs] those of D. */
#ifndef HPR_SOLVER_OUTSIDE_H
#define HPR_SOLVER_OUTSIDE_H

#include "link/coverage.h"
#include "solver/solution.h"

/* Does any channel's light come from outside? */
bool hpr_outside_shines(const hpr_solution *solution);

/* Fills outside, and says in the summary how light from outside is treated. Errors: HPR_ERR_MEMORY,
 * HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED. */
hpr_status hpr_outside_project(hpr_solution *solution, const hpr_coverage *coverage, double *outside);

/* direct += pi L outside */
void hpr_outside_add(const hpr_solution *solution, const double *outside, double *direct);

/*
 * Turns the moments of D into those of what is evaluated at points: lamps or not, (pi L - S) V or not. What
 * shuts a patch's view is about as bright as it is on the average: S (1 - V), with
 *   S = ∫ (H - D) dA / ∫ (1 - V) dA >= 0 over the patch,
 * follows the indirect light closely in corners, and the constant S is in the basis; so the basis has little
 * left to carry. Fills solution->surroundings; solution->irradiance holds the whole H.
 */
void hpr_outside_split(hpr_solution *solution, const double *outside, double *direct);

/* The same with the surroundings that the solution has. */
void hpr_outside_weigh(const hpr_solution *solution, const double *outside, double *direct);

#endif
