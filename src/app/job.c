#include "app/job.h"

#include <hprad/report.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void hpr_job_begin(hpr_job *job, hpr_context *ctx, const hpr_job_events *events, hpr_job_result *result)
{
    *job = (hpr_job){.context = ctx, .events = *events};
    job->result = result ? result : &job->unseen;
    *job->result = (hpr_job_result){.step = HPR_JOB_CHECK};
    hpr_outputs_init(&job->outputs, ctx);
    clock_gettime(CLOCK_MONOTONIC, &job->start);
    hpr_context_clear_error(ctx);
}

static double seconds_since(const struct timespec *start)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - start->tv_sec) + 1e-9 * (double)(now.tv_nsec - start->tv_nsec);
}

hpr_status hpr_job_end(hpr_job *job, hpr_status status)
{
    hpr_outputs_fini(&job->outputs);
    job->result->seconds = seconds_since(&job->start);
    return status;
}

hpr_status hpr_job_enter(hpr_job *job, hpr_job_step step)
{
    job->result->step = step;
    if (hpr_cancelled(job->context))
        return hpr_fail(job->context, HPR_ERR_INTERRUPTED, "interrupted");
    return HPR_OK;
}

void hpr_job_wrote(const hpr_job *job, const hpr_job_file *file)
{
    if (job->events.wrote)
        job->events.wrote(job->events.user, file);
}

static uint32_t little_endian(const unsigned char *byte)
{
    return (uint32_t)byte[0] | (uint32_t)byte[1] << 8 | (uint32_t)byte[2] << 16 | (uint32_t)byte[3] << 24;
}

/* The JSON chunk names the extensions that a file uses; it is small, for the arrays are in the other chunk.
 * Searched piece by piece, so that a wrong length costs no memory; the pieces overlap by the word's length.
 */
bool hpr_job_is_solution(const char *path)
{
    static const char word[] = "\"HPRAD_radiosity\"";
    enum { PIECE = 1 << 16, OVERLAP = sizeof word - 2 };
    unsigned char header[20];
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    bool found = false;
    char *piece = NULL;
    if (fread(header, 1, sizeof header, file) != sizeof header || memcmp(header, "glTF", 4))
        goto cleanup;
    piece = malloc(OVERLAP + PIECE);
    if (!piece)
        goto cleanup;
    size_t left = little_endian(header + 12), kept = 0;
    while (left && !found) {
        size_t got = fread(piece + kept, 1, left < PIECE ? left : PIECE, file);
        if (!got)
            break;
        left -= got;
        size_t held = kept + got;
        found = memmem(piece, held, word, sizeof word - 1) != NULL;
        kept = held < OVERLAP ? held : OVERLAP;
        memmove(piece, piece + held - kept, kept);
    }
cleanup:
    free(piece);
    fclose(file);
    return found;
}

hpr_status hpr_job_read_scene(hpr_job *job, const char *path, const hpr_read_options *options,
                              hpr_scene **scene)
{
    hpr_status status = hpr_job_enter(job, HPR_JOB_READ);
    if (status != HPR_OK)
        return status;
    if (hpr_job_is_solution(path))
        return hpr_fail(job->context, HPR_ERR_FORMAT,
                        "'%s' is a solution, not a scene; show it with 'hprad render'", path);
    hpr_stage_begin(job->context, "read");
    status = hpr_scene_read(job->context, path, options, scene);
    hpr_stage_end(job->context);
    return status;
}

hpr_status hpr_job_run_solve(hpr_job *job, const hpr_scene *scene, const hpr_solve_options *options,
                             const hpr_baseline_options *baseline, const hpr_solve_series *series,
                             hpr_solution **solution)
{
    hpr_status status = hpr_job_enter(job, HPR_JOB_SOLVE);
    if (status != HPR_OK)
        return status;
    struct timespec start;
    clock_gettime(CLOCK_MONOTONIC, &start);
    status = series ? hpr_solve_resume(job->context, scene, options, series, solution)
                    : hpr_baseline_solve(job->context, scene, options, baseline, solution);
    job->result->solve_seconds = seconds_since(&start);
    if (status == HPR_OK)
        job->result->summary = *hpr_solution_summary(*solution);
    return status;
}

hpr_status hpr_job_judge(const hpr_job *job, const hpr_solution *solution, const char *scene_path)
{
    const hpr_solve_summary *summary = hpr_solution_summary(solution);
    if (!(summary->options.tolerance > 0) || summary->reached || isnan(summary->error_estimate))
        return HPR_OK;
    return hpr_fail(job->context, HPR_ERR_TOLERANCE,
                    "%s: the estimated error is %.2e, the tolerance %g, and another refinement would exceed "
                    "--max-time, --max-memory or the finest elements; the result is written",
                    scene_path, summary->error_estimate, summary->options.tolerance);
}

hpr_status hpr_job_write_report(hpr_job *job, const hpr_solution *solution, const char *scene_path,
                                const char *path)
{
    if (!path)
        return HPR_OK;
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status == HPR_OK)
        status = hpr_report_write(job->context, solution, scene_path, path);
    if (status == HPR_OK)
        hpr_job_wrote(job, &(hpr_job_file){.kind = HPR_JOB_FILE_REPORT, .path = path});
    return status;
}
