/*
 * What the radiosity of a solution sends to single points, each by integrals of its own and not through the
 * polynomials of the element that it lies on: Sloan's iterate H~ = D + K rho H. Source: Sloan 1976.
 */
#ifndef HPR_SOLVER_ARRIVALS_H
#define HPR_SOLVER_ARRIVALS_H

#include "link/spots.h"
#include "solver/transport.h"

typedef struct hpr_arrivals_task {
    const hpr_solution *solution; /* its irradiance is the whole H */
    const hpr_transport *transport;
    double tolerance; /* of the integral over each node, relative */
    size_t count;
    const hpr_spot *spot; /* [count] */
    uint32_t call;        /* by which the transport's keeper knows it */
} hpr_arrivals_task;

/* irradiance [count][channels] = K (rho H + M), M only as far as it goes through the basis. Errors:
 * HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_INTERRUPTED. Same bits for any thread count. */
hpr_status hpr_arrivals_gather(const hpr_arrivals_task *task, double *irradiance);

/*
 * irradiance += what the basis carries of the light that comes straight from outside: pi L V if that goes
 * through it; if it is evaluated at points and `surroundings` is set, S V (solver/outside.h). Errors as
 * above.
 */
hpr_status hpr_arrivals_add_outside(const hpr_arrivals_task *task, bool surroundings, double *irradiance);

#endif
