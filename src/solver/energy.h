/* Where the light goes: emitted, absorbed, lost on black backs, escaped, each by a computation of its own. */
#ifndef HPR_SOLVER_ENERGY_H
#define HPR_SOLVER_ENERGY_H

#include "link/links.h"
#include "solver/mass.h"
#include "solver/solution.h"

/*
 * Fills solution->energy. outside: [dofs] the moments of V, the open part of the view; zero if nothing comes
 * from outside.
 *   emitted = ∫ M dA, environment = ∫ pi L V dA, absorbed = ∫ (1 - rho) H dA,
 *   lost_on_backs = ∫ B(y) f_back(y) dA, escaped = ∫ B(y) f_out(y) dA,
 * f_back the part of the light leaving y that meets the back of a single-sided patch, f_out the part that
 * meets nothing. From patches that nothing can shade, f is exact (Lambert's formula) and the integral is so
 * to 1e-11 of what comes in, or 1e-4 of the links' tolerance; from the others f is sampled by stratified
 * rays. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_energy_compute(hpr_solution *solution, const hpr_coverage *coverage, const hpr_mass *mass,
                              const hpr_links *links, const double *outside);

#endif
