/*
 * Light from outside: the environment sends the same radiance L from all directions, so that a point receives
 *   D(x) = pi L V(x),   V(x) = 1/pi ∫ cosθ [nothing is met in the direction ω] dω over the hemisphere,
 * V the open part of its view, weighted by the cosine; 1 in the open.
 */
#ifndef HPR_DIRECT_ENVIRONMENT_H
#define HPR_DIRECT_ENVIRONMENT_H

#include "direct/visible.h"
#include "patch/elements.h"
#include "visibility/visibility.h"

typedef struct hpr_environment hpr_environment;

/* Borrows patches and elements. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE. */
hpr_status hpr_environment_create(const hpr_patches *patches, const hpr_elements *elements,
                                  hpr_environment **environment);
void hpr_environment_destroy(hpr_environment **environment);

/* True if V can be clipped at every point: there are few enough occluders. Else it is sampled, and D goes
 * through the basis. */
bool hpr_environment_affordable(const hpr_environment *environment);

const hpr_visibility *hpr_environment_visibility(const hpr_environment *environment);

/* V at a point, and a bound on its error beside rounding. */
typedef struct hpr_opening {
    double part, error;
} hpr_opening;

/*
 * V at a point of a patch, only if affordable. The view is cut into cones until few occluders are left in
 * each, and there what they hide is clipped away: exact to rounding (V < 1e-12 is 0). Where that takes more
 * than a few thousand cones, the rest of them is decided at their middles, and their size is the error.
 * Never allocates; concurrent calls allowed. Source: Warnock 1969, on the sphere; Lambert's formula.
 */
hpr_opening hpr_environment_opening(const hpr_environment *environment, size_t patch, hpr_vec3 point);

/*
 * V by 4 * side * side cosine-weighted rays (Malley's map of four golden-ratio lattices, each shifted by a
 * hash of `seed`); error: the standard error that the four give. Concurrent calls allowed.
 */
hpr_opening hpr_environment_sample(const hpr_environment *environment, size_t patch, hpr_vec3 point, int side,
                                   uint64_t seed);

/*
 * Moves (s,t) of a leaf a little toward its middle if an occluder out of the leaf's plane touches the point
 * there: V jumps at such points, and this gives the limit from inside. A little is a millionth of the leaf,
 * or what brings the point out of reach of corners that welding has moved. Only if affordable. Concurrent
 * calls allowed.
 */
void hpr_environment_limit(const hpr_environment *environment, size_t leaf, double *s, double *t);

/* The outlines of what blocks, [*count]; borrowed. */
const hpr_convex *hpr_environment_outlines(const hpr_environment *environment, size_t *count);

#endif
