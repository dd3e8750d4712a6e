/* The solution: everything that is needed to show or probe it, owned. Read-only once it is made. */
#ifndef HPR_SOLVER_SOLUTION_H
#define HPR_SOLVER_SOLUTION_H

#include "patch/elements.h"

#include <hprad/solve.h>

struct hpr_solution {
    hpr_context *context;
    char *scene_name; /* file name of the scene without folders */
    size_t channel_count;
    char **channel_name; /* [channel_count] */
    double *environment; /* [channel_count] radiance from outside, W/m2/sr; NULL: none */
    hpr_patches *patches;
    hpr_elements *elements;
    /* [dofs][channels] coefficients of H without what is evaluated at points: D of lamps if summary.direct is
     * HPR_DIRECT_EXACT, (pi L - S) V if summary.environment is HPR_ENVIRONMENT_EXACT, V the open part of the
     * view; H(x) = sum_k irradiance[k] T_k(x) + ..., so that a coefficient has the unit W/m2 times metre */
    double *irradiance;
    double *surroundings; /* [patches][channels] S, W/m2: about how bright is what shuts a patch's view */
    double *error; /* [leaf_count] estimated L2 error of H on the element, W/m2 times metre; NaN: unknown */
    size_t camera_count;
    hpr_camera *camera; /* [camera_count], at least one: a scene without gets one that frames it */
    hpr_energy *energy; /* [channel_count] */
    hpr_solve_summary summary;
};

/*
 * A solution of a scene that is yet to be solved: names, cameras, patches, elements of order, subdivision,
 * grading and feet as the options say, coefficients zero. options: borrowed for the call, copied into the
 * summary. Stage "mesh". Errors: HPR_ERR_ARG, HPR_ERR_MEMORY, HPR_ERR_DEVICE.
 */
hpr_status hpr_solution_begin(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                              hpr_solution **solution);

/* Channels that differ: 1 if all agree in what is emitted, reflected and comes from outside, else their
 * number. */
size_t hpr_solution_distinct_channels(const hpr_solution *solution);

/* Is there something to solve? Else that is warned about, and the zero solution is the answer. */
bool hpr_solution_lit(const hpr_solution *solution, const hpr_scene *scene);

#endif
