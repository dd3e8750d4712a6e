/* What a run did and cost, as JSON. The README lists the keys; they do not change their meaning. */
#include "base/memory_peak.h"
#include "io/atomic_file.h"
#include "io/report_parts.h"
#include "solver/effects.h"

#include <hprad/report.h>
#include <hprad/version.h>
#include <math.h>
#include <string.h>
#include <sys/resource.h>

void hpr_report_add_program(cJSON *root, const hpr_context *ctx, bool *ok)
{
    cJSON *hprad = hpr_json_object(root, "hprad", ok);
    hpr_json_text(hprad, "version", hpr_version(), ok);
    hpr_json_text(hprad, "commit", hpr_commit(), ok);
    hpr_json_text(hprad, "embree", hpr_embree_version(), ok);
    hpr_json_text(root, "isa", hpr_context_isa(ctx), ok);
    hpr_json_number(root, "threads", hpr_context_threads(ctx), ok);
}

static void add_counts(cJSON *root, const hpr_solution *solution, bool *ok)
{
    const hpr_solve_summary *summary = &solution->summary;
    cJSON *settings = hpr_json_object(root, "settings", ok);
    hpr_json_text(settings, "method", hpr_method_name(summary->options.method), ok);
    hpr_json_number(settings, "order", summary->options.order, ok);
    hpr_json_number(settings, "subdivide", summary->options.subdivide, ok);
    hpr_json_number(settings, "feet", summary->options.feet, ok);
    hpr_json_number(settings, "element_size_m", summary->options.element_size, ok);
    hpr_json_number(settings, "grade", summary->options.grade, ok);
    hpr_json_number(settings, "tolerance", summary->options.tolerance > 0 ? summary->options.tolerance : NAN,
                    ok);
    hpr_json_text(settings, "refine", hpr_refine_name(summary->options.refine), ok);
    hpr_json_number(settings, "link_tolerance", summary->link_tolerance, ok);
    hpr_json_number(settings, "block_tolerance", summary->block_tolerance, ok);
    hpr_json_number(settings, "blocked_tolerance", summary->blocked_tolerance, ok);
    hpr_json_number(settings, "solver_tolerance", summary->options.solver_tolerance, ok);
    hpr_json_text(settings, "direct", summary->direct == HPR_DIRECT_EXACT ? "exact" : "galerkin", ok);
    hpr_json_number(settings, "max_sweeps", summary->options.max_sweeps, ok);
    const struct {
        const char *key;
        size_t value;
    } counts[] = {
        {"patches", summary->patch_count},
        {"elements", summary->element_count},
        {"dofs", summary->dof_count},
        {"links", summary->link_count},
        {"steps", (size_t)summary->steps},
        {"block_bytes", summary->block_bytes},
        {"channels", solution->channel_count},
        {"channels_solved", summary->channels_solved},
        {"degenerate", summary->degenerate_count},
        {"duplicate", summary->duplicate_count},
    };
    cJSON *object = hpr_json_object(root, "counts", ok);
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        hpr_json_number(object, counts[i].key, (double)counts[i].value, ok);
}

static void add_counters(cJSON *root, const hpr_context *ctx, bool *ok)
{
    static const char *const keys[HPR_COUNTER_COUNT] = {
        [HPR_COUNT_KERNEL] = "kernel_evaluations",
        [HPR_COUNT_RAYS] = "rays",
        [HPR_COUNT_CLIPS] = "clips",
        [HPR_COUNT_CAMERA_RAYS] = "camera_rays",
        [HPR_COUNT_BLOCKS] = "blocks",
        [HPR_COUNT_PAIRS_HIDDEN] = "pairs_hidden",
        [HPR_COUNT_PAIRS_VISIBLE] = "pairs_visible",
        [HPR_COUNT_PAIRS_PARTIAL] = "pairs_partial",
        [HPR_COUNT_SAMPLED] = "blocks_sampled",
        [HPR_COUNT_SHORT] = "blocks_short",
        [HPR_COUNT_ROUNDED] = "blocks_rounded",
        [HPR_COUNT_TEXTURES] = "texture_means",
    };
    cJSON *counters = hpr_json_object(root, "counters", ok);
    for (int i = 0; i < HPR_COUNTER_COUNT; i++) {
        if (keys[i])
            hpr_json_number(counters, keys[i], (double)hpr_counter_value(ctx, (hpr_counter)i), ok);
    }
}

static double seconds(const struct timeval *time)
{
    return (double)time->tv_sec + 1e-6 * (double)time->tv_usec;
}

void hpr_report_add_cost(cJSON *root, const hpr_context *ctx, bool *ok)
{
    hpr_stage_time times[HPR_MAX_STAGES];
    size_t count = hpr_stage_times(ctx, times);
    cJSON *stages = hpr_json_array(root, "stages", ok);
    for (size_t i = 0; i < count; i++) {
        cJSON *stage = hpr_json_object(stages, NULL, ok);
        hpr_json_text(stage, "name", times[i].name, ok);
        hpr_json_number(stage, "wall_seconds", times[i].wall_s, ok);
        hpr_json_number(stage, "cpu_seconds", times[i].cpu_s, ok);
    }
    struct rusage usage = {0};
    getrusage(RUSAGE_SELF, &usage);
    hpr_json_number(root, "cpu_seconds", seconds(&usage.ru_utime) + seconds(&usage.ru_stime), ok);
    hpr_json_number(root, "peak_memory_bytes", hpr_memory_peak(), ok);
}

static void add_accuracy(cJSON *root, const hpr_solve_summary *summary, bool *ok)
{
    cJSON *solver = hpr_json_object(root, "solver", ok);
    hpr_json_text(solver, "method", hpr_solver_name((hpr_solver_method)summary->solver), ok);
    hpr_json_number(solver, "sweeps", summary->sweeps, ok);
    hpr_json_number(solver, "residual", summary->residual, ok);
    hpr_json_number(solver, "blocks_short", (double)summary->short_count, ok);
    hpr_json_bool(solver, "occluded", summary->occluded, ok);
    cJSON *quadrature = hpr_json_object(root, "quadrature", ok);
    hpr_json_number(quadrature, "block_error", summary->block_error, ok);
    hpr_json_number(quadrature, "sampled_error", summary->sampled_error, ok);
    bool estimated = !isnan(summary->error_estimate);
    if (!estimated)
        hpr_json_null(root, "error_estimate", ok);
    else
        hpr_json_number(root, "error_estimate", summary->error_estimate, ok);
    cJSON *parts = hpr_json_object(root, "error_parts", ok);
    hpr_json_number(parts, "discretisation", estimated ? summary->error_parts.discretisation : NAN, ok);
    hpr_json_number(parts, "links", estimated ? summary->error_parts.links : NAN, ok);
    hpr_json_number(parts, "visibility", estimated ? summary->error_parts.visibility : NAN, ok);
    hpr_json_number(parts, "solver", estimated ? summary->error_parts.solver : NAN, ok);
    hpr_json_number(root, "link_error", summary->link_error, ok);
    hpr_json_number(root, "visibility_error", summary->visibility_error, ok);
}

static void add_environment(cJSON *root, const hpr_solution *solution, bool *ok)
{
    static const char *const modes[] = {"none", "exact", "galerkin"};
    const hpr_solve_summary *summary = &solution->summary;
    cJSON *environment = hpr_json_object(root, "environment", ok);
    cJSON *radiance = hpr_json_array(environment, "radiance", ok);
    for (size_t c = 0; c < solution->channel_count; c++)
        hpr_json_number(radiance, NULL, solution->environment ? solution->environment[c] : 0, ok);
    hpr_json_text(environment, "direct", modes[summary->environment], ok);
    hpr_json_number(environment, "elements_closed_form", (double)summary->environment_closed, ok);
    hpr_json_number(environment, "elements_clipped", (double)summary->environment_clipped, ok);
    hpr_json_number(environment, "elements_sampled", (double)summary->environment_sampled, ok);
    hpr_json_number(environment, "error", summary->environment_error, ok);
}

static void add_energy(cJSON *root, const hpr_solution *solution, bool *ok)
{
    cJSON *channels = hpr_json_array(root, "energy", ok);
    for (size_t c = 0; c < solution->channel_count; c++) {
        const hpr_energy *energy = solution->energy + c;
        double come_in = energy->emitted + energy->environment;
        double balance = come_in - energy->absorbed - energy->lost_on_backs - energy->escaped;
        cJSON *item = hpr_json_object(channels, NULL, ok);
        hpr_json_text(item, "channel", solution->channel_name[c], ok);
        hpr_json_number(item, "emitted", energy->emitted, ok);
        hpr_json_number(item, "environment", energy->environment, ok);
        hpr_json_number(item, "absorbed", energy->absorbed, ok);
        hpr_json_number(item, "lost_on_backs", energy->lost_on_backs, ok);
        hpr_json_number(item, "escaped", energy->escaped, ok);
        hpr_json_number(item, "balance", balance, ok);
        hpr_json_number(item, "relative", balance == 0 ? 0 : balance / come_in, ok);
    }
}

void hpr_report_add_effects(cJSON *root, const hpr_plan_effect *effect, bool *ok)
{
    cJSON *plan = hpr_json_object(root, "plan", ok);
    for (int i = 0; i < HPR_PLAN_EFFECTS; i++) {
        cJSON *item = hpr_json_object(plan, effect[i].name, ok);
        hpr_json_bool(item, "called_for", effect[i].called_for, ok);
        hpr_json_text(item, "why", effect[i].why, ok);
    }
}

static void add_plan(cJSON *root, const hpr_solution *solution, bool *ok)
{
    hpr_plan_effect effect[HPR_PLAN_EFFECTS];
    hpr_effect_facts facts = hpr_effect_facts_of(solution);
    hpr_effects_name(&facts, effect);
    hpr_report_add_effects(root, effect, ok);
}

void hpr_report_add_warnings(cJSON *root, const hpr_context *ctx, bool *ok)
{
    cJSON *warnings = hpr_json_array(root, "warnings", ok);
    size_t count = hpr_warning_count(ctx);
    for (size_t i = 0; i < count; i++)
        hpr_json_text(warnings, NULL, hpr_warning_text(ctx, i), ok);
}

hpr_status hpr_report_save(hpr_context *ctx, cJSON *root, bool ok, const char *path)
{
    char *text = ok ? cJSON_Print(root) : NULL;
    cJSON_Delete(root);
    if (!text)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a report");
    hpr_atomic_file file;
    hpr_status status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK)
        status = hpr_atomic_write(&file, text, strlen(text));
    if (status == HPR_OK)
        status = hpr_atomic_write(&file, "\n", 1);
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    hpr_atomic_abort(&file);
    cJSON_free(text);
    return status;
}

hpr_status hpr_report_write(hpr_context *ctx, const hpr_solution *solution, const char *scene_path,
                            const char *path)
{
    bool ok = true;
    hpr_context_clear_error(ctx);
    cJSON *root = cJSON_CreateObject();
    hpr_report_add_program(root, ctx, &ok);
    hpr_json_text(root, "scene", scene_path ? scene_path : solution->scene_name, &ok);
    add_plan(root, solution, &ok);
    add_counts(root, solution, &ok);
    add_counters(root, ctx, &ok);
    hpr_report_add_cost(root, ctx, &ok);
    add_accuracy(root, &solution->summary, &ok);
    add_environment(root, solution, &ok);
    add_energy(root, solution, &ok);
    hpr_report_add_warnings(root, ctx, &ok);
    return hpr_report_save(ctx, root, ok, path);
}
