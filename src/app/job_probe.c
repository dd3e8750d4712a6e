/* Solution file and table of points -> table of irradiance and radiosity. */
#include "app/job.h"

#include <string.h>

void hpr_job_probe_options_init(hpr_job_probe_options *options)
{
    *options = (hpr_job_probe_options){0};
}

hpr_status hpr_job_probe(hpr_context *ctx, const char *solution_path, const char *points_path,
                         const hpr_job_probe_options *options, hpr_job_result *result)
{
    (void)solution_path;
    (void)points_path;
    hpr_job job;
    hpr_job_begin(&job, ctx, &options->events, result);
    return hpr_job_end(&job, HPR_ERR_UNSUPPORTED);
}
