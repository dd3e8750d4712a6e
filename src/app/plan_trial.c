#include "app/plan_trial.h"

#include "solver/setup.h"

#include <math.h>
#include <time.h>

enum { MOST_DOFS = 600, MOST_TIMES = 2 };

static double cpu_seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static hpr_status is_small(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                           bool *small)
{
    hpr_solution *begun = NULL;
    hpr_status status = hpr_solution_begin(ctx, scene, options, &begun);
    *small = status == HPR_OK && begun->summary.dof_count <= MOST_DOFS;
    hpr_solution_destroy(&begun);
    return status;
}

/* By what the constants were observed to make of the trials, all bundled scenes. */
static double find_slowness(const hpr_solve_summary *trial, const hpr_plan *plan, double cpu_s)
{
    static const double least_s = 0.015, open_s = 0.8, blocked_s = 1.7, most = 4; /* seconds per 1e6 bytes */
    double per_mb = plan->pairs_partial > 0 ? blocked_s : open_s;
    return fmin(fmax(cpu_s / (least_s + 1e-6 * (double)trial->block_bytes * per_mb), 1 / most), most);
}

hpr_status hpr_plan_try(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                        const hpr_plan *plan, hpr_outlook *outlook)
{
    static const double moment_s = 0.2, no_time_s = 1e-9;
    hpr_solve_options trial = *options;
    trial.tolerance = hpr_plan_trial_tolerance;
    trial.max_seconds = no_time_s; /* no second step */
    trial.max_bytes = 0;
    bool small = false;
    hpr_status status = outlook->lit ? is_small(ctx, scene, &trial, &small) : HPR_OK;
    for (int i = 0; status == HPR_OK && small && i < MOST_TIMES; i++) {
        hpr_solution *solution = NULL;
        double begun_s = cpu_seconds();
        status = hpr_solve(ctx, scene, &trial, &solution);
        double took_s = cpu_seconds() - begun_s;
        if (status == HPR_OK) {
            const hpr_solve_summary *summary = hpr_solution_summary(solution);
            outlook->trial_error = summary->error_estimate;
            outlook->trial_cpu_s = i == 0 ? took_s : fmin(took_s, outlook->trial_cpu_s);
            outlook->slowness = find_slowness(summary, plan, outlook->trial_cpu_s);
        }
        hpr_solution_destroy(&solution);
        small = took_s < moment_s;
    }
    return status;
}
