/* What a run of `formfactors` did and cost, as JSON. The README lists the keys. */
#ifndef HPR_IO_FACTORS_REPORT_H
#define HPR_IO_FACTORS_REPORT_H

#include "base/context.h"

typedef struct hpr_factors_report {
    const char *model_path;
    double tolerance;
    int order; /* -1: view factors */
    size_t row_count, pair_count, blocked_count, rounded_count, short_count;
    size_t outside_count;  /* view factors outside [0, 1] by more than 1e-14 */
    double relative_error; /* largest estimated of a pair, relative to its largest entry; */
    double sampled_error;  /* the same of those past sampled blockers */
    bool closed;           /* the model says so */
    double closure_defect;
} hpr_factors_report;

/* Errors: HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. */
hpr_status hpr_factors_report_write(hpr_context *ctx, const hpr_factors_report *report, const char *path);

#endif
