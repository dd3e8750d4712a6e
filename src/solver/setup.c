#include "solver/setup.h"

#include "direct/direct.h"
#include "link/coverage.h"
#include "patch/frame.h"
#include "patch/grade.h"
#include "solver/resolution.h"

#include <math.h>
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
    if (options->tolerance > 0)
        hpr_resolution_begin(solution->patches, options);
    else if (!hpr_resolution_choose(solution->patches, options))
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

hpr_status hpr_setup_elements(hpr_solution *solution, const hpr_scene *scene)
{
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
