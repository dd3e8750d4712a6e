/* Solution file or scene file -> one picture per camera. */
#include "app/job.h"
#include "app/names.h"
#include "solver/solution.h"

#include <string.h>

/* The pictures of one job: what is rendered and where it goes. */
typedef struct picture_list {
    size_t camera_count;
    char **label; /* [camera_count] as {camera} names them */
    size_t count;
    size_t *camera;  /* [count] index of the camera */
    char **exr_path; /* [count] */
    char **png_path; /* [count], entries NULL without preview */
} picture_list;

void hpr_job_render_options_init(hpr_job_render_options *options)
{
    *options = (hpr_job_render_options){0};
    hpr_render_options_init(&options->render);
}

void hpr_job_picture_options_init(hpr_job_picture_options *options)
{
    *options = (hpr_job_picture_options){0};
    hpr_read_options_init(&options->read);
    hpr_solve_options_init(&options->solve);
    hpr_job_render_options_init(&options->pictures);
}

static void release_texts(hpr_context *ctx, size_t count, char **text)
{
    for (size_t i = 0; text && i < count; i++)
        hpr_release(ctx, text[i]);
    hpr_release(ctx, text);
}

static void release_list(hpr_context *ctx, picture_list *list)
{
    hpr_camera_labels_release(ctx, list->camera_count, &list->label);
    release_texts(ctx, list->count, list->exr_path);
    release_texts(ctx, list->count, list->png_path);
    hpr_release(ctx, list->camera);
    *list = (picture_list){0};
}

/* Names the cameras and chooses among them. A scene without camera will get one, without name. */
static hpr_status choose_cameras(hpr_context *ctx, size_t count, const hpr_camera *cameras,
                                 const char *wanted, picture_list *list)
{
    const char **name = NULL;
    size_t first = 0;
    list->camera_count = count ? count : 1;
    list->count = 0;
    hpr_status status = hpr_allocate_into(ctx, &name, list->camera_count, sizeof *name, "camera names");
    if (status != HPR_OK)
        return status;
    for (size_t i = 0; i < count; i++)
        name[i] = cameras[i].name;
    status = hpr_camera_labels(ctx, list->camera_count, name, &list->label);
    if (status != HPR_OK)
        goto cleanup;
    bool all = !wanted || !strcmp(wanted, "all");
    if (!all)
        status = hpr_camera_find(ctx, list->camera_count, name, list->label, wanted, &first);
    if (status != HPR_OK)
        goto cleanup;
    size_t chosen = all ? list->camera_count : 1;
    status = hpr_allocate_into(ctx, &list->camera, chosen, sizeof *list->camera, "a list of cameras");
    if (status != HPR_OK)
        goto cleanup;
    list->count = chosen;
    for (size_t i = 0; i < chosen; i++)
        list->camera[i] = first + i;
cleanup:
    hpr_release(ctx, name);
    return status;
}

/* The pattern in force, owned by the caller: the given or the default one, told apart by camera if needed. */
static hpr_status choose_pattern(hpr_context *ctx, const hpr_job_render_options *options,
                                 const char *input_path, bool insert_camera, const picture_list *list,
                                 char **pattern)
{
    const char *given = options->pattern;
    *pattern = given ? hpr_duplicate_text(ctx, given) : hpr_name_default(ctx, input_path, ".exr");
    if (*pattern && list->count > 1 && (!given || (insert_camera && !hpr_name_varies(given)))) {
        char *varied = hpr_name_insert_camera(ctx, *pattern);
        hpr_release(ctx, *pattern);
        *pattern = varied;
    }
    if (!*pattern)
        return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
    if (list->count > 1 && given && !insert_camera && !hpr_name_varies(given))
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "output name '%s' is one for %zu cameras; put {camera} into it or choose a camera "
                        "(--camera)",
                        given, list->count);
    return HPR_OK;
}

static hpr_status name_pictures(hpr_job *job, const char *pattern, bool preview, picture_list *list)
{
    hpr_context *ctx = job->context;
    hpr_status status =
        hpr_allocate_into(ctx, &list->exr_path, list->count, sizeof *list->exr_path, "file names");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &list->png_path, list->count, sizeof *list->png_path, "file names");
    for (size_t i = 0; i < list->count && status == HPR_OK; i++) {
        const char *label = list->label[list->camera[i]];
        status = hpr_name_expand(ctx, pattern, label, i, &list->exr_path[i]);
        if (status == HPR_OK)
            status = hpr_outputs_claim(&job->outputs, list->exr_path[i]);
        if (status != HPR_OK || !preview)
            continue;
        list->png_path[i] = hpr_name_beside(ctx, list->exr_path[i], ".png");
        if (!list->png_path[i])
            return hpr_fail(ctx, HPR_ERR_MEMORY, "out of memory for a file name");
        status = hpr_outputs_claim(&job->outputs, list->png_path[i]);
    }
    return status;
}

/* Everything about the pictures that can be refused before a long solve. */
static hpr_status plan_pictures(hpr_job *job, const hpr_job_render_options *options, const char *input_path,
                                bool insert_camera, size_t camera_count, const hpr_camera *cameras,
                                picture_list *list)
{
    char *pattern = NULL;
    hpr_status status = hpr_job_enter(job, HPR_JOB_CHECK);
    if (status == HPR_OK)
        status = choose_cameras(job->context, camera_count, cameras, options->camera, list);
    if (status == HPR_OK)
        status = choose_pattern(job->context, options, input_path, insert_camera, list, &pattern);
    if (status == HPR_OK)
        status = name_pictures(job, pattern, options->preview, list);
    hpr_release(job->context, pattern);
    return status;
}

static hpr_status write_exr(hpr_job *job, const hpr_solution *solution, const picture_list *list, size_t i,
                            const hpr_image *image, hpr_job_file *file)
{
    const char *name = hpr_solution_camera_name(solution, list->camera[i]);
    hpr_image_labels labels = {.channel_name = (const char *const *)solution->channel_name,
                               .scene = solution->scene_name,
                               .camera = name && name[0] ? name : file->camera};
    file->kind = HPR_JOB_FILE_EXR;
    file->path = list->exr_path[i];
    hpr_status status = hpr_image_write_exr(job->context, image, &labels, file->path);
    if (status != HPR_OK)
        return status;
    job->result->picture_count++;
    hpr_job_wrote(job, file);
    return HPR_OK;
}

static hpr_status write_png(hpr_job *job, double exposure, const char *path, const hpr_image *image,
                            hpr_job_file *file)
{
    file->kind = HPR_JOB_FILE_PNG;
    file->path = path;
    hpr_status status = hpr_image_write_png(job->context, image, exposure, path, &file->exposure);
    if (status == HPR_OK)
        hpr_job_wrote(job, file);
    return status;
}

static hpr_status write_picture(hpr_job *job, const hpr_job_render_options *options,
                                const hpr_solution *solution, const picture_list *list, size_t i,
                                const hpr_image *image)
{
    hpr_job_file file = {
        .camera = list->label[list->camera[i]], .width = image->width, .height = image->height};
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(job->context, "write");
    status = write_exr(job, solution, list, i, image, &file);
    if (status == HPR_OK && list->png_path[i])
        status = write_png(job, options->exposure, list->png_path[i], image, &file);
    hpr_stage_end(job->context);
    return status;
}

static hpr_status render_pictures(hpr_job *job, const hpr_job_render_options *options,
                                  const hpr_solution *solution, const picture_list *list)
{
    hpr_status status = HPR_OK;
    for (size_t i = 0; i < list->count && status == HPR_OK; i++) {
        hpr_image image = {0};
        status = hpr_job_enter(job, HPR_JOB_RENDER);
        if (status == HPR_OK)
            status = hpr_solution_render(job->context, solution, list->camera[i], &options->render, &image);
        if (status == HPR_OK)
            status = write_picture(job, options, solution, list, i, &image);
        hpr_image_fini(job->context, &image);
    }
    return status;
}

/* What can be said of the outputs before the cameras are known. */
static hpr_status check_early(hpr_job *job, const char *input_path, const hpr_job_picture_options *options)
{
    hpr_outputs_input(&job->outputs, input_path);
    hpr_status status = HPR_OK;
    if (options->pictures.pattern)
        status = hpr_name_check(job->context, options->pictures.pattern);
    if (status == HPR_OK && options->report_path)
        status = hpr_outputs_claim(&job->outputs, options->report_path);
    return status;
}

static hpr_status run_scene(hpr_job *job, const char *path, const hpr_job_picture_options *options,
                            bool insert_camera)
{
    hpr_scene *scene = NULL;
    hpr_solution *solution = NULL;
    picture_list list = {0};
    const hpr_job_environment environment = {options->pictures.environment_count,
                                             options->pictures.environment};
    hpr_status status = hpr_job_read_scene(job, path, &options->read, environment, &scene);
    if (status == HPR_OK)
        status = plan_pictures(job, &options->pictures, path, insert_camera, scene->camera_count,
                               scene->camera, &list);
    if (status == HPR_OK)
        status = hpr_job_run_solve(job, scene, &options->solve, &solution);
    if (status == HPR_OK)
        status = render_pictures(job, &options->pictures, solution, &list);
    if (status == HPR_OK)
        status = hpr_job_write_report(job, solution, path, options->report_path);
    release_list(job->context, &list);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&scene);
    return status;
}

static hpr_status run_solution(hpr_job *job, const char *path, const hpr_job_render_options *options)
{
    hpr_solution *solution = NULL;
    picture_list list = {0};
    if (options->environment_count)
        return hpr_fail(job->context, HPR_ERR_ARG,
                        "'%s' is a solution and has its own light from outside; solve the scene again with "
                        "another --environment",
                        path);
    hpr_status status = hpr_job_enter(job, HPR_JOB_READ);
    if (status == HPR_OK) {
        hpr_stage_begin(job->context, "read");
        status = hpr_solution_read(job->context, path, &solution);
        hpr_stage_end(job->context);
    }
    if (status == HPR_OK) {
        job->result->summary = *hpr_solution_summary(solution);
        status = plan_pictures(job, options, path, false, solution->camera_count, solution->camera, &list);
    }
    if (status == HPR_OK)
        status = render_pictures(job, options, solution, &list);
    release_list(job->context, &list);
    hpr_solution_destroy(&solution);
    return status;
}

hpr_status hpr_job_render(hpr_context *ctx, const char *input_path, const hpr_job_render_options *options,
                          hpr_job_result *result)
{
    hpr_job_picture_options all;
    hpr_job_picture_options_init(&all);
    if (options)
        all.pictures = *options;
    hpr_job job;
    hpr_job_begin(&job, ctx, &all.pictures.events, result);
    hpr_status status = check_early(&job, input_path, &all);
    if (status == HPR_OK && hpr_job_is_solution(input_path))
        status = run_solution(&job, input_path, &all.pictures);
    else if (status == HPR_OK)
        status = run_scene(&job, input_path, &all, false);
    return hpr_job_end(&job, status);
}

hpr_status hpr_job_picture(hpr_context *ctx, const char *scene_path, const hpr_job_picture_options *options,
                           hpr_job_result *result)
{
    hpr_job_picture_options defaults;
    hpr_job_picture_options_init(&defaults);
    if (!options)
        options = &defaults;
    hpr_job job;
    hpr_job_begin(&job, ctx, &options->pictures.events, result);
    hpr_status status = check_early(&job, scene_path, options);
    if (status == HPR_OK)
        status = run_scene(&job, scene_path, options, true);
    return hpr_job_end(&job, status);
}
