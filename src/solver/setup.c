#include "solver/setup.h"

#include "direct/direct.h"
#include "link/coverage.h"
#include "patch/even.h"
#include "patch/frame.h"
#include "patch/grade.h"
#include "solver/resolution.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static hpr_status copy_text(hpr_context *ctx, const char *text, char **copy)
{
    *copy = hpr_duplicate_text(ctx, text ? text : "");
    return *copy ? HPR_OK : hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory: a name");
}

hpr_status hpr_setup_cameras(hpr_solution *solution, const hpr_scene *scene)
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

hpr_status hpr_setup_describe(hpr_solution *solution, const hpr_scene *scene)
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

/* Lowers the degree of the children of marked leaves, marked [node], which have been quartered. */
static hpr_status lower_degrees(const hpr_patches *patches, hpr_elements *elements, const bool *marked,
                                size_t marked_count)
{
    for (size_t i = 0; i < marked_count; i++) {
        for (uint32_t half = 0; marked[i] && half < 2; half++) {
            uint32_t child = elements->child[elements->child[i] + half];
            for (uint32_t which = 0; which < 2; which++)
                elements->degree[child + which] -= elements->degree[child + which] > 1;
        }
    }
    return hpr_elements_index(patches, elements);
}

/* The leaves that the foot of an object cuts, marked [node_count]; returns how many. */
static size_t mark_feet(const hpr_coverage *coverage, const hpr_elements *elements, bool *marked,
                        bool *leaves)
{
    size_t found = 0;
    for (size_t leaf = 0; leaf < elements->leaf_count; leaf++) {
        leaves[leaf] = hpr_coverage_cut(coverage, leaf);
        marked[elements->leaf[leaf]] = leaves[leaf];
        found += leaves[leaf];
    }
    return found;
}

/*
 * Quarters the elements that the foot of an object cuts, `times` times: there H has a jump in its
 * derivatives, or in itself. Like r^lambda it has little for a high degree to take hold of, so that each
 * quartering takes one degree away, down to 1 (linear degrees on a geometric mesh; Schwab 1998, ch. 4).
 */
static hpr_status refine_feet(hpr_solution *solution, int times)
{
    hpr_context *ctx = solution->context;
    hpr_elements *elements = solution->elements;
    hpr_status status = HPR_OK;
    for (int time = 0; status == HPR_OK && time < times; time++) {
        hpr_coverage *coverage = NULL;
        bool *marked = NULL, *leaves = NULL;
        size_t count = elements->node_count, found = 0;
        status = hpr_coverage_create(solution->patches, elements, &coverage);
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &marked, count, sizeof *marked, "elements");
        if (status == HPR_OK)
            status = hpr_allocate_into(ctx, &leaves, elements->leaf_count, sizeof *leaves, "elements");
        if (status == HPR_OK)
            found = mark_feet(coverage, elements, marked, leaves);
        if (found)
            status = hpr_elements_split(solution->patches, elements, leaves);
        if (found && status == HPR_OK)
            status = lower_degrees(solution->patches, elements, marked, count);
        hpr_release(ctx, marked);
        hpr_release(ctx, leaves);
        hpr_coverage_destroy(&coverage);
        if (!found)
            break;
    }
    return status;
}

/* What the options leave open; it is said if that is less than the default. */
static hpr_status choose_resolution(hpr_solution *solution, const hpr_scene *scene)
{
    hpr_solve_options *options = &solution->summary.options;
    hpr_status status = HPR_OK;
    char size[64] = "";
    if (options->tolerance > 0) {
        hpr_resolution_begin(solution->patches, options);
        return HPR_OK;
    }
    bool full = hpr_resolution_choose(solution->patches, options);
    if (options->element_size < 0)
        status = hpr_elements_even_within(solution->patches, options->order, HPR_RESOLUTION_DOFS,
                                          &options->element_size);
    if (status == HPR_OK && options->element_size > 0)
        snprintf(size, sizeof size, " --element-size %.4g", options->element_size);
    if (status == HPR_OK && !full)
        hpr_warn(solution->context,
                 "%s: %zu patches are many for --order %d --subdivide %d --feet %d, so it is --order %d "
                 "--subdivide %d --feet %d%s; these options choose otherwise",
                 scene->path, solution->patches->count, HPR_DEFAULT_ORDER, HPR_DEFAULT_SUBDIVIDE,
                 HPR_DEFAULT_FEET, options->order, options->subdivide, options->feet, size);
    return status;
}

static hpr_status grade(hpr_solution *solution, int levels)
{
    size_t skipped = 0;
    hpr_status status = hpr_elements_grade(solution->patches, solution->elements, levels, &skipped);
    if (status == HPR_OK && skipped > 0)
        hpr_warn(solution->context, "--grade: %zu patches are triangles and stay as they are", skipped);
    return status;
}

hpr_status hpr_setup_elements(hpr_solution *solution, const hpr_scene *scene)
{
    const hpr_solve_options *options = &solution->summary.options;
    hpr_status status = hpr_patches_build(scene, &solution->patches);
    if (status == HPR_OK)
        status = choose_resolution(solution, scene);
    if (status == HPR_OK)
        status =
            hpr_elements_uniform(solution->patches, options->order, options->subdivide, &solution->elements);
    if (status == HPR_OK && options->element_size > 0)
        status = hpr_elements_even(solution->patches, solution->elements, options->element_size);
    if (status == HPR_OK && options->grade > 0)
        status = grade(solution, options->grade);
    if (status == HPR_OK)
        status = refine_feet(solution, options->feet);
    return status;
}

hpr_status hpr_setup_arrays(hpr_solution *solution)
{
    hpr_context *ctx = solution->context;
    const hpr_elements *e = solution->elements;
    size_t dofs = e->dof[e->leaf_count], n = solution->channel_count, patches = solution->patches->count;
    hpr_release(ctx, solution->irradiance);
    hpr_release(ctx, solution->surroundings);
    hpr_release(ctx, solution->error);
    solution->irradiance = solution->surroundings = solution->error = NULL;
    hpr_status status =
        hpr_allocate_into(ctx, &solution->irradiance, dofs * n, sizeof(double), "the solution");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->surroundings, patches * n, sizeof(double), "the solution");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &solution->error, e->leaf_count, sizeof(double), "the solution");
    for (size_t i = 0; status == HPR_OK && i < e->leaf_count; i++)
        solution->error[i] = NAN;
    solution->summary.patch_count = patches;
    solution->summary.degenerate_count = solution->patches->degenerate_count;
    solution->summary.duplicate_count = solution->patches->duplicate_count;
    solution->summary.element_count = e->leaf_count;
    solution->summary.dof_count = dofs;
    bool exact =
        solution->summary.options.direct == HPR_DIRECT_EXACT && hpr_direct_affordable(solution->patches);
    solution->summary.direct = exact ? HPR_DIRECT_EXACT : HPR_DIRECT_GALERKIN;
    return status;
}
