/* Which solves a study consists of. */
#ifndef HPR_APP_STUDY_GRID_H
#define HPR_APP_STUDY_GRID_H

#include "base/context.h"

#include <hprad/study.h>

/*
 * The runs in the order in which they are made, none twice: by method, direct light, order, then subdivision,
 * rising, so that a row comes after the one with a subdivision less; then adaptive ones, by way and
 * tolerance. Of constant methods order 0 only, of classical ones the first kind of direct light only. *run:
 * to be released with hpr_release. Errors: HPR_ERR_ARG (a list that is empty, nothing to refine, a tolerance
 * out of bounds, or of methods that cannot adapt), HPR_ERR_MEMORY.
 */
hpr_status hpr_study_plan(hpr_context *ctx, const hpr_job_study_options *options, size_t *count,
                          hpr_study_run **run);

/* About how long a run takes beside others: what every run takes, and the power 1.5 of the coefficients. */
double hpr_study_weight(const hpr_study_run *run);

#endif
