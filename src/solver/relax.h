/* One Gauss-Seidel sweep over the patches, and what it changed: the step of which the iterations are made. */
#ifndef HPR_SOLVER_RELAX_H
#define HPR_SOLVER_RELAX_H

#include "solver/linear.h"
#include "solver/operator.h"

typedef struct hpr_bright_patch {
    double power; /* |rho D|^2 */
    uint32_t patch;
} hpr_bright_patch;

typedef struct hpr_relaxation {
    hpr_linear_problem *problem;
    const hpr_elements *elements;
    hpr_context *context;
    hpr_operator *op;
    size_t dofs;
    double *reflected;       /* [channels][dofs] */
    double *fresh;           /* [channels][dofs] the newest irradiance */
    hpr_bright_patch *order; /* [patches] the brightest first */
    double *change2, *norm2; /* [channels][leaves] squares, summed in leaf order afterwards */
    bool by_patch;           /* changes are those of hpr_relaxation_worst_patch */
} hpr_relaxation;

hpr_status hpr_relaxation_init(hpr_relaxation *relaxation, hpr_linear_problem *problem);
void hpr_relaxation_fini(hpr_relaxation *relaxation);

/* The change of the last pass on the patch where it is largest, relative to what that patch itself has. */
double hpr_relaxation_worst_patch(const hpr_relaxation *relaxation);

/* reflected = rho x on a patch. */
void hpr_relaxation_reflect(hpr_relaxation *relaxation, size_t patch, const double *x);

/*
 * One sweep in place: patch after patch, the brightest first, x = P (D + K rho x), P the projection to open
 * parts; source false: without D. One block is one patch: its leaves do not see each other. x
 * [channels][dofs]. Returns the relative change of the worst channel. Source: Gortler, Cohen & Slusallek
 * 1994.
 */
double hpr_relaxation_sweep(hpr_relaxation *relaxation, double *x, bool source);

/* All patches at once: fresh = P (D + K rho x), and x is left alone unless `update`. Returns the relative
 * change, which is the residual of x. */
double hpr_relaxation_gather(hpr_relaxation *relaxation, double *x, bool update);

#endif
