/* Light transport on given elements: links, the moments of direct light, the linear system, the energy. */
#ifndef HPR_SOLVER_TRANSPORT_H
#define HPR_SOLVER_TRANSPORT_H

#include "link/coverage.h"
#include "link/links.h"
#include "solver/mass.h"
#include "solver/solution.h"

/* How exact its parts are; relative. */
typedef struct hpr_transport_demand {
    double link_tolerance, block_tolerance, blocked_tolerance; /* 0: chosen (link/links.h) */
    double direct_tolerance;                                   /* of the moments of direct light, */
    double open_direct_tolerance;                              /* where nothing blocks it */
    double solver_tolerance;
    const hpr_block_keeper *keeper; /* or NULL */
    const hpr_links *known;         /* of the elements before they were refined (link/links.h), or NULL */
} hpr_transport_demand;

typedef struct hpr_transport {
    hpr_coverage *coverage;
    hpr_links *links;
    const hpr_block_keeper *keeper; /* borrowed; or NULL */
    hpr_mass mass;
    double *direct; /* [channels][dofs] coefficients of what is evaluated at points: D, or the like */
    double *glow;   /* [channels][dofs] of what textured emitters send through the blocks, where the others' D
                       is evaluated; NULL: there are none */
    double *outside; /* [dofs] moments of V, the open part of the view */
} hpr_transport;

/*
 * solution->irradiance is the whole H after it, from zero; solution->surroundings and the summary's figures
 * are filled. transport: to be closed by hpr_transport_fini, also after a failure. Same bits for any thread
 * count. Errors: HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_NUMERIC (no convergence), HPR_ERR_INTERRUPTED.
 */
hpr_status hpr_transport_solve(hpr_solution *solution, const hpr_transport_demand *demand,
                               hpr_transport *transport);

/* The energy terms, and then solution->irradiance without what is evaluated at points. Errors as above. */
hpr_status hpr_transport_finish(hpr_solution *solution, const hpr_transport *transport);

/*
 * What there was before hpr_transport_finish, of a solution that is finished: its irradiance becomes the
 * whole H again; but the links have no blocks, and their errors are not known. Only the tolerances of links
 * and of direct light matter. transport and errors as above.
 */
hpr_status hpr_transport_restore(hpr_solution *solution, const hpr_transport_demand *demand,
                                 hpr_transport *transport);

/* The links of hpr_transport_solve without their blocks, and the coverage that they borrow; nothing is
 * integrated. transport as above. Errors as above. */
hpr_status hpr_transport_count(const hpr_solution *solution, const hpr_transport_demand *demand,
                               hpr_transport *transport);

void hpr_transport_fini(hpr_transport *transport);

#endif
