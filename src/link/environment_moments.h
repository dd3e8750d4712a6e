/* The moments of light from outside on the elements. */
#ifndef HPR_LINK_ENVIRONMENT_MOMENTS_H
#define HPR_LINK_ENVIRONMENT_MOMENTS_H

#include "direct/environment.h"
#include "link/coverage.h"

/* How many elements were treated in which way, and how well. */
typedef struct hpr_environment_figures {
    size_t closed_form; /* nothing stands between what the element sees: 1 minus the form factors, to 1e-12 */
    size_t clipped;     /* adaptive over points at which the open part is clipped */
    size_t sampled;     /* rays from Gauss points */
    double error;       /* estimated, of the elements' mean V: root of its mean square over the area */
} hpr_environment_figures;

/*
 * moment[dof] = ∫ T_k(x) V(x) dA over the open part of the leaf of the dof, metres. tolerance: of what is
 * clipped, relative to the leaf's mean V. Same bits for any thread count. Errors: HPR_ERR_MEMORY,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_environment_moments(const hpr_environment *environment, const hpr_coverage *coverage,
                                   const hpr_elements *elements, double tolerance, double *moment,
                                   hpr_environment_figures *figures);

#endif
