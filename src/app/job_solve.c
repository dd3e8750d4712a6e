/* Scene file -> solution file. */
#include "app/checkpoint.h"
#include "app/job.h"
#include "app/names.h"

#include <stdio.h>

void hpr_job_solve_options_init(hpr_job_solve_options *options)
{
    *options = (hpr_job_solve_options){0};
    hpr_read_options_init(&options->read);
    hpr_solve_options_init(&options->solve);
    hpr_baseline_options_init(&options->baseline);
}

static hpr_status claim_outputs(hpr_job *job, const char *scene_path, const char *solution_path,
                                const hpr_job_solve_options *options)
{
    hpr_outputs_input(&job->outputs, scene_path);
    hpr_status status = hpr_outputs_claim(&job->outputs, solution_path);
    if (status == HPR_OK && options->report_path)
        status = hpr_outputs_claim(&job->outputs, options->report_path);
    if (status == HPR_OK && options->resume_path)
        status = hpr_outputs_spare(&job->outputs, options->resume_path);
    if (status != HPR_OK || !options->checkpoint_path)
        return status;
    status = hpr_outputs_claim(&job->outputs, options->checkpoint_path); /* may be what is resumed */
    char *blocks = hpr_block_log_path(job->context, options->checkpoint_path);
    if (status == HPR_OK)
        status = blocks ? hpr_outputs_claim(&job->outputs, blocks)
                        : hpr_fail(job->context, HPR_ERR_MEMORY, "out of memory for a file name");
    hpr_release(job->context, blocks);
    return status;
}

/* Solves, as a series that can be taken up again if that is asked for. */
static hpr_status solve(hpr_job *job, const char *scene_path, const hpr_scene *scene,
                        const hpr_job_solve_options *options, const hpr_baseline_options *baseline,
                        hpr_solution **solution)
{
    if (!options->checkpoint_path && !options->resume_path)
        return hpr_job_run_solve(job, scene, &options->solve, baseline, NULL, solution);
    hpr_checkpoint checkpoint;
    hpr_status status = hpr_checkpoint_open(job->context, scene_path, options, &checkpoint);
    if (status == HPR_OK && options->resume_path)
        status = hpr_checkpoint_read(&checkpoint, options->resume_path);
    if (status == HPR_OK)
        status = hpr_checkpoint_begin(&checkpoint);
    const hpr_block_keeper keeper = {hpr_block_log_keep, hpr_block_log_find, &checkpoint.log};
    const hpr_solve_series series = {.done = checkpoint.done,
                                     .done_count = checkpoint.done_count,
                                     .stepped = hpr_checkpoint_write,
                                     .user = &checkpoint,
                                     .blocks = &keeper};
    if (status == HPR_OK)
        status = hpr_job_run_solve(job, scene, &options->solve, NULL, &series, solution);
    hpr_checkpoint_close(&checkpoint);
    return status;
}

static hpr_status write_solution(hpr_job *job, const hpr_solution *solution, const char *path)
{
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(job->context, "write");
    status = hpr_solution_write(job->context, solution, path);
    hpr_stage_end(job->context);
    if (status == HPR_OK)
        hpr_job_wrote(job, &(hpr_job_file){.kind = HPR_JOB_FILE_SOLUTION, .path = path});
    return status;
}

typedef struct progressive {
    hpr_job *job;
    const char *path; /* of the solution in the end */
} progressive;

/* Keeps what shooting has reached. */
static hpr_status keep_shot(void *user, const hpr_solution *solution, int shots)
{
    const progressive *p = user;
    char tail[32];
    snprintf(tail, sizeof tail, "_%06d.glb", shots);
    char *path = hpr_name_beside(p->job->context, p->path, tail);
    hpr_status status = path ? hpr_outputs_claim(&p->job->outputs, path)
                             : hpr_fail(p->job->context, HPR_ERR_MEMORY, "out of memory for a file name");
    if (status == HPR_OK)
        status = write_solution(p->job, solution, path);
    hpr_release(p->job->context, path);
    return status == HPR_OK ? hpr_job_enter(p->job, HPR_JOB_SOLVE) : status;
}

hpr_status hpr_job_solve(hpr_context *ctx, const char *scene_path, const hpr_job_solve_options *options,
                         hpr_job_result *result)
{
    hpr_job_solve_options defaults;
    hpr_job_solve_options_init(&defaults);
    if (!options)
        options = &defaults;
    hpr_job job;
    hpr_job_begin(&job, ctx, &options->events, result);
    hpr_scene *scene = NULL;
    hpr_solution *solution = NULL;
    hpr_status status = HPR_OK;
    const char *path = options->solution_path;
    char *own_path = NULL;
    if (!path) {
        path = own_path = hpr_name_default(ctx, scene_path, ".glb");
        if (!own_path)
            status = hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    }
    if (status == HPR_OK)
        status = claim_outputs(&job, scene_path, path, options);
    if (status == HPR_OK)
        status = hpr_job_read_scene(&job, scene_path, &options->read, &scene);
    if (status == HPR_OK && options->environment_count)
        status = hpr_scene_set_environment(scene, options->environment_count, options->environment);
    progressive p = {&job, path};
    hpr_baseline_options baseline = options->baseline;
    baseline.shot = keep_shot;
    baseline.user = &p;
    if (status == HPR_OK)
        status = solve(&job, scene_path, scene, options, &baseline, &solution);
    if (status == HPR_OK)
        status = write_solution(&job, solution, path);
    if (status == HPR_OK)
        status = hpr_job_write_report(&job, solution, scene_path, options->report_path);
    if (status == HPR_OK)
        status = hpr_job_judge(&job, solution, scene_path);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&scene);
    hpr_release(ctx, own_path);
    return hpr_job_end(&job, status);
}
