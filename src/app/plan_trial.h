/* The first step of a small scene, solved to learn how far it is off and how fast this machine is. */
#ifndef HPR_APP_PLAN_TRIAL_H
#define HPR_APP_PLAN_TRIAL_H

#include "app/plan_look.h"

/* What the step's blocks are integrated for: exact enough for its own error to show. */
static const double hpr_plan_trial_tolerance = 1e-2;

/*
 * Fills trial_error, trial_cpu_s and slowness of the outlook, if there is light and the first step of a
 * tolerance has at most 600 coefficients: it is solved twice (once, if it takes over 0.2 s). options: of the
 * plan. Errors: those of hpr_solve.
 */
hpr_status hpr_plan_try(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                        const hpr_plan *plan, hpr_outlook *outlook);

#endif
