/* What a solution is before it is solved: names, cameras, patches, elements. */
#ifndef HPR_SOLVER_SETUP_H
#define HPR_SOLVER_SETUP_H

#include "scene/scene.h"
#include "solver/solution.h"

/* Names, channels and light from outside. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_setup_describe(hpr_solution *solution, const hpr_scene *scene);

/* Patches, and the elements that summary.options ask for; what they leave open is chosen. Errors:
 * HPR_ERR_MEMORY, HPR_ERR_DEVICE. */
hpr_status hpr_setup_elements(hpr_solution *solution, const hpr_scene *scene);

/* The arrays that depend on the elements, zeroed (error: NaN), and the summary's counts; again after every
 * change of the elements. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_setup_arrays(hpr_solution *solution);

/* The scene's cameras, or one that frames it. Errors: HPR_ERR_MEMORY. */
hpr_status hpr_setup_cameras(hpr_solution *solution, const hpr_scene *scene);

#endif
