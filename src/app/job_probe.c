/* Solution file and table of points -> table of irradiance and radiosity. */
#include "app/job.h"
#include "io/csv_points.h"
#include "solver/solution.h"

#include <string.h>

/* The points and what is found there. */
typedef struct probe {
    size_t count;
    double *point, *normal;         /* [count][3] */
    double *irradiance, *radiosity; /* [count][channels] */
    uint32_t *patch;                /* [count] */
} probe;

void hpr_job_probe_options_init(hpr_job_probe_options *options)
{
    *options = (hpr_job_probe_options){0};
}

static void release_probe(hpr_context *ctx, probe *p)
{
    hpr_release(ctx, p->point);
    hpr_release(ctx, p->normal);
    hpr_release(ctx, p->irradiance);
    hpr_release(ctx, p->radiosity);
    hpr_release(ctx, p->patch);
    *p = (probe){0};
}

/* The table first: it is small, and a mistake in it should show before a large solution is read. */
static hpr_status read_inputs(hpr_job *job, const char *solution_path, const char *points_path, probe *p,
                              hpr_solution **solution)
{
    hpr_context *ctx = job->context;
    hpr_status status = hpr_job_enter(job, HPR_JOB_READ);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(ctx, "read");
    status = hpr_points_read(ctx, points_path, &p->count, &p->point, &p->normal);
    if (status == HPR_OK)
        status = hpr_solution_read(ctx, solution_path, solution);
    hpr_stage_end(ctx);
    return status;
}

static hpr_status evaluate(hpr_job *job, const hpr_solution *solution, bool gather, probe *p)
{
    hpr_context *ctx = job->context;
    size_t channels = solution->channel_count;
    hpr_status status = hpr_job_enter(job, HPR_JOB_RENDER);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &p->irradiance, p->count, channels * sizeof(double), "irradiance");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &p->radiosity, p->count, channels * sizeof(double), "radiosity");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &p->patch, p->count, sizeof *p->patch, "patches of points");
    if (status == HPR_OK)
        status = (gather ? hpr_solution_gather : hpr_solution_probe)(
            ctx, solution, p->count, p->point, p->normal, p->irradiance, p->radiosity, p->patch);
    if (status != HPR_OK)
        return status;
    job->result->summary = solution->summary;
    job->result->point_count = p->count;
    for (size_t i = 0; i < p->count; i++)
        job->result->matched_count += p->patch[i] != HPR_NONE;
    return HPR_OK;
}

/* `path` NULL: standard output. */
static hpr_status write_table(hpr_job *job, const hpr_solution *solution, const probe *p, const char *path)
{
    hpr_probe_table table = {.count = p->count,
                             .channel_count = solution->channel_count,
                             .channel_name = (const char *const *)solution->channel_name,
                             .point = p->point,
                             .normal = p->normal,
                             .irradiance = p->irradiance,
                             .radiosity = p->radiosity,
                             .patch = p->patch};
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status == HPR_OK)
        status = hpr_probe_write(job->context, &table, path);
    if (status == HPR_OK && path)
        hpr_job_wrote(job, &(hpr_job_file){.kind = HPR_JOB_FILE_TABLE, .path = path});
    return status;
}

hpr_status hpr_job_probe(hpr_context *ctx, const char *solution_path, const char *points_path,
                         const hpr_job_probe_options *options, hpr_job_result *result)
{
    hpr_job_probe_options chosen;
    hpr_job_probe_options_init(&chosen);
    if (options)
        chosen = *options;
    if (chosen.output_path && !strcmp(chosen.output_path, "-"))
        chosen.output_path = NULL;
    hpr_job job;
    hpr_job_begin(&job, ctx, &chosen.events, result);
    hpr_solution *solution = NULL;
    probe p = {0};
    hpr_outputs_input(&job.outputs, solution_path);
    hpr_outputs_input(&job.outputs, points_path);
    hpr_status status = HPR_OK;
    if (chosen.output_path)
        status = hpr_outputs_claim(&job.outputs, chosen.output_path);
    if (status == HPR_OK)
        status = read_inputs(&job, solution_path, points_path, &p, &solution);
    if (status == HPR_OK)
        status = evaluate(&job, solution, chosen.gather, &p);
    if (status == HPR_OK)
        status = write_table(&job, solution, &p, chosen.output_path);
    release_probe(ctx, &p);
    hpr_solution_destroy(&solution);
    return hpr_job_end(&job, status);
}
