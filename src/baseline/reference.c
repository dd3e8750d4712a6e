/* Pictures by path tracing: every pixel a mean of independent paths, with its variance. */
#include "baseline/reference.h"

#include "patch/frame.h"
#include "render/film.h"

#include <omp.h>
#include <stdatomic.h>

/* Pixels that a thread takes at a time; the result does not depend on it. */
enum { RUN_PIXELS = 64 };

void hpr_reference_options_init(hpr_reference_options *options)
{
    *options = (hpr_reference_options){0};
}

static hpr_status prepare(hpr_reference *reference)
{
    hpr_context *ctx = reference->context;
    const hpr_scene *scene = reference->scene;
    hpr_status status = hpr_patches_build(scene, &reference->patches);
    if (status == HPR_OK)
        status = hpr_tracer_init(reference->patches, scene->environment, &reference->tracer);
    if (status == HPR_OK && scene->camera_count == 0)
        hpr_patches_frame(reference->patches, &reference->framing);
    if (status == HPR_OK && reference->patches->count == 0)
        hpr_warn(ctx, "%s: no surface; the picture is empty", scene->path);
    else if (status == HPR_OK && reference->tracer.dark)
        hpr_warn(ctx, "%s: no light; the picture is black", scene->path);
    return status;
}

hpr_status hpr_reference_create(hpr_context *ctx, const hpr_scene *scene,
                                const hpr_reference_options *options, hpr_reference **out)
{
    hpr_reference_options defaults;
    hpr_reference_options_init(&defaults);
    options = options ? options : &defaults;
    hpr_context_clear_error(ctx);
    *out = NULL;
    hpr_reference *reference = NULL;
    hpr_status status = hpr_allocate_into(ctx, &reference, 1, sizeof *reference, "a reference");
    if (status != HPR_OK)
        return status;
    reference->context = ctx;
    reference->scene = scene;
    reference->seed = options->seed;
    hpr_stage_begin(ctx, "mesh");
    status = prepare(reference);
    hpr_stage_end(ctx);
    if (status != HPR_OK)
        hpr_reference_destroy(&reference);
    *out = reference;
    return status;
}

void hpr_reference_destroy(hpr_reference **out)
{
    hpr_reference *reference = *out;
    if (!reference)
        return;
    hpr_tracer_fini(&reference->tracer);
    hpr_patches_destroy(&reference->patches);
    hpr_release(reference->context, reference);
    *out = NULL;
}

size_t hpr_reference_camera_count(const hpr_reference *reference)
{
    size_t count = reference->scene->camera_count;
    return count ? count : 1;
}

const char *hpr_reference_camera_name(const hpr_reference *reference, size_t camera)
{
    return reference->scene->camera_count ? reference->scene->camera[camera].name : "";
}

typedef struct view {
    const hpr_reference *reference;
    const hpr_camera *camera;
    size_t number; /* of the camera: its random numbers are its own */
    double aspect;
    uint64_t samples;
    hpr_image *image;
    atomic_bool *stop; /* a path did not end, or the run was cancelled */
} view;

/* scratch: [5][channels]. Mean and sum of squares as they come (Welford 1962): no cancellation. Returns the
 * number of rays after the camera's. */
static uint64_t trace_pixel(const view *v, size_t pixel, double *scratch)
{
    hpr_image *image = v->image;
    size_t n = image->channel_count, width = (size_t)image->width;
    double *mean = scratch, *squares = mean + n, *radiance = squares + n, *throughput = radiance + n;
    uint64_t covered = 0, rays = 0;
    for (size_t c = 0; c < n; c++)
        mean[c] = squares[c] = 0;
    for (uint64_t sample = 0; sample < v->samples; sample++) {
        hpr_random random = hpr_random_of(v->reference->seed, v->number, pixel, sample);
        double x = (double)(pixel % width) + hpr_random_unit(&random);
        double y = (double)(pixel / width) + hpr_random_unit(&random);
        hpr_camera_ray ray;
        hpr_camera_ray_through(v->camera, v->aspect, x / image->width, y / image->height, &ray);
        hpr_path path = hpr_tracer_follow(&v->reference->tracer, &ray, &random, radiance, throughput);
        covered += path.covered;
        rays += path.rays;
        for (size_t c = 0; c < n; c++) {
            double off = radiance[c] - mean[c];
            mean[c] += off / (double)(sample + 1);
            squares[c] += off * (radiance[c] - mean[c]);
        }
        if (path.endless || hpr_cancelled(v->reference->context))
            atomic_store(v->stop, true);
        if (atomic_load_explicit(v->stop, memory_order_relaxed))
            return rays;
    }
    double count = (double)v->samples;
    for (size_t c = 0; c < n; c++) {
        image->radiance[n * pixel + c] = (float)mean[c];
        image->variance[n * pixel + c] = (float)(squares[c] / (count * (count - 1)));
    }
    image->coverage[pixel] = (float)((double)covered / count);
    return rays;
}

/* Pixels in any order: every one stands for itself. scratch: [threads][stride] */
static hpr_status trace_pixels(const view *v, double *scratch, size_t stride)
{
    hpr_context *ctx = v->reference->context;
    size_t pixels = (size_t)v->image->width * (size_t)v->image->height, done = 0;
    size_t runs = (pixels + RUN_PIXELS - 1) / RUN_PIXELS;
#pragma omp parallel for schedule(dynamic) num_threads(hpr_context_threads(ctx))
    for (size_t run = 0; run < runs; run++) {
        size_t first = run * RUN_PIXELS, last = first + RUN_PIXELS < pixels ? first + RUN_PIXELS : pixels;
        uint64_t rays = 0;
        for (size_t pixel = first; pixel < last && !atomic_load(v->stop); pixel++)
            rays += trace_pixel(v, pixel, scratch + stride * (size_t)omp_get_thread_num());
        hpr_count(ctx, HPR_COUNT_RAYS, rays);
        hpr_count(ctx, HPR_COUNT_CAMERA_RAYS, (last - first) * v->samples);
#pragma omp critical(hpr_reference_progress)
        hpr_stage_progress(ctx, (double)++done / (double)runs);
    }
    if (hpr_cancelled(ctx))
        return hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while tracing paths");
    if (atomic_load(v->stop))
        return hpr_fail(ctx, HPR_ERR_NUMERIC,
                        "a path has not ended after %d reflections: where nothing is absorbed and nothing "
                        "escapes there is no finite solution; --max-reflectance 0.99 scales such materials "
                        "down",
                        HPR_MAX_REFLECTIONS);
    return HPR_OK;
}

static hpr_status trace_image(const hpr_reference *reference, size_t number, const hpr_camera *camera,
                              const hpr_render_options *film, hpr_image *image)
{
    hpr_context *ctx = reference->context;
    size_t n = reference->patches->channel_count, threads = (size_t)hpr_context_threads(ctx);
    size_t stride = (5 * n + 15) / 16 * 16; /* threads do not share cache lines */
    double *scratch = NULL;
    atomic_bool stop = false;
    const hpr_film content = {
        .channel_count = n, .environment = reference->scene->environment, .variance = true};
    hpr_status status = hpr_film_open(ctx, camera, film, &content, image);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &scratch, threads, stride * sizeof *scratch, "path tracing");
    if (status == HPR_OK) {
        const view v = {.reference = reference,
                        .camera = camera,
                        .number = number,
                        .aspect = (double)image->width / image->height,
                        .samples = (uint64_t)film->samples,
                        .image = image,
                        .stop = &stop};
        status = trace_pixels(&v, scratch, stride);
    }
    hpr_release(ctx, scratch);
    return status;
}

hpr_status hpr_reference_render(hpr_context *ctx, const hpr_reference *reference, size_t camera,
                                const hpr_render_options *film, hpr_image *image)
{
    const hpr_render_options defaults = {.samples = HPR_DEFAULT_PATHS};
    film = film ? film : &defaults;
    hpr_context_clear_error(ctx);
    *image = (hpr_image){0};
    size_t cameras = hpr_reference_camera_count(reference);
    if (camera >= cameras)
        return hpr_fail(ctx, HPR_ERR_ARG, "camera %zu does not exist: the scene has %zu", camera, cameras);
    if (film->samples < 2 || film->samples > HPR_MAX_PATHS)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d paths per pixel: must be 2 (for the variance) to %d",
                        film->samples, HPR_MAX_PATHS);
    const hpr_camera *seen_by =
        reference->scene->camera_count ? &reference->scene->camera[camera] : &reference->framing;
    hpr_stage_begin(ctx, "trace");
    hpr_status status = trace_image(reference, camera, seen_by, film, image);
    hpr_stage_end(ctx);
    if (status != HPR_OK)
        hpr_image_fini(ctx, image);
    return status;
}
