/* Solution file or scene file -> one picture per camera. */
#include "app/pictures.h"
#include "render/renderer.h"
#include "solver/solution.h"

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

/* The layers of the picture, with what the false colours need. */
static hpr_view_options view_of(const hpr_job_render_options *options)
{
    hpr_view_options view = options->view;
    if (options->false_colour)
        view.layers |= 1u << HPR_LAYER_IRRADIANCE;
    return view;
}

static hpr_status render_picture(hpr_job *job, hpr_renderer *renderer, const hpr_solution *solution,
                                 const hpr_pictures *list, size_t i)
{
    const hpr_job_render_options *options = list->options;
    double centre[3];
    hpr_patches_radius(solution->patches, centre);
    hpr_camera camera = hpr_pictures_view(list, i, solution->camera, centre);
    const hpr_image_labels labels = {.channel_name = (const char *const *)solution->channel_name,
                                     .scene = solution->scene_name,
                                     .camera = camera.name};
    hpr_image image = {0}, reference = {0};
    hpr_render_options film = options->render;
    hpr_view_options view = view_of(options);
    hpr_status status = hpr_pictures_reference(job, list, i, &labels, solution->channel_count, &reference);
    if (reference.radiance && film.width == 0 && film.height == 0) {
        film.width = reference.full_width;
        film.height = reference.full_height;
    }
    if (status == HPR_OK)
        status = hpr_job_enter(job, HPR_JOB_RENDER);
    if (status == HPR_OK)
        status = hpr_renderer_render(renderer, &camera, &film, &view, &image);
    if (status == HPR_OK)
        status = hpr_pictures_write(job, list, i, &image, &reference, &labels);
    hpr_image_fini(job->context, &reference);
    hpr_image_fini(job->context, &image);
    return status;
}

static hpr_status render_pictures(hpr_job *job, const hpr_solution *solution, const hpr_pictures *list)
{
    hpr_renderer *renderer = NULL;
    hpr_status status = hpr_job_enter(job, HPR_JOB_RENDER);
    if (status != HPR_OK)
        return status;
    hpr_stage_begin(job->context, "render");
    status = hpr_renderer_create(job->context, solution, &renderer);
    hpr_stage_end(job->context);
    for (size_t i = 0; i < list->count && status == HPR_OK; i++)
        status = render_picture(job, renderer, solution, list, i);
    hpr_renderer_destroy(&renderer);
    return status;
}

static hpr_status plan_pictures(hpr_job *job, const hpr_job_render_options *options, const char *input_path,
                                bool insert_camera, size_t camera_count, const hpr_camera *cameras,
                                hpr_pictures *list)
{
    const hpr_picture_source source = {.path = input_path,
                                       .tail = ".exr",
                                       .insert_camera = insert_camera,
                                       .camera_count = camera_count,
                                       .camera = cameras};
    return hpr_pictures_plan(job, options, &source, list);
}

static hpr_status run_scene(hpr_job *job, const char *path, const hpr_job_picture_options *options,
                            bool insert_camera)
{
    hpr_scene *scene = NULL;
    hpr_solution *solution = NULL;
    hpr_pictures list = {0};
    const hpr_job_render_options *pictures = &options->pictures;
    hpr_status status = hpr_job_read_scene(job, path, &options->read, &scene);
    if (status == HPR_OK && pictures->environment_count)
        status = hpr_scene_set_environment(scene, pictures->environment_count, pictures->environment);
    if (status == HPR_OK)
        status = plan_pictures(job, &options->pictures, path, insert_camera, scene->camera_count,
                               scene->camera, &list);
    if (status == HPR_OK)
        status = hpr_job_run_solve(job, scene, &options->solve, NULL, NULL, &solution);
    if (status == HPR_OK)
        status = render_pictures(job, solution, &list);
    if (status == HPR_OK)
        status = hpr_job_write_report(job, solution, path, pictures->report_path);
    if (status == HPR_OK)
        status = hpr_job_judge(job, solution, path);
    hpr_pictures_release(job->context, &list);
    hpr_solution_destroy(&solution);
    hpr_scene_destroy(&scene);
    return status;
}

static hpr_status run_solution(hpr_job *job, const char *path, const hpr_job_render_options *options)
{
    hpr_solution *solution = NULL;
    hpr_pictures list = {0};
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
        status = render_pictures(job, solution, &list);
    if (status == HPR_OK)
        status = hpr_job_write_report(job, solution, NULL, options->report_path);
    hpr_pictures_release(job->context, &list);
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
    hpr_status status = hpr_pictures_check(&job, input_path, &all.pictures);
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
    hpr_status status = hpr_pictures_check(&job, scene_path, &options->pictures);
    if (status == HPR_OK)
        status = run_scene(&job, scene_path, options, true);
    return hpr_job_end(&job, status);
}
