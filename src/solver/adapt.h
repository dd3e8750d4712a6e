/*
 * Which elements to refine, and how: where the coefficients of an element fall fast its degree is raised,
 * where they do not it is halved, along the axis along which they do not.
 */
#ifndef HPR_SOLVER_ADAPT_H
#define HPR_SOLVER_ADAPT_H

#include "solver/indicator.h"

/*
 * Refines elements, those that leave out most first, until what all leave out is foretold to fall to `goal`
 * (root of the sum of error2), or to have as many coefficients as a step may add. Returns the number of
 * elements that were refined in *refined: 0 if none could be. The solution's arrays are left as they are and
 * belong to the old elements. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_adapt(hpr_solution *solution, const hpr_indicator *indicator, double goal, size_t *refined);

#endif
