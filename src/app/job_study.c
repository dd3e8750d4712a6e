/* Scene file -> a table of what accuracy costs. */
#include "app/job.h"
#include "app/names.h"
#include "app/study_error.h"
#include "app/study_grid.h"
#include "app/study_run.h"
#include "app/study_table.h"
#include "io/csv_points.h"
#include "io/json_text.h"
#include "solver/resolution.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { TEXT_BYTES = 256, TRUTH_FEET = 2, TRUTH_ORDERS_MORE = 4, TRUTH_LEVELS_MORE = 2 };

typedef struct study {
    hpr_job *job;
    const hpr_job_study_options *options;
    const char *scene_path, *table_path;
    hpr_scene *scene;
    hpr_solution *truth;
    size_t probe_count;
    double *probe, *probe_normal, *known; /* known: the irradiance there, or NULL */
    hpr_yardstick yardstick;
    size_t run_count;
    hpr_study_run *run; /* [run_count] */
    hpr_study_row *row; /* [run_count], of which table.count are made */
    char *earlier;      /* the table that is resumed, or NULL */
    char truth_text[TEXT_BYTES], options_text[TEXT_BYTES];
    hpr_study_table table;
} study;

void hpr_job_study_options_init(hpr_job_study_options *options)
{
    static const int orders[] = {0, 1, 2, 3, 4}, subdivisions[] = {0, 1, 2};
    static const hpr_method methods[] = {HPR_METHOD_GALERKIN};
    static const hpr_direct_mode directs[] = {HPR_DIRECT_EXACT};
    *options = (hpr_job_study_options){.truth_order = HPR_CHOOSE,
                                       .truth_subdivide = HPR_CHOOSE,
                                       .refine = HPR_STUDY_H,
                                       .adapt = HPR_STUDY_HP,
                                       .order_count = sizeof orders / sizeof *orders,
                                       .order = orders,
                                       .subdivide_count = sizeof subdivisions / sizeof *subdivisions,
                                       .subdivide = subdivisions,
                                       .method_count = 1,
                                       .method = methods,
                                       .direct_count = 1,
                                       .direct = directs,
                                       .repeats = 1};
    hpr_read_options_init(&options->read);
    hpr_solve_options_init(&options->solve);
    hpr_baseline_options_init(&options->baseline);
}

static int highest(const int *list, size_t count)
{
    int most = 0;
    for (size_t i = 0; i < count; i++)
        most = list[i] > most ? list[i] : most;
    return most;
}

/* As far as it can be told before anything is solved. */
static hpr_status check(study *s)
{
    hpr_job *job = s->job;
    const hpr_job_study_options *o = s->options;
    if (o->repeats < 1)
        return hpr_fail(job->context, HPR_ERR_ARG, "%d repeats: at least one is needed", o->repeats);
    bool uniform = o->truth_order != HPR_CHOOSE || o->truth_subdivide != HPR_CHOOSE;
    if (!(o->truth_tolerance >= 0 && o->truth_tolerance < 1) || (o->truth_tolerance > 0 && uniform))
        return hpr_fail(job->context, HPR_ERR_ARG,
                        "the solution to compare with: a tolerance in (0, 1), or an order and a subdivision");
    if (o->truth_path && (uniform || o->truth_tolerance > 0))
        return hpr_fail(job->context, HPR_ERR_ARG, "'%s' is there to compare with: nothing finer is solved",
                        o->truth_path);
    const char *inputs[] = {s->scene_path, o->truth_path, o->points_path};
    for (size_t i = 0; i < sizeof inputs / sizeof *inputs; i++) {
        if (inputs[i])
            hpr_outputs_input(&job->outputs, inputs[i]);
    }
    hpr_status status = hpr_outputs_claim(&job->outputs, s->table_path);
    if (status == HPR_OK && o->json_path)
        status = hpr_outputs_claim(&job->outputs, o->json_path);
    if (status == HPR_OK)
        status = hpr_study_plan(job->context, o, &s->run_count, &s->run);
    if (status == HPR_OK)
        status = hpr_allocate_into(job->context, &s->row, s->run_count, sizeof *s->row, "a study");
    return status;
}

/* What is set besides the columns of a row. */
static void describe_options(study *s)
{
    const hpr_job_study_options *o = s->options;
    char environment[HPR_NUMBER_BYTES] = "0";
    if (o->environment_count)
        hpr_number_text(o->environment[0], environment);
    snprintf(s->options_text, sizeof s->options_text,
             "solver=%s feet=%d link_tol=%g block_tol=%g hemicube=%d rays=%d shots=%d environment=%s%s "
             "max_reflectance=%g metallic=%s repeats=%d max_time=%g points=%s",
             hpr_solver_name(o->solve.solver), o->solve.feet == HPR_CHOOSE ? 0 : o->solve.feet,
             o->solve.link_tolerance, o->solve.block_tolerance, o->baseline.hemicube, o->baseline.rays,
             o->baseline.shots, environment, o->environment_count > 1 ? ",..." : "", o->read.max_reflectance,
             o->read.metallic_black ? "black" : "diffuse", o->repeats, o->solve.max_seconds,
             s->known   ? "known"
             : s->probe ? "compared"
                        : "none");
}

static hpr_status read_inputs(study *s)
{
    const hpr_job_study_options *o = s->options;
    hpr_context *ctx = s->job->context;
    hpr_status status = hpr_job_read_scene(s->job, s->scene_path, &o->read, &s->scene);
    if (status == HPR_OK && o->environment_count)
        status = hpr_scene_set_environment(s->scene, o->environment_count, o->environment);
    if (status == HPR_OK && o->points_path)
        status = hpr_points_read_known(ctx, o->points_path, s->scene, &s->probe_count, &s->probe,
                                       &s->probe_normal, &s->known);
    if (status == HPR_OK && o->truth_path)
        status = hpr_solution_read(ctx, o->truth_path, &s->truth);
    return status;
}

/* The order and subdivision of the better solution, where they are not given. */
static hpr_status choose_truth(const study *s, hpr_solve_options *truth)
{
    const hpr_job_study_options *o = s->options;
    hpr_patches *patches = NULL;
    hpr_status status = hpr_patches_build(s->scene, &patches);
    if (status != HPR_OK)
        return status;
    bool graded = o->refine & HPR_STUDY_HP;
    int order = highest(o->order, o->order_count) + (graded ? TRUTH_LEVELS_MORE : TRUTH_ORDERS_MORE);
    truth->order = o->truth_order != HPR_CHOOSE ? o->truth_order
                   : order < HPR_MAX_ORDER      ? order
                                                : HPR_MAX_ORDER;
    truth->subdivide = o->truth_subdivide;
    if (truth->subdivide == HPR_CHOOSE) {
        int most = highest(o->subdivide, o->subdivide_count) + 1;
        for (truth->subdivide = 0; truth->subdivide < most && truth->subdivide < HPR_MAX_SUBDIVIDE;) {
            if (hpr_resolution_dofs(patches, truth->order, truth->subdivide + 1) > HPR_RESOLUTION_DOFS)
                break;
            truth->subdivide++;
        }
    }
    hpr_patches_destroy(&patches);
    if (graded) { /* a singularity is worth more levels than any uniform subdivision */
        int levels = highest(o->order, o->order_count) + TRUTH_LEVELS_MORE;
        truth->grade = levels < HPR_MAX_GRADE ? levels : HPR_MAX_GRADE;
        truth->subdivide = o->truth_subdivide == HPR_CHOOSE ? o->subdivide[0] : o->truth_subdivide;
    }
    return HPR_OK;
}

/* The tolerance of the better solution; 0: it is not adaptive. */
static double truth_tolerance(const hpr_job_study_options *o)
{
    static const double part = 0.2; /* of the least: errors of that size are then known to a fifth */
    double least = 1;
    for (size_t t = 0; t < o->tolerance_count; t++)
        least = fmin(least, o->tolerance[t]);
    bool own = o->truth_tolerance > 0 || !o->tolerance_count || o->truth_order != HPR_CHOOSE ||
               o->truth_subdivide != HPR_CHOOSE;
    return own ? o->truth_tolerance : part * least;
}

static hpr_status solve_adaptive_truth(study *s, hpr_solve_options *truth)
{
    truth->order = truth->subdivide = HPR_CHOOSE;
    truth->refine = HPR_REFINE_HP;
    snprintf(s->truth_text, sizeof s->truth_text, "tolerance %g", truth->tolerance);
    hpr_status status = hpr_job_run_solve(s->job, s->scene, truth, NULL, NULL, &s->truth);
    if (status == HPR_OK && !s->truth->summary.reached)
        hpr_warn(s->job->context, "the solution to compare with has an estimated error of %.2e, not of %g",
                 s->truth->summary.error_estimate, truth->tolerance);
    return status;
}

static hpr_status solve_truth(study *s)
{
    const hpr_job_study_options *o = s->options;
    if (o->truth_path) {
        const char *slash = strrchr(o->truth_path, '/');
        snprintf(s->truth_text, sizeof s->truth_text, "%s", slash ? slash + 1 : o->truth_path);
        return HPR_OK;
    }
    hpr_solve_options truth = o->solve;
    truth.method = HPR_METHOD_GALERKIN;
    truth.direct = HPR_DIRECT_EXACT;
    truth.solver = HPR_SOLVER_AUTO;
    truth.link_tolerance = truth.block_tolerance = truth.max_seconds = 0;
    truth.tolerance = truth_tolerance(o);
    if (truth.tolerance > 0)
        return solve_adaptive_truth(s, &truth);
    if (truth.feet == HPR_CHOOSE || truth.feet < TRUTH_FEET)
        truth.feet = TRUTH_FEET;
    hpr_status status = choose_truth(s, &truth);
    snprintf(s->truth_text, sizeof s->truth_text, "order %d subdivide %d feet %d grade %d", truth.order,
             truth.subdivide, truth.feet, truth.grade);
    if (status == HPR_OK)
        status = hpr_job_run_solve(s->job, s->scene, &truth, NULL, NULL, &s->truth);
    return status;
}

/* On the truth's elements, at least as fine as those of the finest uniform run: so many points that the
 * square of what the truth and the runs can show there is integrated exactly. */
static hpr_status make_yardstick(study *s)
{
    const hpr_job_study_options *o = s->options;
    int subdivide = highest(o->subdivide, o->subdivide_count);
    const hpr_elements *truth = s->truth->elements;
    int order = highest(o->order, o->order_count);
    for (size_t i = 0; i < truth->leaf_count; i++)
        order = truth->degree[truth->leaf[i]] > order ? truth->degree[truth->leaf[i]] : order;
    hpr_yardstick_points points = {.subdivide = subdivide,
                                   .per_edge = order + 1 > 3 ? order + 1 : 3,
                                   .probe_count = s->probe_count,
                                   .probe = s->probe,
                                   .probe_normal = s->probe_normal,
                                   .known = s->known};
    return hpr_yardstick_init(s->truth, &points, &s->yardstick);
}

/* The table of an earlier study, if it is to be resumed and there is one. */
static hpr_status read_earlier(study *s)
{
    FILE *file = s->options->resume ? fopen(s->table_path, "r") : NULL;
    if (!file)
        return HPR_OK;
    size_t capacity = 0, count = 0, got;
    hpr_status status = HPR_OK;
    char piece[4096];
    while (status == HPR_OK && (got = fread(piece, 1, sizeof piece, file)) > 0) {
        status = hpr_grow(s->job->context, &s->earlier, &capacity, count + got + 1, 1);
        if (status == HPR_OK)
            memcpy(s->earlier + count, piece, got);
        count += got; /* what is grown is zeroed: the text ends */
    }
    fclose(file);
    return status;
}

/* log2 of what one more subdivision gained. */
static void find_order(const study *s, hpr_study_row *row)
{
    for (size_t i = 0; i < s->table.count; i++) {
        const hpr_study_run *a = &s->row[i].run, *b = &row->run;
        if (a->method == b->method && a->direct == b->direct && a->order == b->order &&
            a->grade == b->grade && a->subdivide + 1 == b->subdivide)
            row->order_l2 = log2(s->row[i].error_l2 / row->error_l2);
    }
}

static hpr_status save(study *s)
{
    hpr_status status = hpr_job_enter(s->job, HPR_JOB_WRITE);
    if (status == HPR_OK)
        status = hpr_study_write_csv(s->job->context, &s->table, s->table_path);
    if (status == HPR_OK)
        status = hpr_job_enter(s->job, HPR_JOB_SOLVE);
    return status;
}

/* One row, solved or found; *made: there is one. */
static hpr_status make_row(study *s, const hpr_study_run *run, bool *made)
{
    hpr_context *ctx = s->job->context;
    hpr_study_row *row = &s->row[s->table.count];
    hpr_solution *solution = NULL;
    *made = false;
    if (s->earlier)
        hpr_study_find(&s->table.labels, run, s->earlier, row, made);
    if (*made) {
        s->table.count++;
        return HPR_OK;
    }
    hpr_status status = hpr_study_solve(ctx, s->scene, s->options, run, row, &solution);
    if (status == HPR_ERR_MEMORY) {
        char what[TEXT_BYTES];
        if (run->tolerance > 0)
            snprintf(what, sizeof what, "--tol %g --refine %s", run->tolerance, hpr_refine_name(run->adapt));
        else
            snprintf(what, sizeof what, "--method %s --order %d --subdivide %d", hpr_method_name(run->method),
                     run->order, run->subdivide);
        hpr_warn(ctx, "%s is left out: %s", what, hpr_context_error(ctx));
        hpr_context_clear_error(ctx);
        return HPR_OK;
    }
    if (status == HPR_OK)
        status = hpr_yardstick_measure(&s->yardstick, solution, row);
    hpr_solution_destroy(&solution);
    if (status != HPR_OK)
        return status;
    find_order(s, row);
    s->table.count++;
    *made = true;
    return save(s);
}

static double elapsed(const struct timespec *start)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - start->tv_sec) + 1e-9 * (double)(now.tv_nsec - start->tv_nsec);
}

static hpr_status make_rows(study *s)
{
    double done = 0, all = 0;
    struct timespec start;
    hpr_status status = HPR_OK;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (size_t i = 0; i < s->run_count; i++)
        all += hpr_study_weight(&s->run[i]);
    for (size_t i = 0; status == HPR_OK && i < s->run_count; i++) {
        bool made;
        status = make_row(s, &s->run[i], &made);
        done += hpr_study_weight(&s->run[i]);
        if (status == HPR_OK && made && s->options->ran)
            s->options->ran(s->options->events.user, &s->row[s->table.count - 1], i + 1, s->run_count,
                            elapsed(&start) * (all - done) / done);
    }
    return status;
}

/* Errors below that of the truth tell nothing. Of one that no tolerance was asked of the estimate may be far
 * too high. */
static void warn_of_truth(const study *s)
{
    const hpr_solve_summary *truth = &s->truth->summary;
    double own = truth->options.tolerance > 0 ? truth->error_estimate : 0;
    size_t below = 0;
    for (size_t i = 0; i < s->table.count; i++)
        below += s->row[i].error_l2 < own;
    if (below)
        hpr_warn(s->job->context,
                 "%zu of %zu errors are below %.1e, the estimated error of the solution compared with (%s): "
                 "they may "
                 "be that one's",
                 below, s->table.count, own, s->truth_text);
}

/* The table once more, for all rows may have been found. */
static hpr_status finish(study *s)
{
    const char *json = s->options->json_path;
    hpr_status status = save(s);
    if (status == HPR_OK)
        hpr_job_wrote(s->job, &(hpr_job_file){.kind = HPR_JOB_FILE_TABLE, .path = s->table_path});
    if (status == HPR_OK && json)
        status = hpr_study_write_json(s->job->context, &s->table, json);
    if (status == HPR_OK && json)
        hpr_job_wrote(s->job, &(hpr_job_file){.kind = HPR_JOB_FILE_REPORT, .path = json});
    return status;
}

static hpr_status run_study(study *s)
{
    const char *slash = strrchr(s->scene_path, '/');
    hpr_status status = check(s);
    if (status == HPR_OK)
        status = read_inputs(s);
    if (status == HPR_OK)
        status = read_earlier(s);
    if (status == HPR_OK)
        status = solve_truth(s);
    if (status == HPR_OK)
        status = make_yardstick(s);
    if (status != HPR_OK)
        return status;
    describe_options(s);
    s->table = (hpr_study_table){
        .labels = {slash ? slash + 1 : s->scene_path, s->truth_text, s->options_text}, .row = s->row};
    status = make_rows(s);
    if (status == HPR_OK)
        warn_of_truth(s);
    return status == HPR_OK ? finish(s) : status;
}

hpr_status hpr_job_study(hpr_context *ctx, const char *scene_path, const hpr_job_study_options *options,
                         hpr_job_result *result)
{
    hpr_job_study_options defaults;
    hpr_job_study_options_init(&defaults);
    options = options ? options : &defaults;
    hpr_job job;
    hpr_job_begin(&job, ctx, &options->events, result);
    study s = {.job = &job, .options = options, .scene_path = scene_path, .table_path = options->table_path};
    char *own_path = NULL;
    hpr_status status = HPR_OK;
    if (!s.table_path) {
        s.table_path = own_path = hpr_name_default(ctx, scene_path, "_study.csv");
        if (!own_path)
            status = hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    }
    if (status == HPR_OK)
        status = run_study(&s);
    hpr_yardstick_fini(&s.yardstick);
    hpr_solution_destroy(&s.truth);
    hpr_scene_destroy(&s.scene);
    void *arrays[] = {s.probe, s.probe_normal, s.known, s.run, s.row, s.earlier, own_path};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    return hpr_job_end(&job, status);
}
