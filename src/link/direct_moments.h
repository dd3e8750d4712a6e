/* The moments of direct light on the elements. */
#ifndef HPR_LINK_DIRECT_MOMENTS_H
#define HPR_LINK_DIRECT_MOMENTS_H

#include "direct/direct.h"
#include "link/coverage.h"

/*
 * moment[channel][dof] = ∫ T_k(x) D(x) dA over the open part of the leaf of the dof, W/m2 times metre, one
 * kernel block of leaf and whole emitter each: to the relative open_tolerance where nothing comes between,
 * else to blocked_tolerance, by clipping. Blocks that stop short are counted in *short_count. Same bits for
 * any thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_direct_moments(const hpr_direct *direct, const hpr_coverage *coverage,
                              const hpr_elements *elements, double open_tolerance, double blocked_tolerance,
                              double *moment, size_t *short_count);

#endif
