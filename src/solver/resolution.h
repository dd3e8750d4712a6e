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
 * Replaces HPR_CHOOSE in order, subdivide and feet by
 *   (HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE, HPR_DEFAULT_FEET)
 * where that takes at most HPR_RESOLUTION_DOFS coefficients, what is given in the place of what would be
 * chosen. Else feet is 0, and
 *   if subdivide is given: the highest order that stays below,
 *   else: no subdivision, but elements of one size; the highest order from 4 to 1 of which one element per
 *   patch takes at most half of the coefficients, so that the rest can go where patches are large. Where even
 *   order 1 takes more than half, it is order 1 and at last 0 on whole patches.
 * HPR_CHOOSE in element_size becomes 0, or stays if a size is to be found (patch/even.h). Returns false if
 * something coarser than the first was chosen because of the number of patches.
 */
bool hpr_resolution_choose(const hpr_patches *patches, hpr_solve_options *options);

/*
 * The same where elements are refined until a tolerance is met: whole patches, of degree 4 if that makes at
 * most HPR_RESOLUTION_DOFS coefficients, else 2, the least whose coefficients tell how smooth the light is.
 */
void hpr_resolution_begin(const hpr_patches *patches, hpr_solve_options *options);

#endif
