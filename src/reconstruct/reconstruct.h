/* The solution at points: the polynomials, and with exact direct light what each emitter sends to the very
 * point. */
#ifndef HPR_RECONSTRUCT_RECONSTRUCT_H
#define HPR_RECONSTRUCT_RECONSTRUCT_H

#include "direct/direct.h"
#include "direct/environment.h"
#include "link/coverage.h"
#include "solver/solution.h"

typedef struct hpr_reconstruction {
    const hpr_solution *solution; /* borrowed */
    hpr_direct *direct;           /* NULL: direct light is in the coefficients */
    hpr_environment *environment; /* NULL: light from outside is, or there is none */
    hpr_coverage *coverage;
} hpr_reconstruction;

/* Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_UNSUPPORTED (a file whose environment has more before it
 * than is clipped at points). */
hpr_status hpr_reconstruction_init(const hpr_solution *solution, hpr_reconstruction *reconstruction);
void hpr_reconstruction_fini(hpr_reconstruction *reconstruction);

/*
 * H at the point (s,t) of a patch, W/m2: sum_k irradiance[k] T_k of the leaf that holds it, plus D there; 0
 * where the patch is covered. Where surfaces touch D is the limit from inside the leaf. With exact direct
 * light what is not D, the indirect part, is not let below 0. irradiance: [channels]. Never allocates;
 * concurrent calls allowed.
 */
void hpr_reconstruct_point(const hpr_reconstruction *reconstruction, size_t patch, double s, double t,
                           double *irradiance);

/* The same, bit for bit, and indirect [channels]: what of it does not come straight from lamps or outside,
 * where the solution keeps that apart (hpr_reconstruct_parted). */
void hpr_reconstruct_parts(const hpr_reconstruction *reconstruction, size_t patch, double s, double t,
                           double *irradiance, double *indirect);

/* Whether direct light, of lamps and from outside, is evaluated at points, all of it. */
bool hpr_reconstruct_parted(const hpr_reconstruction *reconstruction);

#endif
