/* The film: how large a picture is, and its pixels. */
#ifndef HPR_RENDER_FILM_H
#define HPR_RENDER_FILM_H

#include "scene/scene.h"

#include <hprad/render.h>

/*
 * Sets width, height and channels of a zeroed image and allocates its pixels, all zero; those of `variance`
 * only if asked. One side given: the other follows the camera's aspect; none: 512 high. Errors: HPR_ERR_ARG
 * if a side is not 1 to 32768, HPR_ERR_MEMORY; the caller calls hpr_image_fini in any case.
 */
hpr_status hpr_film_open(hpr_context *ctx, const hpr_camera *camera, const hpr_render_options *options,
                         size_t channel_count, const double *environment, bool variance, hpr_image *image);

#endif
