/* The solution at points. */
#ifndef HPR_RECONSTRUCT_RECONSTRUCT_H
#define HPR_RECONSTRUCT_RECONSTRUCT_H

#include "solver/solution.h"

/*
 * H at the point (s,t) of a patch, W/m2: the polynomials of the leaf that holds it, sum_k irradiance[k] T_k.
 * irradiance: [channels]. Never allocates; concurrent calls allowed.
 */
void hpr_reconstruct_point(const hpr_solution *solution, size_t patch, double s, double t,
                           double *irradiance);

#endif
