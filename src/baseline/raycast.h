/*
 * Form factors by ray casting (Wallace, Elmquist & Haines 1989): the sender is cut into small pieces, each a
 * disc that is seen or not, as a shadow ray to its middle says.
 */
#ifndef HPR_BASELINE_RAYCAST_H
#define HPR_BASELINE_RAYCAST_H

#include "patch/rows.h"

/*
 * factor [rows][rows], row-major, of rows that are one patch each; zero on entry:
 *   F_ij = sum over the n x n pieces k of j, of area a = A_j / n^2 each, V_k a cosθ_i cosθ_k / (pi r_k^2 +
 * a), from the centre of i. Rays are cast only where something may come between i and j, as the solver finds
 * it too. Runs in parallel, the same bits for any number of threads. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE,
 * HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_raycast_factors(const hpr_rows *rows, int n, double *factor, bool *blocked);

#endif
