#ifndef HPRAD_RENDER_H
#define HPRAD_RENDER_H

#include <hprad/solve.h>

#ifdef __cplusplus
extern "C" {
#endif

/** A picture of radiance in single precision, row 0 at the top. */
typedef struct hpr_image {
    int width, height;
    size_t channel_count;
    float *radiance; /**< [height][width][channels], W/m²/sr: the pixel's mean. What surfaces send is thereby
                          premultiplied by coverage; (1 - coverage) times the environment is added */
    float *coverage; /**< [height][width], 0 .. 1: the part of the pixel that shows a surface */
    float *variance; /**< [height][width][channels], of the radiance as an estimate: the square of its
                        standard error, (W/m²/sr)²; NULL if it is none */
    int environment; /**< 1: light from outside shows where no surface does, so that the picture has no holes
                      */
} hpr_image;

typedef struct hpr_render_options {
    int width, height; /**< pixels; 0: 512 high, width from the camera's aspect */
    int samples;       /**< per pixel, stratified; box filter */
} hpr_render_options;

HPR_API void hpr_render_options_init(hpr_render_options *options);

/**
 * Renders one camera of a solution: primary rays, then the polynomials of the patch that is hit. Bitwise the
 * same for any thread count. Errors: HPR_ERR_ARG, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. Fini with
 * hpr_image_fini.
 */
HPR_API hpr_status hpr_solution_render(hpr_context *context, const hpr_solution *solution, size_t camera,
                                       const hpr_render_options *options, hpr_image *image);

/** Frees the pixels; accepts a zeroed image. */
HPR_API void hpr_image_fini(hpr_context *context, hpr_image *image);

/** What an EXR says of itself besides its pixels. Any text may be NULL. */
typedef struct hpr_image_labels {
    const char *const *channel_name; /**< [channels] */
    const char *scene, *camera;
} hpr_image_labels;

/**
 * Writes a single-part scanline EXR: the channels and A, and if the image has them the variances as the layer
 * `variance` (variance.R, variance.G, variance.B); all float, ZIP. Temporary file, renamed. Errors:
 * HPR_ERR_ARG (channels without name or with one name), HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
HPR_API hpr_status hpr_image_write_exr(hpr_context *context, const hpr_image *image,
                                       const hpr_image_labels *labels, const char *path);

/**
 * Writes an 8-bit sRGB preview: radiance times `exposure`, clamped to 0 .. 1; with alpha where the picture
 * has holes. exposure 0: 0.18 over the log-average luminance; the value used is returned through `used` (may
 * be NULL). One channel: grey; three: RGB.
 */
HPR_API hpr_status hpr_image_write_png(hpr_context *context, const hpr_image *image, double exposure,
                                       const char *path, double *used);

#ifdef __cplusplus
}
#endif

#endif
