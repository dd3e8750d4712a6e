#include "app/study_run.h"

#include "base/memory_peak.h"
#include "solver/solution.h"

#include <hprad/baseline.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* The stages of a solve, in the order in which hpr_study_row has them. */
enum { STAGES = 7 };
static const char *const stage_names[STAGES] = {"mesh",   "assembly", "direct light",  "environment",
                                                "solver", "energy",   "error estimate"};

typedef struct cost {
    double wall_s, cpu_s, stage_cpu_s[STAGES];
} cost;

static double clock_seconds(clockid_t id)
{
    struct timespec time;
    clock_gettime(id, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

/* What has been used so far. */
static cost read_clocks(const hpr_context *ctx)
{
    cost now = {clock_seconds(CLOCK_MONOTONIC), clock_seconds(CLOCK_PROCESS_CPUTIME_ID), {0}};
    hpr_stage_time times[HPR_MAX_STAGES];
    size_t count = hpr_stage_times(ctx, times);
    for (size_t i = 0; i < count; i++) {
        for (int s = 0; s < STAGES; s++) {
            if (!strcmp(times[i].name, stage_names[s]))
                now.stage_cpu_s[s] = times[i].cpu_s;
        }
    }
    return now;
}

static int compare(const void *left, const void *right)
{
    double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* The median of one figure of all repeats, those `stride` doubles apart. Sorts `room`, [count]. */
static double median(const double *first, size_t stride, size_t count, double *room)
{
    for (size_t i = 0; i < count; i++)
        room[i] = first[i * stride];
    qsort(room, count, sizeof *room, compare);
    return 0.5 * (room[(count - 1) / 2] + room[count / 2]);
}

static void summarise_costs(const cost *costs, size_t count, double *room, hpr_study_row *row)
{
    const size_t stride = sizeof *costs / sizeof(double);
    double *const stages[STAGES] = {&row->mesh_cpu_s,        &row->assembly_cpu_s, &row->direct_cpu_s,
                                    &row->environment_cpu_s, &row->solver_cpu_s,   &row->energy_cpu_s,
                                    &row->estimate_cpu_s};
    for (int s = 0; s < STAGES; s++)
        *stages[s] = median(&costs->stage_cpu_s[s], stride, count, room);
    row->wall_s = median(&costs->wall_s, stride, count, room);
    row->cpu_s = median(&costs->cpu_s, stride, count, room);
    row->least_cpu_s = room[0];
    row->most_cpu_s = room[count - 1];
}

static void describe(const hpr_solution *solution, hpr_study_row *row)
{
    const hpr_elements *e = solution->elements;
    row->dofs = (double)solution->summary.dof_count;
    row->elements = (double)solution->summary.element_count;
    row->links = (double)solution->summary.link_count;
    row->error_estimate = solution->summary.error_estimate;
    for (size_t i = 0; i < e->leaf_count; i++)
        row->h_m = fmax(row->h_m, sqrt(e->area_m2[e->leaf[i]]));
}

static hpr_solve_options options_of(const hpr_job_study_options *options, const hpr_study_run *run)
{
    hpr_solve_options solve = options->solve;
    solve.method = run->method;
    solve.order = run->order;
    solve.subdivide = run->subdivide;
    solve.grade = run->grade;
    solve.direct = run->direct;
    solve.tolerance = run->tolerance;
    solve.refine = run->adapt;
    if (solve.feet == HPR_CHOOSE && !(run->tolerance > 0))
        solve.feet = 0;
    /* Of methods that have links, and of those that integrate blocks. */
    if (run->method > HPR_METHOD_HIERARCHICAL)
        solve.link_tolerance = 0;
    if (run->method == HPR_METHOD_HEMICUBE || run->method == HPR_METHOD_RAYCAST)
        solve.block_tolerance = 0;
    return solve;
}

/* One solve; cost and counters of it alone. */
static hpr_status solve_once(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *solve,
                             const hpr_baseline_options *baseline, cost *used, hpr_study_row *row,
                             hpr_solution **solution)
{
    const hpr_counter counters[] = {HPR_COUNT_KERNEL, HPR_COUNT_RAYS, HPR_COUNT_CLIPS};
    double *const counts[] = {&row->kernel_evaluations, &row->rays, &row->clips};
    uint64_t before[3];
    for (int k = 0; k < 3; k++)
        before[k] = hpr_counter_value(ctx, counters[k]);
    hpr_memory_reset_peak();
    cost start = read_clocks(ctx);
    hpr_status status = hpr_baseline_solve(ctx, scene, solve, baseline, solution);
    cost end = read_clocks(ctx);
    row->peak_memory_bytes = hpr_memory_peak();
    for (int k = 0; k < 3; k++)
        *counts[k] = (double)(hpr_counter_value(ctx, counters[k]) - before[k]);
    *used = (cost){end.wall_s - start.wall_s, end.cpu_s - start.cpu_s, {0}};
    for (int s = 0; s < STAGES; s++)
        used->stage_cpu_s[s] = end.stage_cpu_s[s] - start.stage_cpu_s[s];
    return status;
}

hpr_status hpr_study_solve(hpr_context *ctx, const hpr_scene *scene, const hpr_job_study_options *options,
                           const hpr_study_run *run, hpr_study_row *row, hpr_solution **solution)
{
    hpr_solve_options solve = options_of(options, run);
    size_t repeats = (size_t)options->repeats;
    cost *costs = NULL;
    double *room = NULL;
    *row = (hpr_study_row){.run = *run, .order_l2 = NAN};
    *solution = NULL;
    hpr_status status = hpr_allocate_into(ctx, &costs, repeats, sizeof *costs, "the times of a study");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &room, repeats, sizeof *room, "the times of a study");
    if (status == HPR_OK && repeats > 1)
        status = solve_once(ctx, scene, &solve, &options->baseline, costs, row, solution);
    for (size_t i = 0; status == HPR_OK && i < repeats; i++) {
        hpr_solution_destroy(solution);
        status = solve_once(ctx, scene, &solve, &options->baseline, costs + i, row, solution);
    }
    if (status == HPR_OK) {
        summarise_costs(costs, repeats, room, row);
        describe(*solution, row);
    }
    hpr_release(ctx, costs);
    hpr_release(ctx, room);
    return status;
}
