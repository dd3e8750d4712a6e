/* Elements of even size: as long on a floor as on the legs that stand on it. */
#ifndef HPR_PATCH_EVEN_H
#define HPR_PATCH_EVEN_H

#include "patch/elements.h"

/*
 * Halves leaves across their longest side until none is longer than longest_m; of a triangle, which can only
 * be halved at its newest vertex, until its three sides are not. No leaf is halved that was made by 2
 * HPR_MAX_SUBDIVIDE halvings of its patch. Leaves are numbered anew. Errors: HPR_ERR_ARG (longest_m is not
 * positive), HPR_ERR_MEMORY.
 */
hpr_status hpr_elements_even(const hpr_patches *patches, hpr_elements *elements, double longest_m);

/*
 * Among the lengths L, L 2^(-1/8), L 2^(-2/8), ..., L the longest side of a patch, the last one down to which
 * whole patches in elements of degree `order` have at most most_dofs coefficients; L if there is none.
 * Errors: HPR_ERR_ARG (order), HPR_ERR_MEMORY.
 */
hpr_status hpr_elements_even_within(const hpr_patches *patches, int order, size_t most_dofs,
                                    double *longest_m);

#endif
