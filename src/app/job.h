/* What the jobs share. */
#ifndef HPR_APP_JOB_H
#define HPR_APP_JOB_H

#include "app/outputs.h"

#include <hprad/job.h>
#include <time.h>

/* One running job. */
typedef struct hpr_job {
    hpr_context *context;
    hpr_job_result *result; /* never NULL */
    hpr_job_result unseen;  /* where result points if the caller wants none */
    hpr_job_events events;
    hpr_outputs outputs;
    struct timespec start;
} hpr_job;

/* Begins at step CHECK with a zeroed result and no old error on the context. */
void hpr_job_begin(hpr_job *job, hpr_context *ctx, const hpr_job_events *events, hpr_job_result *result);

/* Releases what the job holds, notes the seconds, returns `status`. */
hpr_status hpr_job_end(hpr_job *job, hpr_status status);

/* Notes the step. Errors: HPR_ERR_INTERRUPTED if the context was cancelled meanwhile. */
hpr_status hpr_job_enter(hpr_job *job, hpr_job_step step);

/* Hands a finished file to the caller. */
void hpr_job_wrote(const hpr_job *job, const hpr_job_file *file);

/* True if the file is a .glb with hprad's extension. False also if it cannot be read. */
bool hpr_job_is_solution(const char *path);

/* Reads a scene. Errors: those of hpr_scene_read; HPR_ERR_FORMAT if the file is a solution: its picture of
 * itself is no scene to solve. */
hpr_status hpr_job_read_scene(hpr_job *job, const char *path, const hpr_read_options *options,
                              hpr_scene **scene);

/* When everything is written: HPR_ERR_TOLERANCE with a message if the solution misses the tolerance that was
 * asked for. */
hpr_status hpr_job_judge(const hpr_job *job, const hpr_solution *solution, const char *scene_path);

/* Solves by any method; fills summary and solve_seconds of the result. baseline: NULL: defaults. */
hpr_status hpr_job_run_solve(hpr_job *job, const hpr_scene *scene, const hpr_solve_options *options,
                             const hpr_baseline_options *baseline, const hpr_solve_series *series,
                             hpr_solution **solution);

/* Writes the report if path is not NULL. */
hpr_status hpr_job_write_report(hpr_job *job, const hpr_solution *solution, const char *scene_path,
                                const char *path);

#endif
