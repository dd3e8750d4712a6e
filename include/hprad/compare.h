#ifndef HPRAD_COMPARE_H
#define HPRAD_COMPARE_H

#include <hprad/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * How a picture x differs from a reference r, over all pixels and channels. A value that is not finite in
 * either makes the result NaN.
 */
typedef struct hpr_difference {
    double rmse;    /**< sqrt(mean (x - r)²), W/m²/sr */
    double rel_mse; /**< mean of (x - r)² / (r² + 0.01) (Rousselle, Knaus & Zwicker 2011) */
    double psnr_db; /**< 20 log10(max r / rmse); infinite if the pictures are equal */
} hpr_difference;

/**
 * Compares the radiance of two pictures, and makes the picture of the differences x - r. Where `image` is a
 * window of a larger picture, the same window of the reference counts. `difference` may be uninitialised;
 * fini it with hpr_image_fini in any case. Errors: HPR_ERR_ARG (pictures of other size or channels, or a
 * reference that does not hold the window), HPR_ERR_MEMORY.
 */
HPR_API hpr_status hpr_image_compare(hpr_context *context, const hpr_image *image, const hpr_image *reference,
                                     hpr_difference *result, hpr_image *difference);

#ifdef __cplusplus
}
#endif

#endif
