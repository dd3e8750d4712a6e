#include "render/film.h"

#include "render/camera.h"

#include <math.h>

enum { MAX_SIDE = 32768, DEFAULT_HEIGHT = 512 };

static hpr_status choose_size(hpr_context *ctx, const hpr_camera *camera, const hpr_render_options *options,
                              hpr_image *image)
{
    double aspect = hpr_camera_aspect(camera), width = options->width, height = options->height;
    if (height == 0)
        height = width == 0 ? DEFAULT_HEIGHT : round(width / aspect);
    if (width == 0)
        width = round(height * aspect);
    if (!(width >= 1 && width <= MAX_SIDE && height >= 1 && height <= MAX_SIDE))
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %.0f x %.0f pixels: sides must be 1 to %d", width,
                        height, MAX_SIDE);
    image->width = (int)width;
    image->height = (int)height;
    return HPR_OK;
}

hpr_status hpr_film_open(hpr_context *ctx, const hpr_camera *camera, const hpr_render_options *options,
                         size_t channel_count, const double *environment, bool variance, hpr_image *image)
{
    hpr_status status = choose_size(ctx, camera, options, image);
    if (status != HPR_OK)
        return status;
    size_t pixels = (size_t)image->width * (size_t)image->height, bytes = channel_count * sizeof(float);
    image->channel_count = channel_count;
    for (size_t c = 0; environment && c < channel_count; c++)
        image->environment |= environment[c] > 0;
    status = hpr_allocate_into(ctx, &image->radiance, pixels, bytes, "a picture");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &image->coverage, pixels, sizeof(float), "a picture");
    if (status == HPR_OK && variance)
        status = hpr_allocate_into(ctx, &image->variance, pixels, bytes, "a picture");
    return status;
}

void hpr_image_fini(hpr_context *ctx, hpr_image *image)
{
    hpr_release(ctx, image->radiance);
    hpr_release(ctx, image->coverage);
    hpr_release(ctx, image->variance);
    *image = (hpr_image){0};
}
