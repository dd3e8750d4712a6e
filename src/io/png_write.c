/* 8-bit previews as PNG. */
#include "io/png_file.h"

#include <hprad/render.h>
#include <math.h>

static const double middle_grey = 0.18;

/* IEC 61966-2-1, eq. 5 to 7, of a value in 0 .. 1 */
static double srgb(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

/* 0 .. 1 to 0 .. 255; what is no number is black. */
static unsigned char quantise(double value)
{
    if (!(value > 0))
        return 0;
    return (unsigned char)floor(255 * fmin(value, 1) + 0.5);
}

static double luminance(const float *radiance, size_t channel_count)
{
    if (channel_count == 1)
        return (double)radiance[0];
    return 0.2126 * (double)radiance[0] + 0.7152 * (double)radiance[1] + 0.0722 * (double)radiance[2];
}

/*
 * 0.18 over the log-average luminance (Reinhard et al. 2002, eq. 1) of the pixels that show something. Those
 * a million times darker than the brightest are rounding noise and would pull the average down without end.
 */
static double auto_exposure(const hpr_image *image)
{
    size_t n = image->channel_count, pixels = (size_t)image->width * (size_t)image->height, count = 0;
    double largest = 0, sum = 0;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < pixels; i++) {
            double coverage = (double)image->coverage[i];
            double value = luminance(image->radiance + n * i, n) / (image->environment ? 1 : coverage);
            if (!(coverage > 0) || !isfinite(value))
                continue;
            if (pass == 0) {
                largest = fmax(largest, value);
            } else if (value > 1e-6 * largest) {
                sum += log(value);
                count++;
            }
        }
    }
    return count ? middle_grey / exp(sum / (double)count) : 1;
}

static bool has_holes(const hpr_image *image)
{
    if (image->environment)
        return false;
    size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++) {
        if (!(image->coverage[i] >= 1))
            return true;
    }
    return false;
}

/* Pixels of n + alpha bytes. PNG's alpha is not premultiplied, so colours are divided by it. */
static void convert(const hpr_image *image, double exposure, bool alpha, unsigned char *bytes)
{
    size_t n = image->channel_count, pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++) {
        double coverage = (double)image->coverage[i];
        double scale = !alpha ? exposure : coverage > 0 ? exposure / fmin(coverage, 1) : 0;
        for (size_t c = 0; c < n; c++) {
            double value = (double)image->radiance[n * i + c] * scale;
            *bytes++ = value > 0 ? quantise(srgb(fmin(value, 1))) : 0;
        }
        if (alpha)
            *bytes++ = quantise(coverage);
    }
}

static hpr_status check_image(hpr_context *ctx, const hpr_image *image, double exposure)
{
    if (image->width < 1 || image->height < 1 || !image->radiance || !image->coverage)
        return hpr_fail(ctx, HPR_ERR_ARG, "a picture of %d x %d pixels cannot be written", image->width,
                        image->height);
    if (image->channel_count != 1 && image->channel_count != 3)
        return hpr_fail(ctx, HPR_ERR_ARG, "a preview shows one channel or three, not %zu",
                        image->channel_count);
    if (!(exposure >= 0) || !isfinite(exposure))
        return hpr_fail(ctx, HPR_ERR_ARG, "the exposure must be finite and >= 0, not %g", exposure);
    return HPR_OK;
}

hpr_status hpr_image_write_png(hpr_context *ctx, const hpr_image *image, double exposure, const char *path,
                               double *used)
{
    hpr_context_clear_error(ctx);
    hpr_status status = check_image(ctx, image, exposure);
    if (status != HPR_OK)
        return status;
    if (exposure == 0)
        exposure = auto_exposure(image);
    bool alpha = has_holes(image);
    unsigned char *bytes = NULL;
    hpr_atomic_file file;
    status = hpr_atomic_open(ctx, path, &file);
    if (status == HPR_OK)
        status = hpr_allocate_into(ctx, &bytes, (size_t)image->width * (size_t)image->height,
                                   image->channel_count + alpha, "a preview");
    if (status == HPR_OK) {
        convert(image, exposure, alpha, bytes);
        unsigned format = (image->channel_count == 3 ? HPR_PNG_COLOUR : 0u) | (alpha ? HPR_PNG_ALPHA : 0u);
        status = hpr_png_encode(&file, image->width, image->height, format, bytes);
    }
    if (status == HPR_OK)
        status = hpr_atomic_commit(&file);
    hpr_atomic_abort(&file);
    hpr_release(ctx, bytes);
    if (status == HPR_OK && used)
        *used = exposure;
    return status;
}
