/* Scene file -> pictures by path tracing. */
#include "app/pictures.h"
#include "io/reference_report.h"

#include <math.h>
#include <string.h>

void hpr_job_reference_options_init(hpr_job_reference_options *options)
{
    *options = (hpr_job_reference_options){0};
    hpr_read_options_init(&options->read);
    hpr_reference_options_init(&options->reference);
    hpr_job_render_options_init(&options->pictures);
    options->pictures.render.samples = HPR_DEFAULT_PATHS;
}

/* What the report says of the pictures. */
typedef struct tally {
    hpr_reference_picture *picture; /* [pictures] */
    double *value;                  /* [pictures][2][channels] where they keep their means and errors */
} tally;

static hpr_status create_tally(hpr_context *ctx, size_t pictures, size_t channels, tally *t)
{
    hpr_status status =
        hpr_allocate_into(ctx, &t->picture, pictures, sizeof *t->picture, "the pictures' noise");
    if (status == HPR_OK)
        status =
            hpr_allocate_into(ctx, &t->value, pictures, 2 * channels * sizeof(double), "the pictures' noise");
    for (size_t i = 0; status == HPR_OK && i < pictures; i++) {
        t->picture[i].mean_radiance = t->value + 2 * channels * i;
        t->picture[i].standard_error = t->picture[i].mean_radiance + channels;
    }
    return status;
}

static void measure(const hpr_image *image, const char *camera, hpr_reference_picture *picture)
{
    size_t pixels = (size_t)image->width * (size_t)image->height, n = image->channel_count;
    double signal = 0, noise = 0;
    for (size_t c = 0; c < n; c++) {
        double sum = 0, variance = 0;
        for (size_t i = c; i < n * pixels; i += n) {
            sum += (double)image->radiance[i];
            variance += (double)image->variance[i];
            signal += (double)image->radiance[i] * (double)image->radiance[i];
        }
        noise += variance;
        picture->mean_radiance[c] = sum / (double)pixels;
        picture->standard_error[c] = sqrt(variance) / (double)pixels;
    }
    picture->camera = camera;
    picture->width = image->width;
    picture->height = image->height;
    picture->noise = signal > 0 ? sqrt(noise / signal) : 0;
}

static hpr_status write_picture(hpr_job *job, const hpr_scene *scene, const hpr_pictures *list, size_t i,
                                const hpr_image *image)
{
    const char *slash = strrchr(scene->path, '/');
    hpr_image_labels labels = {.channel_name = (const char *const *)scene->channel_name,
                               .scene = slash ? slash + 1 : scene->path};
    if (scene->camera_count)
        labels.camera = scene->camera[hpr_pictures_camera(list, i)].name;
    return hpr_pictures_write(job, list, i, image, NULL, &labels);
}

static hpr_status trace_pictures(hpr_job *job, const hpr_job_reference_options *options,
                                 const hpr_scene *scene, const hpr_reference *reference,
                                 const hpr_pictures *list, tally *t)
{
    hpr_status status = HPR_OK;
    for (size_t i = 0; i < list->count && status == HPR_OK; i++) {
        hpr_image image = {0};
        size_t camera = hpr_pictures_camera(list, i);
        status = hpr_job_enter(job, HPR_JOB_RENDER);
        if (status == HPR_OK)
            status = hpr_reference_render(job->context, reference, camera, &options->pictures.render, &image);
        if (status == HPR_OK) {
            measure(&image, list->label[camera], &t->picture[i]);
            job->result->noise = fmax(job->result->noise, t->picture[i].noise);
            status = write_picture(job, scene, list, i, &image);
        }
        hpr_image_fini(job->context, &image);
    }
    return status;
}

static hpr_status write_report(hpr_job *job, const hpr_reference_report *report, const char *path)
{
    if (!path)
        return HPR_OK;
    hpr_status status = hpr_job_enter(job, HPR_JOB_WRITE);
    if (status == HPR_OK)
        status = hpr_reference_report_write(job->context, report, path);
    if (status == HPR_OK)
        hpr_job_wrote(job, &(hpr_job_file){.kind = HPR_JOB_FILE_REPORT, .path = path});
    return status;
}

static hpr_status run(hpr_job *job, const char *path, const hpr_job_reference_options *options)
{
    hpr_context *ctx = job->context;
    hpr_scene *scene = NULL;
    hpr_reference *reference = NULL;
    hpr_pictures list = {0};
    tally t = {0};
    hpr_status status = hpr_job_read_scene(job, path, &options->read, &scene);
    if (status == HPR_OK) {
        const hpr_picture_source source = {.path = path,
                                           .tail = "_reference.exr",
                                           .camera_count = scene->camera_count,
                                           .camera = scene->camera};
        status = hpr_pictures_plan(job, &options->pictures, &source, &list);
    }
    if (status == HPR_OK && options->pictures.environment_count)
        status = hpr_scene_set_environment(scene, options->pictures.environment_count,
                                           options->pictures.environment);
    if (status == HPR_OK)
        status = hpr_reference_create(ctx, scene, &options->reference, &reference);
    if (status == HPR_OK)
        status = create_tally(ctx, list.count, scene->channel_count, &t);
    if (status == HPR_OK)
        status = trace_pictures(job, options, scene, reference, &list, &t);
    if (status == HPR_OK) {
        const hpr_reference_report report = {.reference = reference,
                                             .scene_path = path,
                                             .samples = options->pictures.render.samples,
                                             .picture_count = list.count,
                                             .picture = t.picture};
        status = write_report(job, &report, options->pictures.report_path);
    }
    job->result->ray_count =
        hpr_counter_value(ctx, HPR_COUNT_RAYS) + hpr_counter_value(ctx, HPR_COUNT_CAMERA_RAYS);
    hpr_release(ctx, t.picture);
    hpr_release(ctx, t.value);
    hpr_pictures_release(ctx, &list);
    hpr_reference_destroy(&reference);
    hpr_scene_destroy(&scene);
    return status;
}

/* Path tracing makes whole pictures of radiance, by the scene's cameras. */
static hpr_status check_options(hpr_context *ctx, const hpr_job_render_options *pictures)
{
    const hpr_view_options *view = &pictures->view;
    if (pictures->camera_file || pictures->orbit || pictures->compare || pictures->false_colour ||
        pictures->first_frame || pictures->frame_count || view->crop[2] || view->crop[3] ||
        view->filter != HPR_FILTER_BOX || view->filter_width > 0 || view->layers)
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "a reference has no camera file, orbit, frames, crop window, filter, layers, false "
                        "colours or comparison");
    return HPR_OK;
}

hpr_status hpr_job_reference(hpr_context *ctx, const char *scene_path,
                             const hpr_job_reference_options *options, hpr_job_result *result)
{
    hpr_job_reference_options defaults;
    hpr_job_reference_options_init(&defaults);
    if (!options)
        options = &defaults;
    hpr_job job;
    hpr_job_begin(&job, ctx, &options->pictures.events, result);
    hpr_status status = check_options(ctx, &options->pictures);
    if (status == HPR_OK)
        status = hpr_pictures_check(&job, scene_path, &options->pictures);
    if (status == HPR_OK)
        status = run(&job, scene_path, options);
    return hpr_job_end(&job, status);
}
