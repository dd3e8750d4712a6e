/*
 * What the elements reflect: B = rho H. Where rho is constant on a patch the coefficients of B are rho times
 * those of H. Where it has a texture they are the projection of rho times the polynomial, by a matrix of the
 * element's,
 *   B_k = sum_l M_kl H_l,   M_kl = ∫ T_k rho T_l dA
 * in each channel; light straight from lamps takes part by its own coefficients. Weights are positive and
 * rules exact for T_k T_l, or next to it where there are many texels: so with 0 <= rho <= 1 the eigenvalues
 * of M lie there too, as those of rho do. Of a leaf in part covered M is G+ times the integral over what is
 * open (link/coverage.h). What a patch with an emissive texture emits is projected by the same rules.
 */
#ifndef HPR_SOLVER_MASS_H
#define HPR_SOLVER_MASS_H

#include "link/coverage.h"

typedef struct hpr_mass {
    const hpr_patches *patches;   /* borrowed */
    const hpr_elements *elements; /* borrowed */
    size_t channel_count;
    size_t *at;    /* [leaves] where its matrices begin, SIZE_MAX: rho is constant on it; NULL: on all */
    double *block; /* [channels][n][n] of one leaf after the other */
    double *glow;  /* [channels][dofs] of M less its mean over the patch; NULL: M is constant on all */
} hpr_mass;

/*
 * The matrices, integrated over the texels of which a leaf shows up to 32 by 32, else over as many cells of
 * several texels each, sampled at points. patches and elements must outlive it. Fini it in any case. Same
 * bits for any thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_mass_init(const hpr_patches *patches, const hpr_elements *elements,
                         const hpr_coverage *coverage, hpr_mass *mass);
void hpr_mass_fini(hpr_mass *mass);

/* Does rho or M vary on the leaf? */
bool hpr_mass_varies(const hpr_mass *mass, size_t leaf);

/*
 * radiosity = rho irradiance on a leaf, in one channel; coefficient k of both stands at index k * stride;
 * they must not overlap. Thread-safe.
 */
void hpr_mass_reflect(const hpr_mass *mass, size_t leaf, size_t channel, size_t stride,
                      const double *irradiance, double *radiosity);

/* Does M vary on the leaf? */
bool hpr_mass_glows(const hpr_mass *mass, size_t leaf);

/* radiosity += M on a leaf, in one channel. Thread-safe. */
void hpr_mass_emit(const hpr_mass *mass, size_t leaf, size_t channel, double *radiosity);

/* The same less the mean of M over the patch, with a stride; nothing where M is constant. */
void hpr_mass_ripple(const hpr_mass *mass, size_t leaf, size_t channel, size_t stride, double *radiosity);

#endif
