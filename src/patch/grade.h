/* Elements graded toward the edges at which patches meet. */
#ifndef HPR_PATCH_GRADE_H
#define HPR_PATCH_GRADE_H

#include "patch/elements.h"

#include <hprad/solve.h>

/*
 * Near an edge that two patches share, H is like r^lambda with r the distance to it, 0 < lambda < 1, and each
 * of its ends is a singular point of its own. So parallelograms are halved `levels` times toward such edges,
 * along the axis across them only, and along them toward their ends as far as the distance to the edge asks:
 * strips of width 2^-k at distance 2^-k, 2 k + 1 boxes in each. So are quadrilaterals, in
 * the parameters of the bilinear map. An edge counts as shared if some point of
 * another patch lies on it at one of nine places, within weld_m. Triangles stay as they are and are counted
 * in *skipped_count. Leaves are numbered anew. Errors: HPR_ERR_ARG (levels), HPR_ERR_MEMORY. Source: Babuska
 * & Guo 1988; Schwab 1998, ch. 4.
 */
hpr_status hpr_elements_grade(const hpr_patches *patches, hpr_elements *elements, int levels,
                              size_t *skipped_count);

#endif
