/* The ways to solve the system that hpr_linear_solve chooses from. Each sets problem->sweeps. */
#ifndef HPR_SOLVER_ITERATIONS_H
#define HPR_SOLVER_ITERATIONS_H

#include "solver/relax.h"

/* How an iteration ended. */
typedef enum hpr_iteration_end {
    HPR_ITERATION_DONE,
    HPR_ITERATION_SLOW,       /* Gauss-Seidel, if allowed to give up: it would take long */
    HPR_ITERATION_STANDSTILL, /* the changes do not fall */
    HPR_ITERATION_LIMIT,      /* max_sweeps */
    HPR_ITERATION_CANCELLED
} hpr_iteration_end;

typedef struct hpr_iteration {
    hpr_iteration_end end;
    double change; /* relative, of the last step */
    double ratio;  /* of the last two changes */
} hpr_iteration;

/*
 * Repeats `step` (a sweep of hpr_relaxation_sweep, or hpr_relaxation_gather: gathering, Jacobi's method)
 * until the error estimated from the last two changes, |change| q / (1 - q) with q their ratio, is within
 * tolerance or the changes are at rounding. gives_up: ends as HPR_ITERATION_SLOW after a few steps if many
 * more are foreseen. Source of the estimate: Golub & Van Loan 2013, 11.2.
 */
typedef double hpr_relaxation_step(hpr_relaxation *relaxation, double *x, bool flag);
hpr_iteration hpr_iterate(hpr_relaxation *relaxation, hpr_relaxation_step *step, bool gives_up);

/*
 * GMRES on x = S(x), S a Gauss-Seidel sweep: the system preconditioned by it, one application of the operator
 * per iteration; a Krylov space of its own for each channel. ratio: of the changes of a sweep, near 1 where
 * an error is much larger than the change that shows it. Source: Saad & Schultz 1986; Saad 2003, 6.5 and 9.3.
 */
hpr_status hpr_gmres(hpr_relaxation *relaxation, double ratio, hpr_iteration *iteration);

/*
 * Progressive refinement: the patch with the most unshot power is shot through its links, again and again
 * (Southwell's method). Source: Cohen, Chen, Wallace & Greenberg 1988; Gortler, Cohen & Slusallek 1994.
 */
hpr_status hpr_shoot(hpr_relaxation *relaxation, hpr_iteration *iteration);

#endif
