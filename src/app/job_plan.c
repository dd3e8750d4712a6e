/* Scene file -> what it calls for, and what that will cost. */
#include "app/job.h"
#include "app/plan_predict.h"
#include "app/plan_trial.h"
#include "base/memory_peak.h"
#include "io/plan_report.h"
#include "link/afford.h"

#include <hprad/plan.h>
#include <math.h>
#include <time.h>

void hpr_job_plan_options_init(hpr_job_plan_options *options)
{
    *options = (hpr_job_plan_options){0};
    hpr_read_options_init(&options->read);
    hpr_solve_options_init(&options->solve);
}

typedef struct planning {
    hpr_job *job;
    const hpr_job_plan_options *options;
    hpr_scene *scene;
    hpr_plan *plan;
    hpr_outlook outlook;
} planning;

static void list_solves(planning *p)
{
    static const double tolerances[HPR_PLAN_TOLERANCES] = {1e-1, 1e-2, 1e-3};
    hpr_plan *plan = p->plan;
    plan->solve_count = 1;
    const hpr_solve_options *given = &p->options->solve;
    plan->solve[0].tolerance = given->tolerance;
    bool others = given->tolerance == 0 && (given->order == HPR_CHOOSE || given->order >= 2);
    for (int i = 0; others && i < HPR_PLAN_TOLERANCES; i++)
        plan->solve[plan->solve_count++].tolerance = tolerances[i];
}

/* The options of one solve: the first step of a tolerance has elements of its own, unless they are given. */
static hpr_solve_options options_of(const planning *p, double tolerance)
{
    hpr_solve_options options = p->options->solve;
    options.tolerance = tolerance;
    if (tolerance == 0)
        options.max_seconds = options.max_bytes = 0;
    return options;
}

/* What the scene calls for, told by the first solve's elements. */
static hpr_status look(planning *p, const hpr_solution *begun)
{
    hpr_effect_facts facts = hpr_effect_facts_of(begun);
    hpr_stage_begin(p->job->context, "plan");
    hpr_status status = hpr_plan_look(begun, p->plan, &facts, &p->outlook);
    hpr_stage_end(p->job->context);
    hpr_effects_name(&facts, p->plan->effect);
    return status;
}

/* Does the table have tolerances? */
static bool may_adapt(const planning *p)
{
    return p->plan->solve_count > 1 || p->plan->solve[0].tolerance > 0;
}

static hpr_status predict(planning *p)
{
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < p->plan->solve_count; i++) {
        hpr_plan_solve *solve = &p->plan->solve[i];
        hpr_solve_options options = options_of(p, solve->tolerance);
        hpr_solution *begun = NULL;
        solve->error = NAN;
        status = hpr_solution_begin(p->job->context, p->scene, &options, &begun);
        if (status == HPR_OK && i == 0)
            status = look(p, begun);
        if (status == HPR_OK && i == 0 && may_adapt(p))
            status = hpr_plan_try(p->job->context, p->scene, &p->options->solve, p->plan, &p->outlook);
        if (status == HPR_OK)
            status = hpr_plan_predict(begun, p->plan, &p->outlook, solve->tolerance, &solve->predicted);
        solve->too_large =
            solve->predicted.memory_bytes > hpr_links_most_bytes(0) || (i == 0 && p->plan->least_bytes > 0);
        hpr_solution_destroy(&begun);
    }
    return status;
}

static double cpu_seconds(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static hpr_status measure_one(planning *p, hpr_plan_solve *solve, double max_s, double max_bytes)
{
    static const double patience = 4; /* the prediction may be too low, and a busy machine slow */
    hpr_solve_options options = options_of(p, solve->tolerance);
    if (solve->tolerance > 0) {
        options.max_seconds = patience * max_s;
        options.max_bytes = max_bytes;
    }
    hpr_solution *solution = NULL;
    hpr_memory_reset_peak();
    double begun_s = cpu_seconds();
    hpr_status status = hpr_job_run_solve(p->job, p->scene, &options, NULL, NULL, &solution);
    if (status == HPR_OK) {
        const hpr_solve_summary *summary = hpr_solution_summary(solution);
        solve->measured = 1;
        solve->error = summary->error_estimate;
        solve->cost = (hpr_plan_cost){.elements = (double)summary->element_count,
                                      .dofs = (double)summary->dof_count,
                                      .links = (double)summary->link_count,
                                      .memory_bytes = hpr_memory_peak(),
                                      .cpu_s = cpu_seconds() - begun_s};
    }
    hpr_solution_destroy(&solution);
    return status;
}

/* What the limits allow, by prediction. */
static hpr_status measure(planning *p)
{
    static const double default_s = 60;
    const hpr_solve_options *asked = &p->options->solve;
    double max_s = asked->max_seconds > 0 ? asked->max_seconds : default_s;
    double max_bytes = hpr_links_most_bytes(asked->max_bytes);
    hpr_status status = HPR_OK;
    for (size_t i = 0; status == HPR_OK && i < p->plan->solve_count; i++) {
        hpr_plan_solve *solve = &p->plan->solve[i];
        bool small = !solve->too_large && solve->predicted.cpu_s <= max_s &&
                     solve->predicted.memory_bytes <= max_bytes;
        if (small)
            status = measure_one(p, solve, max_s, max_bytes);
    }
    return status;
}

static hpr_status run(planning *p, const char *scene_path)
{
    hpr_job *job = p->job;
    const hpr_job_plan_options *o = p->options;
    hpr_outputs_input(&job->outputs, scene_path);
    hpr_status status = o->report_path ? hpr_outputs_claim(&job->outputs, o->report_path) : HPR_OK;
    if (status == HPR_OK)
        status = hpr_job_read_scene(job, scene_path, &o->read, &p->scene);
    if (status == HPR_OK && o->environment_count)
        status = hpr_scene_set_environment(p->scene, o->environment_count, o->environment);
    if (status == HPR_OK)
        status = hpr_job_enter(job, HPR_JOB_SOLVE);
    list_solves(p);
    if (status == HPR_OK)
        status = predict(p);
    if (status == HPR_OK && o->measure)
        status = measure(p);
    if (status != HPR_OK || !o->report_path)
        return status;
    status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status == HPR_OK)
        status = hpr_plan_report_write(job->context, p->plan, scene_path, o->report_path);
    if (status == HPR_OK)
        hpr_job_wrote(job, &(hpr_job_file){.kind = HPR_JOB_FILE_REPORT, .path = o->report_path});
    return status;
}

hpr_status hpr_job_plan(hpr_context *ctx, const char *scene_path, const hpr_job_plan_options *options,
                        hpr_plan *plan, hpr_job_result *result)
{
    hpr_job_plan_options defaults;
    hpr_job_plan_options_init(&defaults);
    if (!options)
        options = &defaults;
    hpr_job job;
    hpr_job_begin(&job, ctx, &options->events, result);
    *plan = (hpr_plan){0};
    planning p = {.job = &job, .options = options, .plan = plan};
    hpr_status status = run(&p, scene_path);
    hpr_scene_destroy(&p.scene);
    return hpr_job_end(&job, status);
}
