/* The film: how large a picture is, which window of it is made, and its pixels. */
#ifndef HPR_RENDER_FILM_H
#define HPR_RENDER_FILM_H

#include "scene/scene.h"

#include <hprad/render.h>

/* What a picture holds. */
typedef struct hpr_film {
    size_t channel_count;
    const double *environment; /* [channel_count] or NULL: none */
    bool variance;
    const hpr_view_options *view; /* NULL: the whole picture, no layers */
} hpr_film;

/*
 * Sets size, window and channels of a zeroed image and allocates its pixels, all zero, and of the rest what
 * `film` asks for. One side given: the other follows the camera's aspect; none: 512 high. Errors: HPR_ERR_ARG
 * if a side is not 1 to 32768 or the window not within the picture, HPR_ERR_MEMORY; the caller calls
 * hpr_image_fini in any case.
 */
hpr_status hpr_film_open(hpr_context *ctx, const hpr_camera *camera, const hpr_render_options *options,
                         const hpr_film *film, hpr_image *image);

#endif
