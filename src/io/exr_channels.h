/* The channels of a picture as OpenEXR stores them: names, kinds, and where their pixels are. */
#ifndef HPR_IO_EXR_CHANNELS_H
#define HPR_IO_EXR_CHANNELS_H

#include "base/context.h"

#include <hprad/render.h>

enum { HPR_EXR_SHORT_NAME = 31, HPR_EXR_LONG_NAME = 255 }; /* lengths that OpenEXR takes */

typedef enum hpr_exr_kind { HPR_EXR_FLOAT, HPR_EXR_HALF, HPR_EXR_UINT } hpr_exr_kind;

typedef struct hpr_exr_channel {
    char name[HPR_EXR_LONG_NAME + 1];
    hpr_exr_kind kind;
    bool colour;       /* a lossy codec may treat it as the eye does */
    const void *pixel; /* float, of HPR_EXR_UINT uint32_t: the first one */
    size_t stride;     /* bytes from one pixel to the next; rows follow each other */
} hpr_exr_channel;

typedef struct hpr_exr_channels {
    size_t count;
    hpr_exr_channel *channel; /* [count] in the order of what is shown; the file sorts by name */
    bool long_names, rgb;     /* rgb: the picture's own channels are R, G and B */
} hpr_exr_channels;

/*
 * R G B A; then variance.R ..., irradiance.R ..., N.X N.Y N.Z, P.X P.Y P.Z, Z, degree, error, patchId,
 * elementId, as far as the picture has them. labels->half stores all as half but for what would be lost:
 * variance, P, Z and the numbers of patches and elements. Errors: HPR_ERR_ARG (names that are missing, equal
 * or taken, a picture without pixels), HPR_ERR_MEMORY. Borrows the picture.
 */
hpr_status hpr_exr_channels_create(hpr_context *ctx, const hpr_image *image, const hpr_image_labels *labels,
                                   hpr_exr_channels *channels);
void hpr_exr_channels_release(hpr_context *ctx, hpr_exr_channels *channels);

#endif
