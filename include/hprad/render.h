#ifndef HPRAD_RENDER_H
#define HPRAD_RENDER_H

#include <hprad/solve.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * What a picture can hold besides radiance. The first five are means over the pixel like the radiance, per
 * channel, and 0 where no surface is: so they are premultiplied by coverage, and where a pixel shows one
 * surface, radiance = emission + albedo * irradiance / pi and irradiance = direct + indirect. The others are
 * of the one point that is seen through the pixel's centre: they would mean nothing if they were averaged.
 */
typedef enum hpr_layer {
    HPR_LAYER_IRRADIANCE, /**< H, W/m² */
    HPR_LAYER_DIRECT,     /**< its part straight from lamps and from outside, W/m² */
    HPR_LAYER_INDIRECT,   /**< the rest, W/m² */
    HPR_LAYER_EMISSION,   /**< emitted radiance M / pi, W/m²/sr */
    HPR_LAYER_ALBEDO,     /**< reflectance */
    HPR_LAYER_NORMAL,     /**< x, y, z of length 1, of the side that is seen, world; 0 0 0 without surface */
    HPR_LAYER_POSITION,   /**< x, y, z in metres, world; 0 0 0 without surface */
    HPR_LAYER_DEPTH,      /**< metres along the camera's axis; infinite without surface */
    HPR_LAYER_DEGREE,     /**< degree of the polynomials on the element; 0 without surface */
    HPR_LAYER_ERROR,      /**< estimated RMS error of H on the element, W/m²; 0 without surface */
    HPR_LAYER_PATCH,      /**< number of the patch, as in the solution; HPR_NONE without surface */
    HPR_LAYER_ELEMENT,    /**< number of the leaf element, as in the solution; HPR_NONE without surface */
    HPR_LAYER_COUNT
} hpr_layer;

/** Name of a layer as EXR has it: irradiance, direct, indirect, emission, albedo, N, P, Z, degree, error,
 *  patchId, elementId. Static text. */
HPR_API const char *hpr_layer_name(hpr_layer layer);
/** The layer of this name, which has `length` characters; HPR_LAYER_COUNT if there is none. */
HPR_API hpr_layer hpr_layer_find(const char *name, size_t length);

/** A picture of radiance in single precision, row 0 at the top. */
typedef struct hpr_image {
    int width, height;
    int left, top;               /**< where its first pixel lies in the whole picture */
    int full_width, full_height; /**< of the whole picture of which this is a window; 0: it is the whole */
    size_t channel_count;
    float *radiance; /**< [height][width][channels], W/m²/sr: the pixel's mean. What surfaces send is thereby
                          premultiplied by coverage; (1 - coverage) times the environment is added */
    float *coverage; /**< [height][width], 0 .. 1: the part of the pixel that shows a surface */
    float *variance; /**< [height][width][channels], of the radiance as an estimate: the square of its
                        standard error, (W/m²/sr)²; NULL if it is none */
    int environment; /**< 1: light from outside shows where no surface does, so that the picture has no holes
                      */
    float *layer[HPR_LAYER_PATCH]; /**< [height][width][components] of each layer before PATCH, NULL: none.
                                        Components: the channels of light and reflectance, 3 of NORMAL and
                                        POSITION, else 1 */
    uint32_t *patch, *element;     /**< [height][width], NULL: none */
} hpr_image;

/** The film: how large a picture is, and how many rays make a pixel. */
typedef struct hpr_render_options {
    int width, height; /**< pixels; 0: 512 high, width from the camera's aspect */
    int samples;       /**< per pixel, stratified */
} hpr_render_options;

HPR_API void hpr_render_options_init(hpr_render_options *options);

/** Weight of the radiance around a pixel's centre, separable in x and y. */
typedef enum hpr_filter {
    HPR_FILTER_BOX,     /**< constant */
    HPR_FILTER_GAUSSIAN /**< exp(-x² / (2 s²)), cut off at three s: s = width / 6 */
} hpr_filter;

/** What of the picture is made, and of what. */
typedef struct hpr_view_options {
    int crop[4]; /**< x0, y0, x1, y1: columns x0 <= x < x1 and rows y0 <= y < y1 of the picture; x1 = y1 = 0:
                      all of it. Its pixels are those of the whole picture, bit for bit */
    hpr_filter filter;
    double filter_width; /**< of the filter's whole support in pixels, up to 16; 0: 1 for the box, 3 for the
                              Gaussian */
    uint32_t layers;     /**< 1 << hpr_layer for each layer that is wanted */
} hpr_view_options;

/** The whole picture, box filter of one pixel, no layers. */
HPR_API void hpr_view_options_init(hpr_view_options *view);

/**
 * Renders one camera of a solution: primary rays, then the polynomials of the patch that is hit. Bitwise the
 * same for any thread count. Errors: HPR_ERR_ARG, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED. Fini with
 * hpr_image_fini.
 */
HPR_API hpr_status hpr_solution_render(hpr_context *context, const hpr_solution *solution, size_t camera,
                                       const hpr_render_options *options, hpr_image *image);

/**
 * The same with a view of its own; `options` and `view` may be NULL. Samples are placed by the filter
 * (importance sampling of its weight), so that all count the same and every pixel stands for itself.
 * Errors: also HPR_ERR_ARG if the crop window is not within the picture, HPR_ERR_UNSUPPORTED if DIRECT or
 * INDIRECT is wanted of a solution that does not keep them apart (direct light through the basis), or ERROR
 * of one without an estimate (of a classical method).
 * Source: Ernst, Stamminger & Greiner 2006 (filter importance sampling).
 */
HPR_API hpr_status hpr_solution_view(hpr_context *context, const hpr_solution *solution, size_t camera,
                                     const hpr_render_options *options, const hpr_view_options *view,
                                     hpr_image *image);

/** Frees the pixels; accepts a zeroed image. */
HPR_API void hpr_image_fini(hpr_context *context, hpr_image *image);

/** What an EXR says of itself besides its pixels, and how it keeps them. Any text may be NULL. */
typedef struct hpr_image_labels {
    const char *const *channel_name; /**< [channels] */
    const char *scene, *camera;
    int half;  /**< 1: 16-bit numbers, but for variance, P, Z and the numbers of patches and elements */
    int tiled; /**< 1: tiles of 64 x 64; 0: scanlines */
} hpr_image_labels;

/**
 * Writes a single-part EXR, ZIP: the channels and A, and if the image has them the variances as the layer
 * `variance` (variance.R, variance.G, variance.B) and every layer of hpr_layer, lights and reflectances as
 * irradiance.R ..., vectors as N.X ...; 32-bit numbers. A window of a larger picture keeps its place in that:
 * it is the data window, the whole is the display window. Temporary file, renamed. A value beyond 65504 is
 * infinite in half and warned about. Errors: HPR_ERR_ARG (channels without name or with one name),
 * HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
HPR_API hpr_status hpr_image_write_exr(hpr_context *context, const hpr_image *image,
                                       const hpr_image_labels *labels, const char *path);

/**
 * Reads the radiance of the first part of an EXR, any size of numbers, scanlines or tiles (the largest
 * level): of channel_count channels of these names. coverage is A, or 1 where there is none. `image` may be
 * uninitialised; fini it with hpr_image_fini in any case. Errors: HPR_ERR_IO, HPR_ERR_FORMAT (no OpenEXR, or
 * a channel is missing or subsampled), HPR_ERR_UNSUPPORTED (deep data), HPR_ERR_MEMORY.
 */
HPR_API hpr_status hpr_image_read_exr(hpr_context *context, const char *path, size_t channel_count,
                                      const char *const *channel_name, hpr_image *image);

/**
 * Writes an 8-bit sRGB preview: radiance times `exposure`, clamped to 0 .. 1; with alpha where the picture
 * has holes. exposure 0: 0.18 over the log-average luminance; the value used is returned through `used` (may
 * be NULL). One channel: grey; three: RGB.
 */
HPR_API hpr_status hpr_image_write_png(hpr_context *context, const hpr_image *image, double exposure,
                                       const char *path, double *used);

/**
 * Writes the layer IRRADIANCE as an 8-bit PNG in colours (viridis: dark blue, green, yellow), with a legend
 * on the right: from 0 to `top` W/m², of three channels the luminance 0.2126 R + 0.7152 G + 0.0722 B, of
 * others the mean. What is above has the top colour, what shows no surface is grey. top 0: the next of 1, 2,
 * 5, 10 ... that is at least 99 % of the pixels' values; the value used is returned through `used` (may be
 * NULL). Errors: HPR_ERR_ARG (no such layer), HPR_ERR_IO, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED.
 */
HPR_API hpr_status hpr_image_write_false_colour(hpr_context *context, const hpr_image *image, double top,
                                                const char *path, double *used);

#ifdef __cplusplus
}
#endif

#endif
