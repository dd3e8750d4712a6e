/* Primary rays, then the polynomials of the patch that is hit. */
#include "render/renderer.h"

#include "math/vec3.h"
#include "patch/paint.h"
#include "reconstruct/reconstruct.h"
#include "render/camera.h"
#include "render/film.h"
#include "render/filter.h"
#include "render/footprint.h"
#include "render/layers.h"
#include "visibility/visibility.h"

#include <math.h>
#include <omp.h>

enum { MAX_SAMPLES = 4096, TILE = 16 /* pixels; enough for neighbours to meet the same patches */ };

/* Means over the pixel: the radiance, then the layers that are averaged. */
enum { MEAN_COUNT = 1 + HPR_LAYER_ALBEDO + 1 };

static const double pi = 3.14159265358979323846;

struct hpr_renderer {
    hpr_context *context;
    const hpr_solution *solution;
    hpr_reconstruction reconstruction;
    hpr_visibility *visibility;
};

hpr_status hpr_renderer_create(hpr_context *ctx, const hpr_solution *solution, hpr_renderer **out)
{
    hpr_renderer *renderer = NULL;
    *out = NULL;
    hpr_status status = hpr_allocate_into(ctx, &renderer, 1, sizeof *renderer, "rendering");
    if (status != HPR_OK)
        return status;
    *renderer = (hpr_renderer){.context = ctx, .solution = solution};
    status = hpr_visibility_create(solution->patches, &renderer->visibility);
    if (status == HPR_OK)
        status = hpr_reconstruction_init(solution, &renderer->reconstruction);
    if (status != HPR_OK)
        hpr_renderer_destroy(&renderer);
    *out = renderer;
    return status;
}

void hpr_renderer_destroy(hpr_renderer **renderer)
{
    if (!*renderer)
        return;
    hpr_reconstruction_fini(&(*renderer)->reconstruction);
    hpr_visibility_destroy(&(*renderer)->visibility);
    hpr_release((*renderer)->context, *renderer);
    *renderer = NULL;
}

/* One picture that is being made. */
typedef struct work {
    const hpr_renderer *renderer;
    const hpr_camera *camera;
    hpr_image *image;
    double aspect;
    uint32_t samples;
    const double *place; /* [samples][2] */
    hpr_sample_view view;
    bool averaged; /* some layer is a mean over the pixel */
    bool central;  /* some layer is of the pixel's centre */
} work;

/* What a thread needs for a pixel. */
typedef struct scratch {
    double *irradiance, *indirect, *reflectance, *exitance, *room; /* [channels] */
    double *sum;                                                   /* [MEAN_COUNT][channels] */
} scratch;

static hpr_hit shoot(const work *w, double x, double y, hpr_camera_ray *ray)
{
    hpr_camera_ray_through(w->camera, w->aspect, x / w->image->full_width, y / w->image->full_height, ray);
    return hpr_visibility_first_hit(w->renderer->visibility, ray->origin, ray->direction, ray->near, ray->far,
                                    true, NULL);
}

/* rho and M of a sample at (x,y) of the full picture, in pixels. */
static void shade(const work *w, const hpr_hit *hit, double x, double y, const scratch *s)
{
    const hpr_patches *patches = w->renderer->solution->patches;
    hpr_footprint footprint = {.patch = hit->patch, .s = hit->s, .t = hit->t};
    if (hpr_patch_texture(patches, hit->patch) || hpr_patch_glow(patches, hit->patch))
        footprint = hpr_footprint_of(&w->view, x / w->image->full_width, y / w->image->full_height,
                                     hit->patch, hit->s, hit->t);
    hpr_footprint_shade(patches, &footprint, s->reflectance, s->exitance, s->room);
}

/* Adds the radiance B/pi = (M + rho H)/pi of a hit, once it is shaded, to the first sum, and what the layers
 * show to theirs. */
static void add_hit(const work *w, const hpr_hit *hit, const scratch *s)
{
    size_t n = w->image->channel_count;
    double *layer = s->sum + n;
    if (w->averaged)
        hpr_reconstruct_parts(&w->renderer->reconstruction, hit->patch, hit->s, hit->t, s->irradiance,
                              s->indirect);
    else
        hpr_reconstruct_point(&w->renderer->reconstruction, hit->patch, hit->s, hit->t, s->irradiance);
    for (size_t c = 0; c < n; c++) {
        s->sum[c] += (s->exitance[c] + s->reflectance[c] * s->irradiance[c]) / pi;
        if (!w->averaged)
            continue;
        layer[n * HPR_LAYER_IRRADIANCE + c] += s->irradiance[c];
        layer[n * HPR_LAYER_DIRECT + c] += s->irradiance[c] - s->indirect[c];
        layer[n * HPR_LAYER_INDIRECT + c] += s->indirect[c];
        layer[n * HPR_LAYER_EMISSION + c] += s->exitance[c] / pi;
        layer[n * HPR_LAYER_ALBEDO + c] += s->reflectance[c];
    }
}

/* The layers that belong to the point behind the pixel's centre. */
static void show_centre(const work *w, int row, int column, size_t pixel)
{
    const hpr_solution *solution = w->renderer->solution;
    const hpr_patches *patches = solution->patches;
    hpr_image *image = w->image;
    hpr_camera_ray ray;
    hpr_hit hit = shoot(w, image->left + column + 0.5, image->top + row + 0.5, &ray);
    size_t leaf = HPR_NONE;
    double point[3] = {0, 0, 0}, depth = INFINITY, s, t;
    if (hit.patch != HPR_NONE) {
        leaf = hpr_elements_locate(patches, solution->elements, hit.patch, hit.s, hit.t, &s, &t);
        hpr_add_scaled3(patches->origin + 3 * hit.patch, hit.s, patches->edge1 + 3 * hit.patch, point);
        hpr_add_scaled3(point, hit.t, patches->edge2 + 3 * hit.patch, point);
        double from_camera[3];
        hpr_subtract3(point, w->camera->origin, from_camera);
        depth = -hpr_dot3(from_camera, w->camera->backward);
    }
    for (int k = 0; k < 3; k++) {
        if (image->layer[HPR_LAYER_NORMAL] && hit.patch != HPR_NONE)
            image->layer[HPR_LAYER_NORMAL][3 * pixel + (size_t)k] = (float)patches->normal[3 * hit.patch + k];
        if (image->layer[HPR_LAYER_POSITION])
            image->layer[HPR_LAYER_POSITION][3 * pixel + (size_t)k] = (float)point[k];
    }
    if (image->layer[HPR_LAYER_DEPTH])
        image->layer[HPR_LAYER_DEPTH][pixel] = (float)depth;
    if (image->layer[HPR_LAYER_DEGREE] && hit.patch != HPR_NONE)
        image->layer[HPR_LAYER_DEGREE][pixel] =
            (float)solution->elements->degree[solution->elements->leaf[leaf]];
    if (image->layer[HPR_LAYER_ERROR] && hit.patch != HPR_NONE)
        image->layer[HPR_LAYER_ERROR][pixel] =
            (float)(solution->error[leaf] /
                    sqrt(solution->elements->area_m2[solution->elements->leaf[leaf]]));
    if (image->patch)
        image->patch[pixel] = hit.patch;
    if (image->element)
        image->element[pixel] = (uint32_t)leaf;
}

static void render_pixel(const work *w, int row, int column, const scratch *s)
{
    hpr_image *image = w->image;
    const double *environment = w->renderer->solution->environment;
    size_t n = image->channel_count, pixel = (size_t)row * (size_t)image->width + (size_t)column;
    uint32_t covered = 0;
    for (size_t i = 0; i < (w->averaged ? MEAN_COUNT : 1) * n; i++)
        s->sum[i] = 0;
    for (uint32_t i = 0; i < w->samples; i++) {
        hpr_camera_ray ray;
        double x = image->left + column + w->place[2 * i], y = image->top + row + w->place[2 * i + 1];
        hpr_hit hit = shoot(w, x, y, &ray);
        if (hit.patch == HPR_NONE) {
            for (size_t c = 0; c < n && environment; c++)
                s->sum[c] += environment[c];
            continue;
        }
        covered++;
        shade(w, &hit, x, y, s);
        add_hit(w, &hit, s);
    }
    for (size_t c = 0; c < n; c++)
        image->radiance[n * pixel + c] = (float)(s->sum[c] / w->samples);
    for (size_t layer = 0; w->averaged && layer + 1 < MEAN_COUNT; layer++) {
        for (size_t c = 0; image->layer[layer] && c < n; c++)
            image->layer[layer][n * pixel + c] = (float)(s->sum[(layer + 1) * n + c] / w->samples);
    }
    image->coverage[pixel] = (float)((double)covered / w->samples);
    if (w->central)
        show_centre(w, row, column, pixel);
}

static void render_tile(const work *w, int tile, int across, const scratch *s)
{
    int top = tile / across * TILE, left = tile % across * TILE;
    for (int row = top; row < top + TILE && row < w->image->height; row++) {
        for (int column = left; column < left + TILE && column < w->image->width; column++)
            render_pixel(w, row, column, s);
    }
}

/* Tiles in any order: every pixel stands for itself. memory: [threads][stride] */
static hpr_status render_tiles(const work *w, double *memory, size_t stride)
{
    hpr_context *ctx = w->renderer->context;
    size_t n = w->image->channel_count;
    int across = (w->image->width + TILE - 1) / TILE, down = (w->image->height + TILE - 1) / TILE;
    int tiles = across * down, done = 0;
    uint64_t rays = w->samples + w->central;
#pragma omp parallel for schedule(dynamic) num_threads(hpr_context_threads(ctx))
    for (int tile = 0; tile < tiles; tile++) {
        if (hpr_cancelled(ctx))
            continue;
        double *own = memory + stride * (size_t)omp_get_thread_num();
        const scratch s = {.irradiance = own,
                           .indirect = own + n,
                           .reflectance = own + 2 * n,
                           .exitance = own + 3 * n,
                           .room = own + 4 * n,
                           .sum = own + 5 * n};
        render_tile(w, tile, across, &s);
#pragma omp critical(hpr_render_progress)
        hpr_stage_progress(ctx, (double)++done / tiles);
    }
    if (hpr_cancelled(ctx))
        return hpr_fail(ctx, HPR_ERR_INTERRUPTED, "interrupted while rendering");
    hpr_count(ctx, HPR_COUNT_CAMERA_RAYS, rays * (uint64_t)w->image->width * (uint64_t)w->image->height);
    return HPR_OK;
}

static bool has_estimate(const hpr_solution *solution)
{
    size_t leaf = 0, count = solution->elements->leaf_count;
    while (leaf < count && isfinite(solution->error[leaf]))
        leaf++;
    return leaf == count;
}

static hpr_status check(const hpr_renderer *renderer, int samples, const hpr_view_options *view)
{
    static const uint32_t parts = 1u << HPR_LAYER_DIRECT | 1u << HPR_LAYER_INDIRECT;
    hpr_context *ctx = renderer->context;
    const hpr_solution *solution = renderer->solution;
    if (samples < 1 || samples > MAX_SAMPLES)
        return hpr_fail(ctx, HPR_ERR_ARG, "%d samples per pixel: must be 1 to %d", samples, MAX_SAMPLES);
    if (!(view->filter_width >= 0 && view->filter_width <= HPR_MAX_FILTER_WIDTH))
        return hpr_fail(ctx, HPR_ERR_ARG, "a filter of %g pixels: must be above 0 and up to %d",
                        view->filter_width, HPR_MAX_FILTER_WIDTH);
    if (view->layers >> HPR_LAYER_COUNT)
        return hpr_fail(ctx, HPR_ERR_ARG, "the set of layers %#x has unknown ones", (unsigned)view->layers);
    if (view->layers & parts && !hpr_reconstruct_parted(&renderer->reconstruction))
        return hpr_fail(ctx, HPR_ERR_UNSUPPORTED,
                        "%s: direct and indirect light are not told apart in this solution: its direct light "
                        "went through the basis (--direct galerkin, or too many lamps)",
                        solution->scene_name);
    if (view->layers & 1u << HPR_LAYER_ERROR && !has_estimate(solution))
        return hpr_fail(ctx, HPR_ERR_UNSUPPORTED, "%s: this solution has no estimate of its error to show",
                        solution->scene_name);
    return HPR_OK;
}

static hpr_status render_film(const hpr_renderer *renderer, const hpr_camera *camera, uint32_t samples,
                              const hpr_view_options *view, hpr_image *image)
{
    hpr_context *ctx = renderer->context;
    uint32_t means = (1u << (HPR_LAYER_ALBEDO + 1)) - 1;
    size_t stride =
        ((5 + MEAN_COUNT) * image->channel_count + 15) / 16 * 16; /* threads share no cache line */
    double *memory = NULL, *place = NULL;
    hpr_status status = hpr_allocate_into(ctx, &memory, (size_t)hpr_context_threads(ctx),
                                          stride * sizeof *memory, "rendering");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &place, samples, 2 * sizeof *place, "rendering");
    if (status == HPR_OK) {
        hpr_filter_places(view->filter, view->filter_width, samples, place);
        double aspect = (double)image->full_width / image->full_height;
        double wide = (view->filter_width > 0 ? view->filter_width : 1) / sqrt(samples); /* pixels */
        const work w = {.renderer = renderer,
                        .camera = camera,
                        .image = image,
                        .aspect = aspect,
                        .view = {.patches = renderer->solution->patches,
                                 .camera = camera,
                                 .aspect = aspect,
                                 .across = wide / image->full_width,
                                 .down = wide / image->full_height},
                        .samples = samples,
                        .place = place,
                        .averaged = (view->layers & means) != 0,
                        .central = (view->layers & ~means) != 0};
        status = render_tiles(&w, memory, stride);
    }
    hpr_release(ctx, place);
    hpr_release(ctx, memory);
    return status;
}

hpr_status hpr_renderer_render(hpr_renderer *renderer, const hpr_camera *camera,
                               const hpr_render_options *options, const hpr_view_options *view,
                               hpr_image *image)
{
    hpr_context *ctx = renderer->context;
    hpr_render_options film_defaults;
    hpr_view_options view_defaults;
    hpr_render_options_init(&film_defaults);
    hpr_view_options_init(&view_defaults);
    options = options ? options : &film_defaults;
    view = view ? view : &view_defaults;
    *image = (hpr_image){0};
    const hpr_film film = {.channel_count = renderer->solution->channel_count,
                           .environment = renderer->solution->environment,
                           .view = view};
    hpr_status status = check(renderer, options->samples, view);
    if (status == HPR_OK)
        status = hpr_film_open(ctx, camera, options, &film, image);
    if (status == HPR_OK) {
        hpr_stage_begin(ctx, "render");
        status = render_film(renderer, camera, (uint32_t)options->samples, view, image);
        hpr_stage_end(ctx);
    }
    if (status != HPR_OK)
        hpr_image_fini(ctx, image);
    return status;
}
