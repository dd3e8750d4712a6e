#include "reconstruct/reconstruct.h"
#include "render/camera.h"
#include "render/film.h"
#include "render/strata.h"
#include "visibility/visibility.h"

#include <omp.h>

enum { MAX_SAMPLES = 4096, DEFAULT_SAMPLES = 4 };

static const double pi = 3.14159265358979323846;

void hpr_render_options_init(hpr_render_options *options)
{
    *options = (hpr_render_options){.samples = DEFAULT_SAMPLES};
}

typedef struct view {
    const hpr_solution *solution;
    hpr_reconstruction reconstruction;
    const hpr_visibility *visibility;
    const hpr_camera *camera;
    hpr_strata strata;
    double aspect;
} view;

/* Adds the radiance B/pi = (M + rho H)/pi of a hit to sum [channels]; irradiance [channels] is scratch. */
static void add_radiance(const view *v, const hpr_hit *hit, double *irradiance, double *sum)
{
    const hpr_patches *patches = v->solution->patches;
    size_t n = v->solution->channel_count;
    hpr_reconstruct_point(&v->reconstruction, hit->patch, hit->s, hit->t, irradiance);
    for (size_t c = 0; c < n; c++) {
        size_t i = n * hit->patch + c;
        sum[c] += (patches->exitance[i] + patches->reflectance[i] * irradiance[c]) / pi;
    }
}

/* scratch: [2][channels] */
static void render_pixel(const view *v, hpr_image *image, size_t row, size_t column, double *scratch)
{
    size_t n = image->channel_count, pixel = row * (size_t)image->width + column;
    double *sum = scratch, *irradiance = scratch + n;
    uint32_t covered = 0;
    for (size_t c = 0; c < n; c++)
        sum[c] = 0;
    for (uint32_t sample = 0; sample < v->strata.count; sample++) {
        double x, y;
        hpr_camera_ray ray;
        hpr_strata_place(&v->strata, sample, &x, &y);
        hpr_camera_ray_through(v->camera, v->aspect, ((double)column + x) / image->width,
                               ((double)row + y) / image->height, &ray);
        hpr_hit hit =
            hpr_visibility_first_hit(v->visibility, ray.origin, ray.direction, ray.near, ray.far, true, NULL);
        if (hit.patch == HPR_NONE) {
            for (size_t c = 0; c < n && v->solution->environment; c++)
                sum[c] += v->solution->environment[c];
            continue;
        }
        covered++;
        add_radiance(v, &hit, irradiance, sum);
    }
    for (size_t c = 0; c < n; c++)
        image->radiance[n * pixel + c] = (float)(sum[c] / v->strata.count);
    image->coverage[pixel] = (float)((double)covered / v->strata.count);
}

/* Rows in any order: every pixel stands for itself. scratch: [threads][stride] */
static hpr_status render_rows(hpr_context *ctx, const view *v, hpr_image *image, double *scratch,
                              size_t stride)
{
    int done = 0;
#pragma omp parallel for schedule(dynamic) num_threads(hpr_context_threads(ctx))
    for (int row = 0; row < image->height; row++) {
        if (hpr_cancelled(ctx))
            continue;
        for (int column = 0; column < image->width; column++)
            render_pixel(v, image, (size_t)row, (size_t)column,
                         scratch + stride * (size_t)omp_get_thread_num());
        hpr_count(ctx, HPR_COUNT_CAMERA_RAYS, (uint64_t)image->width * v->strata.count);
#pragma omp critical(hpr_render_progress)
        hpr_stage_progress(ctx, (double)++done / image->height);
    }
    if (hpr_cancelled(ctx))
        return hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while rendering");
    return HPR_OK;
}

static hpr_status render_image(hpr_context *ctx, const hpr_solution *solution, const hpr_camera *camera,
                               int samples, hpr_image *image)
{
    size_t n = solution->channel_count;
    size_t stride = (2 * n + 15) / 16 * 16; /* threads do not share cache lines */
    hpr_visibility *visibility = NULL;
    double *scratch = NULL;
    hpr_status status = hpr_allocate_into(ctx, &scratch, (size_t)hpr_context_threads(ctx),
                                          stride * sizeof *scratch, "rendering");
    if (status == HPR_OK)
        status = hpr_visibility_create(solution->patches, &visibility);
    hpr_reconstruction reconstruction = {0};
    if (status == HPR_OK)
        status = hpr_reconstruction_init(solution, &reconstruction);
    if (status == HPR_OK) {
        const view v = {.solution = solution,
                        .reconstruction = reconstruction,
                        .visibility = visibility,
                        .camera = camera,
                        .strata = hpr_strata_of((uint32_t)samples),
                        .aspect = (double)image->width / image->height};
        status = render_rows(ctx, &v, image, scratch, stride);
    }
    hpr_reconstruction_fini(&reconstruction);
    hpr_visibility_destroy(&visibility);
    hpr_release(ctx, scratch);
    return status;
}

hpr_status hpr_solution_render(hpr_context *ctx, const hpr_solution *solution, size_t camera,
                               const hpr_render_options *options, hpr_image *image)
{
    hpr_render_options defaults;
    hpr_context_clear_error(ctx);
    hpr_render_options_init(&defaults);
    if (!options)
        options = &defaults;
    *image = (hpr_image){0};
    if (camera >= solution->camera_count)
        return hpr_fail(ctx, HPR_ERR_ARG, "camera %zu does not exist: the solution has %zu", camera,
                        solution->camera_count);
    if (options->samples < 1 || options->samples > MAX_SAMPLES)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d samples per pixel: must be 1 to %d", options->samples,
                        MAX_SAMPLES);
    const hpr_camera *view_from = &solution->camera[camera];
    hpr_status status =
        hpr_film_open(ctx, view_from, options, solution->channel_count, solution->environment, false, image);
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "render");
        status = render_image(ctx, solution, view_from, options->samples, image);
        hpr_stage_end(ctx);
    }
    if (status != HPR_OK)
        hpr_image_fini(ctx, image);
    return status;
}
