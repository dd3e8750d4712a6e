#include "base/context.h"

#include <hprad/compare.h>
#include <math.h>

static int whole(int full, int own)
{
    return full ? full : own;
}

/* Where the window of `image` begins in the pixels of `reference`. */
static hpr_status place_window(hpr_context *ctx, const hpr_image *image, const hpr_image *reference,
                               int *left, int *top)
{
    int width = whole(image->full_width, image->width), height = whole(image->full_height, image->height);
    int other_width = whole(reference->full_width, reference->width);
    int other_height = whole(reference->full_height, reference->height);
    if (width != other_width || height != other_height || image->channel_count != reference->channel_count)
        return hpr_fail(ctx, HPR_ERR_ARG,
                        "the picture has %d x %d pixels in %zu channels, the reference %d x %d in %zu", width,
                        height, image->channel_count, other_width, other_height, reference->channel_count);
    *left = image->left - reference->left;
    *top = image->top - reference->top;
    if (*left < 0 || *top < 0 || *left + image->width > reference->width ||
        *top + image->height > reference->height)
        return hpr_fail(ctx, HPR_ERR_ARG, "the reference does not hold the window of %d x %d pixels at %d,%d",
                        image->width, image->height, image->left, image->top);
    return HPR_OK;
}

hpr_status hpr_image_compare(hpr_context *ctx, const hpr_image *image, const hpr_image *reference,
                             hpr_difference *result, hpr_image *difference)
{
    static const double softening = 0.01;
    int left = 0, top = 0;
    size_t n = image->channel_count, pixels = (size_t)image->width * (size_t)image->height;
    *difference = (hpr_image){0};
    hpr_context_clear_error(ctx);
    hpr_status status = place_window(ctx, image, reference, &left, &top);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &difference->radiance, pixels, n * sizeof(float), "a difference");
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &difference->coverage, pixels, sizeof(float), "a difference");
    if (status != HPR_OK)
        return status;
    difference->width = image->width;
    difference->height = image->height;
    difference->left = image->left;
    difference->top = image->top;
    difference->full_width = image->full_width;
    difference->full_height = image->full_height;
    difference->channel_count = n;
    double sum = 0, relative = 0, largest = 0;
    for (size_t i = 0; i < pixels; i++) {
        size_t row = i / (size_t)image->width + (size_t)top, column = i % (size_t)image->width + (size_t)left;
        const float *other = reference->radiance + n * (row * (size_t)reference->width + column);
        difference->coverage[i] = 1;
        for (size_t c = 0; c < n; c++) {
            double r = (double)other[c], d = (double)image->radiance[n * i + c] - r;
            difference->radiance[n * i + c] = (float)d;
            sum += d * d;
            relative += d * d / (r * r + softening);
            largest = fmax(largest, r);
        }
    }
    double values = (double)(n * pixels);
    result->rmse = sqrt(sum / values);
    result->rel_mse = relative / values;
    result->psnr_db = sum == 0 ? INFINITY : 20 * log10(largest / result->rmse);
    return HPR_OK;
}
