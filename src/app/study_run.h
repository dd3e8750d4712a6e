/* One run of a study: solved, timed, counted. */
#ifndef HPR_APP_STUDY_RUN_H
#define HPR_APP_STUDY_RUN_H

#include "base/context.h"

#include <hprad/study.h>

/*
 * Solves the scene as `run` and the options say, options->repeats times, and once before that if that is more
 * than one. Fills `row` but for its errors; *solution is that of the last time. Errors: those of
 * hpr_baseline_solve.
 */
hpr_status hpr_study_solve(hpr_context *ctx, const hpr_scene *scene, const hpr_job_study_options *options,
                           const hpr_study_run *run, hpr_study_row *row, hpr_solution **solution);

#endif
