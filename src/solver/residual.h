/*
 * How far a solution is from what its own radiosity sends to its points: ‖H~ - H‖ with H~ = D + K rho H,
 * light from outside counted with D. H is the projection of H~, so K of the difference is small, and ‖H~ - H‖
 * is the error of H to leading order. Source: Sloan 1976; Atkinson 1997, ch. 3.
 */
#ifndef HPR_SOLVER_RESIDUAL_H
#define HPR_SOLVER_RESIDUAL_H

#include "solver/indicator.h"
#include "solver/transport.h"

typedef struct hpr_residual {
    double error2;          /* square of the relative error, the worst channel's */
    double standard_error2; /* of error2, from the choice of the points */
} hpr_residual;

/*
 * Measured at points of random leaves, more of them where `indicator` says that more is left out:
 * error2 = 1/count sum_i (H~ - H)^2 / (p_i norm2), p_i the density of the points. indirect [dofs][channels]
 * as for hpr_indicate, norm2 [channels] square of the norm of H. tolerance: of the integrals over senders.
 * Raises indicator's error2 of leaves where the points show more than it says. Errors: HPR_ERR_MEMORY,
 * HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED. Same bits for any thread count.
 */
hpr_status hpr_residual_measure(const hpr_solution *solution, const hpr_transport *transport,
                                const double *indirect, const double *norm2, double tolerance, size_t count,
                                hpr_indicator *indicator, hpr_residual *residual);

#endif
