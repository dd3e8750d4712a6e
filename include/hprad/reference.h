#ifndef HPRAD_REFERENCE_H
#define HPRAD_REFERENCE_H

#include <hprad/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/**
 * Monte Carlo path tracing of diffuse scenes: the independent check of everything else. A reference shares
 * the scene, the camera and the film with the solver, and rays; no element, no quadrature, no clipping.
 */
typedef struct hpr_reference hpr_reference;

enum { HPR_DEFAULT_PATHS = 64, HPR_MAX_PATHS = 1 << 24 };

typedef struct hpr_reference_options {
    uint64_t seed; /**< of the random numbers; another seed gives other noise around the same mean */
} hpr_reference_options;

/** Seed 0. */
HPR_API void hpr_reference_options_init(hpr_reference_options *options);

/**
 * Makes a scene ready for path tracing. `options` may be NULL. Errors: HPR_ERR_MEMORY,
 * HPR_ERR_DEVICE. A scene without
 * patches or without light gives a warning. Borrows the scene until destroyed.
 */
HPR_API hpr_status hpr_reference_create(hpr_context *context, const hpr_scene *scene,
                                        const hpr_reference_options *options, hpr_reference **reference);

/** Frees it; accepts NULL and sets NULL. */
HPR_API void hpr_reference_destroy(hpr_reference **reference);

/** At least one: a scene without camera gets one that frames it. */
HPR_API size_t hpr_reference_camera_count(const hpr_reference *reference);
/** "" if it has none. Valid as long as the scene. */
HPR_API const char *hpr_reference_camera_name(const hpr_reference *reference, size_t camera);

/**
 * Renders one camera. For pixel P of n = film->samples paths (2 .. HPR_MAX_PATHS; `film` NULL:
 * HPR_DEFAULT_PATHS and the default size), x_i the radiance along the i-th, which passes through a uniformly
 * random place of the pixel (box filter):
 *   radiance = mean of x_i, an unbiased estimate of the mean over P of
 *     L = (M + rho H) / pi, H = ∫ G V (M + rho H) dA + pi L_env (the part of the view that is open),
 *     where a surface is seen, and L_env where none is;
 *   variance = Σ (x_i - mean)² / (n (n - 1)), an unbiased estimate of the variance of that mean;
 *   coverage = the part of the paths that saw a surface first; L_env is no surface.
 * Backs of single-sided surfaces are culled for camera rays and absorb the paths that reach them, as
 * everywhere in hprad; reflectance is the patch's mean. The same bits for any thread count; the first paths
 * are the same whatever their number. Concurrent calls on one reference are not allowed.
 * Errors: HPR_ERR_ARG, HPR_ERR_MEMORY, HPR_ERR_INTERRUPTED, HPR_ERR_NUMERIC (a path does not end: nothing
 * absorbs and nothing escapes; the message names the remedy). Fini with hpr_image_fini.
 * Source: Kajiya 1986 (path tracing); Veach & Guibas 1995 (lamps and directions joined, balance heuristic);
 * Arvo & Kirk 1990 (Russian roulette).
 */
HPR_API hpr_status hpr_reference_render(hpr_context *context, const hpr_reference *reference, size_t camera,
                                        const hpr_render_options *film, hpr_image *image);

#ifdef __cplusplus
}
#endif

#endif
