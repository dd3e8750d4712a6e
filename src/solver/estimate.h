/* The estimated error of a solution, from what it leaves out of its own transport. */
#ifndef HPR_SOLVER_ESTIMATE_H
#define HPR_SOLVER_ESTIMATE_H

#include "solver/indicator.h"
#include "solver/transport.h"

typedef struct hpr_estimate {
    hpr_context *context;
    double *indirect;         /* [dofs][channels] what the basis carries */
    double *norm2;            /* [channels] square of the norm of the whole H */
    hpr_indicator *indicator; /* [leaf_count] where it comes from */
    double indicated;         /* root of the sum of the indicator's error2 */
} hpr_estimate;

/*
 * Fills summary.error_estimate and error_parts of a solution that hpr_transport_solve has made, and its error
 * per element: the element's share, by the indicator, of what the elements leave out. tolerance: of the
 * irradiance, relative; the integrals are a hundred times as exact. estimate: to be closed by
 * hpr_estimate_fini, also after a failure, or if it is all zero. Stage "error estimate". Same bits for any
 * thread count. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_estimate_init(hpr_solution *solution, const hpr_transport *transport, double tolerance,
                             hpr_estimate *estimate);
void hpr_estimate_fini(hpr_estimate *estimate);

#endif
