/*
 * Which elements to refine, and how: where the coefficients of an element fall fast its degree is raised,
 * where they do not it is halved, along the axis along which they do not.
 */
#ifndef HPR_SOLVER_ADAPT_H
#define HPR_SOLVER_ADAPT_H

#include "solver/indicator.h"

/* What a series of steps has refined, in order. */
typedef struct hpr_refinements {
    size_t count, capacity;
    hpr_refinement *item;
} hpr_refinements;

/*
 * Refines elements, those that leave out most first, until what all leave out is foretold to fall to `goal`
 * (root of the sum of error2), or to have as many coefficients as a step may add; appends what it did to
 * `done`, as of `step`: nothing if nothing could be refined. The solution's arrays are left as they are and
 * belong to the old elements. Errors: HPR_ERR_MEMORY.
 */
hpr_status hpr_adapt(hpr_solution *solution, const hpr_indicator *indicator, double goal, uint32_t step,
                     hpr_refinements *done);

/* Does the same refinements of one step again. Errors: HPR_ERR_ARG (an element that does not exist, is named
 * twice or has the highest degree), HPR_ERR_MEMORY. */
hpr_status hpr_adapt_again(hpr_solution *solution, const hpr_refinement *refinement, size_t count);

#endif
