/*
 * Which elements to refine, and how: where the coefficients of an element fall fast its degree is raised,
 * where they do not it is halved, along the axis along which they do not (solver/proposal.h).
 */
#ifndef HPR_SOLVER_ADAPT_H
#define HPR_SOLVER_ADAPT_H

#include "solver/estimate.h"

/* What a series of steps has refined, in order. */
typedef struct hpr_refinements {
    size_t count, capacity;
    hpr_refinement *item;
} hpr_refinements;

/*
 * Refines elements with as few coefficients as possible so that what all leave out is foretold to fall to
 * `goal` (root of the sum of error2), or as far as one refinement of each brings it; appends what it did to
 * `done`, as of `step`: nothing if nothing could be refined. The solution's arrays are left as they are and
 * belong to the old elements. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_adapt(hpr_solution *solution, const hpr_estimate *estimate, double goal, uint32_t step,
                     hpr_refinements *done);

/* Does the same refinements of one step again. Errors: HPR_ERR_ARG (an element that does not exist or is
 * named twice, a degree that there is not), HPR_ERR_MEMORY. */
hpr_status hpr_adapt_again(hpr_solution *solution, const hpr_refinement *refinement, size_t count);

#endif
