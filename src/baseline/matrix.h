/* The classical radiosity system on a full matrix, H = F (M + rho H), and the ways to solve it. */
#ifndef HPR_BASELINE_MATRIX_H
#define HPR_BASELINE_MATRIX_H

#include "base/context.h"

#include <hprad/solve.h>

typedef struct hpr_matrix_problem {
    /* in */
    hpr_context *context;
    size_t count, channel_count;
    const double *factor;      /* [count][count] row-major: F_ij, what leaves i that reaches j */
    const double *area_m2;     /* [count] */
    const double *reflectance; /* [channel_count][count] */
    const double *exitance;    /* [channel_count][count] M, W/m2 */
    hpr_solver_method method;  /* none but auto, gauss-seidel, gathering, shooting, direct */
    double tolerance;          /* on the estimated relative error of H: the worst channel's */
    int max_sweeps;            /* a sweep of shooting is as many shots as there are elements */
    int shots;                 /* of shooting: the end after so many; 0: on convergence */
    int every;                 /* `shot` is called after so many shots; 0: never */
    hpr_status (*shot)(void *user, int shots);
    void *user;
    /* out */
    double *irradiance; /* [channel_count][count] H, W/m2 */
    int sweeps;         /* passes over the matrix; shots; 0 of elimination */
    hpr_solver_method used;
    double residual; /* |F (M + rho H) - H| / |H|, area-weighted L2, worst channel, computed afresh */
} hpr_matrix_problem;

/*
 * Gathering is Jacobi's method, Gauss-Seidel takes new values as they come; both start from H = 0. Shooting
 * starts from M unshot: the element with the most unshot power, A dB summed over the channels, adds
 * F_ji dB_i to every H_j and rho_j times that to what j has unshot (Cohen, Chen, Wallace & Greenberg 1988);
 * it ends when what is unshot cannot change H by more than the tolerance. Same bits for any thread count.
 * Errors: HPR_ERR_NUMERIC (max_sweeps reached, or a singular matrix), HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED,
 * and what `shot` returns.
 */
hpr_status hpr_matrix_solve(hpr_matrix_problem *problem);

#endif
