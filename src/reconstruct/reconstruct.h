/* Evaluating a solution. */
#ifndef HPR_RECONSTRUCT_RECONSTRUCT_H
#define HPR_RECONSTRUCT_RECONSTRUCT_H

#include "solver/solution.h"

/*
 * H at x(s,t) of a patch: irradiance[c] = sum_k coefficient[k][c] T_k(x), W/m2. irradiance: [channels].
 * Concurrent calls allowed with distinct results.
 */
void hpr_reconstruct_point(const hpr_solution *solution, size_t patch, double s, double t,
                           double *irradiance);

#endif
