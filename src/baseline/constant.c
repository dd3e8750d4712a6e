/* Constant radiosity: a scene solved by a full matrix of form factors between its elements. */
#include "baseline/factors.h"
#include "baseline/matrix.h"
#include "link/afford.h"
#include "solver/solution.h"

#include <math.h>
#include <string.h>

void hpr_baseline_options_init(hpr_baseline_options *options)
{
    *options = (hpr_baseline_options){.hemicube = HPR_DEFAULT_HEMICUBE, .rays = HPR_DEFAULT_RAYS};
}

static hpr_status check_own(hpr_context *ctx, const hpr_baseline_options *b, bool shoots)
{
    if (b->hemicube < 2 || b->hemicube > HPR_MAX_HEMICUBE || b->hemicube % 2)
        return hpr_fail(ctx, HPR_ERR_ARG, "a hemicube of %d pixels: must be even, 2 to %d", b->hemicube,
                        HPR_MAX_HEMICUBE);
    if (b->rays < 1 || b->rays > HPR_MAX_RAYS)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d x %d rays to a sender: must be 1 to %d", b->rays, b->rays,
                        HPR_MAX_RAYS);
    if (b->shots < 0 || b->every < 0 || (b->every > 0 && !b->shot))
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "%d shots, shown after every %d: must not be negative, and shown to "
                        "someone",
                        b->shots, b->every);
    if ((b->shots || b->every) && !shoots)
        return hpr_fail(ctx, HPR_ERR_ARG, "shots are of the solver 'shooting'");
    return HPR_OK;
}

/* Refuses what would have no effect, and settles what is left open. */
static hpr_status take_options(hpr_context *ctx, const hpr_scene *scene, const hpr_baseline_options *b,
                               hpr_solve_options *o)
{
    const char *name = hpr_method_name(o->method);
    if (o->order > 0)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d: method '%s' has one constant per element", o->order,
                        name);
    if (o->solver == HPR_SOLVER_GMRES)
        return hpr_fail(ctx, HPR_ERR_ARG, "solver '%s' is not one of method '%s'", hpr_solver_name(o->solver),
                        name);
    if (o->link_tolerance > 0)
        return hpr_fail(ctx, HPR_ERR_ARG, "link tolerance %g: method '%s' has no links", o->link_tolerance,
                        name);
    if (o->block_tolerance > 0 && o->method != HPR_METHOD_EXACT)
        return hpr_fail(ctx, HPR_ERR_ARG, "block tolerance %g: method '%s' has no blocks", o->block_tolerance,
                        name);
    for (size_t c = 0; c < scene->channel_count; c++) {
        if (scene->environment[c] > 0)
            return hpr_fail(ctx, HPR_ERR_UNSUPPORTED, "method '%s' knows no light from outside", name);
    }
    o->order = 0;
    o->feet = o->feet == HPR_CHOOSE ? 0 : o->feet;
    o->direct = HPR_DIRECT_GALERKIN;
    return check_own(ctx, b, o->solver == HPR_SOLVER_SHOOTING);
}

typedef struct run {
    hpr_solution *solution;
    const hpr_baseline_options *baseline;
    hpr_matrix_problem problem;
    double *factor, *area_m2, *reflectance, *exitance;
    hpr_factors_done done;
} run;

/* The full matrix, of elimination a second time. */
static hpr_status check_memory(const run *r)
{
    size_t count = r->solution->elements->leaf_count;
    double copies = r->problem.method == HPR_SOLVER_DIRECT ? 2 : 1;
    double needed = copies * (double)count * (double)count * sizeof(double);
    double most = hpr_links_most_bytes(r->solution->summary.options.max_bytes);
    if (needed > most)
        return hpr_fail(r->solution->context, HPR_ERR_MEMORY,
                        "the full matrix of %zu elements needs %.3g GB, more than %.3g GB (--max-memory): "
                        "take a lower --subdivide",
                        count, 1e-9 * needed, 1e-9 * most);
    return HPR_OK;
}

static hpr_status allocate(run *r)
{
    hpr_context *ctx = r->solution->context;
    size_t n = r->problem.count, values = n * r->problem.channel_count;
    const struct {
        double **array;
        size_t count;
    } arrays[] = {{&r->factor, n * n},
                  {&r->area_m2, n},
                  {&r->reflectance, values},
                  {&r->exitance, values},
                  {&r->problem.irradiance, values}};
    hpr_status status = check_memory(r);
    for (size_t i = 0; status == HPR_OK && i < sizeof arrays / sizeof *arrays; i++)
        status = hpr_allocate_into(ctx, arrays[i].array, arrays[i].count, sizeof(double), "the full matrix");
    return status;
}

static void describe(run *r)
{
    const hpr_patches *patches = r->solution->patches;
    const hpr_elements *e = r->solution->elements;
    size_t n = r->problem.count, channels = patches->channel_count;
    for (size_t i = 0; i < n; i++) {
        size_t patch = e->patch[e->leaf[i]];
        r->area_m2[i] = e->area_m2[e->leaf[i]];
        for (size_t c = 0; c < r->problem.channel_count; c++) {
            r->reflectance[c * n + i] = patches->reflectance[channels * patch + c];
            r->exitance[c * n + i] = patches->exitance[channels * patch + c];
        }
    }
    r->problem.factor = r->factor;
    r->problem.area_m2 = r->area_m2;
    r->problem.reflectance = r->reflectance;
    r->problem.exitance = r->exitance;
}

/* H as coefficients of T_0 = 1 / sqrt(A), and the energy terms that follow from it. */
static void take_over(run *r)
{
    hpr_solution *solution = r->solution;
    const hpr_patches *patches = solution->patches;
    size_t n = r->problem.count, channels = solution->channel_count;
    for (size_t c = 0; c < channels; c++) {
        hpr_energy energy = {.lost_on_backs = NAN, .escaped = NAN};
        const double *h = r->problem.irradiance + (r->problem.channel_count == 1 ? 0 : c) * n;
        for (size_t i = 0; i < n; i++) {
            size_t at = channels * solution->elements->patch[solution->elements->leaf[i]] + c;
            solution->irradiance[channels * i + c] = sqrt(r->area_m2[i]) * h[i];
            energy.emitted += r->area_m2[i] * patches->exitance[at];
            energy.absorbed += r->area_m2[i] * (1 - patches->reflectance[at]) * h[i];
        }
        solution->energy[c] = energy;
    }
    solution->summary.sweeps = r->problem.sweeps;
}

static hpr_status show(void *user, int shots)
{
    run *r = user;
    hpr_context *ctx = r->solution->context;
    take_over(r);
    hpr_stage_end(ctx); /* what is done with it is no part of the solving */
    hpr_status status = r->baseline->shot(r->baseline->user, r->solution, shots);
    hpr_stage_begin(ctx, "solver");
    return status;
}

static void summarise(run *r)
{
    hpr_solve_summary *s = &r->solution->summary;
    s->link_count = r->done.pair_count;
    s->block_bytes = r->problem.count * r->problem.count * sizeof(double);
    s->short_count = r->done.short_count;
    s->occluded = r->done.blocked;
    s->channels_solved = r->problem.channel_count;
    s->solver = (int)r->problem.used;
    s->residual = r->problem.residual;
    if (r->done.short_count)
        hpr_warn(r->solution->context, "%zu form factors stopped short of their tolerance",
                 r->done.short_count);
}

static hpr_status solve(run *r, const hpr_solve_options *options)
{
    hpr_solution *solution = r->solution;
    hpr_context *ctx = solution->context;
    r->problem = (hpr_matrix_problem){.context = ctx,
                                      .count = solution->elements->leaf_count,
                                      .channel_count = hpr_solution_distinct_channels(solution),
                                      .method = options->solver,
                                      .tolerance = options->solver_tolerance,
                                      .max_sweeps = options->max_sweeps,
                                      .shots = r->baseline->shots,
                                      .every = r->baseline->every,
                                      .shot = show,
                                      .user = r};
    hpr_status status = allocate(r);
    if (status == HPR_OK) {
        describe(r);
        hpr_stage_begin(ctx, "assembly");
        status = hpr_baseline_factors(solution->patches, solution->elements, options, r->baseline, r->factor,
                                      &r->done);
        hpr_stage_end(ctx);
    }
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "solver");
        status = hpr_matrix_solve(&r->problem);
        hpr_stage_end(ctx);
    }
    if (status == HPR_OK) {
        take_over(r);
        summarise(r);
    }
    double *arrays[] = {r->factor, r->area_m2, r->reflectance, r->exitance, r->problem.irradiance};
    for (size_t i = 0; i < sizeof arrays / sizeof *arrays; i++)
        hpr_release(ctx, arrays[i]);
    return status;
}

hpr_status hpr_baseline_solve(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                              const hpr_baseline_options *baseline, hpr_solution **out)
{
    hpr_solve_options chosen;
    hpr_baseline_options defaults;
    hpr_solve_options_init(&chosen);
    hpr_baseline_options_init(&defaults);
    if (options)
        chosen = *options;
    run r = {.baseline = baseline ? baseline : &defaults};
    if (chosen.method <= HPR_METHOD_HIERARCHICAL)
        return hpr_solve(ctx, scene, &chosen, out);
    hpr_context_clear_error(ctx);
    *out = NULL;
    if (chosen.method > HPR_METHOD_EXACT)
        return hpr_fail(ctx, HPR_ERR_ARG, "method %d does not exist", (int)chosen.method);
    hpr_status status = take_options(ctx, scene, r.baseline, &chosen);
    if (status == HPR_OK)
        status = hpr_solution_begin(ctx, scene, &chosen, &r.solution);
    if (status == HPR_OK && hpr_solution_lit(r.solution, scene))
        status = solve(&r, &chosen);
    if (status != HPR_OK)
        hpr_solution_destroy(&r.solution);
    *out = r.solution;
    return status;
}
