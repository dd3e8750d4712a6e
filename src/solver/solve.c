/* From a scene to a solution: patches, elements, links, the linear system, the energy balance. */
#include "link/direct_moments.h"
#include "link/links.h"
#include "patch/frame.h"
#include "patch/grade.h"
#include "solver/energy.h"
#include "solver/linear.h"
#include "solver/operator.h"
#include "solver/outside.h"
#include "solver/resolution.h"
#include "solver/solution.h"

#include <math.h>
#include <string.h>

void hpr_solve_options_init(hpr_solve_options *options)
{
    *options = (hpr_solve_options){.order = HPR_CHOOSE,
                                   .subdivide = HPR_CHOOSE,
                                   .feet = HPR_CHOOSE,
                                   .solver_tolerance = 1e-13,
                                   .max_sweeps = 20000};
}

const char *hpr_method_name(hpr_method method)
{
    static const char *const names[] = {
        [HPR_METHOD_GALERKIN] = "galerkin", [HPR_METHOD_HIERARCHICAL] = "hierarchical",
        [HPR_METHOD_HEMICUBE] = "hemicube", [HPR_METHOD_RAYCAST] = "raycast",
        [HPR_METHOD_EXACT] = "exact",
    };
    return names[method];
}

static hpr_status check_options(hpr_context *ctx, const hpr_solve_options *options)
{
    if (options->order < HPR_CHOOSE || options->order > HPR_MAX_ORDER)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d is not in 0 .. %d", options->order, HPR_MAX_ORDER);
    if (options->subdivide < HPR_CHOOSE || options->subdivide > HPR_MAX_SUBDIVIDE)
        return hpr_fail(ctx, HPR_ERR_ARG, "subdivision %d is not in 0 .. %d", options->subdivide,
                        HPR_MAX_SUBDIVIDE);
    if (options->feet < HPR_CHOOSE || options->feet > HPR_MAX_FEET)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d quarterings at feet are not in 0 .. %d", options->feet,
                        HPR_MAX_FEET);
    if (options->grade < 0 || options->grade > HPR_MAX_GRADE)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d levels of grading are not in 0 .. %d", options->grade,
                        HPR_MAX_GRADE);
    if (!(options->link_tolerance >= 0 && options->link_tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "link tolerance %g is not in [0, 1)", options->link_tolerance);
    if (!(options->block_tolerance >= 0 && options->block_tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "block tolerance %g is not in [0, 1)", options->block_tolerance);
    if (!(options->solver_tolerance > 0 && options->solver_tolerance < 1))
        return hpr_fail(ctx, HPR_ERR_ARG, "solver tolerance %g is not in (0, 1)", options->solver_tolerance);
    if (options->max_sweeps < 1)
        return hpr_fail(ctx, HPR_ERR_ARG, "at least one sweep is needed, not %d", options->max_sweeps);
    return HPR_OK;
}

static hpr_status copy_text(hpr_context *ctx, const char *text, char **copy)
{
    *copy = hpr_duplicate_text(ctx, text ? text : "");
    return *copy ? HPR_OK : hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a name");
}

static hpr_status copy_cameras(hpr_solution *solution, const hpr_scene *scene)
{
    hpr_context *ctx = solution->context;
    hpr_camera framing;
    const hpr_camera *cameras = scene->camera;
    size_t count = scene->camera_count;
    if (count == 0) {
        hpr_patches_frame(solution->patches, &framing);
        cameras = &framing;
        count = 1;
    }
    hpr_status status = hpr_allocate_into(ctx, &solution->camera, count, sizeof *solution->camera, "cameras");
    solution->camera_count = status == HPR_OK ? count : 0;
    for (size_t i = 0; status == HPR_OK && i < count; i++) {
        solution->camera[i] = cameras[i];
        status = copy_text(ctx, cameras[i].name, &solution->camera[i].name);
    }
    return status;
}

static hpr_status describe(hpr_solution *solution, const hpr_scene *scene)
{
    hpr_context *ctx = solution->context;
    size_t n = scene->channel_count;
    const char *slash = strrchr(scene->path, '/');
    hpr_status status = copy_text(ctx, slash ? slash + 1 : scene->path, &solution->scene_name);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->channel_name, n, sizeof(char *), "channel names");
    solution->channel_count = n;
    for (size_t c = 0; status == HPR_OK && c < n; c++)
        status = copy_text(ctx, scene->channel_name[c], &solution->channel_name[c]);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->environment, n, sizeof(double), "light from outside");
    if (status == HPR_OK)
        memcpy(solution->environment, scene->environment, n * sizeof(double));
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->energy, n, sizeof *solution->energy, "energy terms");
    return status;
}

/* Quarters the elements that the foot of an object cuts, `times` times: there H has a jump in its
 * derivatives, or in itself. */
static hpr_status refine_feet(hpr_solution *solution, int times)
{
    hpr_context *ctx = solution->context;
    hpr_status status = HPR_OK;
    for (int time = 0; status == HPR_OK && time < times; time++) {
        hpr_coverage *coverage = NULL;
        bool *marked = NULL;
        size_t count = solution->elements->leaf_count, found = 0;
        status = hpr_coverage_create(solution->patches, solution->elements, &coverage);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &marked, count, sizeof *marked, "elements");
        for (size_t leaf = 0; status == HPR_OK && leaf < count; leaf++) {
            int parts;
            marked[leaf] = hpr_coverage_parts(coverage, leaf, &parts) && parts > 0;
            found += marked[leaf];
        }
        if (status == HPR_OK && found)
            status = hpr_elements_split(solution->patches, solution->elements, marked);
        hpr_release(ctx, marked);
        hpr_coverage_destroy(&coverage);
        if (!found)
            break;
    }
    return status;
}

static void choose_resolution(hpr_solution *solution, const hpr_scene *scene)
{
    hpr_solve_options *options = &solution->summary.options;
    if (!hpr_resolution_choose(solution->patches, options))
        hpr_warn(solution->context,
                 "%s: %zu patches are many for --order %d --subdivide %d --feet %d, so it is --order %d "
                 "--subdivide %d --feet %d; these options choose otherwise",
                 scene->path, solution->patches->count, HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE,
                 HPR_DEFAULT_FEET, options->order, options->subdivide, options->feet);
}

static hpr_status grade(hpr_solution *solution, int levels)
{
    size_t skipped = 0;
    hpr_status status = hpr_elements_grade(solution->patches, solution->elements, levels, &skipped);
    if (status == HPR_OK && skipped > 0)
        hpr_warn(solution->context, "--grade: %zu patches are triangles and stay as they are", skipped);
    return status;
}

static hpr_status make_mesh(hpr_solution *solution, const hpr_scene *scene)
{
    hpr_context *ctx = solution->context;
    const hpr_solve_options *options = &solution->summary.options;
    hpr_status status = hpr_patches_build(scene, &solution->patches);
    if (status == HPR_OK) {
        choose_resolution(solution, scene);
        status =
            hpr_elements_uniform(solution->patches, options->order, options->subdivide, &solution->elements);
    }
    if (status == HPR_OK && options->grade > 0)
        status = grade(solution, options->grade);
    if (status == HPR_OK)
        status = refine_feet(solution, options->feet);
    if (status != HPR_OK)
        return status;
    const hpr_elements *e = solution->elements;
    size_t dofs = e->dof[e->leaf_count];
    status = hpr_allocate_into(ctx, &solution->irradiance, dofs * solution->channel_count, sizeof(double),
                               "the solution");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->surroundings,
                                   solution->patches->count * solution->channel_count, sizeof(double),
                                   "the solution");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->error, e->leaf_count, sizeof(double), "the solution");
    for (size_t i = 0; status == HPR_OK && i < e->leaf_count; i++)
        solution->error[i] = NAN;
    solution->summary.patch_count = solution->patches->count;
    solution->summary.degenerate_count = solution->patches->degenerate_count;
    solution->summary.duplicate_count = solution->patches->duplicate_count;
    solution->summary.element_count = e->leaf_count;
    solution->summary.dof_count = dofs;
    bool exact = options->direct == HPR_DIRECT_EXACT && hpr_direct_affordable(solution->patches);
    solution->summary.direct = exact ? HPR_DIRECT_EXACT : HPR_DIRECT_GALERKIN;
    return status;
}

static bool channels_agree(const hpr_solution *solution)
{
    const hpr_patches *patches = solution->patches;
    size_t n = patches->channel_count;
    for (size_t c = 1; c < n; c++) {
        if (solution->environment[c] != solution->environment[0])
            return false;
    }
    for (size_t i = 0; i < patches->count * n; i++) {
        size_t first = i - i % n;
        if (patches->exitance[i] != patches->exitance[first] ||
            patches->reflectance[i] != patches->reflectance[first])
            return false;
    }
    return true;
}

size_t hpr_solution_distinct_channels(const hpr_solution *solution)
{
    return channels_agree(solution) ? 1 : solution->channel_count;
}

static bool has_light(const hpr_solution *solution)
{
    const hpr_patches *patches = solution->patches;
    for (size_t i = 0; i < patches->count * patches->channel_count; i++) {
        if (patches->exitance[i] > 0)
            return true;
    }
    return hpr_outside_shines(solution);
}

/* The first to_channels of each row of a table [count][from_channels]. */
static void take_channels(double *to, size_t to_channels, const double *from, size_t from_channels,
                          size_t count)
{
    for (size_t i = 0; i < count; i++)
        memcpy(to + i * to_channels, from + i * from_channels, to_channels * sizeof *to);
}

/* Solves as many channels as differ. direct: [channels][dofs] */
static hpr_status solve_system(hpr_solution *solution, const hpr_links *links, const hpr_coverage *coverage,
                               const double *direct, const hpr_solve_options *options)
{
    hpr_context *ctx = solution->context;
    const hpr_patches *patches = solution->patches;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    size_t solved = hpr_solution_distinct_channels(solution);
    double *reflectance = NULL;
    hpr_linear_problem problem = {.patches = patches,
                                  .links = links,
                                  .channel_count = solved,
                                  .coverage = coverage,
                                  .direct = direct,
                                  .method = options->solver,
                                  .tolerance = options->solver_tolerance,
                                  .max_sweeps = options->max_sweeps};
    hpr_status status =
        hpr_allocate_into(ctx, &reflectance, patches->count * solved, sizeof(double), "the solver");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &problem.irradiance, dofs * solved, sizeof(double), "the solver");
    if (status == HPR_OK) {
        take_channels(reflectance, solved, patches->reflectance, n, patches->count);
        memcpy(problem.irradiance, direct, dofs * solved * sizeof *direct);
        problem.reflectance = reflectance;
        status = hpr_linear_solve(&problem);
        for (size_t i = 0; i < n * dofs; i++)
            solution->irradiance[i] = problem.irradiance[(solved == 1 ? 0 : i % n) * dofs + i / n];
    }
    solution->summary.channels_solved = solved;
    solution->summary.solver = (int)problem.used;
    solution->summary.sweeps = problem.sweeps;
    solution->summary.residual = problem.residual;
    hpr_release(ctx, reflectance);
    hpr_release(ctx, problem.irradiance);
    return status;
}

/* D = K M: through the blocks. */
static hpr_status gather_direct(const hpr_solution *solution, const hpr_links *links, double *direct)
{
    hpr_context *ctx = solution->context;
    const hpr_patches *patches = solution->patches;
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    double *emission = NULL;
    hpr_operator *op = NULL;
    hpr_status status = hpr_allocate_into(ctx, &emission, n * dofs, sizeof(double), "direct light");
    if (status != HPR_OK)
        return status;
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        size_t node = e->leaf[leaf];
        for (size_t c = 0; c < n; c++)
            emission[c * dofs + e->dof[leaf]] =
                sqrt(e->area_m2[node]) * patches->exitance[n * e->patch[node] + c];
    }
    status = hpr_operator_create(links, n, &op);
    if (status == HPR_OK)
        hpr_operator_apply(op, emission, direct);
    hpr_operator_destroy(&op);
    hpr_release(ctx, emission);
    return status;
}

/* The moments of D by clipping: where D jumps the quadrature is cut, so that what the elements cannot show of
 * D is orthogonal to what they send. */
static hpr_status project_direct(hpr_solution *solution, const hpr_coverage *coverage, double *direct)
{
    static const double tolerance = 1e-5;
    hpr_direct *emitters = NULL;
    size_t short_count = 0;
    hpr_status status = hpr_direct_create(solution->patches, solution->elements, &emitters);
    if (status == HPR_OK)
        status = hpr_direct_moments(emitters, coverage, solution->elements, tolerance, direct, &short_count);
    hpr_direct_destroy(&emitters);
    return status;
}

static hpr_status find_direct(hpr_solution *solution, const hpr_links *links, const hpr_coverage *coverage,
                              double *direct)
{
    if (solution->summary.direct == HPR_DIRECT_EXACT)
        return project_direct(solution, coverage, direct);
    return gather_direct(solution, links, direct);
}

static void summarise_links(hpr_solution *solution, const hpr_links *links)
{
    hpr_solve_summary *summary = &solution->summary;
    summary->link_count = links->count;
    summary->block_bytes = links->block_count * sizeof(double);
    summary->link_tolerance = links->link_tolerance;
    summary->link_error = links->link_error;
    summary->block_tolerance = links->tolerance;
    summary->blocked_tolerance = links->blocked_tolerance;
    summary->visibility_error = links->sampling_error;
    summary->short_count = links->short_count;
    summary->block_error = links->block_error;
    summary->sampled_error = links->sampled_error;
    summary->occluded = links->occluded;
    if (links->short_count)
        hpr_warn(solution->context, "%zu kernel blocks stopped short of their tolerance", links->short_count);
}

/* H without what is evaluated where it is wanted. Destroys `direct`. */
static void take_out(hpr_solution *solution, const hpr_coverage *coverage, const double *outside,
                     double *direct)
{
    const hpr_elements *e = solution->elements;
    size_t n = solution->channel_count, dofs = solution->summary.dof_count;
    hpr_outside_split(solution, outside, direct);
    for (size_t leaf = 0; leaf < e->leaf_count; leaf++) {
        for (size_t c = 0; c < n; c++)
            hpr_coverage_project(coverage, leaf, direct + c * dofs + e->dof[leaf]);
    }
    for (size_t i = 0; i < n * dofs; i++)
        solution->irradiance[i] -= direct[i % n * dofs + i / n];
}

static hpr_status link_up(const hpr_solution *solution, const hpr_coverage *coverage,
                          const hpr_solve_options *options, hpr_links **links)
{
    const hpr_patches *patches = solution->patches;
    size_t n = patches->channel_count;
    bool *sends = NULL;
    hpr_status status = hpr_allocate_into(solution->context, &sends, patches->count, sizeof *sends, "links");
    if (status != HPR_OK)
        return status;
    bool emission = solution->summary.direct == HPR_DIRECT_GALERKIN;
    for (size_t i = 0; i < patches->count * n; i++)
        sends[i / n] |= patches->reflectance[i] > 0 || (emission && patches->exitance[i] > 0);
    const hpr_links_demand demand = {.link_tolerance = options->link_tolerance,
                                     .block_tolerance = options->block_tolerance,
                                     .sends = sends,
                                     .constant = options->method == HPR_METHOD_HIERARCHICAL};
    status = hpr_links_assemble(coverage, solution->elements, &demand, links);
    hpr_release(solution->context, sends);
    return status;
}

/* Stages in order; each fills its part of the solution. The energy terms need the whole H. */
static hpr_status transport(hpr_solution *solution, const hpr_solve_options *options)
{
    hpr_context *ctx = solution->context;
    hpr_links *links = NULL;
    hpr_coverage *coverage = NULL;
    double *direct = NULL, *outside = NULL; /* [channels][dofs]; [dofs] */
    hpr_stage_begin(ctx, "assembly");
    hpr_status status = hpr_coverage_create(solution->patches, solution->elements, &coverage);
    if (status == HPR_OK)
        status = link_up(solution, coverage, options, &links);
    hpr_stage_end(ctx);
    if (status == HPR_OK) {
        summarise_links(solution, links);
        status = hpr_allocate_into(ctx, &direct, solution->channel_count * solution->summary.dof_count,
                                   sizeof *direct, "direct light");
    }
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &outside, solution->summary.dof_count, sizeof *outside,
                                   "light from outside");
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "direct light");
        status = find_direct(solution, links, coverage, direct);
        hpr_stage_end(ctx);
    }
    if (status == HPR_OK && hpr_outside_shines(solution)) {
        hpr_stage_begin(ctx, "environment");
        status = hpr_outside_project(solution, coverage, outside);
        hpr_stage_end(ctx);
        hpr_outside_add(solution, outside, direct);
    }
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "solver");
        status = solve_system(solution, links, coverage, direct, options);
        hpr_stage_end(ctx);
    }
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "energy");
        status = hpr_energy_compute(solution, coverage, outside);
        hpr_stage_end(ctx);
    }
    if (status == HPR_OK)
        take_out(solution, coverage, outside, direct);
    hpr_release(ctx, direct);
    hpr_release(ctx, outside);
    hpr_coverage_destroy(&coverage);
    hpr_links_destroy(&links);
    return status;
}

bool hpr_solution_lit(const hpr_solution *solution, const hpr_scene *scene)
{
    if (solution->patches->count == 0)
        hpr_warn(solution->context, "%s: no surface; the solution is empty", scene->path);
    else if (!has_light(solution))
        hpr_warn(solution->context, "%s: no light; the solution is zero", scene->path);
    else
        return true;
    return false;
}

hpr_status hpr_solution_begin(hpr_context *ctx, const hpr_scene *scene, const hpr_solve_options *options,
                              hpr_solution **out)
{
    hpr_solution *solution = NULL;
    *out = NULL;
    hpr_status status = check_options(ctx, options);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution, 1, sizeof *solution, "a solution");
    if (status != HPR_OK)
        return status;
    solution->context = ctx;
    solution->summary.options = *options;
    hpr_stage_begin(ctx, "mesh");
    status = describe(solution, scene);
    if (status == HPR_OK)
        status = make_mesh(solution, scene);
    if (status == HPR_OK)
        status = copy_cameras(solution, scene);
    hpr_stage_end(ctx);
    if (status != HPR_OK)
        hpr_solution_destroy(&solution);
    *out = solution;
    return status;
}

/* What a method of this operator asks for. */
static hpr_status take_method(hpr_context *ctx, hpr_solve_options *options)
{
    static const double hierarchical_tolerance = 0.3;
    if (options->solver == HPR_SOLVER_DIRECT)
        return hpr_fail(ctx, HPR_ERR_ARG, "elimination needs a full matrix, method '%s' has none",
                        hpr_method_name(options->method));
    if (options->method == HPR_METHOD_GALERKIN)
        return HPR_OK;
    if (options->method != HPR_METHOD_HIERARCHICAL)
        return hpr_fail(ctx, HPR_ERR_ARG, "method %d is none of hpr_solve", (int)options->method);
    if (options->order > 0)
        return hpr_fail(ctx, HPR_ERR_ARG, "order %d: method '%s' has one constant per element",
                        options->order, hpr_method_name(options->method));
    options->order = 0;
    options->direct = HPR_DIRECT_GALERKIN;
    if (options->link_tolerance == 0)
        options->link_tolerance = hierarchical_tolerance;
    return HPR_OK;
}

hpr_status hpr_solve(hpr_context *context, const hpr_scene *scene, const hpr_solve_options *options,
                     hpr_solution **out)
{
    hpr_solve_options chosen;
    hpr_solve_options_init(&chosen);
    if (options)
        chosen = *options;
    hpr_context_clear_error(context);
    *out = NULL;
    hpr_solution *solution = NULL;
    hpr_status status = take_method(context, &chosen);
    if (status == HPR_OK)
        status = hpr_solution_begin(context, scene, &chosen, &solution);
    if (status == HPR_OK && hpr_solution_lit(solution, scene))
        status = transport(solution, &chosen);
    if (status != HPR_OK)
        hpr_solution_destroy(&solution);
    *out = solution;
    return status;
}
