/* How finely a scene is solved when nobody says it. */
#ifndef HPR_SOLVER_RESOLUTION_H
#define HPR_SOLVER_RESOLUTION_H

#include "patch/patches.h"

#include <hprad/solve.h>

/* So many coefficients are what a chosen resolution may have, elements quartered at feet not counted: at
 * most half a gigabyte of blocks, and 10 to 20 s of a furnished room. */
enum { HPR_RESOLUTION_DOFS = 12000 };

/* Coefficients of uniform elements; a double, for it may be astronomical. */
double hpr_resolution_dofs(const hpr_patches *patches, int order, int subdivide);

/*
 * Replaces HPR_CHOOSE in order, subdivide and feet. Tried from fine to coarse are
 *   (order, subdivide) = (4,2) (3,2) (2,2) (2,1) (1,1) (1,0) (0,0),
 * with what is given in the place of what would be chosen; the first that has at most HPR_RESOLUTION_DOFS
 * coefficients is taken, else the last. feet: HPR_DEFAULT_FEET if the first was taken or nothing was to be
 * chosen, else 0. Returns false if something coarser than the first was chosen.
 */
bool hpr_resolution_choose(const hpr_patches *patches, hpr_solve_options *options);

#endif
