#ifndef HPRAD_BASELINE_H
#define HPRAD_BASELINE_H

#include <hprad/solve.h>

#ifdef __cplusplus
extern "C" {
#endif

/*
 * The classical methods: one constant per element, the full matrix of form factors between elements, solved
 * by elimination, by gathering or by shooting. They are here to be compared with, on the same patches and
 * elements as hprad's own.
 */

enum { HPR_DEFAULT_HEMICUBE = 256, HPR_MAX_HEMICUBE = 4096, HPR_DEFAULT_RAYS = 2, HPR_MAX_RAYS = 64 };

/** What the classical methods ask for beside hpr_solve_options. */
typedef struct hpr_baseline_options {
    int hemicube; /**< pixels along an edge of the cube, even, 2 .. HPR_MAX_HEMICUBE */
    int rays;     /**< of ray casting: N x N discs per sender, 1 .. HPR_MAX_RAYS */
    int shots;    /**< shooting ends after so many, converged or not; 0: when it has converged */
    int every;    /**< `shot` is called after so many shots; 0: never */
    /** The solution so far; read-only, valid during the call. What it returns other than HPR_OK ends the
     * solve. */
    hpr_status (*shot)(void *user, const hpr_solution *solution, int shots);
    void *user;
} hpr_baseline_options;

HPR_API void hpr_baseline_options_init(hpr_baseline_options *options);

/**
 * Solves a scene by options->method. HPR_METHOD_GALERKIN and HPR_METHOD_HIERARCHICAL: hpr_solve. Else
 *   H_i = sum_j F_ij (M_j + rho_j H_j)
 * over the leaves of the elements, F_ij the part of what leaves i that reaches j, and
 *   HPR_METHOD_HEMICUBE  what five faces around the centre of i show of j, pixel by pixel; casts no ray
 *                        (Cohen & Greenberg 1985);
 *   HPR_METHOD_RAYCAST   from the centre of i to rays x rays discs of j, each of an equal share a of its
 *                        area, past what a shadow ray meets: sum of a cosθi cosθj / (pi r² + a) (Wallace,
 *                        Elmquist & Haines 1989);
 *   HPR_METHOD_EXACT     the mean over i, as hprad integrates it, to options->block_tolerance (0: 1e-6).
 * options->solver is HPR_SOLVER_AUTO (Gauss-Seidel), HPR_SOLVER_GAUSS_SEIDEL, HPR_SOLVER_GATHERING (Jacobi),
 * HPR_SOLVER_SHOOTING (Cohen, Chen, Wallace & Greenberg 1988; without their ambient term; summary.sweeps
 * counts the shots) or HPR_SOLVER_DIRECT (elimination with pivoting). Order and feet that are HPR_CHOOSE
 * become 0. max_sweeps counts passes over all elements, of shooting as many shots as there are elements. In
 * the result direct light is in the coefficients, and of the energy terms lost_on_backs and escaped are NaN,
 * for the matrix does not tell them apart. Same bits for any thread count.
 * `baseline` may be NULL: defaults. Errors: HPR_ERR_ARG (options out of range, or of no effect with the
 * method), HPR_ERR_UNSUPPORTED (light from outside), HPR_ERR_MEMORY, HPR_ERR_DEVICE, HPR_ERR_NUMERIC (no
 * convergence, or a singular matrix), HPR_ERR_INTERRUPTED.
 */
HPR_API hpr_status hpr_baseline_solve(hpr_context *context, const hpr_scene *scene,
                                      const hpr_solve_options *options, const hpr_baseline_options *baseline,
                                      hpr_solution **solution);

#ifdef __cplusplus
}
#endif

#endif
