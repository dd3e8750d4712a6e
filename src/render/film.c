#include "render/film.h"

#include "render/camera.h"
#include "render/layers.h"

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

static hpr_status choose_window(hpr_context *ctx, const hpr_view_options *view, hpr_image *image)
{
    image->full_width = image->width;
    image->full_height = image->height;
    if (!view || (view->crop[2] == 0 && view->crop[3] == 0))
        return HPR_OK;
    int left = view->crop[0], top = view->crop[1], right = view->crop[2], bottom = view->crop[3];
    if (left < 0 || top < 0 || right <= left || bottom <= top || right > image->width ||
        bottom > image->height)
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "the window %d,%d to %d,%d is empty or not within the picture of %d x %d pixels",
                        left, top, right, bottom, image->width, image->height);
    image->left = left;
    image->top = top;
    image->width = right - left;
    image->height = bottom - top;
    return HPR_OK;
}

static hpr_status allocate_layers(hpr_context *ctx, uint32_t layers, size_t pixels, hpr_image *image)
{
    hpr_status status = HPR_OK;
    for (int layer = 0; layer < HPR_LAYER_COUNT && status == HPR_OK; layer++) {
        if (!(layers >> layer & 1))
            continue;
        size_t bytes = hpr_layer_components((hpr_layer)layer, image->channel_count) * sizeof(float);
        if (layer == HPR_LAYER_PATCH)
            status = hpr_allocate_into(ctx, &image->patch, pixels, sizeof *image->patch, "a picture");
        else if (layer == HPR_LAYER_ELEMENT)
            status = hpr_allocate_into(ctx, &image->element, pixels, sizeof *image->element, "a picture");
        else
            status = hpr_allocate_into(ctx, &image->layer[layer], pixels, bytes, "a picture");
    }
    return status;
}

hpr_status hpr_film_open(hpr_context *ctx, const hpr_camera *camera, const hpr_render_options *options,
                         const hpr_film *film, hpr_image *image)
{
    hpr_status status = choose_size(ctx, camera, options, image);
    if (status == HPR_OK)
        status = choose_window(ctx, film->view, image);
    if (status != HPR_OK)
        return status;
    size_t n = film->channel_count;
    size_t pixels = (size_t)image->width * (size_t)image->height, bytes = n * sizeof(float);
    image->channel_count = n;
    for (size_t c = 0; film->environment && c < n; c++)
        image->environment |= film->environment[c] > 0;
    status = hpr_allocate_into(ctx, &image->radiance, pixels, bytes, "a picture");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &image->coverage, pixels, sizeof(float), "a picture");
    if (status == HPR_OK && film->variance)
        status = hpr_allocate_into(ctx, &image->variance, pixels, bytes, "a picture");
    if (status == HPR_OK && film->view)
        status = allocate_layers(ctx, film->view->layers, pixels, image);
    return status;
}

void hpr_image_fini(hpr_context *ctx, hpr_image *image)
{
    hpr_release(ctx, image->radiance);
    hpr_release(ctx, image->coverage);
    hpr_release(ctx, image->variance);
    for (int layer = 0; layer < HPR_LAYER_PATCH; layer++)
        hpr_release(ctx, image->layer[layer]);
    hpr_release(ctx, image->patch);
    hpr_release(ctx, image->element);
    *image = (hpr_image){0};
}
